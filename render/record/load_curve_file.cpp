// Equilibria are known only when all samples are written, and samples know no equilibria. The
// arrays are therefore added to the closed file, before its hash is taken.
#include "render/record/load_curve_file.h"

#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sim/trajectory/array_file.h"

namespace kirireel::record {
namespace {

using mechanics::Equilibrium;
using trajectory::ArrayReader;
using trajectory::ArrayWriter;
using trajectory::Shape;

constexpr const char* kGroup = "load_curve";
constexpr const char* kGripNames = "load_curve/grip";
constexpr const char* kTurns = "load_curve/is_turn";
constexpr const char* kModes = "load_curve/unstable_modes";
constexpr const char* kTurnings = "load_curve/turning";
constexpr const char* kLeading = "leading";

/// One number of each state.
struct StateNumber {
  const char* array;
  double Equilibrium::*member;
  const char* unit;
};
constexpr StateNumber kNumbers[] = {
    {"load_curve/load", &Equilibrium::load, "1"},
    {"load_curve/energy", &Equilibrium::energy, "J"},
    {"load_curve/stiffness", &Equilibrium::stiffness, "N/m, or N m/rad if the leading grip turns"}};

/// One number of each grip in each state.
struct GripNumber {
  const char* array;
  std::vector<double> Equilibrium::*member;
  const char* unit;
};
constexpr GripNumber kGripNumbers[] = {
    {"load_curve/displacement", &Equilibrium::displacements, "m, or rad if is_turn"},
    {"load_curve/force", &Equilibrium::forces, "N, or N m if is_turn"}};

void write(ArrayWriter& file, const char* name, const std::vector<double>& numbers,
           const Shape& shape, const std::string& unit) {
  file.write(name, std::span<const double>(numbers), shape);
  file.setAttribute(name, "unit", unit);
}

void write(ArrayWriter& file, const char* name, const std::vector<int>& numbers,
           const Shape& shape) {
  file.write(name, std::span<const int>(numbers), shape);
}

void writeStates(ArrayWriter& file, const mechanics::LoadCurve& curve) {
  file.addGroup(kGroup);
  file.setAttribute(kGroup, kLeading, static_cast<double>(curve.leading));
  const std::size_t states = curve.states.size(), grips = curve.grips.size();
  std::vector<std::string> names;
  std::vector<int> turns;
  for (const mechanics::GripName& grip : curve.grips) {
    names.push_back(grip.name);
    turns.push_back(grip.isTurn ? 1 : 0);
  }
  file.write(kGripNames, names);
  write(file, kTurns, turns, {grips});
  for (const auto& [array, member, unit] : kNumbers) {
    std::vector<double> numbers;
    for (const Equilibrium& state : curve.states) numbers.push_back(state.*member);
    write(file, array, numbers, {states}, unit);
  }
  for (const auto& [array, member, unit] : kGripNumbers) {
    std::vector<double> numbers;
    for (const Equilibrium& state : curve.states) {
      numbers.insert(numbers.end(), (state.*member).begin(), (state.*member).end());
    }
    write(file, array, numbers, {states, grips}, unit);
  }
  std::vector<int> modes, turnings;
  for (const Equilibrium& state : curve.states) {
    modes.push_back(state.unstableModes);
    turnings.push_back(static_cast<int>(state.turning));
  }
  write(file, kModes, modes, {states});
  write(file, kTurnings, turnings, {states});
  std::string values = "0 none";
  for (const mechanics::Turning turning :
       {mechanics::Turning::LoadLimit, mechanics::Turning::ForceLimit,
        mechanics::Turning::Bifurcation}) {
    values += fmt::format(", {} {}", static_cast<int>(turning), mechanics::toString(turning));
  }
  file.setAttribute(kTurnings, "values", values);
}

/// Throws if an array has another shape.
void requireShape(const ArrayReader& file, const char* name, const Shape& shape) {
  if (file.shape(name) == shape) return;
  file.refuse(std::string("the array ") + name + " does not have an entry for each equilibrium");
}

void readStates(const ArrayReader& file, mechanics::LoadCurve& curve) {
  const std::vector<std::string> names = file.texts(kGripNames);
  const std::size_t grips = names.size(), states = trajectory::entryCount(file.shape(kModes));
  requireShape(file, kTurns, {grips});
  requireShape(file, kTurnings, {states});
  const std::vector<int> turns = file.integers(kTurns);
  for (std::size_t g = 0; g < grips; ++g) curve.grips.push_back({names[g], turns[g] != 0});
  const double leading = file.numberAttribute(kGroup, kLeading);
  // Comparisons with NaN are false: NaN is rejected.
  if (!(leading >= 0 && leading < static_cast<double>(grips))) {
    file.refuse("the leading grip of load_curve does not exist");
  }
  curve.leading = static_cast<std::size_t>(leading);
  curve.states.resize(states);
  for (const auto& [array, member, unit] : kNumbers) {
    requireShape(file, array, {states});
    const std::vector<double> numbers = file.doubles(array);
    for (std::size_t k = 0; k < states; ++k) curve.states[k].*member = numbers[k];
  }
  for (const auto& [array, member, unit] : kGripNumbers) {
    requireShape(file, array, {states, grips});
    const std::vector<double> numbers = file.doubles(array);
    for (std::size_t k = 0; k < states; ++k) {
      const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(k * grips);
      (curve.states[k].*member).assign(first, first + static_cast<std::ptrdiff_t>(grips));
    }
  }
  const std::vector<int> modes = file.integers(kModes), turnings = file.integers(kTurnings);
  for (std::size_t k = 0; k < states; ++k) {
    curve.states[k].unstableModes = modes[k];
    if (turnings[k] < 0 || turnings[k] > static_cast<int>(mechanics::Turning::Bifurcation)) {
      file.refuse("a state of load_curve has an unknown turning");
    }
    curve.states[k].turning = static_cast<mechanics::Turning>(turnings[k]);
  }
}

}  // namespace

void addLoadCurve(const std::filesystem::path& trajectory, const mechanics::LoadCurve& curve) {
  ArrayWriter file(trajectory, trajectory, ArrayWriter::Opening::Extend);
  writeStates(file, curve);
  file.close();
}

std::optional<mechanics::LoadCurve> readLoadCurve(const std::filesystem::path& trajectory) {
  const ArrayReader file(trajectory);
  if (!file.has(kGroup)) return std::nullopt;
  mechanics::LoadCurve curve;
  readStates(file, curve);
  return curve;
}

}  // namespace kirireel::record
