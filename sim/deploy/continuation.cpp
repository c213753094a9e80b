// A path of the mechanism by the nearest points to a guide.
//
// The guide g(s), s from 0 to 1, moves each brick by itself from its start to its goal: its centre
// goes straight, and it turns evenly about one axis. It opens the joints. Of all states with closed
// joints, c(q) = 0, the one nearest to g(s) is sought, from the one before:
//   minimise |q - g(s)|_W  with  c(q) = 0  and  phi(q) >= 0,
// phi the gaps of contacts, and W = diag(1, w rho^2) for each brick: places count once, turns by
// their arc at the radius of gyration rho, weighted w. One move is the step
//   minimise |u - (g(s) - q)|_W  with  J u = 0,  C u >= -phi,
// followed by closing the joints again, which is what the joint solver does in a step of unit time
// from the velocities g(s) - q, with W for its masses and without forces: Gauss-Newton for the
// nearest point. The contact finder sweeps each move, so that no brick passes through another
// however long the move. s goes on by equal parts: where the mechanism follows its guide, the path
// is even.
//
// A move aims at the part t of the way, 1 where the mechanism is straight. On a curved one
//   |q' - g|^2 = |q - g|^2 - 2 m^2 / t + c m^2,  m = |q' - q|,
// c of the curvature, and t = 1 / c leads to the nearest point: a farther move would swing from one
// side of it to the other. Each move says c for the next. Where closing would undo too much of a
// move, or bricks have no room, it is made again and aims at half of the way.
//
// Compliant joints replace c(q) = 0 by a spring energy: the state minimises
//   |q - g(s)|_W^2 + r |c(q)|^2,  r the stiffness of a joint over the weight of a place,
// so that a design without freedom leaves its start, its joints open where they must. In a model
// whose coordinates were rounded that is what "closed" means, with r from the rounding: see
// assembled_state.h.
//
// Full extension is sought by gradient ascent of the sum of squared distances from the common
// centre on the mechanism, with momentum: Nesterov (1983), Soviet Math. Doklady 27.
//
// Nearest points are followed as in predictor-corrector continuation: Allgower, Georg (1990),
// Introduction to Numerical Continuation Methods, chapters 2 and 6.
#include "sim/deploy/continuation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <ranges>
#include <utility>

#include "sim/deploy/assembled_state.h"
#include "sim/deploy/dynamics.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel::deploy {
namespace {

// The guide moves on by this part of a tile from state to state, in so many states.
// Lengths below are in parts of a tile or of a state; a state is the distance from one kept state
// to the next.
constexpr double kStateShare = 0.02;
constexpr double kMostStates = 200;
// A leap may be so much longer than its guide's, and the length of a state more.
constexpr double kLongestLeap = 4;
// Without a leap progress begins with this, and grows by a factor from state to state.
constexpr double kFirstProgress = 1e-5;
constexpr double kGrowth = 1.3;
// Moves towards one place of the guide, and towards the goal.
constexpr int kMovesAState = 4;
constexpr int kMovesAtGoal = 300;
// Moves towards the goal before compliant joints close.
constexpr int kMovesToSettle = 60;
// A move longer than so many states of the guide is made again, shorter.
constexpr double kLongestMove = 3;
// A move shorter than this part of a state needs no further one.
constexpr double kShortMove = 0.05;
// At the goal a move below this part of a tile is none.
constexpr double kNoMove = 1e-10;
// So many places of the guide with hardly a move in a row: the bricks are stuck.
constexpr int kStuckPlaces = 8;
// An error at the end above this part of a tile: another state may be nearer to the target.
constexpr double kFarError = 1e-6;
// A move that fails, is too long, or leads away from its place, aims at half of the way, and so on
// down to these parts of it; the next moves aim farther again.
constexpr double kLeastAim = 1e-6;
constexpr double kLeastGood = 1.0 / 16;
constexpr double kAimGrowth = 1.5;
// Of the distance from a place, or of a tile: so little is neither nearer nor farther.
constexpr double kNoFarther = 1e-6;
// While extending, the place is so many reaches away, and below this reach the bricks are stuck.
constexpr double kReach = 5;
constexpr double kLeastReach = 1e-6;
// Towards full extension, places are at first this part of the usual distance away, and at most so
// much farther from the centre than the state.
constexpr double kFirstReach = 1e-3;
constexpr double kWider = 1.0;
// A state on the way is at least this part of the tiles' root mean square distance from their
// centre.
constexpr double kRadiusStates = 100;
// A path ends with a move of at least this part of a state.
constexpr double kResting = 0.5;
constexpr double kNoGain = 1e-12;  // of the sum of squares, relative
constexpr int kMostExtending = 2000;
// Within the rounding of the coordinates a move below this part of the last digit is none.
constexpr double kNoDigit = 0.1;
// Exact joints may cost so many times what a path of rounded ones did.
constexpr double kExactCost = 4;
// Moves that close compliant joints beyond the first order, at most.
constexpr int kSettlingMoves = 4;
// Joints near a flush start, over the weight of a place, until the start is reached. On caps of 64
// to 144 tiles 1e4 opens joints least, by 2e-4 to 3e-3 of a tile; where it wedges, softer ones do.
constexpr double kNearStart[] = {1e4, 1e3, 1e2};
// A saddle is left by a turn of so many radians, and where that gains so much extent.
constexpr double kNudge = 0.02;
constexpr double kMoreExtent = 1e-6;

/// The same bricks with the metric of the path in place of their masses.
std::vector<model::Brick> metricBricks(const scene::Scene& scene, double turnWeight) {
  std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  for (model::Brick& brick : bricks) {
    const double radius = gyrationRadius(brick);
    brick.mass = 1;
    brick.inertia = turnWeight * radius * radius * Matrix3::Identity();
  }
  return bricks;
}

scene::Scene withoutLoads(scene::Scene scene) {
  scene.environment.gravity.setZero();
  scene.environment.brickFriction = 0;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.solver = scene::SolverSettings{.planar = scene.solver.planar};
  return scene;
}

Vector3 commonCentre(const Poses& poses) {
  Vector3 sum = Vector3::Zero();
  for (const Pose& pose : poses) sum += pose.position;
  return sum / static_cast<double>(poses.size());
}

/// The mean place of the bricks of each piece; `pieces` are those of model::piecesOf().
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

/// Each brick farther from the centre of its piece by a part.
Poses spread(Poses poses, const std::vector<int>& pieces, double part) {
  const std::vector<Vector3> centres = centresOf(poses, pieces);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].position += part * (poses[i].position - centres[pieces[i]]);
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

/// The mechanism in one metric, moved from place to place.
class Mechanism {
 public:
  Mechanism(const scene::Scene& scene, const ContinuationSettings& settings, const Poses& start)
      : scene_(scene),
        jointStiffness_(settings.jointStiffness),
        turnWeight_(settings.turnWeight),
        tile_(model::tileSize(scene.model)),
        bricks_(metricBricks(scene, settings.turnWeight)) {
    restart(start);
  }

  // Forgets contacts: overlaps at these poses count as those of a start.
  void restart(const Poses& start) {
    dynamics_ = makeDynamics(scene_, scene::sceneNeeds(scene_), bricks_, start);
    dynamics_->setJointStiffness(jointStiffness_);
    dynamics_->setHalving(isTouching());
  }

  /// Holds joints by this over the stiffness of the pull from now on.
  void holdJoints(double stiffness) {
    jointStiffness_ = stiffness;
    dynamics_->setJointStiffness(jointStiffness_);
  }

  /// Closes compliant joints beyond the first order, moving bricks as little as that takes: one
  /// move is one step of Gauss-Newton, which leaves gaps of half the square of the turns.
  void settle(Poses& poses, SearchBudget& budget) {
    for (int i = 0; i < kSettlingMoves; ++i) {
      const double moved = move(poses, poses, std::numeric_limits<double>::infinity(), budget);
      if (moved <= scene_.model.rounding) return;
    }
  }

  const std::vector<model::Brick>& bricks() const { return bricks_; }
  bool close(Poses& poses) { return closeInPlace(poses, *dynamics_); }
  void restore(const SymmetricStates& symmetries, Poses& poses) {
    symmetries.restore(poses, *dynamics_);
  }

  /// Moves towards a place, at most about `longest` metres. Returns how far, metres.
  double move(Poses& poses, const Poses& place, double longest, SearchBudget& budget) {
    const double before = distance(poses, place);
    for (bool isFirst = true;; isFirst = false) {
      Motion motion{poses, aimedAt(poses, place)};
      const StepReport report = dynamics_->advance(motion, 1, withoutForces);
      budget.spend(report.work);
      const double moved = pathDistance(bricks_, poses, motion.poses);
      const double after = distance(motion.poses, place);
      // Among contacts the solver has tried a failed move in halves.
      const bool isGood = (report.unconverged == 0 || isTouching()) &&
                          (!isExact() || after <= (1 + kNoFarther) * before + kNoFarther * tile_);
      const bool isTaken = isGood || (moved > 0 && aim_ <= kLeastGood);
      if ((isTaken && !(moved > longest)) || aim_ <= kLeastAim) {
        if (isFirst) aimNext(report, before, distance(poses, motion.poses), after);
        poses = std::move(motion.poses);
        return moved;
      }
      aim_ *= moved > longest ? std::min(0.5, 0.5 * longest / moved) : 0.5;
    }
  }

 private:
  bool isExact() const { return std::isinf(jointStiffness_); }
  bool isTouching() const { return scene_.environment.contacts != scene::ContactFilter::None; }

  /// From a state to a place, in the metric of the mechanism, metres.
  double distance(const Poses& state, const Poses& place) const {
    return pathDistance(bricks_, state, place, turnWeight_);
  }

  /// Says how far the next move aims, from how far the last one led: see the head of this file.
  void aimNext(const StepReport& report, double before, double moved, double after) {
    double best = 1;
    if (isExact() && moved > kNoFarther * before) {
      const double gained = 0.5 * (before - after) * (before + after) / (moved * moved);
      best = 1 / std::max(1.0, 2 * (1 / aim_ - gained));
    }
    if (report.halved > 0) best = std::min(best, 0.5 * aim_);
    aim_ = std::clamp(best, 0.5 * aim_, std::min(1.0, kAimGrowth * aim_));
  }

  /// The velocities that take free bricks so far on the way to a place in a second.
  std::vector<Velocity> aimedAt(const Poses& from, const Poses& place) const {
    std::vector<Velocity> velocities;
    for (std::size_t i = 0; i < from.size(); ++i) {
      velocities.push_back({aim_ * (place[i].position - from[i].position),
                            aim_ * turnBetween(from[i].rotation, place[i].rotation)});
    }
    return velocities;
  }

  static void withoutForces(const Poses&, std::vector<model::Load>& loads) {
    std::ranges::fill(loads, model::Load{});
  }

  const scene::Scene& scene_;
  double jointStiffness_;  // over the bricks' unit mass and the unit time squared
  double turnWeight_;
  double tile_;     // metres
  double aim_ = 1;  // the part of the way to a place that moves aim at, up to 1
  std::vector<model::Brick> bricks_;
  std::unique_ptr<Dynamics> dynamics_;
};

class Continuation {
 public:
  /// `closedStiffness`: of joints that are closed, as ContinuationSettings::jointStiffness.
  Continuation(const scene::Scene& scene, Poses start, const ContinuationSettings& settings,
               double closedStiffness, SearchBudget& budget, const PathObserver& shouldContinue)
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

  /// Follows the given states from the first, closed, to the last.
  // A leap off the singular start, then state by state.
  MechanismPath along(std::vector<Poses> states) {
    states.front() = poses_;
    for (const Poses& state : states) symmetries_.keepThoseOf(state);
    for (Poses& state : states) state = model::symmetricMean(state, symmetries_.group());
    const PathGuide guide(mechanism_.bricks(), std::move(states));
    path_.guideLength = guide.length();
    const double count =
        std::clamp(path_.guideLength / (kStateShare * tile_), kLeastStates, kMostStates);
    stateLength_ = path_.guideLength / count;
    if (stateLength_ > 0) {
      if (settings_.leap > 0 && !settings_.areJointsCompliant()) leap(guide);
      follow(guide, 1 / count);
    }
    return finish();
  }

  MechanismPath toExtension() {
    const double radius = pathDistance(mechanism_.bricks(), poses_, spread(poses_, pieces_, 1));
    if (radius == 0) return finish();  // loose tiles
    stateLength_ = std::max(kStateShare * tile_, radius / kRadiusStates);
    extend();
    // Where nothing extends the tiles, they stand at a maximum or, often by symmetry, at a saddle.
    while (mayContinue() && leaveSaddle()) continue;
    leaveOutRest();
    path_.guideLength = path_.length();
    return finish();
  }

 private:
  static ContinuationSettings heldBy(ContinuationSettings settings, double closedStiffness) {
    settings.jointStiffness = std::min(settings.jointStiffness, closedStiffness);
    return settings;
  }

  /// Whether closed joints are so within the rounding of the coordinates.
  bool isRounded() const {
    return settings_.jointStiffness == closedStiffness_ && settings_.areJointsCompliant();
  }

  bool mayContinue() {
    path_.isCutShort =
        path_.isCutShort || budget_.isSpent() || (shouldContinue_ && !shouldContinue_(progress_));
    return !path_.isCutShort && !path_.isStuck;
  }

  void keep() {
    const bool isFirst = path_.states.empty();
    const double length =
        isFirst ? 0
                : path_.length() + pathDistance(mechanism_.bricks(), path_.states.back(), poses_);
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

  /// Moves the tiles apart until nothing extends them any more.
  void extend() {
    const double whole = pathDistance(mechanism_.bricks(), poses_, spread(poses_, pieces_, 1));
    const double widest = kReach * stateLength_ / whole;
    // Bricks that lie flush part by tiny moves, and would wedge by larger ones.
    double part = kFirstReach * widest;
    double reached = extent(poses_, pieces_);
    Poses last = poses_;
    int gains = 0;  // in a row
    for (int i = 0; i < kMostExtending && part > kLeastReach * widest && mayContinue(); ++i) {
      // Going on as before, more so the longer it gains.
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
      // Far places cost halved moves: they come nearer where moves are as long as they may be.
      part = moved < 0.5 * stateLength_ ? std::min(kGrowth * part, kWider) : part / kGrowth;
    }
  }

  /// Leaves out the states beside the last one: they go to and fro where the extent hardly grows.
  void leaveOutRest() {
    const auto distanceToLast = [&](std::size_t state) {
      return pathDistance(mechanism_.bricks(), path_.states[state], poses_);
    };
    std::size_t kept = path_.states.size() - 1;
    if (kept == 0) return;
    while (kept > 1 && distanceToLast(kept - 1) < kResting * stateLength_) --kept;
    path_.states.resize(kept);
    path_.lengths.resize(kept);
    keep();
  }

  /// Turns all tiles a little in one sense, which keeps a symmetry by turns but no mirror symmetry,
  /// and extends them from there. Returns whether they came farther; else they stay.
  bool leaveSaddle() {
    const Poses before = poses_;
    const MechanismPath soFar = path_;
    Poses place = poses_;
    for (std::size_t i = 0; i < place.size(); ++i) {
      const Vector3 normal = place[i].rotation * mechanism_.bricks()[i].normal;
      place[i].rotation = Quaternion(Eigen::AngleAxisd(kNudge, normal)) * place[i].rotation;
    }
    moveTowards(place);
    extend();
    if (extent(poses_, pieces_) > (1 + kMoreExtent) * extent(before, pieces_)) return true;
    poses_ = before;
    path_ = soFar;
    mechanism_.restart(poses_);
    return false;
  }

  /// Goes to the closed state near the guide, where there is one.
  void leap(const PathGuide& guide) {
    Poses first = guide.at(settings_.leap);
    if (!mechanism_.close(first)) return;
    const double far = pathDistance(mechanism_.bricks(), poses_, first);
    if (far > kLongestLeap * settings_.leap * path_.guideLength + stateLength_) return;
    poses_ = std::move(first);
    mechanism_.restore(symmetries_, poses_);
    keep();
    // The overlaps that a leap makes count as those of the start.
    mechanism_.restart(poses_);
    progress_ = settings_.leap;
  }

  void follow(const PathGuide& guide, double largest) {
    double advance = progress_ > 0 ? std::min(progress_, largest) : kFirstProgress;
    int still = 0;
    for (; progress_ < 1 && mayContinue(); advance = std::min(kGrowth * advance, largest)) {
      progress_ = std::min(1.0, progress_ + advance);
      const double wanted = advance * path_.guideLength;
      const double before = path_.length();
      const Poses place = guide.at(progress_);
      for (int i = 0; i < kMovesAState && mayContinue(); ++i) {
        if (moveTowards(place) < kShortMove * wanted) break;
      }
      still = path_.length() - before < kShortMove * wanted ? still + 1 : 0;
      // Compliant joints may wait for their guide for long before they give way.
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

  // Moves towards the goal until a move is none.
  void goTo(const Poses& goal) {
    for (int i = 0; i < kMovesAtGoal && mayContinue(); ++i) {
      if (moveTowards(goal) < noMove()) break;
    }
  }

  /// A move that is shorter is none, metres.
  double noMove() const {
    return std::max(kNoMove * tile_, isRounded() ? kNoDigit * scene_.model.rounding : 0);
  }

  /// Comes nearer to the goal by softer joints, as long as they are closed within the rounding.
  void soften(const Poses& goal) {
    const std::vector<model::Pivot> pivots =
        model::makePivots(scene_.model.joints, mechanism_.bricks());
    softenWhileClosed(scene_.model, [&](double stiffness) {
      const Poses before = poses_;
      const MechanismPath soFar = path_;
      mechanism_.holdJoints(stiffness);
      goTo(goal);
      if (trajectory::jointGap(pivots, poses_).max <= roundedGap(scene_.model)) return true;
      poses_ = before;
      path_ = soFar;
      return false;
    });
  }

  MechanismPath finish() {
    path_.symmetries = symmetries_.group();
    if (scene_.model.target) {
      path_.error = errorOf(poses_);
      if (!settings_.areJointsCompliant() && path_.error > kFarError * tile_) endWhereNearest();
    }
    return std::move(path_);
  }

  double errorOf(const Poses& state) const {
    return trajectory::targetError(*scene_.model.target, mechanism_.bricks(), state);
  }

  /// Where the target is out of reach, a path may come nearer to it than its end: it ends there.
  void endWhereNearest() {
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
  Poses poses_;  // the last state
  Mechanism mechanism_;
  SymmetricStates symmetries_;  // that the path keeps
  double stateLength_ = 0;      // of the guide from state to state, metres
  double progress_ = 0;         // along the guide, 0 to 1
  SearchBudget& budget_;
  const PathObserver& shouldContinue_;
  MechanismPath path_;
};

/// Follows a guide between two states of which neither need be the scene's target.
MechanismPath followBetween(const scene::Scene& scene, std::vector<Poses> guide,
                            const ContinuationSettings& settings, SearchBudget& budget,
                            const PathObserver& shouldContinue) {
  scene::Scene between = scene;
  between.solver.planar = scene::sceneNeeds(scene).planar.on;
  between.model.target.reset();
  const double exact = std::numeric_limits<double>::infinity();
  return Continuation(between, guide.front(), settings, exact, budget, shouldContinue)
      .along(std::move(guide));
}

/// Ends a path at its state that is nearest to a place.
void endNearest(const std::vector<model::Brick>& bricks, const Poses& place, MechanismPath& path) {
  const auto nearest = std::ranges::min_element(
      path.states, {}, [&](const Poses& state) { return pathDistance(bricks, state, place); });
  path.states.erase(nearest + 1, path.states.end());
}

/// Measures a path anew whose states have changed.
void measureLengths(const std::vector<model::Brick>& bricks, MechanismPath& path) {
  path.lengths = {0};
  for (std::size_t k = 1; k < path.states.size(); ++k) {
    path.lengths.push_back(path.length() +
                           pathDistance(bricks, path.states[k - 1], path.states[k]));
  }
}

/// Whether each state has one with joints closed exactly beside it, within the rounding's reach.
bool closesExactly(const scene::Scene& scene, const std::vector<Poses>& states) {
  const scene::Scene alone = [&] {
    scene::Scene copy = scene;
    copy.environment = scene::Environment{};
    return copy;
  }();
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const auto dynamics = makeDynamics(alone, scene::sceneNeeds(alone), bricks, states.front());
  const double reach = roundedReach(scene.model);
  return std::ranges::all_of(states, [&](const Poses& state) {
    Poses closed = state;
    return dynamics->assemble(closed) && pathDistance(bricks, state, closed) <= reach;
  });
}

/// Ends a path at its last state before joints open by more than the rounding of the coordinates
/// explains; see roundedReach().
void endBeforeJointsOpen(const scene::Scene& scene, MechanismPath& path) {
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<model::Pivot> pivots = model::makePivots(scene.model.joints, bricks);
  const auto isOpen = [&](const Poses& state) {
    return trajectory::jointGap(pivots, state).max > roundedReach(scene.model);
  };
  const auto open = std::ranges::find_if(path.states.begin() + 1, path.states.end(), isOpen);
  if (open == path.states.end()) return;
  path.endsAtOpenJoints = true;
  path.states.erase(open, path.states.end());
  path.lengths.resize(path.states.size());
  path.guideLength = path.length();
}

/// A path whose joints close within the rounding of the coordinates, which cost that much work:
/// with exact joints where the tiles fit each other all along it.
MechanismPath closedExactly(const scene::Scene& scene, MechanismPath rounded, double cost,
                            SearchBudget& budget, const PathObserver& shouldContinue) {
  rounded.isRounded = true;
  if (rounded.isStuck || rounded.isCutShort) return rounded;
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<model::Pivot> pivots = model::makePivots(scene.model.joints, bricks);
  rounded.isStuck = std::ranges::any_of(rounded.states, [&](const Poses& state) {
    return trajectory::jointGap(pivots, state).max > roundedReach(scene.model);
  });
  if (rounded.isStuck || !closesExactly(scene, rounded.states)) return rounded;
  SearchBudget part(std::min(kExactCost * cost, budget.left()));
  MechanismPath exact = Continuation(scene, rounded.states.front(), {.leap = 0},
                                     std::numeric_limits<double>::infinity(), part, shouldContinue)
                            .along(rounded.states);
  budget.spend(part.spent());
  if (exact.isStuck || exact.isCutShort) return rounded;
  const double apart = pathDistance(bricks, exact.states.back(), rounded.states.back());
  exact.guideLength = rounded.guideLength;
  exact.endsAtOpenJoints = rounded.endsAtOpenJoints;
  return apart <= roundedReach(scene.model) ? exact : rounded;
}

}  // namespace

double gyrationRadius(const model::Brick& brick) {
  double sum = 0;
  for (const Vector3& point : brick.bottom) sum += point.squaredNorm();
  return std::sqrt(sum / static_cast<double>(brick.bottom.size()));
}

trajectory::PenetrationMeter overlapMeter(const scene::Environment& environment,
                                          const std::vector<model::Brick>& bricks,
                                          std::span<const model::Pivot> pivots,
                                          const Poses& start) {
  const bool countsJoined = environment.contacts != scene::ContactFilter::Unjoined;
  return {bricks, pivots, environment.pivotZone, start, 0, countsJoined};
}

bool closeInPlace(Poses& poses, Dynamics& dynamics) {
  const Vector3 centre = commonCentre(poses);
  if (!dynamics.assemble(poses)) return false;
  const Vector3 drift = commonCentre(poses) - centre;
  for (Pose& pose : poses) pose.position -= drift;
  return true;
}

double pathDistance(const std::vector<model::Brick>& bricks, const Poses& from, const Poses& to,
                    double turnWeight) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const double radius = gyrationRadius(bricks[i]);
    sum +=
        (to[i].position - from[i].position).squaredNorm() +
        turnWeight * radius * radius * turnBetween(from[i].rotation, to[i].rotation).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(bricks.size()));
}

MechanismPath continueAlong(const scene::Scene& scene, std::vector<Poses> guide,
                            const ContinuationSettings& settings, SearchBudget& budget,
                            const PathObserver& shouldContinue) {
  const double closed = roundedJointStiffness(scene.model);
  const double before = budget.spent();
  MechanismPath path = Continuation(scene, guide.front(), settings, closed, budget, shouldContinue)
                           .along(std::move(guide));
  if (!std::isfinite(closed) || settings.areJointsCompliant()) return path;
  return closedExactly(scene, std::move(path), budget.spent() - before, budget, shouldContinue);
}

MechanismPath connect(const scene::Scene& scene, std::vector<Poses> guide, SearchBudget& budget,
                      const PathObserver& shouldContinue) {
  return followBetween(scene, std::move(guide), {.leap = 0}, budget, shouldContinue);
}

MechanismPath continueFromGoal(const scene::Scene& scene, const Poses& start, const Poses& goal,
                               SearchBudget& budget, const PathObserver& shouldContinue) {
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const double near = kNoFarther * model::tileSize(scene.model);
  const auto isAtStart = [&](const MechanismPath& path) {
    return pathDistance(bricks, path.states.back(), start) <= near;
  };
  MechanismPath back = connect(scene, {goal, start}, budget, shouldContinue);
  endNearest(bricks, start, back);
  back.isStuck = !isAtStart(back);
  for (const double stiffness : kNearStart) {
    if (back.isCutShort || !back.isStuck) break;
    MechanismPath rest =
        followBetween(scene, {back.states.back(), start}, {.leap = 0, .jointStiffness = stiffness},
                      budget, shouldContinue);
    back.isCutShort = rest.isCutShort;
    if (!isAtStart(rest)) continue;
    back.isStuck = false;
    back.symmetries = std::move(rest.symmetries);
    std::move(std::next(rest.states.begin()), rest.states.end(), std::back_inserter(back.states));
  }
  std::ranges::reverse(back.states);
  if (!back.isStuck) back.states.front() = start;
  measureLengths(bricks, back);
  if (scene.model.target) back.error = trajectory::targetError(*scene.model.target, bricks, goal);
  return back;
}

MechanismPath continueToExtension(const scene::Scene& scene, SearchBudget& budget,
                                  const PathObserver& shouldContinue) {
  const Poses start =
      model::startPoses(scene.model.tiles, model::makeBricks(scene.model.tiles, scene.brick));
  const double closed = roundedJointStiffness(scene.model);
  const double before = budget.spent();
  MechanismPath path =
      Continuation(scene, start, {.turnWeight = 1}, closed, budget, shouldContinue).toExtension();
  if (!std::isfinite(closed)) return path;
  endBeforeJointsOpen(scene, path);
  return closedExactly(scene, std::move(path), budget.spent() - before, budget, shouldContinue);
}

// ------------------------------------------------------------------------------------------------
// q(s) = argmin |q - ((1 - s) q0 + s q1)|_M subject to c(q) = 0: the straight state between two
// samples, projected on the joints in the metric of the masses by Gauss-Newton steps (Hairer,
// Lubich and Wanner, Geometric Numerical Integration, 2006, IV.4). The straight state is wrong by
// the square of the step, so two or three steps close it to rounding.

namespace {

/// Joints count as closed below this part of a tile, here as in a run's figures.
constexpr double kClosedJoints = 1e-9;
/// Closing moves the bricks by less than this part of the way between the samples, unless it leads
/// to another branch of the mechanism.
constexpr double kMostClosing = 0.5;
/// A brick moves in the plane when it leaves it by less than this, tiles and radians.
constexpr double kInPlane = 1e-9;

// Whether all bricks are upright and only turn about the vertical, at one height, from one sample
// to the next. A run in the plane has to be interpolated in the plane: solved in space, rounding
// could tilt its bricks.
bool movesInPlane(const std::vector<model::Brick>& bricks, const Poses& from, const Poses& to,
                  double tileSize) {
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Vector3 normal = from[i].rotation * bricks[i].normal;
    if (normal.head<2>().norm() > kInPlane) return false;
    if (turnBetween(from[i].rotation, to[i].rotation).head<2>().norm() > kInPlane) return false;
    if (std::abs(to[i].position.z() - from[i].position.z()) > kInPlane * tileSize) return false;
  }
  return true;
}

/// The largest turn of any brick from one state to another, radians.
double largestTurn(const Poses& from, const Poses& to) {
  double largest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    largest = std::max(largest, from[i].rotation.angularDistance(to[i].rotation));
  }
  return largest;
}

}  // namespace

StateInterpolator::StateInterpolator(const model::Model& model,
                                     const std::vector<model::Brick>& bricks)
    : model_(model),
      bricks_(bricks),
      pinned_(bricks.size(), false),
      pivots_(model::makePivots(model.joints, bricks)),
      tileSize_(model::tileSize(model)) {}

// Samples whose joints were compliant are open; they are not closed between.
bool StateInterpolator::areClosed(const Poses& poses) const {
  return trajectory::jointGap(pivots_, poses).max <= kClosedJoints * tileSize_;
}

void StateInterpolator::setPinned(const std::vector<int>& tiles) {
  pinned_.assign(bricks_.size(), false);
  for (const int tile : tiles) pinned_[static_cast<std::size_t>(tile)] = true;
}

// A solver for the plane or for space, made at its first use and kept: making one plans the
// factorisation.
mechanics::JointSolver& StateInterpolator::solverFor(const Poses& from, const Poses& to) {
  const bool planar = movesInPlane(bricks_, from, to, tileSize_);
  std::unique_ptr<mechanics::JointSolver>& solver = planar ? inPlane_ : inSpace_;
  if (!solver) {
    solver = mechanics::makeJointSolver(
        bricks_, pivots_, {.planar = planar, .lengthScale = tileSize_, .supports = {}});
  }
  solver->setPinned(pinned_);
  return *solver;
}

// The closed state nearest to the straight one. Where the joints do not close, or closing leads far
// away, the nearer of the two samples is taken instead: it is at least a state of the run.
Poses StateInterpolator::closedBetween(const Poses& from, const Poses& to, double share) {
  const Poses straight = interpolate(from, to, share);
  Poses closed = straight;
  const double gap = solverFor(from, to).assemble(closed);
  const double way = pathDistance(bricks_, from, to);
  const double moved = pathDistance(bricks_, straight, closed);
  if (gap <= kClosedJoints * tileSize_ && moved <= kMostClosing * way) return closed;
  return share < 0.5 ? from : to;
}

// The time and the poses are interpolated, and the measures are computed anew from the poses.
// Everything else is that of the earlier sample, its pins included.
trajectory::Sample StateInterpolator::between(const trajectory::Sample& from,
                                              const trajectory::Sample& to, double share) {
  if (share <= 0) return from;
  if (share >= 1) return to;
  trajectory::Sample sample = from;
  sample.time = from.time + share * (to.time - from.time);
  setPinned(from.pinned);
  const bool mustClose = !pivots_.empty() && areClosed(from.poses) && areClosed(to.poses);
  sample.poses = mustClose ? closedBetween(from.poses, to.poses, share)
                           : interpolate(from.poses, to.poses, share);
  sample.jointGap = trajectory::jointGap(pivots_, sample.poses).max;
  const std::optional<std::vector<model::Tile>>& target = model_.target;
  if (target) sample.targetError = trajectory::targetError(*target, bricks_, sample.poses);
  return sample;
}

std::vector<Poses> StateInterpolator::momentsBetween(const Poses& from, const Poses& to) {
  if (!(largestTurn(from, to) <= kMostTurnBetween)) return {};  // also when not a number
  const std::array<Poses, 2> straight = {interpolate(from, to, 1.0 / 3),
                                         interpolate(from, to, 2.0 / 3)};
  std::array<Poses, 2> closed = straight;
  if (!pivots_.empty() && areClosed(from) && areClosed(to)) {
    setPinned({});
    double gap = 0;
    for (Poses& poses : closed) gap = std::max(gap, solverFor(from, to).assemble(poses));
    if (gap > kClosedJoints * tileSize_) closed = straight;
  }
  return momentsThrough(from, closed, to);
}

// p(s) = open(s) + b(s) (closed(1/3) - open(1/3)) + b(1 - s) (closed(2/3) - open(2/3)) with
// b(s) = 27/2 s (1 - s) (2/3 - s), rotations by rotation vectors. Joints open by the fourth power
// of the turn.
void moveByThirds(Poses& poses, double share, const std::array<Poses, 2>& open,
                  const std::array<Poses, 2>& closed) {
  const double whole = 13.5 * share * (1 - share);
  const std::array<double, 2> bulges = {whole * (2.0 / 3 - share), whole * (share - 1.0 / 3)};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Vector3 turn = Vector3::Zero();
    for (std::size_t third = 0; third < 2; ++third) {
      const Pose &from = open[third][i], &to = closed[third][i];
      poses[i].position += bulges[third] * (to.position - from.position);
      turn += bulges[third] * turnBetween(from.rotation, to.rotation);
    }
    poses[i].rotation = (rotationFromVector(turn) * poses[i].rotation).normalized();
  }
}

std::vector<Poses> momentsThrough(const Poses& from, const std::array<Poses, 2>& thirds,
                                  const Poses& to) {
  const std::array<Poses, 2> straight = {interpolate(from, to, 1.0 / 3),
                                         interpolate(from, to, 2.0 / 3)};
  std::vector<Poses> moments;
  for (int k = 1; k <= kMomentsBetween; ++k) {
    const double share = static_cast<double>(k) / (kMomentsBetween + 1);
    moveByThirds(moments.emplace_back(interpolate(from, to, share)), share, straight, thirds);
  }
  return moments;
}

}  // namespace kirireel::deploy
