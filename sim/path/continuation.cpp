// Kinematic path by the points nearest to a guide.
//
// The guide g(s), s in [0, 1], moves each brick independently from its start to its goal. The
// centre moves on a straight line, and the brick rotates uniformly about one axis. The guide opens
// the joints. The path consists of the closed states, c(q) = 0, that are nearest to g(s). Each is
// computed from the state before:
//   minimise |q - g(s)|_W  with  c(q) = 0  and  phi(q) >= 0,
// phi the gaps of contacts, and W = diag(1, w rho^2) for each brick. Positions have weight 1.
// Rotations count by their arc at the radius of gyration rho, with weight w. One move is the step
//   minimise |u - (g(s) - q)|_W  with  J u = 0,  C u >= -phi,
// and then closes the joints again. This is a Gauss-Newton step for the nearest point. The joint
// solver computes it as a step of unit time with the velocities g(s) - q, with W as masses and
// without forces. The contact finder sweeps each move: no brick passes through another, even in a
// long move. s grows in equal steps. If the mechanism follows its guide, the states are therefore
// equidistant.
//
// A move aims at the fraction t of the distance to g. t is 1 if the mechanism is straight. On a
// curved mechanism
//   |q' - g|^2 = |q - g|^2 - 2 m^2 / t + c m^2,  m = |q' - q|,
// c depends on the curvature, and t = 1 / c leads to the nearest point. A larger t would oscillate
// about it. Each move estimates c for the next one. If closing undoes too much of a move, or bricks
// have no room, the move is repeated with half the fraction.
//
// Compliant joints replace c(q) = 0 by a spring energy. The state minimises
//   |q - g(s)|_W^2 + r |c(q)|^2,  r the stiffness of a joint over the weight of a position.
// A design without freedom can then leave its start by opening joints. In a model whose coordinates
// were rounded, this energy also defines "closed". r then follows from the rounding, see
// assembled_state.h.
//
// Full extension maximises the sum of squared distances from the common centre on the mechanism, by
// gradient ascent with momentum: Nesterov (1983), Soviet Math. Doklady 27. Near the maximum the sum
// differs by the square of the distance, so its gains lead only to the root of rounding. The last
// digits come from the moves themselves, which vanish there: Anderson's mixing, Walker, Ni (2011),
// SIAM J. Numer. Anal. 49.
//
// Nearest points are followed as in predictor-corrector continuation: Allgower, Georg (1990),
// Introduction to Numerical Continuation Methods, chapters 2 and 6.
#include "sim/path/continuation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "sim/model/isometry.h"
#include "sim/run/assembled_state.h"
#include "sim/run/dynamics.h"
#include "sim/run/path_evaluation.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel::path {
namespace {

// Step of the guide from state to state, as a fraction of a tile, and the maximum number of states.
// Lengths below are fractions of a tile or of a state. "State" as a length is the distance between
// two consecutive states of the path.
constexpr double kStateShare = 0.02;
constexpr double kMaxStates = 200;
// The jump off the start may be this many times longer than that of its guide, plus one state.
constexpr double kLongestJump = 4;
// Without a jump, progress starts with this value and grows by this factor from state to state.
constexpr double kFirstProgress = 1e-5;
constexpr double kGrowth = 1.3;
// Maximum number of moves towards one state of the guide, and towards the goal.
constexpr int kMovesAState = 4;
constexpr int kMovesAtGoal = 300;
// Maximum number of moves towards the goal before compliant joints close.
constexpr int kMovesToSettle = 60;
// A move longer than this many states of the guide is repeated with a smaller fraction. A longer
// way to one state of the guide is kept in all its moves.
constexpr double kLongestMove = 3;
// A move shorter than this fraction of a state is the last one towards its guide state.
constexpr double kShortMove = 0.05;
// At the goal, moves stop below this fraction of a tile.
constexpr double kNoMove = 1e-10;
// The bricks are stuck after this many consecutive guide states with hardly any move.
constexpr int kStuckPlaces = 8;
// Above this error at the end (fraction of a tile), an earlier state may be nearer to the target.
constexpr double kFarError = 1e-6;
// If a move fails, is too long or increases the distance, its aim is halved, down to these
// fractions of the distance. The aim of later moves grows again by kAimGrowth.
constexpr double kMinAim = 1e-6;
constexpr double kMinGood = 1.0 / 16;
constexpr double kAimGrowth = 1.5;
// Aims are powers of two. Their exponents are multiples of the inverse of this number.
constexpr double kAimSteps = 8;
// Tolerance for changes of distance, as a fraction of the distance or of a tile.
constexpr double kNoFarther = 1e-6;
// Extension: maximum distance of the aim, in states, and the fraction below which bricks are stuck.
constexpr double kReach = 5;
constexpr double kMinReach = 1e-6;
// Extension: the first aim is this fraction of the maximum distance away. An aim is at most kWider
// times farther from the centre than the state.
constexpr double kFirstReach = 1e-3;
constexpr double kWider = 1.0;
// Extension: a state's length is at least the tiles' root mean square distance from their centre
// over this number.
constexpr double kRadiusStates = 100;
// The last move of a path has at least this fraction of a state.
constexpr double kResting = 0.5;
constexpr double kNoGain = 1e-12;  // of the sum of squares, relative
constexpr int kMaxExtending = 2000;
// Refinement of the maximum: moves that are mixed, moves without a shorter one at which it ends,
// and the largest distance, in states.
constexpr int kMixedMoves = 12;
constexpr int kMaxVainMoves = 10;
constexpr double kFarthestRefined = 0.5;
// Moves stop below this fraction of the coordinates' rounding.
constexpr double kNoDigit = 0.1;
// Maximum cost of the path with exact joints, relative to that of the path with rounded joints.
constexpr double kExactCost = 4;
// Joint stiffnesses near a flush start, over the weight of a position, tried in order. On caps of
// 64 to 144 tiles 1e4 opens joints least, by 2e-4 to 3e-3 of a tile. If it jams, softer joints
// arrive.
constexpr double kNearStart[] = {1e4, 1e3, 1e2};
// Perturbation that leaves a saddle, radians, and the relative gain in extent that confirms it.
constexpr double kPerturbation = 0.02;
constexpr double kMoreExtent = 1e-6;

scene::Scene withoutLoads(scene::Scene scene) {
  scene.environment.gravity.setZero();
  scene.environment.brickFriction = 0;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.solver = scene::SolverSettings{.planar = scene.solver.planar};
  return scene;
}

/// The mean position of the bricks of each piece. `pieces` comes from model::piecesOf().
std::vector<Vector3> centresOf(const Poses& poses, const std::vector<int>& pieces) {
  std::vector<Vector3> centres(1 + *std::ranges::max_element(pieces), Vector3::Zero());
  std::vector<double> counts(centres.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    centres[pieces[i]] += poses[i].position;
    ++counts[pieces[i]];
  }
  for (std::size_t k = 0; k < centres.size(); ++k) centres[k] /= counts[k];
  return centres;
}

/// Moves each brick away from the centre of its piece, by a fraction of its distance.
Poses spread(Poses poses, const std::vector<int>& pieces, double part) {
  const std::vector<Vector3> centres = centresOf(poses, pieces);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].position += part * (poses[i].position - centres[pieces[i]]);
  }
  return poses;
}

/// Moves each piece of a state rigidly to where it is nearest to that of `start`. A path has a
/// drift: loops of moves rotate and shift the whole. Its rounding grows with the number of moves.
Poses withoutDrift(const std::vector<brick::Brick>& bricks, const Poses& start,
                   const std::vector<int>& pieces, bool isPlanar, Poses poses) {
  const std::vector<Vector3> from = centresOf(poses, pieces), to = centresOf(start, pieces);
  std::vector<std::vector<Vector3>> now(from.size()), before(from.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double radius = run::gyrationRadius(bricks[i]);
    for (const double side : {-radius, radius}) {
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3 arm = side * Vector3::Unit(axis);
        now[pieces[i]].push_back(poses[i].position + poses[i].rotation * arm);
        before[pieces[i]].push_back(start[i].position + start[i].rotation * arm);
      }
    }
  }
  for (std::size_t k = 0; k < from.size(); ++k) {
    Quaternion turn(model::bestRigidMotion(now[k], before[k]).rotation);
    if (isPlanar) turn.x() = turn.y() = 0;
    turn.normalize();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (pieces[i] != static_cast<int>(k)) continue;
      poses[i] = {to[k] + turn * (poses[i].position - from[k]), turn * poses[i].rotation};
    }
  }
  return poses;
}

/// The sum of squared distances from the centres of the pieces, square metres.
double extent(const Poses& poses, const std::vector<int>& pieces) {
  const std::vector<Vector3> centres = centresOf(poses, pieces);
  double sum = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    sum += (poses[i].position - centres[pieces[i]]).squaredNorm();
  }
  return sum;
}

/// The state at such a run::displacement() from another one.
Poses displaced(const std::vector<brick::Brick>& bricks, Poses poses, const Eigen::VectorXd& by) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i] = kirireel::displaced(poses[i], by.segment<3>(6 * i),
                                   by.segment<3>(6 * i + 3) / run::gyrationRadius(bricks[i]));
  }
  return poses;
}

/// Anderson's mixing of the last points of x -> x + move(x). It leads to the x that does not move.
class Mixing {
 public:
  /// The next point, from the last one and its move.
  Eigen::VectorXd next(const Eigen::VectorXd& point, const Eigen::VectorXd& move) {
    points_.push_back(point);
    moves_.push_back(move);
    if (points_.size() > kMixedMoves + 1) {
      points_.erase(points_.begin());
      moves_.erase(moves_.begin());
    }
    const auto count = static_cast<Eigen::Index>(points_.size()) - 1;
    if (count == 0) return point + move;
    Eigen::MatrixXd steps(point.size(), count), changes(point.size(), count);
    for (Eigen::Index k = 0; k < count; ++k) {
      steps.col(k) = points_[k + 1] - points_[k];
      changes.col(k) = moves_[k + 1] - moves_[k];
    }
    const Eigen::VectorXd weights = changes.colPivHouseholderQr().solve(move);
    return point + move - (steps + changes) * weights;
  }

 private:
  std::vector<Eigen::VectorXd> points_, moves_;
};

/// The mechanism in one metric. It moves states towards guide states.
class Mechanism {
 public:
  Mechanism(const scene::Scene& scene, const ContinuationSettings& settings, const Poses& start)
      : scene_(scene),
        jointStiffness_(settings.jointStiffness),
        turnWeight_(settings.turnWeight),
        tile_(model::tileSize(scene.model)),
        bricks_(run::metricBricks(scene, settings.turnWeight)) {
    restart(start);
  }

  // Resets contacts: overlaps at these poses count as overlaps of the start.
  void restart(const Poses& start) {
    start_ = start;
    forgetMoves(aim_);
  }

  /// Continues anywhere, with the given aim, as if there had been no moves since the last restart.
  void forgetMoves(double aim) {
    aim_ = aim;
    dynamics_ = run::makeDynamics(scene_, scene::sceneNeeds(scene_), bricks_, start_,
                                  contacts::FaceContact::Planes);
    dynamics_->setJointStiffness(jointStiffness_);
    dynamics_->setHalving(isTouching());
    dynamics_->setFine(true);
  }

  /// Sets the joint stiffness, relative to the stiffness of the pull.
  void holdJoints(double stiffness) {
    jointStiffness_ = stiffness;
    dynamics_->setJointStiffness(jointStiffness_);
  }

  /// Closes compliant joints beyond the first order.
  void settle(Poses& poses, run::SearchBudget& budget) {
    budget.spend(run::settle(bricks_, scene_.model.rounding, *dynamics_, poses));
  }

  const std::vector<brick::Brick>& bricks() const { return bricks_; }
  bool close(Poses& poses) { return run::closeInPlace(poses, *dynamics_); }
  void restore(const run::SymmetricStates& symmetries, Poses& poses) {
    symmetries.restore(poses, *dynamics_);
  }

  /// The fraction of the distance at which the next move aims, (0, 1].
  double aim() const { return aim_; }

  /// The state after one move that aims at `place` itself.
  Poses step(const Poses& from, const Poses& place, run::SearchBudget& budget) {
    Motion motion{from, aimedAt(from, place, 1)};
    budget.spend(dynamics_->advance(motion, 1, run::withoutForces).work);
    return std::move(motion.poses);
  }

  /// Moves towards `place`, by at most about `longest` metres. Returns the distance moved, metres.
  double move(Poses& poses, const Poses& place, double longest, run::SearchBudget& budget) {
    const double before = distance(poses, place);
    for (bool isFirst = true;; isFirst = false) {
      Motion motion{poses, aimedAt(poses, place, aim_)};
      const StepReport report = dynamics_->advance(motion, 1, run::withoutForces);
      budget.spend(report.work);
      const double moved = run::pathDistance(bricks_, poses, motion.poses);
      const double after = distance(motion.poses, place);
      // Among contacts the solver has already halved a failed move.
      const bool isGood = (report.unconverged == 0 || isTouching()) &&
                          (!isExact() || after <= (1 + kNoFarther) * before + kNoFarther * tile_);
      const bool isTaken = isGood || (moved > 0 && aim_ <= kMinGood);
      if ((isTaken && !(moved > longest)) || aim_ <= kMinAim) {
        if (isFirst) aimNext(report, before, distance(poses, motion.poses), after);
        poses = std::move(motion.poses);
        return moved;
      }
      setAim(aim_ * (moved > longest ? std::min(0.5, 0.5 * longest / moved) : 0.5));
    }
  }

 private:
  bool isExact() const { return std::isinf(jointStiffness_); }
  bool isTouching() const { return scene_.environment.contacts != scene::ContactFilter::None; }

  /// Distance from a state to other poses in the metric of the mechanism, metres.
  double distance(const Poses& state, const Poses& place) const {
    return run::pathDistance(bricks_, state, place, turnWeight_);
  }

  /// Computes the next move's aim from the last move; see the head of this file.
  void aimNext(const StepReport& report, double before, double moved, double after) {
    double best = 1;
    if (isExact() && moved > kNoFarther * before) {
      const double gained = 0.5 * (before - after) * (before + after) / (moved * moved);
      best = 1 / std::max(1.0, 2 * (1 / aim_ - gained));
    }
    if (report.halved > 0) best = std::min(best, 0.5 * aim_);
    setAim(std::clamp(best, 0.5 * aim_, std::min(1.0, kAimGrowth * aim_)));
  }

  /// Rounds the aim, so rounding errors of a move do not change the length of the next one.
  void setAim(double aim) { aim_ = std::exp2(std::round(kAimSteps * std::log2(aim)) / kAimSteps); }

  /// The velocities that move free bricks by the fraction `aim` of the distance to other poses, in
  /// 1 s.
  static std::vector<Velocity> aimedAt(const Poses& from, const Poses& place, double aim) {
    std::vector<Velocity> velocities;
    for (std::size_t i = 0; i < from.size(); ++i) {
      velocities.push_back({aim * (place[i].position - from[i].position),
                            aim * turnBetween(from[i].rotation, place[i].rotation)});
    }
    return velocities;
  }

  const scene::Scene& scene_;
  double jointStiffness_;  // relative to the bricks' unit mass and unit time
  double turnWeight_;
  double tile_;     // metres
  double aim_ = 1;  // the fraction of the distance at which moves aim, (0, 1]
  std::vector<brick::Brick> bricks_;
  Poses start_;  // whose overlaps may remain
  std::unique_ptr<run::Dynamics> dynamics_;
};

class Continuation {
 public:
  /// `closedStiffness`: stiffness of closed joints, as ContinuationSettings::jointStiffness.
  Continuation(const scene::Scene& scene, Poses start, const ContinuationSettings& settings,
               double closedStiffness, run::SearchBudget& budget,
               const PathObserver& shouldContinue)
      : scene_(withoutLoads(scene)),
        settings_(heldBy(settings, closedStiffness)),
        closedStiffness_(closedStiffness),
        tile_(model::tileSize(scene.model)),
        pieces_(model::piecesOf(scene.model)),
        poses_(std::move(start)),
        mechanism_(scene_, settings_, poses_),
        symmetries_(scene),
        budget_(budget),
        shouldContinue_(shouldContinue) {
    symmetries_.keepThoseOf(poses_);
    if (!settings_.areJointsCompliant()) mechanism_.close(poses_);
    mechanism_.restore(symmetries_, poses_);
    keep();
  }

  /// Follows the given states from the first, which is closed, to the last.
  // Jumps off a singular start, then continues state by state.
  run::MechanismPath along(std::vector<Poses> states) {
    states.front() = poses_;
    for (const Poses& state : states) symmetries_.keepThoseOf(state);
    for (Poses& state : states) state = model::symmetricMean(state, symmetries_.group());
    const PathGuide guide(mechanism_.bricks(), std::move(states));
    path_.guideLength = guide.length();
    const double count =
        std::clamp(path_.guideLength / (kStateShare * tile_), kMinStates, kMaxStates);
    stateLength_ = path_.guideLength / count;
    if (stateLength_ > 0) {
      if (settings_.jump > 0 && !settings_.areJointsCompliant()) jump(guide);
      follow(guide, 1 / count);
    }
    return finish();
  }

  run::MechanismPath toExtension() {
    const double radius =
        run::pathDistance(mechanism_.bricks(), poses_, spread(poses_, pieces_, 1));
    if (radius == 0) return finish();  // loose tiles
    stateLength_ = std::max(kStateShare * tile_, radius / kRadiusStates);
    extend();
    if (settings_.jointStiffness < closedStiffness_) {
      closeCompliantJoints();
      extend();
    }
    // Without any gain in extent, the state is a maximum or, often by symmetry, a saddle.
    while (mayContinue() && leaveSaddle()) continue;
    if (ascent_ > 0 && !isTouching()) refine();
    omitRest();
    if (!isTouching()) removeDrift();
    // Neither rounding nor creep among bricks that lock each other is motion.
    if (path_.length() <= std::max(model::kClosedShare * tile_, creep())) {
      path_.states.resize(1);
      path_.lengths.resize(1);
      poses_ = path_.states.front();
    }
    path_.guideLength = path_.length();
    return finish();
  }

 private:
  /// The poses and the path of an extension so far.
  struct ExtensionState {
    Poses poses;
    run::MechanismPath path;
    double ascent, aim;
  };

  static ContinuationSettings heldBy(ContinuationSettings settings, double closedStiffness) {
    settings.jointStiffness = std::min(settings.jointStiffness, closedStiffness);
    return settings;
  }

  /// Whether "closed" means closed within the rounding of the coordinates.
  bool isRounded() const {
    return settings_.jointStiffness == closedStiffness_ && settings_.areJointsCompliant();
  }

  bool isTouching() const { return scene_.environment.contacts != scene::ContactFilter::None; }

  bool mayContinue() {
    path_.isCutShort =
        path_.isCutShort || budget_.isSpent() || (shouldContinue_ && !shouldContinue_(progress_));
    return !path_.isCutShort && !path_.isStuck;
  }

  void keep() {
    const bool isFirst = path_.states.empty();
    const double length = isFirst ? 0
                                  : path_.length() + run::pathDistance(mechanism_.bricks(),
                                                                       path_.states.back(), poses_);
    path_.states.push_back(poses_);
    path_.lengths.push_back(length);
  }

  double moveTowards(const Poses& place) {
    const double moved = mechanism_.move(poses_, place, kLongestMove * stateLength_, budget_);
    if (isRounded()) mechanism_.settle(poses_, budget_);
    mechanism_.restore(symmetries_, poses_);
    keep();
    return moved;
  }

  /// From here on, joints are closed as far as the tiles fit each other.
  void closeCompliantJoints() {
    settings_.jointStiffness = closedStiffness_;
    mechanism_.holdJoints(closedStiffness_);
    if (isRounded()) mechanism_.settle(poses_, budget_);
    if (!settings_.areJointsCompliant()) mechanism_.close(poses_);
    mechanism_.restore(symmetries_, poses_);
    keep();
  }

  /// Moves the tiles apart until the extent no longer grows.
  void extend() {
    const double whole = run::pathDistance(mechanism_.bricks(), poses_, spread(poses_, pieces_, 1));
    const double widest = kReach * stateLength_ / whole;
    // Flush bricks separate by tiny moves. Larger moves would jam.
    double part = kFirstReach * widest;
    double reached = extent(poses_, pieces_);
    Poses last = poses_;
    int gains = 0;  // consecutive gains
    for (int i = 0; i < kMaxExtending && part > kMinReach * widest && mayContinue(); ++i) {
      // The momentum grows with the number of consecutive gains.
      const double momentum = gains / (gains + 3.0);
      const Poses ahead = interpolate(last, poses_, 1 + momentum);
      Poses tried = poses_;
      const double moved =
          mechanism_.move(tried, spread(ahead, pieces_, part), stateLength_, budget_);
      if (isRounded()) mechanism_.settle(tried, budget_);
      mechanism_.restore(symmetries_, tried);
      const double extended = extent(tried, pieces_);
      if (!(extended - reached > kNoGain * reached)) {
        if (gains == 0) part *= 0.3;
        gains = 0;
        continue;
      }
      ++gains;
      last = std::exchange(poses_, std::move(tried));
      keep();
      reached = extended;
      ascent_ = part * mechanism_.aim();
      // Distant aims cost halved moves. The aim comes nearer if moves already have full length.
      part = moved < 0.5 * stateLength_ ? std::min(kGrowth * part, kWider) : part / kGrowth;
    }
  }

  /// Moves from the end of extend() to the maximum, to rounding.
  void refine() {
    const std::vector<brick::Brick>& bricks = mechanism_.bricks();
    const Poses before = poses_;
    Poses at = poses_, best = poses_;
    double least = std::numeric_limits<double>::infinity();
    Mixing mixing;
    for (int vain = 0; vain < kMaxVainMoves && mayContinue(); ++vain) {
      Poses moved = mechanism_.step(at, spread(at, pieces_, ascent_), budget_);
      if (isRounded()) mechanism_.settle(moved, budget_);
      mechanism_.restore(symmetries_, moved);
      const Eigen::VectorXd move = run::displacement(bricks, at, moved);
      if (move.norm() < least) {
        least = move.norm();
        best = moved;
        vain = 0;
      }
      at = displaced(bricks, before, mixing.next(run::displacement(bricks, before, at), move));
    }
    const bool isNear = run::pathDistance(bricks, before, best) < kFarthestRefined * stateLength_;
    if (!isNear || extent(best, pieces_) < (1 - kNoGain) * extent(before, pieces_)) return;
    poses_ = std::move(best);
    keep();
  }

  /// Without contacts, nothing fixes the position of a piece; see withoutDrift().
  void removeDrift() {
    const bool isPlanar = scene::sceneNeeds(scene_).planar.on;
    for (std::size_t k = 1; k < path_.states.size(); ++k) {
      path_.states[k] = withoutDrift(mechanism_.bricks(), path_.states.front(), pieces_, isPlanar,
                                     std::move(path_.states[k]));
    }
    poses_ = path_.states.back();
    path_.lengths = run::pathLengths(mechanism_.bricks(), path_.states);
  }

  /// The longest path, metres, that may be due to overlaps which contacts tolerate. Bricks that
  /// lock each other to second order move by x if they overlap by x^2 / 2 of a tile.
  double creep() const {
    if (!isTouching()) return 0;
    const std::vector<brick::Pivot> pivots =
        brick::makePivots(scene_.model.joints, mechanism_.bricks());
    const double overlap =
        run::overlapMeter(scene_.environment, mechanism_.bricks(), pivots, path_.states.front())
            .grownAt(poses_);
    return std::sqrt(2 * tile_ * overlap);
  }

  /// Removes the states near the last one: there they oscillate with hardly any gain in extent.
  void omitRest() {
    const auto distanceToLast = [&](std::size_t state) {
      return run::pathDistance(mechanism_.bricks(), path_.states[state], poses_);
    };
    std::size_t kept = path_.states.size() - 1;
    if (kept == 0) return;
    while (kept > 1 && distanceToLast(kept - 1) < kResting * stateLength_) --kept;
    path_.states.resize(kept);
    path_.lengths.resize(kept);
    keep();
  }

  /// Rotates all tiles a little in the same sense and extends them again. This keeps rotational
  /// symmetry but breaks mirror symmetry. Of both senses the one that extends farther counts:
  /// a mirrored sheet takes the opposite one. Returns whether the extent grew. If not, the state is
  /// restored.
  bool leaveSaddle() {
    const ExtensionState before{poses_, path_, ascent_, mechanism_.aim()};
    std::optional<ExtensionState> farthest;
    double needed = (1 + kMoreExtent) * extent(poses_, pieces_);
    for (const double angle : {kPerturbation, -kPerturbation}) {
      returnTo(before);
      moveTowards(twisted(angle));
      extend();
      const double extended = extent(poses_, pieces_);
      if (!(extended > needed)) continue;
      farthest = {poses_, path_, ascent_, mechanism_.aim()};
      needed = (1 + kMoreExtent) * extended;
    }
    returnTo(farthest.value_or(before));
    return farthest.has_value();
  }

  /// The current state with all tiles rotated about their normals by an angle, radians.
  Poses twisted(double angle) const {
    Poses place = poses_;
    for (std::size_t i = 0; i < place.size(); ++i) {
      const Vector3 normal = place[i].rotation * mechanism_.bricks()[i].normal;
      place[i].rotation = Quaternion(Eigen::AngleAxisd(angle, normal)) * place[i].rotation;
    }
    return place;
  }

  void returnTo(const ExtensionState& place) {
    poses_ = place.poses;
    path_ = place.path;
    ascent_ = place.ascent;
    mechanism_.forgetMoves(place.aim);
  }

  /// Jumps to the closed state near the guide, if there is one.
  void jump(const PathGuide& guide) {
    Poses first = guide.at(settings_.jump);
    if (!mechanism_.close(first)) return;
    const double far = run::pathDistance(mechanism_.bricks(), poses_, first);
    if (far > kLongestJump * settings_.jump * path_.guideLength + stateLength_) return;
    poses_ = std::move(first);
    mechanism_.restore(symmetries_, poses_);
    keep();
    // Overlaps that the jump causes count as overlaps of the start.
    mechanism_.restart(poses_);
    progress_ = settings_.jump;
  }

  void follow(const PathGuide& guide, double largest) {
    double advance = progress_ > 0 ? std::min(progress_, largest) : kFirstProgress;
    int still = 0;
    for (; progress_ < 1 && mayContinue(); advance = std::min(kGrowth * advance, largest)) {
      progress_ = std::min(1.0, progress_ + advance);
      const double expected = advance * path_.guideLength;
      const double before = path_.length();
      const std::size_t first = path_.states.size();
      const Poses place = guide.at(progress_);
      for (int i = 0; i < kMovesAState && mayContinue(); ++i) {
        if (moveTowards(place) < kShortMove * expected) break;
      }
      still = path_.length() - before < kShortMove * expected ? still + 1 : 0;
      omitCorrections(first);
      // Compliant joints may resist their guide for many states before they open.
      path_.isStuck = still >= kStuckPlaces && (isRounded() || !settings_.areJointsCompliant());
    }
    if (settings_.areJointsCompliant()) {
      for (int i = 0; i < kMovesToSettle && mayContinue(); ++i) {
        if (moveTowards(guide.end()) < noMove()) break;
      }
      mechanism_.holdJoints(closedStiffness_);
    }
    goTo(guide.end());
    if (isRounded()) soften(guide.end());
  }

  /// Removes the states from `first` to the last but one, which lead to the point nearest to one
  /// state of the guide: as part of the path they would make it zigzag. A longer way is kept.
  void omitCorrections(std::size_t first) {
    if (first + 1 >= path_.states.size()) return;
    const double moved =
        run::pathDistance(mechanism_.bricks(), path_.states[first - 1], path_.states.back());
    if (moved > kLongestMove * stateLength_) return;
    path_.states.resize(first);
    path_.lengths.resize(first);
    keep();
  }

  // Moves towards the goal until the moves become negligible.
  void goTo(const Poses& goal) {
    for (int i = 0; i < kMovesAtGoal && mayContinue(); ++i) {
      if (moveTowards(goal) < noMove()) break;
    }
  }

  /// Moves below this length are negligible, metres.
  double noMove() const {
    return std::max(kNoMove * tile_, isRounded() ? kNoDigit * scene_.model.rounding : 0);
  }

  /// Comes nearer to the goal with softer joints, as long as they stay closed within the rounding.
  void soften(const Poses& goal) {
    const std::vector<brick::Pivot> pivots =
        brick::makePivots(scene_.model.joints, mechanism_.bricks());
    run::softenWhileClosed(scene_.model, [&](double stiffness) {
      const Poses before = poses_;
      const run::MechanismPath soFar = path_;
      mechanism_.holdJoints(stiffness);
      goTo(goal);
      if (trajectory::jointGap(pivots, poses_).max <= run::roundedGap(scene_.model)) return true;
      poses_ = before;
      path_ = soFar;
      return false;
    });
  }

  run::MechanismPath finish() {
    path_.symmetries = symmetries_.group();
    if (scene_.model.target) {
      path_.error = errorOf(poses_);
      if (!settings_.areJointsCompliant() && path_.error > kFarError * tile_) endAtNearest();
    }
    return std::move(path_);
  }

  double errorOf(const Poses& state) const {
    return trajectory::targetError(*scene_.model.target, mechanism_.bricks(), state);
  }

  /// If the target is out of reach, ends the path at the state that is nearest to the target.
  void endAtNearest() {
    std::size_t nearest = path_.states.size() - 1;
    for (std::size_t k = 0; k < path_.states.size(); ++k) {
      const double error = errorOf(path_.states[k]);
      if (error >= path_.error) continue;
      nearest = k;
      path_.error = error;
    }
    path_.states.resize(nearest + 1);
    path_.lengths.resize(nearest + 1);
  }

  scene::Scene scene_;
  ContinuationSettings settings_;
  double closedStiffness_;
  double tile_;  // metres
  std::vector<int> pieces_;
  Poses poses_;  // the current state
  Mechanism mechanism_;
  run::SymmetricStates symmetries_;  // symmetries that the path keeps
  double ascent_ = 0;                // relative distance of the last aim with a gain in extent
  double stateLength_ = 0;           // step of the guide from state to state, metres
  double progress_ = 0;              // along the guide, [0, 1]
  run::SearchBudget& budget_;
  const PathObserver& shouldContinue_;
  run::MechanismPath path_;
};

/// Follows a guide between two states. Neither has to be the scene's target.
run::MechanismPath followBetween(const scene::Scene& scene, std::vector<Poses> guide,
                                 const ContinuationSettings& settings, run::SearchBudget& budget,
                                 const PathObserver& shouldContinue) {
  scene::Scene between = scene;
  between.solver.planar = scene::sceneNeeds(scene).planar.on;
  between.model.target.reset();
  const double exact = std::numeric_limits<double>::infinity();
  return Continuation(between, guide.front(), settings, exact, budget, shouldContinue)
      .along(std::move(guide));
}

/// Ends a path at its state nearest to other poses.
void endNearest(const std::vector<brick::Brick>& bricks, const Poses& place,
                run::MechanismPath& path) {
  const auto nearest = std::ranges::min_element(
      path.states, {}, [&](const Poses& state) { return run::pathDistance(bricks, state, place); });
  path.states.erase(nearest + 1, path.states.end());
}

/// Whether a state with exactly closed joints lies near each state, within roundedReach().
bool closesExactly(const scene::Scene& scene, const std::vector<Poses>& states) {
  const scene::Scene bare = scene::withoutEnvironment(scene);
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const auto dynamics = run::makeDynamics(bare, scene::sceneNeeds(bare), bricks, states.front());
  const double reach = run::roundedReach(scene.model);
  return std::ranges::all_of(states, [&](const Poses& state) {
    Poses closed = state;
    return dynamics->assemble(closed) && run::pathDistance(bricks, state, closed) <= reach;
  });
}

/// A test of a state for open joints: beyond roundedReach() if the coordinates are rounded.
auto testForOpenJoints(const scene::Scene& scene) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const double reach = scene.model.rounding > 0
                           ? run::roundedReach(scene.model)
                           : run::kAllowedOpening * model::tileSize(scene.model);
  return [pivots = brick::makePivots(scene.model.joints, bricks), reach](const Poses& state) {
    return trajectory::jointGap(pivots, state).max > reach;
  };
}

/// Ends a path at its last state with closed joints.
void endBeforeJointsOpen(const scene::Scene& scene, run::MechanismPath& path) {
  const auto open =
      std::ranges::find_if(path.states.begin() + 1, path.states.end(), testForOpenJoints(scene));
  if (open == path.states.end()) return;
  path.endsAtOpenJoints = true;
  path.states.erase(open, path.states.end());
  path.lengths.resize(path.states.size());
  path.guideLength = path.length();
}

/// Repeats a path with exact joints. Returns the given path, closed within the rounding, if the
/// tiles do not fit each other along the whole path. `cost` is the work that the given path took.
run::MechanismPath closedExactly(const scene::Scene& scene, run::MechanismPath rounded, double cost,
                                 run::SearchBudget& budget, const PathObserver& shouldContinue) {
  rounded.isRounded = true;
  if (rounded.isStuck || rounded.isCutShort) return rounded;
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  rounded.isStuck = std::ranges::any_of(rounded.states, testForOpenJoints(scene));
  if (rounded.isStuck || !closesExactly(scene, rounded.states)) return rounded;
  run::SearchBudget part(std::min(kExactCost * cost, budget.left()));
  run::MechanismPath exact =
      Continuation(scene, rounded.states.front(), {.jump = 0},
                   std::numeric_limits<double>::infinity(), part, shouldContinue)
          .along(rounded.states);
  budget.spend(part.spent());
  if (exact.isStuck || exact.isCutShort) return rounded;
  const double apart = run::pathDistance(bricks, exact.states.back(), rounded.states.back());
  exact.guideLength = rounded.guideLength;
  exact.endsAtOpenJoints = rounded.endsAtOpenJoints;
  return apart <= run::roundedReach(scene.model) ? exact : rounded;
}

}  // namespace

run::MechanismPath continueAlong(const scene::Scene& scene, std::vector<Poses> guide,
                                 const ContinuationSettings& settings, run::SearchBudget& budget,
                                 const PathObserver& shouldContinue) {
  const double closed = run::roundedJointStiffness(scene.model);
  const double before = budget.spent();
  run::MechanismPath path =
      Continuation(scene, guide.front(), settings, closed, budget, shouldContinue)
          .along(std::move(guide));
  if (!std::isfinite(closed) || settings.areJointsCompliant()) return path;
  return closedExactly(scene, std::move(path), budget.spent() - before, budget, shouldContinue);
}

run::MechanismPath connect(const scene::Scene& scene, std::vector<Poses> guide,
                           run::SearchBudget& budget, const PathObserver& shouldContinue) {
  return followBetween(scene, std::move(guide), {.jump = 0}, budget, shouldContinue);
}

run::MechanismPath continueFromGoal(const scene::Scene& scene, std::vector<Poses> guide,
                                    run::SearchBudget& budget, const PathObserver& shouldContinue) {
  const Poses start = guide.front();
  std::ranges::reverse(guide);
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const double near = kNoFarther * model::tileSize(scene.model);
  const auto isAtStart = [&](const run::MechanismPath& path) {
    return run::pathDistance(bricks, path.states.back(), start) <= near;
  };
  run::MechanismPath back = connect(scene, std::move(guide), budget, shouldContinue);
  endNearest(bricks, start, back);
  back.isStuck = !isAtStart(back);
  for (const double stiffness : kNearStart) {
    if (back.isCutShort || !back.isStuck) break;
    run::MechanismPath rest =
        followBetween(scene, {back.states.back(), start}, {.jump = 0, .jointStiffness = stiffness},
                      budget, shouldContinue);
    back.isCutShort = rest.isCutShort;
    if (!isAtStart(rest)) continue;
    back.isStuck = false;
    back.symmetries = std::move(rest.symmetries);
    std::move(std::next(rest.states.begin()), rest.states.end(), std::back_inserter(back.states));
  }
  std::ranges::reverse(back.states);
  if (!back.isStuck) back.states.front() = start;
  back.lengths = run::pathLengths(bricks, back.states);
  // The joints of rounded tiles may have moved the end away from the goal.
  if (scene.model.target)
    back.error = trajectory::targetError(*scene.model.target, bricks, back.states.back());
  return back;
}

run::MechanismPath continueToExtension(const scene::Scene& scene, double jointStiffness,
                                       run::SearchBudget& budget,
                                       const PathObserver& shouldContinue) {
  const Poses start =
      brick::startPoses(scene.model.tiles, brick::makeBricks(scene.model.tiles, scene.brick));
  const double closed = run::roundedJointStiffness(scene.model);
  const double before = budget.spent();
  run::MechanismPath path =
      Continuation(scene, start, {.turnWeight = 1, .jointStiffness = jointStiffness}, closed,
                   budget, shouldContinue)
          .toExtension();
  if (jointStiffness < closed) {
    path.endsAtOpenJoints = testForOpenJoints(scene)(path.states.back());
    return path;
  }
  endBeforeJointsOpen(scene, path);
  if (!std::isfinite(closed)) return path;
  return closedExactly(scene, std::move(path), budget.spent() - before, budget, shouldContinue);
}

}  // namespace kirireel::path
