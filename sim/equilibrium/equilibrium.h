/// States of a sheet that is loaded by grips.
#pragma once

#include <string>
#include <vector>

#include "sim/base/geometry.h"

namespace kirireel {

/// What is special about an equilibrium.
enum class Turning {
  None,
  LoadLimit,   ///< the load turns: under it the sheet would snap from here
  ForceLimit,  ///< the force on the leading grip turns: a sheet that is pushed would snap from here
  Bifurcation,  ///< other equilibria branch off: a sheet that is not perfect leaves the path
};

/// "limit of the load", "limit of the force", "bifurcation", "" for none.
std::string toString(Turning turning);

/// One equilibrium on the path.
struct Equilibrium {
  double load = 0;
  Poses poses;
  double energy = 0;                  ///< of the springs, joules
  std::vector<double> displacements;  ///< of each grip, see ElasticSheet; metres or radians
  std::vector<double> forces;         ///< likewise, newtons or N m
  /// Of the leading grip, d(force)/d(displacement) along the path, N/m or N m/rad.
  double stiffness = 0;
  /// In how many independent ways the sheet would leave this state under the present control.
  int unstableModes = 0;
  Turning turning = Turning::None;
};

/// What the states of a load path tell of each grip.
struct GripName {
  std::string name;     ///< "grip 1 x": numbers count from 1, as the scene file has them
  bool isTurn = false;  ///< radians and N m, else metres and newtons
};

/// The equilibria that a run went through.
struct LoadCurve {
  std::vector<GripName> grips;  ///< in the order of Equilibrium::forces
  std::size_t leading = 0;      ///< the one whose stiffness is told
  std::vector<Equilibrium> states;
};

/// The table: a row a state with load, energy, stiffness, unstable modes, what turns there, and
/// each grip's displacement and force; numbers read back to the last bit.
std::string loadTable(const LoadCurve& curve);

}  // namespace kirireel
