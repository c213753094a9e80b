// The table of a load path as text: one row for each equilibrium, in SI units, with all digits.
#include "sim/equilibrium/equilibrium.h"

#include <algorithm>

#include <fmt/format.h>

namespace kirireel {
namespace {

/// "grip_1_x" of "grip 1 x".
std::string columnOf(const GripName& grip) {
  std::string column = grip.name;
  std::ranges::replace(column, ' ', '_');
  return column;
}

}  // namespace

// The words of the table's column "turning"; empty for an ordinary state.
std::string toString(Turning turning) {
  switch (turning) {
    case Turning::LoadLimit:
      return "limit of the load";
    case Turning::ForceLimit:
      return "limit of the force";
    case Turning::Bifurcation:
      return "bifurcation";
    case Turning::None:
      break;
  }
  return "";
}

// Numbers are written with the fewest digits that give them back exactly.
std::string loadTable(const LoadCurve& curve) {
  std::string text = "load,energy_J,stiffness,unstable_modes,turning";
  for (const GripName& grip : curve.grips) {
    text += grip.isTurn ? fmt::format(",{0}_rad,{0}_moment_N_m", columnOf(grip))
                        : fmt::format(",{0}_m,{0}_force_N", columnOf(grip));
  }
  text += '\n';
  for (const Equilibrium& state : curve.states) {
    text += fmt::format("{},{},{},{},{}", state.load, state.energy, state.stiffness,
                        state.unstableModes, toString(state.turning));
    for (std::size_t g = 0; g < curve.grips.size(); ++g) {
      text += fmt::format(",{},{}", state.displacements[g], state.forces[g]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace kirireel
