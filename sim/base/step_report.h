/// Counts, times and energies of the steps of a run, as sums.
#pragma once

#include <array>
#include <type_traits>

#include "sim/base/state_tape.h"

namespace kirireel {

/// Figures of one step, or of several together: every one is a sum. See kStepFigures.
struct StepReport {
  long steps = 0;   ///< solver steps, including the halves of halved ones
  long halved = 0;  ///< steps redone as two halves
  /// Steps that missed their tolerances at the shortest length. Bricks in contact moved as rigid
  /// pieces; other steps were accepted.
  long unconverged = 0;
  long factorizations = 0;  ///< of the system matrix
  long rejected = 0;        ///< rejected steps to a tolerance
  /// Seconds in which the requested tolerance was not kept, because of many contacts ...
  double touchingTime = 0;
  double singularTime = 0;  ///< ... or because of singular joints
  /// By how much the errors of steps may exceed the requested tolerance because of rounding,
  /// metres.
  double rounding = 0;
  double energyRounding = 0;  ///< the same of the energy, joules
  /// Energy removed by dampers, joules.
  double damped = 0;
  double impacted = 0;  ///< energy removed by contacts, through impacts and friction, joules
  /// Cost of the steps, in multiplications with an addition. It is counted from the plan of
  /// elimination and the pairs examined, and is the same on every machine.
  double work = 0;

  /// Adds all figures of further steps.
  StepReport& operator+=(const StepReport& other);

  /// Records or plays back all figures.
  void transfer(StateTape& tape);
};

/// One figure of a StepReport: its name in files, and access to it.
struct StepFigure {
  const char* name;      ///< in trajectory.h5, as in "steps/halved_steps"
  const char* unit;      ///< "1" for a count
  const char* part;      ///< section of summary.json with the sum, "cost" or "accuracy"; null: none
  const char* partName;  ///< its name there
  double (*get)(const StepReport&);  ///< reads it
  void (*set)(StepReport&, double);  ///< sets it
};

/// The figure that is a field of StepReport, a long or a double. It is read and written as a
/// double.
template <auto Field>
constexpr StepFigure stepFigure(const char* name, const char* unit, const char* part = nullptr,
                                const char* partName = nullptr) {
  return {name,
          unit,
          part,
          partName ? partName : name,
          [](const StepReport& report) { return static_cast<double>(report.*Field); },
          [](StepReport& report, double value) {
            report.*Field = static_cast<std::remove_reference_t<decltype(report.*Field)>>(value);
          }};
}

/// All figures of a StepReport. Sums, files, summary, `verify` and checkpoints follow this list.
inline constexpr std::array kStepFigures = {
    stepFigure<&StepReport::steps>("solver_steps", "1", "cost", "steps"),
    stepFigure<&StepReport::halved>("halved_steps", "1", "cost"),
    stepFigure<&StepReport::unconverged>("unconverged_steps", "1", "cost"),
    stepFigure<&StepReport::factorizations>("factorizations", "1", "cost"),
    stepFigure<&StepReport::rejected>("rejected_steps", "1", "cost"),
    stepFigure<&StepReport::touchingTime>("touching_time", "s", "accuracy"),
    stepFigure<&StepReport::singularTime>("singular_time", "s", "accuracy"),
    stepFigure<&StepReport::rounding>("rounding", "m", "accuracy"),
    stepFigure<&StepReport::energyRounding>("energy_rounding", "J", "accuracy"),
    stepFigure<&StepReport::damped>("damped", "J"),
    stepFigure<&StepReport::impacted>("impacted", "J"),
    stepFigure<&StepReport::work>("work", "1")};
static_assert(sizeof(StepReport) == kStepFigures.size() * sizeof(double),
              "a figure of StepReport is not in the list");

inline StepReport& StepReport::operator+=(const StepReport& other) {
  for (const StepFigure& figure : kStepFigures) {
    figure.set(*this, figure.get(*this) + figure.get(other));
  }
  return *this;
}

inline void StepReport::transfer(StateTape& tape) {
  for (const StepFigure& figure : kStepFigures) {
    double value = figure.get(*this);
    tape.transfer(value);
    figure.set(*this, value);
  }
}

}  // namespace kirireel
