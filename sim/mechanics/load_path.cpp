// Equilibria are the stationary points of the Lagrangian energy + multipliers . c in the
// coordinates q, with constraints c(q, load) = 0. Newton's method solves
//   | H  J^T | | dq |   | -g - J^T m |
//   | J   0  | | dm | = | -c         |,   H the exact Hessian with the constraints' curvature,
// with the factor L D L^T of H + w J^T J, w large, and refinement. If the constraints are linear in
// q, the factor is that of P H P + s (1 - P) instead: P projects onto the motions that they allow,
// and s is any stiffness. Redundant rows of J need no special treatment. D has one negative entry
// for each direction in which the energy falls within the constraints (Sylvester's law of inertia;
// the second term makes all others positive). The load is an unknown too. The length of the step
// along the last tangent fixes it (Riks 1979; Crisfield 1981). The path therefore continues at load
// limits.
//
// Newton's method may find a state of another branch. A step is accepted if positions, forces and
// energy change as the slopes at both of its ends predict (trapezoidal rule), and if every change
// in the count of negative entries is located. Otherwise it is halved. The step length depends only
// on this: additional requested states are computed between its ends and do not change the path.
// Between two states the path is a cubic through their positions and tangents. From it Newton's
// method needs one or two rounds, also near bifurcations, where it could reach another branch from
// farther away. Riks, An incremental approach to the solution of snapping and buckling problems,
// Int. J. Solids Struct. 15, 1979; Wriggers, Nonlinear Finite Element Methods, 2008, ch. 7.
#include "sim/mechanics/load_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/interruption.h"

namespace kirireel::mechanics {
namespace {

using Vector = LoadedSheet::Vector;
using Matrix = LoadedSheet::Matrix;

// Weight of constraints over the largest stiffness. Heavier constraints have larger rounding
// errors. They are used only for nearly redundant constraints, as in almost closed sheets, if the
// default weight is too small compared with the forces in the sheet.
constexpr double kPenalty = 1e6;
constexpr double kMaxPenalty = 1e12;
constexpr double kHeavier = 1e2;
// A stiffness below this fraction of the largest counts as zero: with weights, and without.
constexpr double kNoResistance = 1e-8;
constexpr double kNoFreeResistance = 1e-12;
constexpr int kRefinements = 20;
constexpr double kRefined = 1e-13;           // residual, relative to the right side
constexpr double kClosedConstraint = 1e-12;  // constraints, length scales
constexpr double kBalanced = 1e-13;          // forces, relative to the stiffest spring
constexpr int kNewtonRounds = 12;
constexpr int kFewRounds = 4;              // the next step may be longer after so few rounds
constexpr double kLongestFirstMove = 0.3;  // move per round in the search for the first equilibrium
constexpr int kRelaxations = 500;
constexpr double kFirstShift = 1e-3;  // relative to the stiffest spring, if the energy falls
constexpr double kMaxShift = 1e6;
constexpr double kShortestStep = 1e-7;  // fraction of the longest step
// Maximum deviation of a step from its prediction: positions relative to the step, energy and
// forces relative to their change. All of them also have a tolerance relative to the stiffest
// spring.
constexpr double kPlacesMissed = 0.01;
constexpr double kEnergyMissed = 0.05;
constexpr double kForcesMissed = 0.1;
constexpr double kNothingMissed = 1e-6;
// Special states are located to this length of path. Bifurcations have an eigenvalue below this
// fraction of the largest stiffness.
constexpr double kLocated = 1e-12;
constexpr double kOneEvent = 1e-7;  // changes closer than this along the path are one event
constexpr double kCritical = 1e-6;
constexpr double kStraight = 0.9;  // cosine between a tangent and the cubic's tangent
constexpr int kEigenRounds = 8;
// A grip that is stiffer than the stiffest spring by this factor is held by joints.
constexpr double kRigid = 1e6;
constexpr double kNoSlope = 1e-8;  // change of force along the path, over the stiffest spring
constexpr double kNoStiffness = std::numeric_limits<double>::quiet_NaN();
// A smaller displacement along the path is rounding. It is relative to the move of the sheet, plus
// the move of the stiffest spring under the force.
constexpr double kNoDisplacement = 1e-10;
constexpr double kBackwards = -1;  // loads below this end the path

/// A point on the path in its unknowns, and the tangent.
struct PathPoint {
  Vector q;
  Vector multipliers;
  double load = 0;
};

/// L D L^T of one matrix after another. The order of elimination depends only on the pattern of
/// entries, and is found again only if that changes.
class SymmetricFactor : public Eigen::SimplicialLDLT<Matrix> {
 public:
  /// Factors a compressed matrix.
  void computeNext(const Matrix& matrix) {
    const std::vector<int> starts(matrix.outerIndexPtr(),
                                  matrix.outerIndexPtr() + matrix.outerSize() + 1);
    const std::vector<int> places(matrix.innerIndexPtr(),
                                  matrix.innerIndexPtr() + matrix.nonZeros());
    if (starts != starts_ || places != places_) analyzePattern(matrix);
    starts_ = starts;
    places_ = places;
    factorize(matrix);
  }

 private:
  std::vector<int> starts_, places_;  // the pattern of the last matrix
};

/// The factored equations at one point.
class Equations {
 public:
  /// Uses the factor until the next equations do.
  Equations(const LoadedSheet& sheet, const PathPoint& at, SymmetricFactor& factor)
      : H_(sheet.hessian(at.q, at.load, at.multipliers)),
        J_(sheet.jacobian(at.q)),
        linear_(sheet.linearRows()),
        scale_(sheet.stiffnessScale()),
        factor_(factor) {
    factorise(kPenalty * scale_);
  }

  /// Adds a constant to all stiffnesses, large enough that the energy rises in all directions.
  void makeConvex() {
    Matrix identity(H_.rows(), H_.cols());
    identity.setIdentity();
    for (double shift = kFirstShift * scale_; negatives() > 0 && shift < kMaxShift * scale_;
         shift *= 4) {
      H_ += shift * identity;
      factorise(weight_);
    }
  }

  // False if a pivot is 0 up to rounding: the tangent does not exist there.
  bool isFactored() const { return factor_.info() == Eigen::Success; }
  /// Count of negative directions within the constraints: exact after solve().
  int negatives() const { return static_cast<int>((factor_.vectorD().array() < 0).count()); }
  /// Whether some motion has almost no resistance.
  bool isLoose() const {
    const double none = scale_ * (linear_ ? kNoFreeResistance : kNoResistance);
    return !isFactored() || factor_.vectorD().cwiseAbs().minCoeff() < none;
  }

  /// The change of q and of the multipliers.
  struct Change {
    Vector q;
    Vector multipliers;
    double rest = 0;  ///< residual of the equations, relative to the right side
  };

  /// Solves for the change, with heavier constraints if the refinement needs them.
  Change solve(const Vector& forces, const Vector& gaps) {
    double best = weight_;
    Change found = refine(forces, gaps);
    while (!linear_ && found.rest > kRefined && weight_ < kMaxPenalty * scale_) {
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

  /// The eigenvalue of H nearest to 0 within the constraints, over the largest stiffness. Inverse
  /// iteration; meant for values near 0.
  double nearestEigenvalue() const {
    Vector mode = Vector::LinSpaced(H_.cols(), 1, 2);
    double value = 0;
    for (int round = 0; round < kEigenRounds; ++round) {
      mode = factor_.solve(mode).eval();
      mode.normalize();
      value = mode.dot(H_ * mode);
    }
    return value / scale_;
  }

 private:
  // The weight is in joules, as H is: the constraints are in length scales or radians.
  void factorise(double weight) {
    weight_ = weight;
    if (linear_) {
      factor_.computeNext(Matrix(linear_->free * H_ * linear_->free) +
                          scale_ * Matrix(linear_->held * J_));
    } else {
      factor_.computeNext(H_ + weight_ * Matrix(J_.transpose() * J_));
    }
  }

  // The change that removes residuals up to the rounding of the factor.
  Change correction(const Vector& forces, const Vector& gaps) const {
    if (!linear_) {
      const Vector step = factor_.solve(forces + weight_ * (J_.transpose() * gaps));
      return {step, weight_ * (J_ * step - gaps)};
    }
    Vector step = linear_->held * gaps;
    const Vector within = linear_->free * (forces - H_ * step);
    step += linear_->free * factor_.solve(within);
    return {step, linear_->held.transpose() * (forces - H_ * step)};
  }

  // 0 / 0 counts as no residual.
  static double shareOf(double part, double whole) { return part > 0 ? part / whole : 0; }

  // Iterative refinement of H dq + J^T dm = forces, J dq = gaps. With the factor of H + w J^T J,
  // each round updates the multipliers by w times the constraints' residual. This is the method of
  // multipliers for the linear equations.
  Change refine(const Vector& forces, const Vector& gaps) const {
    Change change{Vector::Zero(H_.cols()), Vector::Zero(J_.rows())};
    for (int round = 0; round < kRefinements; ++round) {
      const Vector restOfForces = forces - H_ * change.q - J_.transpose() * change.multipliers;
      const Vector restOfGaps = gaps - J_ * change.q;
      change.rest = std::max(shareOf(restOfForces.norm(), forces.norm() + scale_ * gaps.norm()),
                             shareOf(restOfGaps.norm(), gaps.norm() + change.q.norm()));
      if (change.rest <= kRefined && round > 0) break;
      const Change step = correction(restOfForces, restOfGaps);
      change.q += step.q;
      change.multipliers += step.multipliers;
    }
    return change;
  }

  Matrix H_, J_;
  double weight_ = 0;
  const LinearRows* linear_;
  double scale_;
  SymmetricFactor& factor_;
};

/// Follows one sheet.
class Follower {
 public:
  Follower(const LoadedSheet& sheet, std::size_t leading, const LoadPathSettings& settings,
           const EquilibriumObserver& observer)
      : sheet_(sheet), leading_(leading), settings_(settings), observer_(observer) {}

  // The loop of predictor and corrector: a step along the tangent, then Newton's method back to the
  // path. Failures halve the step, and a small number of rounds lengthens it. The first step is a
  // tenth of the longest, because the curvature of the path is unknown.
  LoadPath follow() {
    Point at{relax(), {}, 0};
    at.along = tangentAt(at.at, nullptr);
    bool shouldContinue = note(at, Turning::None);
    double step = 0.1 * settings_.longestStep;
    for (int steps = 0; shouldContinue && mayContinue(at, steps);) {
      checkInterruption();
      step = std::min(step, settings_.longestStep);
      std::optional<Point> next = stepFrom(at, step);
      const bool arrives = next && next->at.load >= 1;
      if (arrives) next = arrivalBetween(at, *next);
      std::vector<Special> special;
      if (!next || !isPredicted(at, *next) || !locate(at, *next, special)) {
        step *= 0.5;
        if (step >= kShortestStep * settings_.longestStep) continue;
        giveUp(at);
        break;
      }
      ++steps;
      shouldContinue = noteBetween(at, *next, special) && note(*next, Turning::None);
      if (next->rounds <= kFewRounds) step *= 1.5;
      at = std::move(*next);
      if (!arrives) continue;
      path_.arrives = shouldContinue;
      break;
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
    double forceSlope = 0;  // of the leading grip, over that of its displacement
    double displacementSlope = 0;
  };
  struct Point {
    PathPoint at;
    Tangent along;
    int rounds = 0;
  };
  /// A state that is not the end of a step: a special or a requested one.
  struct Special {
    Point point;
    Turning turning = Turning::None;
  };

  // The scalar product of arc length. It is divided by a third of the unknowns, i.e. the mean over
  // tiles or nodes: a step has the same meaning for sheets of any size.
  double product(const Vector& a, const Vector& b) const {
    return 3 * a.dot(b) / static_cast<double>(sheet_.unknowns());
  }

  // The length of the straight line between two points.
  double distance(const PathPoint& a, const PathPoint& b) const {
    const Vector move = b.q - a.q;
    return std::hypot(std::sqrt(product(move, move)), b.load - a.load);
  }

  // The first equation's residual, gradient + J^T multipliers, joules.
  Vector forcesAt(const PathPoint& at) const {
    return sheet_.gradient(at.q, at.load) + sheet_.jacobian(at.q).transpose() * at.multipliers;
  }

  // Forces are scaled by the largest of stiffness and multipliers, both joules: the rounding of
  // large forces limits the accuracy of equilibrium.
  bool isBalanced(const Vector& forces, const Vector& gaps, const PathPoint& at) const {
    const double largest =
        std::max({sheet_.stiffnessScale(),
                  at.multipliers.size() ? at.multipliers.lpNorm<Eigen::Infinity>() : 0});
    return forces.lpNorm<Eigen::Infinity>() <= kBalanced * largest &&
           (gaps.size() == 0 || gaps.lpNorm<Eigen::Infinity>() <= kClosedConstraint);
  }

  /// The equilibrium near the start, by Newton's method with descent in energy.
  PathPoint relax() const {
    PathPoint at{sheet_.startCoordinates(), Vector::Zero(sheet_.rows()), 0};
    for (int round = 0; round < kRelaxations; ++round) {
      Equations equations(sheet_, at, factor_);
      // A singular H at the start means a mechanism. No load path begins there.
      if (equations.isLoose()) {
        throw RunError(
            "error: the sheet can move without resistance. Hold it with grips or `pin`, and add "
            "springs at its hinges (`hinge_stiffness`)");
      }
      const Vector gaps = sheet_.residual(at.q, 0);
      if (equations.negatives() == 0 && isBalanced(forcesAt(at), gaps, at)) return at;
      // Newton's step then lowers the energy, also from a start next to a maximum.
      equations.makeConvex();
      const Equations::Change change = equations.solve(-forcesAt(at), -gaps);
      // Rotations are nonlinear: a round moves no coordinate beyond the range of the linearisation.
      const double share = std::min(1.0, kLongestFirstMove / change.q.lpNorm<Eigen::Infinity>());
      at.q += share * change.q;
      at.multipliers += share * change.multipliers;
    }
    throw RunError("error: no equilibrium was found near the unloaded start");
  }

  // The direction (dq, dm, dload) in which the equations stay satisfied: H dq + J^T dm = pull,
  // J dq = motion for dload = 1, scaled to length 1. It has the sign of the previous tangent: the
  // path never reverses by itself.
  Tangent tangentAt(const PathPoint& at, const Tangent* before) const {
    Equations equations(sheet_, at, factor_);
    Equations::Change change = equations.solve(sheet_.pull(at.q), sheet_.motion());
    const double length = std::sqrt(product(change.q, change.q) + 1);
    const bool isBack = before && product(change.q, before->q) + before->load < 0;
    Tangent along{std::move(change.q), std::move(change.multipliers), 1, equations.negatives()};
    const double factor = (isBack ? -1 : 1) / length;
    along.q *= factor;
    along.multipliers *= factor;
    along.load *= factor;
    setSlopes(at, along);
    return along;
  }

  /// The equilibrium at a distance along the tangent, if Newton's method finds it.
  std::optional<Point> stepFrom(const Point& from, double step) const {
    return corrected(
        {from.at.q + step * from.along.q, from.at.multipliers + step * from.along.multipliers,
         from.at.load + step * from.along.load},
        from.along);
  }

  /// The equilibrium in the plane through a point, perpendicular to a direction.
  std::optional<Point> corrected(PathPoint at, const Tangent& along) const {
    const Vector place = at.q;
    const double load = at.load;
    for (int round = 0; round < kNewtonRounds; ++round) {
      const Vector forces = forcesAt(at);
      const Vector gaps = sheet_.residual(at.q, at.load);
      if (!forces.allFinite()) return std::nullopt;
      if (isBalanced(forces, gaps, at)) return Point{at, tangentAt(at, &along), round};
      Equations equations(sheet_, at, factor_);
      if (!equations.isFactored()) return std::nullopt;
      const Equations::Change closing = equations.solve(-forces, -gaps);
      const Equations::Change tangent = equations.solve(sheet_.pull(at.q), sheet_.motion());
      // The change of load that keeps the plane is found from two solves on one factor (closing and
      // tangent): the matrix stays symmetric.
      const double off = product(along.q, at.q - place) + along.load * (at.load - load);
      const double change =
          -(off + product(along.q, closing.q)) / (product(along.q, tangent.q) + along.load);
      at.q += closing.q + change * tangent.q;
      at.multipliers += closing.multipliers + change * tangent.multipliers;
      at.load += change;
    }
    return std::nullopt;
  }

  /// A point on the cubic through the positions and tangents of two points, not corrected, and the
  /// direction between them.
  PathPoint onCubic(const Point& a, const Point& b, double share, Tangent& along) const {
    const double length = distance(a.at, b.at);
    const double square = share * share, cube = square * share;
    const double ofB = 3 * square - 2 * cube;
    const double slopeA = length * (share - 2 * square + cube), slopeB = length * (cube - square);
    along.q = (1 - share) * a.along.q + share * b.along.q;
    along.multipliers = (1 - share) * a.along.multipliers + share * b.along.multipliers;
    along.load = (1 - share) * a.along.load + share * b.along.load;
    const double norm = std::hypot(std::sqrt(product(along.q, along.q)), along.load);
    along.q /= norm;
    along.multipliers /= norm;
    along.load /= norm;
    const auto blend = [&](const auto& from, const auto& to, const auto& slopeFrom,
                           const auto& slopeTo) {
      return ((1 - ofB) * from + ofB * to + slopeA * slopeFrom + slopeB * slopeTo);
    };
    return {blend(a.at.q, b.at.q, a.along.q, b.along.q),
            blend(a.at.multipliers, b.at.multipliers, a.along.multipliers, b.along.multipliers),
            blend(a.at.load, b.at.load, a.along.load, b.along.load)};
  }

  /// The equilibrium between the two ends of a step. If the equations are nearly singular and the
  /// tangent has another direction, the result has the tangent of the cubic.
  std::optional<Point> between(const Point& a, const Point& b, double share) const {
    Tangent along;
    const PathPoint guess = onCubic(a, b, share, along);
    std::optional<Point> found = corrected(guess, along);
    if (!found) return found;
    Tangent& tangent = found->along;
    if (product(along.q, tangent.q) + along.load * tangent.load >= kStraight) return found;
    along.negatives = tangent.negatives;
    setSlopes(found->at, along);
    tangent = std::move(along);
    return found;
  }

  /// Whether the leading grip's displacement changes only by rounding: joints lock its direction.
  bool isStill(const Tangent& along) const {
    const double unit = leadingUnit();
    const double most =
        along.q.norm() + std::abs(along.forceSlope) * unit / sheet_.stiffnessScale();
    return std::abs(along.displacementSlope) <= kNoDisplacement * unit * most;
  }

  /// A figure of a grip, or its sum over grips: indices from the number of grips are those of sums.
  template <typename Figure>
  double sumOver(std::size_t index, const Figure& figure) const {
    if (index < sheet_.grips()) return figure(index);
    double sum = 0;
    for (const auto& [grip, share] : settings_.sums[index - sheet_.grips()]) {
      sum += share * figure(grip);
    }
    return sum;
  }

  // All grips of a sum move, none rotates: they have one unit.
  double leadingUnit() const {
    if (leading_ < sheet_.grips()) return sheet_.unit(leading_);
    return sheet_.unit(settings_.sums[leading_ - sheet_.grips()].front().grip);
  }

  // The rates of the leading grip's force and displacement along a tangent.
  void setSlopes(const PathPoint& at, Tangent& along) const {
    along.forceSlope = sumOver(
        leading_, [&](std::size_t g) { return sheet_.force(g, along.load, along.multipliers); });
    along.displacementSlope = sumOver(
        leading_, [&](std::size_t g) { return sheet_.displacementSlope(g, at.q, along.q); });
  }

  /// Whether positions, energy and forces change between two points as their slopes predict.
  bool isPredicted(const Point& a, const Point& b) const {
    const double length = distance(a.at, b.at);
    if (length == 0) return true;
    const Vector missed = b.at.q - a.at.q - 0.5 * length * (a.along.q + b.along.q);
    const double missedLoad = b.at.load - a.at.load - 0.5 * length * (a.along.load + b.along.load);
    if (std::hypot(std::sqrt(product(missed, missed)), missedLoad) > kPlacesMissed * length)
      return false;
    const auto isNear = [&](double change, double slopeA, double slopeB, double part,
                            double nothing) {
      const double most = 0.5 * length * (std::abs(slopeA) + std::abs(slopeB));
      return std::abs(change - 0.5 * length * (slopeA + slopeB)) <= part * most + nothing;
    };
    const double stiffness = kNothingMissed * sheet_.stiffnessScale() * length;
    if (!isNear(sheet_.energy(b.at.q) - sheet_.energy(a.at.q), energySlope(a), energySlope(b),
                kEnergyMissed, stiffness * length))
      return false;
    for (std::size_t g = 0; g < sheet_.grips(); ++g) {
      const auto force = [&](double load, const Vector& multipliers) {
        return sheet_.force(g, load, multipliers);
      };
      if (!isNear(force(b.at.load, b.at.multipliers) - force(a.at.load, a.at.multipliers),
                  force(a.along.load, a.along.multipliers),
                  force(b.along.load, b.along.multipliers), kForcesMissed,
                  stiffness / sheet_.unit(g)))
        return false;
    }
    return true;
  }

  double energySlope(const Point& point) const {
    return sheet_.gradient(point.at.q, 0).dot(point.along.q);
  }

  /// The equilibrium at a given load, from one nearby.
  // Newton's method with a fixed load.
  std::optional<PathPoint> balancedAt(PathPoint at, double load) const {
    at.load = load;
    for (int round = 0; round < kNewtonRounds; ++round) {
      const Vector forces = forcesAt(at);
      const Vector gaps = sheet_.residual(at.q, load);
      if (isBalanced(forces, gaps, at)) return at;
      const Equations::Change change = Equations(sheet_, at, factor_).solve(-forces, -gaps);
      at.q += change.q;
      at.multipliers += change.multipliers;
    }
    return std::nullopt;
  }

  // Ends a path that loops or reaches negative loads, and records the reason.
  bool mayContinue(const Point& point, int steps) {
    if (steps >= settings_.maxSteps) {
      path_.trouble = fmt::format("the path has {} steps at the load {:.6g} and continues",
                                  settings_.maxSteps, point.at.load);
    } else if (point.at.load < kBackwards) {
      path_.trouble = "the path turns back to loads below -1";
    }
    return path_.trouble.empty();
  }

  // Records why no further step is possible. If a moving grip is stiffer than any spring could make
  // it, joints stop it.
  void giveUp(const Point& at) {
    path_.trouble = fmt::format("no equilibrium was found beyond the load {:.6g}", at.at.load);
    // At the start, the motion of the grips may be at its limit, as for a sheet of squares at 90
    // degrees. Such a start can be left in two directions.
    if (at.at.load == 0) {
      path_.trouble += "; start slightly away from the point where the sheet may turn back";
      return;
    }
    const Equilibrium& last = path_.states.back();
    const double unit = leadingUnit();
    // Also true if no stiffness is known.
    if (!(std::abs(last.stiffness) * unit * unit <= kRigid * sheet_.stiffnessScale()))
      path_.extent = last.displacements[leading_];
  }

  // The state at load 1 between two points.
  std::optional<Point> arrivalBetween(const Point& before, const Point& beyond) const {
    double low = 0, high = 1;
    Tangent along;
    while (high - low > kLocated) {
      const double middle = 0.5 * (low + high);
      (onCubic(before, beyond, middle, along).load < 1 ? low : high) = middle;
    }
    std::optional<PathPoint> end = balancedAt(onCubic(before, beyond, high, along), 1);
    if (!end) return std::nullopt;
    Tangent tangent = tangentAt(*end, &along);
    return Point{std::move(*end), std::move(tangent), beyond.rounds};
  }

  // Whether these points show no limit of the load and no change of stability between them.
  static bool areAlike(const Point& a, const Point& b) {
    return a.along.load * b.along.load >= 0 && a.along.negatives == b.along.negatives;
  }

  /// Locates the special states within a step, in order. Returns whether all were found.
  bool locate(const Point& from, const Point& to, std::vector<Special>& found) const {
    if (!locateChanges(from, to, found)) return false;
    // Smaller slopes are rounding: their sign has no meaning.
    const double noise = kNoSlope * sheet_.stiffnessScale() / leadingUnit();
    const double before = from.along.forceSlope, after = to.along.forceSlope;
    const bool isAboveNoise = std::min(std::abs(before), std::abs(after)) > noise;
    if (!isAboveNoise || before * after >= 0) return true;
    Point low = from, high = to;
    if (!bisect(low, high, [&](const Point& middle) {
          return middle.along.forceSlope * from.along.forceSlope > 0;
        }))
      return false;
    // The force of dead loads has its limit at the limit of the load.
    if (low.along.load * high.along.load < 0) return true;
    found.push_back({low, Turning::ForceLimit});
    std::ranges::stable_sort(
        found, {}, [&](const Special& special) { return distance(from.at, special.point.at); });
    return true;
  }

  /// Moves two points together to the change of a property that the first has and the second has
  /// not. Returns false if no equilibrium is found between them.
  template <typename Property>
  bool bisect(Point& low, Point& high, const Property& isLow) const {
    while (distance(low.at, high.at) > kLocated) {
      checkInterruption();
      std::optional<Point> middle = between(low, high, 0.5);
      if (!middle) middle = between(low, high, 0.4);
      if (!middle) return isCritical(low) || isCritical(high);
      const double inside = distance(low.at, high.at);
      if (!(distance(low.at, middle->at) < inside && distance(middle->at, high.at) < inside))
        return isCritical(low) || isCritical(high);
      (isLow(*middle) ? low : high) = std::move(*middle);
    }
    return true;
  }

  bool isCritical(const Point& point) const {
    const Equations equations(sheet_, point.at, factor_);
    return !equations.isFactored() || std::abs(equations.nearestEigenvalue()) < kCritical;
  }

  // Limits of the load and changes of stability. Those at the same point are merged.
  bool locateChanges(const Point& from, const Point& to, std::vector<Special>& found) const {
    Point rest = from;
    while (!areAlike(rest, to)) {
      // Brackets the first change: points like the beginning are before it.
      Point low = rest, high = to;
      if (!bisect(low, high, [&](const Point& middle) { return areAlike(rest, middle); }))
        return false;
      const bool isLimit = low.along.load * high.along.load < 0;
      const bool isOne =
          !isLimit && !found.empty() && distance(found.back().point.at, low.at) <= kOneEvent;
      if (isLimit) {
        found.push_back({low, Turning::LoadLimit});
      } else if (!isOne && (isCritical(low) || isCritical(high))) {
        found.push_back({isCritical(low) ? low : high, Turning::Bifurcation});
      }
      rest = std::move(high);
    }
    return true;
  }

  /// Records the special states of a step and the requested ones. Returns whether the path may
  /// continue.
  bool noteBetween(const Point& from, const Point& to, const std::vector<Special>& turning) {
    std::vector<Special> all = turning;
    const int parts =
        static_cast<int>(std::ceil(std::abs(to.at.load - from.at.load) * settings_.minStates));
    for (int k = 1; k < parts; ++k) {
      checkInterruption();
      std::optional<Point> middle = between(from, to, static_cast<double>(k) / parts);
      if (middle) all.push_back({std::move(*middle), Turning::None});
    }
    std::ranges::stable_sort(all, {}, [&](const Special& special) {
      return product(from.along.q, special.point.at.q - from.at.q) +
             from.along.load * (special.point.at.load - from.at.load);
    });
    return std::ranges::all_of(
        all, [&](const Special& special) { return note(special.point, special.turning); });
  }

  // Keeps an equilibrium with its forces and displacements, and reports it to the observer. Returns
  // whether the observer continues.
  bool note(const Point& point, Turning turning) {
    const auto& at = point.at;
    const auto& along = point.along;
    Equilibrium state;
    state.load = at.load;
    state.poses = sheet_.posesAt(at.q);
    state.coordinates = at.q;
    state.energy = sheet_.energy(at.q);
    for (std::size_t k = 0; k < sheet_.grips() + settings_.sums.size(); ++k) {
      state.displacements.push_back(
          sumOver(k, [&](std::size_t g) { return sheet_.displacement(g, at.q); }));
      state.forces.push_back(
          sumOver(k, [&](std::size_t g) { return sheet_.force(g, at.load, at.multipliers); }));
    }
    // d(force) / d(displacement) along the path, N/m or N m/rad. It grows without bound where the
    // displacement reverses (snap-back).
    state.stiffness = isStill(along) ? kNoStiffness : along.forceSlope / along.displacementSlope;
    state.unstableModes = along.negatives;
    state.turning = turning;
    path_.states.push_back(std::move(state));
    return !observer_ || observer_(path_.states.back());
  }

  const LoadedSheet& sheet_;
  std::size_t leading_;
  LoadPathSettings settings_;
  const EquilibriumObserver& observer_;
  mutable SymmetricFactor factor_;  // of the latest equations
  LoadPath path_;
};

}  // namespace

LoadPath followLoad(const LoadedSheet& sheet, std::size_t leading, const LoadPathSettings& settings,
                    const EquilibriumObserver& observer) {
  return Follower(sheet, leading, settings, observer).follow();
}

// ------------------------------------------------------------------------------------------------
// The table of a load path as text: one row per equilibrium, with all digits.

namespace {

/// For example "grip_1_x" for "grip 1 x".
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

// Numbers have the fewest digits that reproduce them exactly. An unknown stiffness is empty.
std::string loadTable(const LoadCurve& curve, const LengthUnit& unit) {
  const GripName& leading = curve.grips[curve.leading];
  std::string text =
      fmt::format("load,energy_J,{}_stiffness_{},unstable_modes,turning", columnOf(leading),
                  leading.isTurn ? "N_m_per_rad" : "N_per_" + unit.name);
  for (const GripName& grip : curve.grips) {
    text += grip.isTurn ? fmt::format(",{0}_rad,{0}_moment_N_m", columnOf(grip))
                        : fmt::format(",{0}_{1},{0}_force_N", columnOf(grip), unit.name);
  }
  text += '\n';
  for (const Equilibrium& state : curve.states) {
    const double stiffness = state.stiffness * (leading.isTurn ? 1 : unit.metres);
    text += fmt::format("{},{},{},{},{}", state.load, state.energy,
                        std::isnan(stiffness) ? "" : fmt::format("{}", stiffness),
                        state.unstableModes, toString(state.turning));
    for (std::size_t g = 0; g < curve.grips.size(); ++g) {
      const double moved = state.displacements[g];
      text += fmt::format(",{},{}", curve.grips[g].isTurn ? moved : inUnit(moved, unit),
                          state.forces[g]);
    }
    text += '\n';
  }
  return text;
}

}  // namespace kirireel::mechanics
