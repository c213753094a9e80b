// Equilibria are where the Lagrangian energy + multipliers . c is stationary in the coordinates q
// under the constraints c(q, load) = 0. Newton's method solves
//   | H  J^T | | dq |   | -g - J^T m |
//   | J   0  | | dm | = | -c         |,   H the exact Hessian, constraints' curvature included,
// with the factor L D L^T of H + w J^T J, w large, and refinement: redundant rows of J need no
// care, and the negative entries of D are the directions in which the energy falls within the
// constraints (Sylvester's law of inertia: J^T J fills up all others). The load is an unknown too,
// fixed by the length of the step along the last tangent (Riks 1979; Crisfield 1981). The path
// continues at load limits. A step over which the load, or the leading force, turns, or the count
// of negative entries changes, is halved until the special state is located. Riks, An incremental
// approach to the solution of snapping and buckling problems, Int. J. Solids Struct. 15, 1979;
// Wriggers, Nonlinear Finite Element Methods, 2008, ch. 7.
#include "sim/mechanics/load_path.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/interruption.h"

namespace kirireel::mechanics {
namespace {

using Vector = LoadedSheet::Vector;
using Matrix = LoadedSheet::Matrix;

// Heavier constraints are rounded more; they are taken where constraints are so nearly redundant,
// as in sheets that are almost shut, that the default weight does not outweigh the forces that the
// sheet carries.
constexpr double kMostPenalty = 1e12;
constexpr double kHeavier = 1e2;
constexpr int kRefinements = 20;
constexpr double kRefined = 1e-13;           // of the right side
constexpr double kClosedConstraint = 1e-12;  // constraints, length scales
constexpr double kBalanced = 1e-13;          // forces, parts of the stiffest spring
constexpr int kNewtonRounds = 12;
constexpr int kFewRounds = 4;              // after so many the next step may be longer
constexpr double kLongestFirstMove = 0.3;  // in one round while the first equilibrium is sought
constexpr int kRelaxations = 500;
constexpr double kFirstShift = 1e-3;  // of the stiffest spring, where the energy falls
constexpr double kMostShift = 1e6;
constexpr double kShortestStep = 1e-7;  // of the longest
constexpr double kStraight = 0.9;       // cosine between the directions at the ends of a step
constexpr int kLimitBisections = 60;
constexpr double kNoSlope = 1e-8;  // of the force along the path, parts of the stiffest spring
constexpr double kBackwards = -1;  // loads below this end the path

/// A point on the path in its unknowns, and the tangent.
struct PathPoint {
  Vector q;
  Vector multipliers;
  double load = 0;
};

/// The factored equations at one point.
class Equations {
 public:
  Equations(const LoadedSheet& sheet, const PathPoint& at)
      : H_(sheet.hessian(at.q, at.load, at.multipliers)),
        J_(sheet.jacobian(at.q)),
        scale_(sheet.stiffnessScale()),
        none_(sheet.noStiffness()) {
    factorise(sheet.constraintWeight() * scale_);
  }

  /// Adds as much to all stiffnesses as it takes for the energy to rise in all directions.
  void makeConvex() {
    Matrix identity(H_.rows(), H_.cols());
    identity.setIdentity();
    for (double shift = kFirstShift * scale_; negatives() > 0 && shift < kMostShift * scale_;
         shift *= 4) {
      H_ += shift * identity;
      factorise(weight_);
    }
  }

  // False where a pivot is 0 to rounding: the tangent does not exist there.
  bool isFactored() const { return factor_.info() == Eigen::Success; }
  /// Of the directions that constraints leave: exact after solve().
  int negatives() const { return static_cast<int>((factor_.vectorD().array() < 0).count()); }
  /// Whether some motion has almost no resistance.
  bool isLoose() const {
    return !isFactored() || factor_.vectorD().cwiseAbs().minCoeff() < none_ * scale_;
  }

  /// The change of q and of the multipliers.
  struct Change {
    Vector q;
    Vector multipliers;
    double rest = 0;  ///< what the equations miss by, part of the right side
  };

  /// Solves for the change, with heavier constraints where refinement needs them.
  Change solve(const Vector& forces, const Vector& gaps) {
    double best = weight_;
    Change found = refine(forces, gaps);
    while (found.rest > kRefined && weight_ < kMostPenalty * scale_) {
      factorise(kHeavier * weight_);
      if (!isFactored()) break;
      Change heavier = refine(forces, gaps);
      if (!(heavier.rest < found.rest)) continue;
      found = std::move(heavier);
      best = weight_;
    }
    if (weight_ != best) factorise(best);
    return found;
  }

 private:
  // The weight is in joules, as H is: the constraints are in length scales or radians.
  void factorise(double weight) {
    weight_ = weight;
    factor_.compute(Matrix(H_ + weight_ * Matrix(J_.transpose() * J_)));
  }

  // 0 of 0 counts as nothing missing.
  static double shareOf(double part, double whole) { return part > 0 ? part / whole : 0; }

  // Iterative refinement of H dq + J^T dm = forces, J dq = gaps on the factor of H + w J^T J. Each
  // round solves for what is missing and updates the multipliers by w times what the constraints
  // still miss by, which is the method of multipliers for the linear equations.
  Change refine(const Vector& forces, const Vector& gaps) const {
    Change change{Vector::Zero(H_.cols()), Vector::Zero(J_.rows())};
    for (int round = 0; round < kRefinements; ++round) {
      const Vector restOfForces = forces - H_ * change.q - J_.transpose() * change.multipliers;
      const Vector restOfGaps = gaps - J_ * change.q;
      change.rest = std::max(shareOf(restOfForces.norm(), forces.norm() + scale_ * gaps.norm()),
                             shareOf(restOfGaps.norm(), gaps.norm() + change.q.norm()));
      if (change.rest <= kRefined && round > 0) break;
      const Vector step = factor_.solve(restOfForces + weight_ * (J_.transpose() * restOfGaps));
      change.q += step;
      change.multipliers += weight_ * (J_ * step - restOfGaps);
    }
    return change;
  }

  Matrix H_, J_;
  double weight_ = 0;
  double scale_;
  double none_;
  Eigen::SimplicialLDLT<Matrix> factor_;
};

/// Follows one sheet.
class Follower {
 public:
  Follower(const LoadedSheet& sheet, std::size_t leading, const LoadPathSettings& settings,
           const EquilibriumObserver& observer)
      : sheet_(sheet), leading_(leading), settings_(settings), observer_(observer) {}

  // The loop of predictor and corrector: a step along the tangent, Newton's method back to the
  // path, half the step after a failure, a longer one after few rounds. The first step is a tenth
  // of the longest, because nothing is known yet of how the path bends.
  LoadPath follow() {
    PathPoint at = relax();
    Tangent along = tangentAt(at, nullptr);
    bool goesOn = note(at, along, Turning::None);
    double step = 0.1 * settings_.longestStep;
    while (goesOn && mayGoOn(at)) {
      checkInterruption();
      step = std::min(step, longestStep(along));
      const std::optional<Stepped> next = stepFrom(at, along, step);
      if (!next) {
        step *= 0.5;
        if (step >= kShortestStep * settings_.longestStep) continue;
        path_.trouble = fmt::format("no equilibrium was found beyond the load {:.6g}", at.load);
        // A start where what grips move is at its limit, as a sheet of squares is at 90 degrees,
        // can leave it to two sides.
        if (at.load == 0)
          path_.trouble += "; start slightly away from the point where the sheet may turn back";
        break;
      }
      // The last step went past the end: the state at the load 1 is found between the two.
      if (next->at.load >= 1) return arrive(at, next->at, along, goesOn);
      goesOn = noteTurning(at, along, step, *next);
      at = next->at;
      along = next->along;
      goesOn = goesOn && note(at, along, Turning::None);
      if (next->rounds <= kFewRounds) step *= 1.5;
    }
    return std::move(path_);
  }

 private:
  /// The direction of the path at a point, of length 1.
  struct Tangent {
    Vector q;
    Vector multipliers;
    double load = 0;
    int negatives = 0;
    double forceSlope = 0;  // of the leading grip, by its displacement's
    double displacementSlope = 0;
  };
  struct Stepped {
    PathPoint at;
    Tangent along;
    int rounds = 0;
  };

  // The load grows by at most 1 / leastStates in a step: a curve has enough states to be
  // drawn.
  double longestStep(const Tangent& along) const {
    return std::min(settings_.longestStep, 1 / (settings_.leastStates * std::abs(along.load)));
  }

  // The scalar product of arc length. Divided by a third of the unknowns it is the mean over the
  // tiles, or nodes: a step means the same on sheets of any size.
  double product(const Vector& a, const Vector& b) const {
    return 3 * a.dot(b) / static_cast<double>(sheet_.unknowns());
  }

  // The first equation's residual, gradient + J^T multipliers, joules.
  Vector forcesAt(const PathPoint& at) const {
    return sheet_.gradient(at.q, at.load) + sheet_.jacobian(at.q).transpose() * at.multipliers;
  }

  // Forces are scaled by the largest of stiffness and multipliers, both joules: a sheet that
  // carries large forces cannot be balanced better than these are rounded.
  bool isBalanced(const Vector& forces, const Vector& gaps, const PathPoint& at) const {
    const double largest =
        std::max({sheet_.stiffnessScale(),
                  at.multipliers.size() ? at.multipliers.lpNorm<Eigen::Infinity>() : 0});
    return forces.lpNorm<Eigen::Infinity>() <= kBalanced * largest &&
           (gaps.size() == 0 || gaps.lpNorm<Eigen::Infinity>() <= kClosedConstraint);
  }

  /// The equilibrium next to the start, by Newton's method downhill in energy.
  PathPoint relax() const {
    PathPoint at{sheet_.startCoordinates(), Vector::Zero(sheet_.rows()), 0};
    for (int round = 0; round < kRelaxations; ++round) {
      Equations equations(sheet_, at);
      // A singular H at the start means a mechanism. No load path begins there.
      if (equations.isLoose()) {
        throw RunError(
            "error: the sheet can move without resistance; hold it with grips or `pin`, and put "
            "springs at its hinges (`hinge_stiffness`)");
      }
      const Vector gaps = sheet_.residual(at.q, 0);
      if (equations.negatives() == 0 && isBalanced(forcesAt(at), gaps, at)) return at;
      // Newton's step then lowers the energy, also from a start next to a maximum.
      equations.makeConvex();
      const Equations::Change change = equations.solve(-forcesAt(at), -gaps);
      // Turns are nonlinear: a round moves no coordinate farther than the formulas hold.
      const double share = std::min(1.0, kLongestFirstMove / change.q.lpNorm<Eigen::Infinity>());
      at.q += share * change.q;
      at.multipliers += share * change.multipliers;
    }
    throw RunError("error: no equilibrium was found near the start, before any load");
  }

  // The direction (dq, dm, dload) in which the equations stay satisfied: H dq + J^T dm = pull, J dq
  // = motion for dload = 1, scaled to the length 1. Its sign is that of the previous tangent, so
  // the path never turns round by itself.
  Tangent tangentAt(const PathPoint& at, const Tangent* before) const {
    Equations equations(sheet_, at);
    Equations::Change change = equations.solve(sheet_.pull(at.q), sheet_.motion());
    const double length = std::sqrt(product(change.q, change.q) + 1);
    const bool isBack = before && product(change.q, before->q) + before->load < 0;
    Tangent along{std::move(change.q), std::move(change.multipliers), 1, equations.negatives()};
    const double factor = (isBack ? -1 : 1) / length;
    along.q *= factor;
    along.multipliers *= factor;
    along.load *= factor;
    along.forceSlope = sheet_.force(leading_, along.load, along.multipliers);
    along.displacementSlope = sheet_.displacementSlope(leading_, at.q, along.q);
    return along;
  }

  /// The equilibrium so far along the tangent, where Newton's method finds it.
  std::optional<Stepped> stepFrom(const PathPoint& from, const Tangent& along, double step) const {
    PathPoint at{from.q + step * along.q, from.multipliers + step * along.multipliers,
                 from.load + step * along.load};
    for (int round = 0; round < kNewtonRounds; ++round) {
      const Vector forces = forcesAt(at);
      const Vector gaps = sheet_.residual(at.q, at.load);
      if (!forces.allFinite()) return std::nullopt;
      if (isBalanced(forces, gaps, at) && round > 0) {
        const Tangent next = tangentAt(at, &along);
        // Where the path bends that much, the state may be another branch's.
        if (product(along.q, next.q) + along.load * next.load < kStraight) return std::nullopt;
        return Stepped{at, next, round};
      }
      Equations equations(sheet_, at);
      if (!equations.isFactored()) return std::nullopt;
      const Equations::Change closing = equations.solve(-forces, -gaps);
      const Equations::Change tangent = equations.solve(sheet_.pull(at.q), sheet_.motion());
      // Arc length: the projection on the tangent must stay at `step`. The change of load that
      // keeps it is found from two solves on one factor (closing and tangent): the matrix
      // stays symmetric.
      const double off =
          product(along.q, at.q - from.q) + along.load * (at.load - from.load) - step;
      const double change =
          -(off + product(along.q, closing.q)) / (product(along.q, tangent.q) + along.load);
      at.q += closing.q + change * tangent.q;
      at.multipliers += closing.multipliers + change * tangent.multipliers;
      at.load += change;
    }
    return std::nullopt;
  }

  /// The equilibrium at a given load, from one nearby.
  // Newton's method at a fixed load: the load is fixed here.
  std::optional<PathPoint> balancedAt(PathPoint at, double load) const {
    at.load = load;
    for (int round = 0; round < kNewtonRounds; ++round) {
      const Vector forces = forcesAt(at);
      const Vector gaps = sheet_.residual(at.q, load);
      if (isBalanced(forces, gaps, at)) return at;
      const Equations::Change change = Equations(sheet_, at).solve(-forces, -gaps);
      at.q += change.q;
      at.multipliers += change.multipliers;
    }
    return std::nullopt;
  }

  // Ends a path that loops or reaches negative loads, with the reason.
  bool mayGoOn(const PathPoint& at) {
    if (static_cast<int>(path_.states.size()) >= settings_.mostStates) {
      path_.trouble = fmt::format("the path has {} states at the load {:.6g} and continues",
                                  settings_.mostStates, at.load);
    } else if (at.load < kBackwards) {
      path_.trouble = "the path turns back to loads below -1";
    }
    return path_.trouble.empty();
  }

  // Guesses the state at the load 1 between the last two, and balances it.
  LoadPath arrive(const PathPoint& before, const PathPoint& beyond, const Tangent& along,
                  bool goesOn) {
    const double share = (1 - before.load) / (beyond.load - before.load);
    PathPoint guess{before.q + share * (beyond.q - before.q),
                    before.multipliers + share * (beyond.multipliers - before.multipliers), 1};
    if (const auto end = balancedAt(std::move(guess), 1); end && goesOn) {
      note(*end, tangentAt(*end, &along), Turning::None);
      path_.arrives = true;
    } else {
      path_.trouble = "no equilibrium was found at the load 1";
    }
    return std::move(path_);
  }

  /// What turns between two points of the path.
  Turning turningBetween(const Tangent& a, const Tangent& b) const {
    if (a.load * b.load < 0) return Turning::LoadLimit;
    if (a.negatives != b.negatives) return Turning::Bifurcation;
    // A slope so small is rounding: its sign means nothing.
    const double noise = kNoSlope * sheet_.stiffnessScale() / sheet_.unit(leading_);
    const bool isClear = std::abs(a.forceSlope - b.forceSlope) > noise;
    return isClear && a.forceSlope * b.forceSlope < 0 ? Turning::ForceLimit : Turning::None;
  }

  /// Locates and stores limits within a step. Returns whether the path may continue.
  bool noteTurning(const PathPoint& from, const Tangent& along, double step, const Stepped& end) {
    const Turning turning = turningBetween(along, end.along);
    if (turning == Turning::None) return true;
    double low = 0, high = step;
    Stepped found = end;
    // Bisection on the length of the step from the same point: `low` is before what turns, `high`
    // behind it. Each try is a whole equilibrium: the state that is noted lies on the path.
    for (int k = 0; k < kLimitBisections && high - low > 1e-15 * step; ++k) {
      const double middle = 0.5 * (low + high);
      const std::optional<Stepped> next = stepFrom(from, along, middle);
      if (!next) break;
      found = *next;
      (turningBetween(along, next->along) == Turning::None ? low : high) = middle;
    }
    return note(found.at, found.along, turning);
  }

  // Keeps an equilibrium with its forces and displacements, and reports it to the observer. Returns
  // whether the observer continues.
  bool note(const PathPoint& at, const Tangent& along, Turning turning) {
    Equilibrium state;
    state.load = at.load;
    state.poses = sheet_.posesAt(at.q);
    state.energy = sheet_.energy(at.q);
    for (std::size_t g = 0; g < sheet_.grips(); ++g) {
      state.displacements.push_back(sheet_.displacement(g, at.q));
      state.forces.push_back(sheet_.force(g, at.load, at.multipliers));
    }
    // d(force) / d(displacement) along the path, N/m or N m/rad. It is infinite where the
    // displacement turns back (snap-back).
    state.stiffness = along.forceSlope / along.displacementSlope;
    state.unstableModes = along.negatives;
    state.turning = turning;
    path_.states.push_back(std::move(state));
    return !observer_ || observer_(path_.states.back());
  }

  const LoadedSheet& sheet_;
  std::size_t leading_;
  LoadPathSettings settings_;
  const EquilibriumObserver& observer_;
  LoadPath path_;
};

}  // namespace

LoadPath followLoad(const LoadedSheet& sheet, std::size_t leading, const LoadPathSettings& settings,
                    const EquilibriumObserver& observer) {
  return Follower(sheet, leading, settings, observer).follow();
}

// ------------------------------------------------------------------------------------------------
// The table of a load path as text: one row for each equilibrium, in SI units, with all digits.

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

}  // namespace kirireel::mechanics
