/// Equilibria of a sheet along a load: what is asked of the sheet, its states, and the path.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "sim/base/geometry.h"

namespace kirireel::mechanics {

// ------------------------------------------------------------------------------------------------
// States of a sheet that is loaded by grips.

/// What is special about an equilibrium.
enum class Turning {
  None,         ///< nothing
  LoadLimit,    ///< load limit: a sheet under dead load snaps here
  ForceLimit,   ///< force limit of the leading grip: a sheet under force control snaps here
  Bifurcation,  ///< other equilibria branch off: a sheet that is not perfect leaves the path
};

/// "limit of the load", "limit of the force", "bifurcation", "" for none.
std::string toString(Turning turning);

/// One equilibrium on the path.
struct Equilibrium {
  double load = 0;                    ///< >= 0; 1 is the whole load
  Poses poses;                        ///< one per brick
  double energy = 0;                  ///< of the springs, joules
  std::vector<double> displacements;  ///< of each grip, see ElasticSheet; metres or radians
  std::vector<double> forces;         ///< of each grip, newtons or N m
  /// Of the leading grip, d(force)/d(displacement) along the path, N/m or N m/rad.
  double stiffness = 0;
  /// In how many independent ways the sheet would leave this state under the present control.
  int unstableModes = 0;
  Turning turning = Turning::None;  ///< what is special about it
};

/// Results for each grip along a load path.
struct GripName {
  std::string name;     ///< "grip 1 x": numbers count from 1, as the scene file has them
  bool isTurn = false;  ///< radians and N m, else metres and newtons
};

/// The equilibria that a run went through.
struct LoadCurve {
  std::vector<GripName> grips;      ///< in the order of Equilibrium::forces
  std::size_t leading = 0;          ///< the one whose stiffness is reported
  std::vector<Equilibrium> states;  ///< in their order along the path
};

/// The table: a row a state with load, energy, stiffness, unstable modes, what turns there, and
/// each grip's displacement and force; numbers read back to the last bit.
std::string loadTable(const LoadCurve& curve);

// ------------------------------------------------------------------------------------------------
// What a load path is followed through: the energy of a sheet and the constraints on it as
// functions of coordinates, and the grips that load it.

/// A sheet in coordinates q, each a length in length scales or an angle in radians; energies are in
/// joules. Grips are counted from 0; the load is what their moves and forces are in proportion to.
/// Everything is a function of only q, load and multipliers; objects have no state that a call
/// changes. Vectors have unknowns() or rows() entries.
class LoadedSheet {
 public:
  /// Coordinates, or one number a row.
  using Vector = Eigen::VectorXd;
  /// Derivatives, which are mostly 0.
  using Matrix = Eigen::SparseMatrix<double>;

  virtual ~LoadedSheet() = default;

  /// The number of coordinates: length of q, gradient and pull.
  virtual int unknowns() const = 0;
  /// The number of constraints: length of residual, motion and multipliers. Rows may be redundant.
  virtual int rows() const = 0;
  /// How many grips load the sheet.
  virtual std::size_t grips() const = 0;

  /// The coordinates of the sheet as it was built, at the load 0.
  virtual Vector startCoordinates() const = 0;
  /// Where the tiles are; those that give are where they fit best.
  virtual Poses posesAt(const Vector& q) const = 0;

  /// What the sheet holds, joules.
  virtual double energy(const Vector& q) const = 0;
  /// The largest stiffness of a coordinate, joules, the reference of tolerances.
  virtual double stiffnessScale() const = 0;
  /// A stiffness below this part of the largest counts as none.
  virtual double noStiffness() const = 0;
  /// How much heavier constraints weigh than the largest stiffness where equations are factored.
  virtual double constraintWeight() const = 0;
  /// d(energy)/dq less the grips' forces, load * pull(q).
  virtual Vector gradient(const Vector& q, double load) const = 0;
  /// The grips' forces at the load 1.
  virtual Vector pull(const Vector& q) const = 0;
  /// What must be 0, in length scales and radians.
  virtual Vector residual(const Vector& q, double load) const = 0;
  /// Its derivative by q.
  virtual Matrix jacobian(const Vector& q) const = 0;
  /// Minus its derivative by the load.
  virtual Vector motion() const = 0;
  /// The derivative of gradient + jacobian^T multipliers by q.
  /// Symmetric, all entries given.
  virtual Matrix hessian(const Vector& q, double load, const Vector& multipliers) const = 0;

  /// What a grip's displacement is a multiple of in q: metres, or 1 for turns.
  virtual double unit(std::size_t grip) const = 0;
  /// How far a grip has moved since the start, the mean over its handles, metres or radians.
  virtual double displacement(std::size_t grip, const Vector& q) const = 0;
  /// Its derivative along a direction of q.
  virtual double displacementSlope(std::size_t grip, const Vector& q,
                                   const Vector& along) const = 0;
  /// What a grip pulls with along its direction, newtons or N m. Linear in load and multipliers.
  /// Of a grip that moves, minus the sum of its rows' multipliers; of one that pushes, load times
  /// its amount.
  virtual double force(std::size_t grip, double load, const Vector& multipliers) const = 0;
};

// ------------------------------------------------------------------------------------------------
// Equilibria of an elastic sheet along a load, followed by arc length through snap-through and
// snap-back.

/// The path, from the load 0.
struct LoadPath {
  std::vector<Equilibrium> states;  ///< in their order along the path
  bool arrives = false;             ///< its last state has the load 1
  std::string trouble;              ///< why not: one line
  /// Where joints let the leading grip move no further, its displacement (metres or radians).
  std::optional<double> extent;
};

/// How a path is followed.
struct LoadPathSettings {
  /// Longest step, in the root mean square of all tiles' moves (in length scales and radians) and
  /// the load.
  double longestStep = 0.05;
  int mostSteps = 2000;  ///< of the whole path, where it ends unless it has arrived before
  int leastStates = 1;   ///< while the load grows by 1; does not change the path
};

/// Called with each state; return false to end the path.
using EquilibriumObserver = std::function<bool(const Equilibrium&)>;

/// Follows the equilibria of a sheet from the one next to its start, at the load 0, until the load
/// is 1. Limit points and bifurcations on the way are located and noted as states of their own; no
/// branch is taken. `leading`: the grip whose force and stiffness are reported. Throws RunError if
/// no equilibrium is found at the load 0, or the sheet can move without any resistance there.
/// Each state costs a few sparse factorisations of the Hessian. The sheet must outlive the call.
LoadPath followLoad(const LoadedSheet& sheet, std::size_t leading, const LoadPathSettings& settings,
                    const EquilibriumObserver& observer);

}  // namespace kirireel::mechanics
