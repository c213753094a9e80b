// The joint-closed states nearest to a target, computed by long implicit steps.
//
// 1. Each brick is fitted to its target independently. Then the joints are closed
//    (Gauss-Newton in the mass metric).
// 2. The scene's springs pull, with 16 times their stiffness and exact joints. Each step is
//    one of implicit Euler from rest with h = 0.25 s. For stiffness K and mass M it minimises
//      |x|_M^2 / (2 h^2) + E(q + x)
//    over displacements x that joints allow. For h^2 K >> M this is Newton's method on the
//    springs' energy E. It converges to the equilibrium, a local minimum of the sum of
//    squares. If its joints do not close, the step is repeated with a shorter h.
// 3. The goal is the smallest maximum distance, not the smallest sum of squares. w_i is
//    multiplied by e_i / max e, e_i the brick's error (m). All weights are scaled to the mean
//    1 and bounded on both sides: every brick is pulled. This is Lawson's iteration (see
//    measures.cpp). Joints make the problem nonconvex, and its guarantee does not apply.
// 4. If an error remains, 2 and 3 are repeated from the start, which may lie in another basin
//    of attraction. The result is the best of all states.
#include "sim/run/assembled_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/brick/contact.h"
#include "sim/formats/joint_faces.h"
#include "sim/run/dynamics.h"
#include "sim/run/forces.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel::run {
namespace {

// Steps start from rest. Long steps then approximate Newton's method on the springs' energy.
constexpr double kStep = 0.25;  // seconds
// A step whose joints do not close is repeated with this fraction of its length, down to this
// fraction of the longest.
constexpr double kShorter = 0.25;
constexpr double kShortestStep = 1e-3;
// The largest stiffening factor of a run's springs (kLargestFactor of forces.cpp).
constexpr double kSpringStiffening = 16;
constexpr int kSteps = 200;
constexpr int kStepsFromStart = 100;
constexpr double kConverged = 1e-7;         // relative change of the error per step
constexpr double kNegligibleError = 1e-12;  // in tile edges

// Reweighting starts above this error in tile edges, and above this multiple of the rigid bound.
constexpr double kWorthwhile = 1e-6;
constexpr double kAtBound = 1.001;
// It ends after this many steps, or after kPatienceSteps steps without the relative gain kGain.
constexpr int kReweightings = 200;
constexpr int kPatienceSteps = 25;
constexpr double kGain = 1e-3;
// Bounds on the spring weights, relative to the mean.
constexpr double kMinWeight = 1e-3;
constexpr double kMaxWeight = 30;

/// Joined bricks pulled to their target by springs, step by step from rest.
class Assembly {
 public:
  Assembly(const scene::Scene& scene, const std::function<bool()>& shouldContinue)
      : scene_(scene),
        target_(*scene.model.target),
        bricks_(brick::makeBricks(scene.model.tiles, scene.brick)),
        pivots_(brick::makePivots(scene.model.joints, bricks_)),
        springs_(bricks_, target_, scene.model.pulledTiles, scene.springs),
        weights_(bricks_.size(), 1.0),
        tile_(model::tileSize(scene.model)),
        rigidBound_(trajectory::rigidBound(scene.model.tiles, target_)),
        shouldContinue_(shouldContinue) {
    pull_ = [this](const Poses& poses, std::vector<brick::Load>& loads) {
      for (std::size_t i = 0; i < poses.size(); ++i) {
        loads[i] = springs_.load(static_cast<int>(i), poses[i], kSpringStiffening);
        loads[i].force *= weights_[i];
        loads[i].stiffness *= weights_[i];
      }
    };
  }

  // The steps at the head of the file, in order.
  AssembledState find() {
    AssembledState state;
    beginAt(bestFitPoses(bricks_, target_));
    comeToRest(kSteps);
    soften();
    findNearest(state);
    return state;
  }

 private:
  // Continues from the equilibrium state.
  void findNearest(AssembledState& state) {
    state.restError = state.error = error();
    state.restPoses = state.poses = motion_.poses;
    if (isNearEnough(state)) return;
    approach(state);
    if (isNearEnough(state)) return;
    if (mayStep()) {
      beginAt(brick::startPoses(scene_.model.tiles, bricks_));
      comeToRest(kStepsFromStart);
      if (keepIfNearer(state)) approach(state);
    }
    keepStartIfNearer(state);
  }

  void beginAt(Poses poses) {
    motion_.poses = std::move(poses);
    step_ = kStep;
    weights_.assign(bricks_.size(), 1.0);
    dynamics_ = makeDynamics(scene_, scene::sceneNeeds(scene_), bricks_, motion_.poses,
                             contacts::FaceContact::Plane);
    dynamics_->setHalving(false);
    // Joints of rounded tiles are springs, relative to the pull's own stiffness. If tiles fit in no
    // state nearby, joints have the stiffness for misfits.
    const double rounded = roundedJointStiffness(scene_.model);
    if (std::isfinite(rounded)) {
      dynamics_->setJointStiffness(rounded * pullStiffness());
    } else if (!dynamics_->assemble(motion_.poses)) {
      dynamics_->setJointStiffness(misfitStiffness(scene_, bricks_));
    }
  }

  /// Comes nearer with softer joints, as long as they stay closed within the rounding.
  void soften() {
    if (!std::isfinite(roundedJointStiffness(scene_.model))) return;
    double closed = roundedJointStiffness(scene_.model);
    softenWhileClosed(scene_.model, [&](double stiffness) {
      const Poses before = motion_.poses;
      dynamics_->setJointStiffness(stiffness * pullStiffness());
      comeToRest(kSteps);
      if (largestGap(motion_.poses) <= roundedGap(scene_.model)) {
        closed = stiffness;
        return true;
      }
      motion_.poses = before;
      return false;
    });
    dynamics_->setJointStiffness(closed * pullStiffness());
  }

  /// The largest stiffness of the springs that pull a brick to its place, N/m.
  double pullStiffness() const {
    double stiffest = 0;
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      const brick::Load load =
          springs_.load(static_cast<int>(i), motion_.poses[i], kSpringStiffening);
      stiffest = std::max(stiffest, load.stiffness(0, 0));
    }
    return stiffest;
  }

  /// If the target is far out of reach, the start may be the nearest state.
  void keepStartIfNearer(AssembledState& state) const {
    Poses start = brick::startPoses(scene_.model.tiles, bricks_);
    if (!makeDynamics(scene_, scene::sceneNeeds(scene_), bricks_, start)->assemble(start)) return;
    const double found = trajectory::targetError(target_, bricks_, start);
    if (!(found < (1 - kGain) * state.error)) return;
    state.error = found;
    state.poses = std::move(start);
  }

  /// Whether the error is too small to search further.
  bool isNearEnough(const AssembledState& state) const {
    return state.error <= std::max(kWorthwhile * tile_, kAtBound * rigidBound_);
  }

  bool keepIfNearer(AssembledState& state) const {
    const double found = error();
    if (!(found < state.error)) return false;
    state.error = found;
    state.poses = motion_.poses;
    return true;
  }

  double error() const { return trajectory::targetError(target_, bricks_, motion_.poses); }
  double largestGap(const Poses& poses) const { return trajectory::jointGap(pivots_, poses).max; }
  bool mayStep() const { return !shouldContinue_ || shouldContinue_(); }

  /// One implicit step from rest: without velocities it does not overshoot the minimum. Returns
  /// false if the joints do not close even after the shortest one.
  bool step() {
    for (; step_ >= kShortestStep * kStep; step_ *= kShorter) {
      Motion tried{motion_.poses, std::vector<Velocity>(bricks_.size())};
      dynamics_->advance(tried, step_, pull_);
      const bool isExact = std::isinf(dynamics_->jointStiffness());
      if (isExact && largestGap(tried.poses) > model::kClosedShare * tile_) continue;
      motion_ = std::move(tried);
      return true;
    }
    return false;
  }

  // Steps until the error no longer changes, at most `steps` times.
  void comeToRest(int steps) {
    double last = error();
    for (int i = 0; i < steps && last > kNegligibleError * tile_ && mayStep(); ++i) {
      if (!step()) break;
      const double before = last;
      last = error();
      if (std::abs(last - before) <= kConverged * last) break;
    }
  }

  // Lawson's update of the bricks' weights.
  void reweight() {
    const std::vector<double> errors =
        trajectory::brickTargetErrors(target_, bricks_, motion_.poses);
    const double largest = *std::ranges::max_element(errors);
    double sum = 0;
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      weights_[i] *= errors[i] / largest;
      sum += weights_[i];
    }
    const double even = static_cast<double>(weights_.size()) / sum;
    for (double& weight : weights_) weight = std::clamp(even * weight, kMinWeight, kMaxWeight);
  }

  // Takes reweighted steps as long as the error decreases.
  void approach(AssembledState& state) {
    double gainedFrom = state.error;
    int patience = kPatienceSteps;
    for (int i = 0; i < kReweightings && patience > 0 && mayStep(); ++i) {
      if (isNearEnough(state)) break;
      reweight();
      if (!step()) break;
      --patience;
      if (!keepIfNearer(state) || state.error > (1 - kGain) * gainedFrom) continue;
      gainedFrom = state.error;
      patience = kPatienceSteps;
    }
  }

  const scene::Scene& scene_;
  const std::vector<model::Tile>& target_;
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  TargetSprings springs_;
  std::vector<double> weights_;  // of the springs, one per brick, mean 1
  double tile_;                  // metres
  double rigidBound_;            // metres
  const std::function<bool()>& shouldContinue_;
  Motion motion_;
  double step_ = kStep;  // seconds
  std::unique_ptr<Dynamics> dynamics_;
  mechanics::LoadSource pull_;
};

}  // namespace

AssembledState assembleAtTarget(const scene::Scene& scene,
                                const std::function<bool()>& shouldContinue) {
  if (!scene.model.target) return {};
  scene::Scene bare = scene::withoutEnvironment(scene);
  bare.solver.kind = scene::SolverKind::Direct;
  const std::optional<model::SheetFrame> frame = scene::ownAxes(bare);
  if (!frame) return Assembly(bare, shouldContinue).find();
  const scene::Scene lying = scene::inAxes(*frame, bare);
  AssembledState state = Assembly(lying, shouldContinue).find();
  for (Poses* poses : {&state.poses, &state.restPoses}) {
    *poses = model::toWorld(*frame, std::move(*poses));
  }
  return state;
}

// ------------------------------------------------------------------------------------------------
// Constants of assembled_state.h. d is the last digit of the coordinates over the mean edge. r = 10
// / d is the stiffness of joints over that of the pull. Softer joints are tried in steps of ten,
// down to r = 10.

namespace {

constexpr double kDigits = 10;
// Joints are softened by this factor, at most down to this stiffness.
constexpr double kSofter = 10;
constexpr double kSoftest = 10;

}  // namespace

double roundedJointStiffness(const model::Model& model) {
  const double tile = model::tileSize(model);
  return model.rounding > model::kClosedShare * tile ? kDigits * tile / model.rounding
                                                     : std::numeric_limits<double>::infinity();
}

double roundedReach(const model::Model& model) {
  return kDigits * model.rounding;
}

double roundedGap(const model::Model& model) {
  return 2 * model.rounding;
}

void softenWhileClosed(const model::Model& model,
                       const std::function<bool(double stiffness)>& closes) {
  double stiffness = roundedJointStiffness(model);
  do {
    stiffness /= kSofter;
  } while (stiffness >= kSoftest && closes(stiffness));
}

// ------------------------------------------------------------------------------------------------
// Pairs of bricks that overlap at the target, and changes that separate them.
//
// Overlaps are measured at the equilibrium of the scene's springs near the target, with closed
// joints and without contacts. Two changes can free a pair. One is another face for its joints, if
// the sheet folds: the model is assembled again with the faces of FaceRule::Fold for the
// overlapping pairs, and checked again. The other is a smaller thickness: thicknesses decrease in
// steps of a tenth, only for this pair, with fixed bottom faces. The overlap may not be monotonic
// in the thickness, which rules out bisection.

namespace {

using TilePair = std::pair<int, int>;

// Overlaps below this fraction of a tile do not block.
constexpr double kNegligibleDepth = 1e-4;
// Thickness decreases by this factor, down to this fraction of the scene's own.
constexpr double kThinnerStep = 0.9;
constexpr double kThinnest = 1e-3;

// Pairs that the contacts consider, the deepest first.
std::vector<trajectory::Penetration> overlapsAt(const scene::Scene& scene, const Poses& poses) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<brick::Pivot> pivots = brick::makePivots(scene.model.joints, bricks);
  std::vector<trajectory::Penetration> overlaps =
      trajectory::penetrationsOutsidePivots(bricks, pivots, scene.environment.pivotZone, poses,
                                            kNegligibleDepth * model::tileSize(scene.model));
  if (scene.environment.contacts == scene::ContactFilter::Unjoined) {
    const auto joined = brick::sharedCorners(pivots);
    std::erase_if(overlaps, [&](const trajectory::Penetration& overlap) {
      return joined.contains({overlap.brickA, overlap.brickB});
    });
  }
  return overlaps;
}

/// The model with the joints of overlapping pairs moved to the face that a fold to its target
/// needs.
model::Model withFreeingFaces(const model::Model& model,
                              const std::vector<trajectory::Penetration>& overlaps) {
  std::set<TilePair> blocked;
  for (const trajectory::Penetration& overlap : overlaps)
    blocked.insert({overlap.brickA, overlap.brickB});
  model::Model folded = model;
  formats::chooseJointFaces(folded, formats::FaceRule::Fold);
  model::Model freed = model;
  for (std::size_t i = 0; i < freed.joints.size(); ++i) {
    model::Joint& joint = freed.joints[i];
    const TilePair pair = std::minmax(joint.a.tile, joint.b.tile);
    if (joint.kind == model::JointKind::Pivot && blocked.contains(pair)) joint = folded.joints[i];
  }
  return freed;
}

/// The joint faces that free pairs, for the pairs that can be freed.
std::map<TilePair, model::JointFace> freeingFaces(
    const scene::Scene& scene, const std::vector<trajectory::Penetration>& overlaps) {
  scene::Scene freed = scene;
  freed.model = withFreeingFaces(scene.model, overlaps);
  std::map<TilePair, model::JointFace> faces;
  for (std::size_t i = 0; i < freed.model.joints.size(); ++i) {
    const model::Joint& joint = freed.model.joints[i];
    if (joint.face == scene.model.joints[i].face) continue;
    faces[std::minmax(joint.a.tile, joint.b.tile)] = joint.face;
  }
  if (faces.empty()) return faces;
  for (const trajectory::Penetration& overlap :
       overlapsAt(freed, assembleAtTarget(freed).restPoses)) {
    faces.erase({overlap.brickA, overlap.brickB});
  }
  return faces;
}

/// A tile's brick with another thickness, and its pose with the same bottom face.
struct ThinBrick {
  brick::Brick brick;
  Pose pose;
};

// Keeps the bottom face at the tile.
ThinBrick thinned(const scene::Scene& scene, int tile, const brick::Brick& brick, const Pose& pose,
                  double thickness) {
  brick::BrickRule rule = scene.brick;
  rule.thickness = thickness;
  ThinBrick thin{brick::makeBrick(scene.model.tiles[tile], rule), pose};
  // The centre of mass of a thinner brick is nearer to its bottom.
  thin.pose.position += pose.rotation * (brick.bottom[0] - thin.brick.bottom[0]);
  return thin;
}

/// The joints of each pair of tiles, renumbered for a model of these two tiles only: 0 is the
/// smaller index, 1 the other.
using JointsByPair = std::map<TilePair, std::vector<model::Joint>>;

JointsByPair jointsByPair(const model::Model& model) {
  JointsByPair joints;
  for (model::Joint joint : model.joints) {
    const TilePair pair = std::minmax(joint.a.tile, joint.b.tile);
    joint.a.tile = joint.a.tile == pair.first ? 0 : 1;
    joint.b.tile = 1 - joint.a.tile;
    joints[pair].push_back(joint);
  }
  return joints;
}

/// Whether two bricks of this thickness do not overlap.
bool isFree(const scene::Scene& scene, const trajectory::Penetration& overlap, const Poses& poses,
            const std::vector<model::Joint>& between, double thickness) {
  std::vector<brick::Brick> bricks;
  Poses placed;
  for (const int tile : {overlap.brickA, overlap.brickB}) {
    const brick::Brick brick = brick::makeBrick(scene.model.tiles[tile], scene.brick);
    ThinBrick thin = thinned(scene, tile, brick, poses[tile], thickness);
    bricks.push_back(std::move(thin.brick));
    placed.push_back(thin.pose);
  }
  const trajectory::Penetration left = trajectory::deepestPenetrationOutsidePivots(
      bricks, brick::makePivots(between, bricks), scene.environment.pivotZone, placed);
  return left.depth <= kNegligibleDepth * model::tileSize(scene.model);
}

// The largest tested thickness that frees the pair, metres. 0 if none does.
double freeingThickness(const scene::Scene& scene, const trajectory::Penetration& overlap,
                        const Poses& poses, const std::vector<model::Joint>& between) {
  for (double share = kThinnerStep; share > kThinnest; share *= kThinnerStep) {
    const double thickness = share * scene.brick.thickness;
    if (isFree(scene, overlap, poses, between, thickness)) return thickness;
  }
  return 0;
}

}  // namespace

std::vector<BlockingPair> blockingPairs(const scene::Scene& scene, const Poses& atTarget) {
  std::vector<BlockingPair> pairs;
  if (atTarget.empty() || !scene::sceneNeeds(scene).contacts.on) return pairs;
  const std::vector<trajectory::Penetration> overlaps = overlapsAt(scene, atTarget);
  if (overlaps.empty()) return pairs;
  const std::map<TilePair, model::JointFace> faces = freeingFaces(scene, overlaps);
  const JointsByPair joints = jointsByPair(scene.model);
  for (const trajectory::Penetration& overlap : overlaps) {
    BlockingPair pair{overlap.brickA, overlap.brickB, overlap.depth, {}, 0};
    const auto face = faces.find({pair.tileA, pair.tileB});
    if (face != faces.end()) pair.freeingFace = face->second;
    const auto between = joints.find({pair.tileA, pair.tileB});
    pair.freeingThickness =
        freeingThickness(scene, overlap, atTarget,
                         between == joints.end() ? std::vector<model::Joint>{} : between->second);
    pairs.push_back(pair);
  }
  return pairs;
}

std::string describe(const BlockingPair& pair, int countsFrom, const LengthUnit& unit) {
  std::vector<std::string> remedies;
  if (pair.freeingFace) {
    remedies.push_back(fmt::format("joints on the {}",
                                   *pair.freeingFace == model::JointFace::Top ? "top" : "bottom"));
  }
  if (pair.freeingThickness > 0) {
    remedies.push_back(
        fmt::format("a thickness of {}", lengthText(pair.freeingThickness, unit, 2)));
  }
  return fmt::format("tiles {} and {} by {} ({})", countsFrom + pair.tileA, countsFrom + pair.tileB,
                     lengthText(pair.overlap, unit, 2),
                     remedies.empty() ? "the tiles themselves overlap"
                                      : fmt::format("free with {}", fmt::join(remedies, " or ")));
}

}  // namespace kirireel::run
