/// Equilibria of a sheet along a load: the interface of the sheet, its states, and the path.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "sim/base/geometry.h"
#include "sim/base/length_unit.h"

namespace kirireel::mechanics {

// ------------------------------------------------------------------------------------------------
// States of a sheet under grips.

/// Type of a special equilibrium.
enum class Turning {
  None,         ///< nothing
  LoadLimit,    ///< limit of the load: a sheet under dead load jumps here
  ForceLimit,   ///< limit of the leading grip's force: a sheet under force control jumps here
  Bifurcation,  ///< other equilibria branch off: an imperfect sheet leaves the path
};

/// "limit of the load", "limit of the force", "bifurcation", "" for none.
std::string toString(Turning turning);

/// One equilibrium on the path.
struct Equilibrium {
  double load = 0;              ///< >= 0; 1 is the whole load
  Poses poses;                  ///< one per brick
  Eigen::VectorXd coordinates;  ///< of the sheet, see LoadedSheet; empty in results of runs
  double energy = 0;            ///< of the springs, joules
  /// Of each grip, see ElasticSheet, then of each sum over grips: metres or radians.
  std::vector<double> displacements;
  std::vector<double> forces;  ///< of the same, newtons or N m
  /// Stiffness at the leading grip: d(force)/d(displacement) along the path, N/m or N m/rad. NaN if
  /// the displacement changes only by rounding.
  double stiffness = 0;
  /// Number of independent unstable directions under the present control.
  int unstableModes = 0;
  Turning turning = Turning::None;  ///< what is special about it
};

/// Name and type of a grip in results.
struct GripName {
  /// For example "grip 1 x"; numbers count from 1, as in the scene file. "grip 1 along" is along
  /// the direction of a load that has several of x, y and z.
  std::string name;
  bool isTurn = false;  ///< radians and N m, else metres and newtons
};

/// One term of a sum over grips.
struct GripShare {
  std::size_t grip = 0;  ///< index
  double share = 1;      ///< factor
};

/// A displacement or a force as a weighted sum of those of grips. Grips that rotate have no part in
/// sums.
using GripSum = std::vector<GripShare>;

/// The equilibria that a run went through.
struct LoadCurve {
  std::vector<GripName> grips;      ///< in the order of Equilibrium::forces
  std::size_t leading = 0;          ///< index of the grip whose stiffness is reported
  std::vector<Equilibrium> states;  ///< in their order along the path
};

/// The table: one row per state with load, energy, stiffness, unstable modes, turning, and each
/// grip's displacement and force. Lengths are in `unit`, which the columns name. Numbers are exact
/// when read back.
std::string loadTable(const LoadCurve& curve, const LengthUnit& unit = {});

// ------------------------------------------------------------------------------------------------
// The interface of a sheet that a load path follows: its energy and constraints as functions of
// coordinates, and the grips that load it.

/// Consecutive rows of constraints.
struct RowRange {
  Eigen::Index first = 0;
  Eigen::Index count = 0;
};

/// The motions of coordinates under constraints that are linear in them.
struct LinearRows {
  Eigen::SparseMatrix<double> held;  ///< the least motions that change the rows: the pseudoinverse
  Eigen::SparseMatrix<double> free;  ///< the projection onto the motions that change no row
};

/// A sheet in coordinates q, each a length in length scales or an angle in radians. Energies are in
/// joules. Grip indices are >= 0. The load scales the moves and forces of all grips. All functions
/// depend only on q, load and multipliers, and no call changes the object. Vectors have unknowns()
/// or rows() entries.
class LoadedSheet {
 public:
  /// Coordinates, or one number per row.
  using Vector = Eigen::VectorXd;
  /// Sparse derivatives.
  using Matrix = Eigen::SparseMatrix<double>;

  virtual ~LoadedSheet() = default;

  /// The number of coordinates: length of q, gradient and pull.
  virtual int unknowns() const = 0;
  /// The number of constraints: length of residual, motion and multipliers. Rows may be redundant.
  virtual int rows() const = 0;
  /// The number of grips.
  virtual std::size_t grips() const = 0;
  /// The rows of a grip that moves, of all its handles. Empty for a grip that pushes.
  virtual RowRange rowsOf(std::size_t grip) const = 0;

  /// The coordinates of the sheet as it was built, at load 0.
  virtual Vector startCoordinates() const = 0;
  /// The poses of the tiles. Elastic tiles have the pose that fits best.
  virtual Poses posesAt(const Vector& q) const = 0;

  /// Energy stored in the sheet, joules.
  virtual double energy(const Vector& q) const = 0;
  /// The largest stiffness of a coordinate, joules, the reference of tolerances.
  virtual double stiffnessScale() const = 0;
  /// d(energy)/dq minus the grips' forces, load * pull(q).
  virtual Vector gradient(const Vector& q, double load) const = 0;
  /// The grips' forces at load 1.
  virtual Vector pull(const Vector& q) const = 0;
  /// The constraint residuals, which must be 0, in length scales and radians.
  virtual Vector residual(const Vector& q, double load) const = 0;
  /// The derivative of residual() with respect to q.
  virtual Matrix jacobian(const Vector& q) const = 0;
  /// The motions under the rows if residual() is linear in q, else null.
  virtual const LinearRows* linearRows() const { return nullptr; }
  /// Minus the derivative of residual() with respect to the load.
  virtual Vector motion() const = 0;
  /// The derivative of gradient + jacobian^T multipliers with respect to q. Symmetric, with all
  /// entries stored.
  virtual Matrix hessian(const Vector& q, double load, const Vector& multipliers) const = 0;

  /// The unit of a grip's displacement in q: metres, or 1 for rotations.
  virtual double unit(std::size_t grip) const = 0;
  /// The mean displacement of a grip's handles since the start, metres or radians.
  virtual double displacement(std::size_t grip, const Vector& q) const = 0;
  /// The derivative of displacement() along a direction of q.
  virtual double displacementSlope(std::size_t grip, const Vector& q,
                                   const Vector& along) const = 0;
  /// The force of a grip along its direction, newtons or N m. Linear in load and multipliers. For a
  /// moving grip, minus the sum of its rows' multipliers. For a pushing grip, load times its
  /// amount.
  virtual double force(std::size_t grip, double load, const Vector& multipliers) const = 0;
};

// ------------------------------------------------------------------------------------------------
// Equilibria of an elastic sheet along a load, followed by arc length through snap-through and
// snap-back.

/// The path, from load 0.
struct LoadPath {
  std::vector<Equilibrium> states;  ///< in their order along the path
  bool arrives = false;             ///< the last state has load 1
  std::string trouble;              ///< one line: why it does not arrive; else empty
  /// Displacement at which joints stop the leading grip (metres or radians).
  std::optional<double> extent;
};

/// Settings of path following.
struct LoadPathSettings {
  /// Longest step, in the root mean square of all tiles' moves (in length scales and radians) and
  /// the load.
  double longestStep = 0.05;
  int maxSteps = 2000;  ///< limit for the whole path
  int minStates = 1;    ///< while the load grows by 1; does not change the path
  /// Sums to record, after the grips: for example the force along a direction.
  std::vector<GripSum> sums = {};
};

/// Called with each state; return false to end the path.
using EquilibriumObserver = std::function<bool(const Equilibrium&)>;

/// Follows the equilibria of a sheet from the one near its start, at load 0, to load 1. Limit
/// points and bifurcations are located and recorded as separate states. Branches are not followed.
/// `leading`: the index of the grip whose force and stiffness are reported, or the number of grips
/// plus the index of a sum. Throws RunError if no equilibrium is found at load 0, or if the sheet
/// can move there without resistance. Each state costs a few sparse factorisations of the Hessian.
/// The sheet must outlive the call.
LoadPath followLoad(const LoadedSheet& sheet, std::size_t leading, const LoadPathSettings& settings,
                    const EquilibriumObserver& observer);

}  // namespace kirireel::mechanics
