/// Equilibria of an elastic sheet along a load, followed by arc length through snap-through and
/// snap-back.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/equilibrium/equilibrium.h"
#include "sim/equilibrium/loaded_sheet.h"

namespace kirireel {

/// The path, from the load 0.
struct LoadPath {
  std::vector<Equilibrium> states;
  bool arrives = false;  ///< its last state has the load 1
  std::string trouble;   ///< why not: one line
};

struct LoadPathSettings {
  /// Longest step, in the root mean square of all tiles' moves (in length scales and radians) and
  /// the load.
  double longestStep = 0.05;
  int mostStates = 2000;
  int leastStates = 1;  ///< while the load grows by 1
};

/// Called with each state; return false to end the path.
using EquilibriumObserver = std::function<bool(const Equilibrium&)>;

/// Follows the equilibria of a sheet from the one next to its start, at the load 0, until the load
/// is 1. Limit points and bifurcations on the way are located and noted as states of their own; no
/// branch is taken. `leading`: the grip whose force and stiffness are told. Throws RunError where
/// no equilibrium is found at the load 0, or the sheet can move without any resistance there.
/// Each state costs a few sparse factorisations of the Hessian. The sheet must outlive the call.
LoadPath followLoad(const LoadedSheet& sheet, std::size_t leading, const LoadPathSettings& settings,
                    const EquilibriumObserver& observer);

}  // namespace kirireel
