// The second compact state of a sheet that has one motion once it has left its start.
//
// 1. *One motion*: half-way to full extension the joints' equations leave one freedom.
// 2. *Following*: the next state is predicted by a straight line through the last two. Then its
//    joints are closed. Steps are short: closing moves it by a small fraction of the step. If a
//    step is much shorter than the one before, both states are taken at its distance. One motion
//    has one curve, which passes full extension without a branch.
// 3. *Meeting*: each hinge at a corner has two gaps, one on either side. A gap is the distance
//    of the hinge angle from a bound. A step closes a gap by at most half: tiles approach
//    without overlap. Tiles without a common hinge may overlap before; bisection finds that
//    state.
// 4. *The end*: a compact state is often singular. Other motions branch off there, and joints
//    close badly near it. It is therefore extrapolated: poses as polynomials of the first gap
//    (Neville's rule), through the last states, at gap 0.
#include "sim/path/closing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/brick/hinge.h"
#include "sim/run/dynamics.h"
#include "sim/run/mechanism_path.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::path {
namespace {

constexpr double kStepsToExtension = 60;
// If closing the joints moves a step by more than this fraction, the step is halved.
constexpr double kMaxCorrection = 0.1;
// The search fails if a step is shorter than this fraction of a tile.
constexpr double kMinStep = 1e-7;
// Steps grow by this factor.
constexpr double kLongerStep = 1.3;
// If steps are shorter than this fraction of the step before, its secant is too far from the
// tangent.
constexpr double kShorterStep = 0.5;
// A path longer than this multiple of the extension path has no second compact state.
constexpr double kLongestPath = 20;
// A step closes a gap by at most this fraction.
constexpr double kGapShare = 0.5;
// A gap that closes by less in a step is constant, radians.
constexpr double kStill = 1e-9;
// Below this gap the end is extrapolated, radians. The error is about the product of the last
// kNodes gaps.
constexpr double kNearGap = 1e-3;
constexpr std::size_t kNodes = 5;
// The gaps of rounded tiles, as a multiple of the root of the rounding in tiles.
constexpr double kAboveRounding = 10;
// At the end, smaller gaps count as closed, radians. A compact state is singular: rounded tiles
// leave gaps of about the root of the rounding.
constexpr double kClosedGap = 1e-6;
constexpr int kBisections = 40;

class ClosingPath {
 public:
  ClosingPath(const scene::Scene& scene, run::SearchBudget& budget,
              const PathObserver& shouldContinue, run::GeometricPath& found)
      : scene_(scene::withoutEnvironment(scene)),
        tile_(model::tileSize(scene.model)),
        bricks_(brick::makeBricks(scene.model.tiles, scene.brick)),
        metric_(run::metricBricks(scene)),
        pivots_(brick::makePivots(scene.model.joints, bricks_)),
        hinges_(brick::findHinges(bricks_, pivots_, scene::sceneNeeds(scene).planar.on).hinges),
        jointStiffness_(run::roundedJointStiffness(scene.model)),
        dynamics_(run::makeDynamics(scene_, scene::sceneNeeds(scene), metric_,
                                    found.path.states.front())),
        meter_(run::overlapMeter(scene.environment, bricks_, pivots_, found.path.states.front())),
        budget_(budget),
        shouldContinue_(shouldContinue),
        found_(found),
        path_(found.path),
        extension_(found.path.length()) {
    dynamics_->setJointStiffness(jointStiffness_);
    dynamics_->setFine(true);
  }

  void follow() {
    requireOneMotion();
    last_ = path_.states.back();
    before_ = beforeLast();
    gaps_ = gapsAt(last_);
    const double longest = extension_ / kStepsToExtension;
    const double allowed =
        meter_.grownAt(last_) +
        run::kAllowedOverlap * tile_;  // the path to extension has the same limit
    double step = longest;
    // The gaps of the previous state show which gaps are closing.
    std::vector<double> earlier = gapsAt(before_, gaps_);
    while (mayContinue()) {
      const double made = run::pathDistance(metric_, before_, last_);
      step = std::min(step, kGapShare * distanceToMeeting(earlier, made));
      Poses tried = interpolate(before_, last_, 1 + step / made);
      const Poses predicted = tried;
      const bool isClosed = close(tried);
      const double off = run::pathDistance(metric_, predicted, tried);
      if (!isClosed || off > kMaxCorrection * step) {
        step *= 0.5;
        if (step < kMinStep * tile_) throw stopped();
        if (step < kShorterStep * made) takeNearerBefore(step / made, earlier);
        continue;
      }
      if (const double grown = meter_.grownAt(tried); grown > allowed) {
        keep(lastFree(tried, allowed));
        note(true);
        return;
      }
      earlier = std::exchange(gaps_, gapsAt(tried, gaps_));
      before_ = std::exchange(last_, std::move(tried));
      keep(last_);
      if (const std::optional<std::size_t> gap = closingGap(earlier);
          gap && gaps_[*gap] < nearGap()) {
        finish(*gap);
        return;
      }
      if (path_.length() > (1 + kLongestPath) * extension_) throw neverMeets();
      step = std::min(kLongerStep * step, longest);
    }
    path_.isCutShort = true;
  }

 private:
  bool isExact() const { return std::isinf(jointStiffness_); }

  /// Below this gap the end is extrapolated, radians. Rounded joints resist motions whose singular
  /// values exceed the root of the rounding in tiles. Singular values are about as large as the
  /// gap.
  double nearGap() const { return std::max(kNearGap, gapOfRounding()); }
  /// Gaps that rounding may leave, radians.
  double gapOfRounding() const { return kAboveRounding * std::sqrt(scene_.model.rounding / tile_); }

  bool mayContinue() {
    return !budget_.isSpent() && (!shouldContinue_ || shouldContinue_(budget_.share()));
  }

  void requireOneMotion() const {
    if (!run::isExtension(scene_, path_)) {
      throw InputError(
          "error: `to = closed` follows the motion of the sheet, but the sheet does not extend "
          "from its start. Set `target` or other joints (`joints_file`)");
    }
    if (found_.evaluation.overlapGrowth > run::kAllowedOverlap * tile_) {
      throw InputError(
          "error: `to = closed`: tiles overlap before full extension, so they cannot move beyond "
          "it. Set `target`");
    }
    const auto half = std::ranges::lower_bound(path_.lengths, 0.5 * extension_);
    const Poses& state = path_.states[static_cast<std::size_t>(half - path_.lengths.begin())];
    const bool isPlanar = scene::sceneNeeds(scene_).planar.on;
    const trajectory::Mobility left = trajectory::mobility(
        scene_.model, brick::bottomTiles(bricks_, state),
        isPlanar ? trajectory::Freedom::Plane : trajectory::Freedom::Space, scene_.brick.thickness);
    if (!left.isCounted || left.freedoms <= 1) return;
    throw InputError(
        fmt::format("error: `to = closed` needs a sheet with one motion, but this sheet has {} "
                    "half way to full extension. Set `target`, or connect tiles rigidly (`fix`)",
                    left.freedoms));
  }

  static InputError stopped() {
    return InputError(
        "error: `to = closed`: beyond full extension the sheet stops before its tiles meet. Set "
        "`target`");
  }
  static InputError neverMeets() {
    return InputError(
        "error: `to = closed`: the tiles do not meet again beyond full extension. Set `target`");
  }

  /// The last state that is far enough from the end to define a direction.
  const Poses& beforeLast() const {
    std::size_t k = path_.states.size() - 1;
    while (k > 0 && run::pathDistance(metric_, path_.states[k], last_) <
                        0.5 * extension_ / kStepsToExtension) {
      --k;
    }
    return path_.states[k];
  }

  /// Replaces the state before the last one by a state of the same curve at this fraction of the
  /// distance. `earlier`: gaps of that state.
  void takeNearerBefore(double share, std::vector<double>& earlier) {
    Poses nearer = interpolate(before_, last_, 1 - share);
    if (!close(nearer)) return;
    before_ = std::move(nearer);
    earlier = gapsAt(before_, gaps_);
  }

  /// Closes the joints of a nearby state, within the rounding of the model's coordinates.
  bool close(Poses& poses) {
    if (isExact()) {
      budget_.spend(100.0 * static_cast<double>(bricks_.size() * bricks_.size()));
      return run::closeInPlace(poses, *dynamics_);
    }
    budget_.spend(run::settle(metric_, scene_.model.rounding, *dynamics_, poses));
    return trajectory::jointGap(pivots_, poses).max <= run::roundedReach(scene_.model);
  }

  /// Two gaps per hinge: the distances of its angle from both bounds, radians. Angles are
  /// continuous with `before`.
  std::vector<double> gapsAt(const Poses& poses, const std::vector<double>& before = {}) const {
    std::vector<double> gaps;
    for (std::size_t k = 0; k < hinges_.size(); ++k) {
      double gap = brick::hingeAngle(hinges_[k], poses) - hinges_[k].least;
      if (!before.empty()) {
        constexpr double kTurn = 2 * std::numbers::pi;
        gap += kTurn * std::round((before[2 * k] - gap) / kTurn);
      }
      gaps.push_back(gap);
      gaps.push_back(hinges_[k].most - hinges_[k].least - gap);
    }
    return gaps;
  }

  /// The closing gap that reaches zero first at the current rate.
  std::optional<std::size_t> closingGap(const std::vector<double>& earlier) const {
    std::optional<std::size_t> first;
    double least = 0;
    for (std::size_t k = 0; k < gaps_.size(); ++k) {
      const double closed = earlier[k] - gaps_[k];
      if (closed < kStill || !(gaps_[k] > 0)) continue;
      const double left = gaps_[k] / closed;
      if (first && left >= least) continue;
      first = k;
      least = left;
    }
    return first;
  }

  /// Remaining path length at the current rate, metres.
  double distanceToMeeting(const std::vector<double>& earlier, double made) const {
    const std::optional<std::size_t> gap = closingGap(earlier);
    return gap ? made * gaps_[*gap] / (earlier[*gap] - gaps_[*gap])
               : std::numeric_limits<double>::infinity();
  }

  /// The last state before tiles without a common hinge overlap, by bisection.
  Poses lastFree(const Poses& beyond, double allowed) {
    double free = 0, blocked = 1;
    Poses best = last_;
    for (int k = 0; k < kBisections; ++k) {
      const double share = 0.5 * (free + blocked);
      Poses tried = interpolate(last_, beyond, share);
      const bool isFree = close(tried) && meter_.grownAt(tried) <= allowed;
      (isFree ? free : blocked) = share;
      if (isFree) best = std::move(tried);
    }
    return best;
  }

  void keep(const Poses& poses) {
    path_.lengths.push_back(path_.length() +
                            run::pathDistance(bricks_, path_.states.back(), poses));
    path_.states.push_back(poses);
  }

  /// Adds the end, extrapolated from the last states and their gaps.
  void finish(std::size_t gap) {
    const std::size_t count = std::min(kNodes, path_.states.size());
    const std::vector<Poses> states(path_.states.end() - static_cast<std::ptrdiff_t>(count),
                                    path_.states.end());
    std::vector<double> nodes(count);
    std::vector<double> known = gaps_;
    for (std::size_t k = count; k-- > 0;) {
      known = gapsAt(states[k], known);
      nodes[k] = known[gap];
    }
    Poses end = run::polynomialAt(0, nodes, states, states.back());
    Poses closed = end;
    if (close(closed) && run::pathDistance(metric_, end, closed) < nearGap() * nearGap() * tile_) {
      end = std::move(closed);
    }
    keep(end);
    gaps_ = gapsAt(end, gaps_);
    note(false);
  }

  void note(bool meetBetween) {
    const double closed = std::max(kClosedGap, gapOfRounding());
    std::size_t count = 0;
    for (std::size_t k = 0; k < hinges_.size(); ++k) {
      count += std::min(std::abs(gaps_[2 * k]), std::abs(gaps_[2 * k + 1])) <= closed;
    }
    found_.closedWords =
        fmt::format("the path ends when the tiles meet again{}: {} of {} hinges are closed",
                    meetBetween ? " away from their hinges" : "", count, hinges_.size());
    found_.evaluation.overlapGrowthAtEnd = meter_.grownAt(path_.states.back());
    for (const Poses& state : path_.states) {
      found_.evaluation.overlapGrowth = meter_.grownAt(state, found_.evaluation.overlapGrowth);
    }
    found_.evaluation.length = path_.length();
    path_.guideLength = path_.length();
  }

  scene::Scene scene_;
  double tile_;                       // metres
  std::vector<brick::Brick> bricks_;  // of the scene
  std::vector<brick::Brick> metric_;  // the same with the path's metric as masses
  std::vector<brick::Pivot> pivots_;
  std::vector<brick::Hinge> hinges_;
  double jointStiffness_;
  std::unique_ptr<run::Dynamics> dynamics_;  // closes joints
  trajectory::PenetrationMeter meter_;
  run::SearchBudget& budget_;
  const PathObserver& shouldContinue_;
  run::GeometricPath& found_;
  run::MechanismPath& path_;
  double extension_;  // length of the path to full extension, metres
  Poses before_, last_;
  std::vector<double> gaps_;  // of the last state
};

}  // namespace

void continueUntilClosed(const scene::Scene& scene, run::SearchBudget& budget,
                         const PathObserver& shouldContinue, run::GeometricPath& found) {
  ClosingPath(scene, budget, shouldContinue, found).follow();
}

}  // namespace kirireel::path
