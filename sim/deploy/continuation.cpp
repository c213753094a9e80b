// A path of the mechanism by the nearest points to a guide.
//
// The guide g(s), s from 0 to 1, moves each brick by itself from its start to its goal: its centre
// goes straight, and it turns evenly about one axis. It opens the joints. Of all states with closed
// joints, c(q) = 0, the one nearest to g(s) is sought, from the one before:
//   minimise |q - g(s)|_W  with  c(q) = 0  and  phi(q) >= 0,
// phi the gaps of contacts, and W = diag(1, w rho^2) for each brick: places count once, turns by
// their arc at the radius of gyration rho, weighted w. One move is the step
//   minimise |u - (g(s) - q)|_W  with  J u = 0,  C u >= -phi,
// followed by closing the joints again, which is what the joint solver does in a step from rest
// with W for its masses and a stiff spring from q to g(s). The solver's contact finder sweeps each
// move, so that no brick passes through another however long the move. s goes on by equal parts:
// where the mechanism follows its guide, the path is even.
//
// Nearest points are followed as in predictor-corrector continuation: Allgower, Georg (1990),
// Introduction to Numerical Continuation Methods, chapters 2 and 6.
#include "sim/deploy/continuation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "sim/deploy/dynamics.h"
#include "sim/measure/measures.h"

namespace kirireel {
namespace {

// The guide moves on by this part of a tile from state to state, in so many states.
constexpr double kStateShare = 0.02;
constexpr double kLeastStates = 60;
constexpr double kMostStates = 200;
// A leap may be so much longer than its guide's, and the length of a state more.
constexpr double kLongestLeap = 4;
// Without a leap progress begins with this, and grows by a factor from state to state.
constexpr double kFirstProgress = 1e-5;
constexpr double kGrowth = 1.3;
// Moves towards one place of the guide, and towards the goal.
constexpr int kMovesAState = 4;
constexpr int kMovesAtGoal = 300;
// A move longer than so many states of the guide is made again, shorter.
constexpr double kLongestMove = 3;
// A move shorter than this part of a state needs no further one.
constexpr double kShortMove = 0.05;
// At the goal a move below this part of a tile is none.
constexpr double kNoMove = 1e-10;
// So many places of the guide with hardly a move in a row: the bricks are stuck.
constexpr int kStuckPlaces = 8;
// While opening, a move shorter than this part of its reach halves the reach.
constexpr double kOpened = 0.1;
// The pull towards the guide over mass and time squared: a move goes all but this part of the way.
constexpr double kPull = 1e4;
constexpr double kWeakestPull = 1e-6;
// While opening, the place is so many reaches away, and below this reach the bricks are stuck.
constexpr double kReach = 5;
constexpr double kLeastReach = 1e-6;
// Towards full extension, places are at most so much farther from the centre than the state.
constexpr double kWider = 1.0;
constexpr double kNoGain = 1e-12;  // of the sum of squares, relative
constexpr int kMostExtending = 2000;

double gyrationRadius(const Brick& brick) {
  double sum = 0;
  for (const Vector3& point : brick.bottom) sum += point.squaredNorm();
  return std::sqrt(sum / static_cast<double>(brick.bottom.size()));
}

/// The same bricks with the metric of the path in place of their masses.
std::vector<Brick> metricBricks(const Scene& scene, double turnWeight) {
  std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  for (Brick& brick : bricks) {
    const double radius = gyrationRadius(brick);
    brick.mass = 1;
    brick.inertia = turnWeight * radius * radius * Matrix3::Identity();
  }
  return bricks;
}

Scene withoutLoads(Scene scene) {
  scene.environment.gravity.setZero();
  scene.environment.brickFriction = 0;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.solver = SolverSettings{.planar = scene.solver.planar};
  return scene;
}

/// Each brick farther from the common centre by a part.
Poses spread(Poses poses, double part) {
  Vector3 centre = Vector3::Zero();
  for (const Pose& pose : poses) centre += pose.position / static_cast<double>(poses.size());
  for (Pose& pose : poses) pose.position += part * (pose.position - centre);
  return poses;
}

/// The sum of squared distances from the common centre, square metres.
double extent(const Poses& poses) {
  Vector3 sum = Vector3::Zero();
  double squares = 0;
  for (const Pose& pose : poses) {
    sum += pose.position;
    squares += pose.position.squaredNorm();
  }
  return squares - sum.squaredNorm() / static_cast<double>(poses.size());
}

/// The mechanism in one metric, moved from place to place.
class Mechanism {
 public:
  Mechanism(const Scene& scene, double turnWeight, const Poses& start)
      : scene_(scene),
        bricks_(metricBricks(scene, turnWeight)),
        dynamics_(makeDynamics(scene_, sceneNeeds(scene_), bricks_, start)) {}

  void restart(const Poses& start) {
    dynamics_ = makeDynamics(scene_, sceneNeeds(scene_), bricks_, start);
  }

  const std::vector<Brick>& bricks() const { return bricks_; }
  bool close(Poses& poses) { return dynamics_->assemble(poses); }

  /// Moves towards a place, at most about `longest` metres. Turns are left free unless `turns`.
  /// Returns how far, metres.
  double move(Poses& poses, const Poses& place, double longest, bool turns, SearchBudget& budget) {
    double pull = kPull;
    for (;;) {
      Motion motion{poses, std::vector<Velocity>(poses.size())};
      const LoadSource loads = [&](const Poses& from, std::vector<Load>& to) {
        for (std::size_t i = 0; i < from.size(); ++i)
          to[i] = towards(from[i], place[i], pull, turns ? pull * bricks_[i].inertia(0, 0) : 0);
      };
      budget.spend(dynamics_->advance(motion, 1, loads).work);
      const double moved = pathDistance(bricks_, poses, motion.poses);
      if (!(moved > longest) || pull < kWeakestPull) {
        poses = std::move(motion.poses);
        return moved;
      }
      // A move goes pull / (1 + pull) of the way.
      const double share = std::min(0.5, 0.5 * pull / (1 + pull) * longest / moved);
      pull = share / (1 - share);
    }
  }

 private:
  static Load towards(const Pose& from, const Pose& to, double pull, double turning) {
    Load load;
    load.force.head<3>() = pull * (to.position - from.position);
    load.force.tail<3>() = turning * turnBetween(from.rotation, to.rotation);
    load.stiffness.diagonal().head<3>().setConstant(pull);
    load.stiffness.diagonal().tail<3>().setConstant(turning);
    return load;
  }

  const Scene& scene_;
  std::vector<Brick> bricks_;
  std::unique_ptr<Dynamics> dynamics_;
};

class Continuation {
 public:
  Continuation(const Scene& scene, const ContinuationSettings& settings, SearchBudget& budget,
               const std::function<bool()>& goesOn)
      : scene_(withoutLoads(scene)),
        settings_(settings),
        tile_(tileSize(scene.model)),
        poses_(startPoses(scene.model.tiles, makeBricks(scene.model.tiles, scene.brick))),
        mechanism_(scene_, settings.turnWeight, poses_),
        budget_(budget),
        goesOn_(goesOn) {
    mechanism_.close(poses_);
    keep();
  }

  MechanismPath to(const Poses& goal) {
    path_.guideLength = pathDistance(mechanism_.bricks(), poses_, goal);
    const double states =
        std::clamp(path_.guideLength / (kStateShare * tile_), kLeastStates, kMostStates);
    stateLength_ = path_.guideLength / states;
    if (stateLength_ > 0) {
      const double done = settings_.leap > 0 ? leap(goal) : 0;
      const bool isOpened = open();
      follow(goal, isOpened ? 0 : done, 1 / states);
    }
    return finish();
  }

  MechanismPath toExtension() {
    stateLength_ = kStateShare * tile_;
    double part =
        kReach * stateLength_ / pathDistance(mechanism_.bricks(), poses_, spread(poses_, 1));
    double reached = extent(poses_);
    for (int i = 0; i < kMostExtending && mayGoOn() && part > kLeastReach; ++i) {
      Poses tried = poses_;
      const double moved =
          mechanism_.move(tried, spread(poses_, part), stateLength_, true, budget_);
      const double extended = extent(tried);
      if (!(extended > reached)) {
        part *= 0.3;
        continue;
      }
      poses_ = std::move(tried);
      keep();
      if (extended - reached < kNoGain * reached) break;
      reached = extended;
      // Far places cost halved moves: they come nearer where moves are as long as they may be.
      part = moved < 0.5 * stateLength_ ? std::min(kGrowth * part, kWider) : part / kGrowth;
    }
    path_.guideLength = path_.length();
    return finish();
  }

 private:
  bool mayGoOn() {
    path_.isCutShort = path_.isCutShort || budget_.isSpent() || (goesOn_ && !goesOn_());
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
    const double moved = mechanism_.move(poses_, place, kLongestMove * stateLength_, true, budget_);
    keep();
    return moved;
  }

  /// Returns the progress that the leap made, 0 where there is no closed state nearby.
  double leap(const Poses& goal) {
    Poses first = interpolate(poses_, goal, settings_.leap);
    if (!mechanism_.close(first)) return 0;
    const double far = pathDistance(mechanism_.bricks(), poses_, first);
    if (far > kLongestLeap * settings_.leap * path_.guideLength + stateLength_) return 0;
    poses_ = std::move(first);
    keep();
    // The overlaps that a leap makes count as those of the start.
    mechanism_.restart(poses_);
    return settings_.leap;
  }

  /// Moves the tiles apart, turns free. Returns whether that was asked for.
  bool open() {
    if (settings_.opening <= 0) return false;
    Mechanism loose(scene_, 1, poses_);
    const double end = path_.length() + settings_.opening * tile_;
    double reach = kFirstProgress * tile_;
    while (path_.length() < end && mayGoOn() && reach > kLeastReach * tile_) {
      const double whole = pathDistance(mechanism_.bricks(), poses_, spread(poses_, 1));
      const double moved =
          loose.move(poses_, spread(poses_, kReach * reach / whole), reach, false, budget_);
      keep();
      reach = moved > kOpened * reach ? std::min(kGrowth * reach, stateLength_) : 0.3 * reach;
    }
    return true;
  }

  void follow(const Poses& goal, double progress, double largest) {
    const Poses from = settings_.opening > 0 ? poses_ : path_.states.front();
    double advance = progress > 0 ? std::min(progress, largest) : kFirstProgress;
    int still = 0;
    for (; progress < 1 && mayGoOn(); advance = std::min(kGrowth * advance, largest)) {
      progress = std::min(1.0, progress + advance);
      const double wanted = advance * path_.guideLength;
      const double before = path_.length();
      const Poses place = interpolate(from, goal, progress);
      for (int i = 0; i < kMovesAState && mayGoOn(); ++i) {
        if (moveTowards(place) < kShortMove * wanted) break;
      }
      still = path_.length() - before < kShortMove * wanted ? still + 1 : 0;
      path_.isStuck = still >= kStuckPlaces;
    }
    for (int i = 0; i < kMovesAtGoal && mayGoOn(); ++i) {
      if (moveTowards(goal) < kNoMove * tile_) break;
    }
  }

  MechanismPath finish() {
    if (scene_.model.target) {
      path_.error = targetError(*scene_.model.target, mechanism_.bricks(), poses_);
    }
    return std::move(path_);
  }

  Scene scene_;
  ContinuationSettings settings_;
  double tile_;  // metres
  Poses poses_;  // the last state
  Mechanism mechanism_;
  double stateLength_ = 0;  // of the guide from state to state, metres
  SearchBudget& budget_;
  const std::function<bool()>& goesOn_;
  MechanismPath path_;
};

}  // namespace

double pathDistance(const std::vector<Brick>& bricks, const Poses& from, const Poses& to) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const double radius = gyrationRadius(bricks[i]);
    sum += (to[i].position - from[i].position).squaredNorm() +
           radius * radius * turnBetween(from[i].rotation, to[i].rotation).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(bricks.size()));
}

MechanismPath continueTo(const Scene& scene, const Poses& goal,
                         const ContinuationSettings& settings, SearchBudget& budget,
                         const std::function<bool()>& goesOn) {
  return Continuation(scene, settings, budget, goesOn).to(goal);
}

MechanismPath continueToExtension(const Scene& scene, SearchBudget& budget,
                                  const std::function<bool()>& goesOn) {
  return Continuation(scene, {.turnWeight = 1}, budget, goesOn).toExtension();
}

}  // namespace kirireel
