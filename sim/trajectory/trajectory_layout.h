/// The names in trajectory.h5 that its writer and its reader share.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "sim/brick/hinge.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::layout {

/// The attribute "format" of the file itself.
inline constexpr const char* kFormat = "kirireel trajectory";
inline constexpr double kFormatVersion = 2;
inline constexpr double kFirstVersion = 1;  ///< had neither steps nor figures
/// Columns of model/joints: tile, vertex, tile, vertex, face, kind.
inline constexpr std::size_t kJointColumns = 6;

/// A number that each spring at a hinge has; files without springs, and of earlier releases, have
/// no group "hinges".
struct SpringColumn {
  const char* name;  ///< of its array
  double& (*field)(HingeSpring&);
  const char* unit;
};
inline constexpr std::array kSpringColumns = {
    SpringColumn{"hinges/start", [](HingeSpring& s) -> double& { return s.hinge.start; }, "rad"},
    SpringColumn{"hinges/least", [](HingeSpring& s) -> double& { return s.hinge.least; }, "rad"},
    SpringColumn{"hinges/most", [](HingeSpring& s) -> double& { return s.hinge.most; }, "rad"},
    SpringColumn{"hinges/stiffness", [](HingeSpring& s) -> double& { return s.stiffness; },
                 "N m/rad"},
    SpringColumn{"hinges/rest", [](HingeSpring& s) -> double& { return s.rest; }, "rad"},
    SpringColumn{"hinges/damping", [](HingeSpring& s) -> double& { return s.damping; },
                 "N m s/rad"}};

/// A figure that each sample has.
struct Measure {
  const char* name;  ///< of its array
  double Sample::*field;
};
inline constexpr std::array kMeasures = {Measure{"measures/joint_gap", &Sample::jointGap},
                                         Measure{"measures/target_error", &Sample::targetError},
                                         Measure{"measures/penetration", &Sample::penetration}};

/// What each step has, beside the figures of its report.
struct StepColumn {
  const char* name;  ///< of its array
  double StepRecord::*field;
  const char* unit;
};
inline constexpr std::array kStepColumns = {
    StepColumn{"steps/time", &StepRecord::time, "s"},
    StepColumn{"steps/joint_gap", &StepRecord::jointGap, "m"},
    StepColumn{"steps/joint_gap_mean", &StepRecord::jointGapMean, "m"},
    StepColumn{"steps/target_error", &StepRecord::targetError, "m"}};

/// The array of a figure of the steps' reports. Files of earlier releases do not have all.
inline std::string arrayOf(const StepFigure& figure) {
  return std::string("steps/") + figure.name;
}

/// Energies that each sample of a run with dynamics has.
struct EnergyChannel {
  const char* name;  ///< of its array
  double Energies::*field;
  const char* description;
};
inline constexpr std::array kEnergies = {
    EnergyChannel{"energy/kinetic", &Energies::kinetic, "of the bricks"},
    EnergyChannel{"energy/spring", &Energies::spring,
                  "stored in springs that pull tiles, and in joints that give"},
    EnergyChannel{"energy/elastic", &Energies::elastic, "stored in springs at hinges"},
    EnergyChannel{"energy/work", &Energies::work, "put in so far by drives and gravity"},
    EnergyChannel{"energy/damped", &Energies::damped, "taken so far by dampers"},
    EnergyChannel{"energy/impacted", &Energies::impacted,
                  "taken so far by impacts and friction of contacts"}};

inline constexpr const char* kJointForces = "forces/joint";
inline constexpr const char* kIndeterminate = "forces/joint_indeterminate";
inline constexpr const char* kHoldTimes = "holds/time";
inline constexpr const char* kHoldKinds = "holds/kind";
inline constexpr const char* kHoldTiles = "holds/tiles";
/// Vectors of a hold.
struct HoldChannel {
  const char* name;  ///< of its array
  Vector3 Hold::*field;
  const char* unit;
};
inline constexpr std::array kHolds = {HoldChannel{"holds/force", &Hold::force, "N"},
                                      HoldChannel{"holds/moment", &Hold::moment, "N m"},
                                      HoldChannel{"holds/point", &Hold::point, "m"}};

}  // namespace kirireel::layout
