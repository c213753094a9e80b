// Bricks that would overlap at the target, and what would free each pair of them.
//
// Overlaps are measured in the state where the scene's springs rest near the target, joints closed
// and without contacts. A pair is freed by another face of its joints where the sheet folds (the
// model is assembled again with the faces of FaceRule::Fold for the pairs that overlap, and looked
// at again), or by thinner bricks: thicknesses are tried downwards in steps of a tenth, for the
// pair alone, its bottoms where they were. Overlap need not fall steadily with the thickness, so
// that no bisection is used.
#include "sim/deploy/blockage.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "sim/brick/shared_corners.h"
#include "sim/deploy/assembled_state.h"
#include "sim/measure/measures.h"
#include "sim/model/face_choice.h"

namespace kirireel {
namespace {

using TilePair = std::pair<int, int>;

// Overlaps below this part of a tile do not stop anything.
constexpr double kNegligibleDepth = 1e-4;
// Thicknesses are tried in steps of this factor, down to this part of the scene's own.
constexpr double kThinnerStep = 0.9;
constexpr double kThinnest = 1e-3;
// What looking at one pair of bricks once is worth, in multiplications.
// Counted and not measured, so that the search ends alike on every machine.
constexpr double kWorkOfPair = 20'000;

// Pairs that contacts would look at, the deepest first.
std::vector<Penetration> overlapsAt(const Scene& scene, const Poses& poses) {
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  const std::vector<Pivot> pivots = makePivots(scene.model.joints, bricks);
  std::vector<Penetration> overlaps = penetrationsOutsidePivots(
      bricks, pivots, scene.environment.pivotZone, poses, kNegligibleDepth * tileSize(scene.model));
  if (scene.environment.contacts == ContactFilter::Unjoined) {
    const auto joined = sharedCorners(pivots);
    std::erase_if(overlaps, [&](const Penetration& overlap) {
      return joined.contains({overlap.brickA, overlap.brickB});
    });
  }
  return overlaps;
}

/// The model with the joints between pairs that overlap where a fold to its target leaves room.
Model withFreeingFaces(const Model& model, const std::vector<Penetration>& overlaps) {
  std::set<TilePair> blocked;
  for (const Penetration& overlap : overlaps) blocked.insert({overlap.brickA, overlap.brickB});
  Model folded = model;
  chooseJointFaces(folded, FaceRule::Fold);
  Model freed = model;
  for (std::size_t i = 0; i < freed.joints.size(); ++i) {
    Joint& joint = freed.joints[i];
    const TilePair pair = std::minmax(joint.a.tile, joint.b.tile);
    if (joint.kind == JointKind::Pivot && blocked.contains(pair)) joint = folded.joints[i];
  }
  return freed;
}

/// The faces that joints of pairs would have to lie on, for the pairs that this frees.
std::map<TilePair, JointFace> freeingFaces(const Scene& scene,
                                           const std::vector<Penetration>& overlaps,
                                           SearchBudget& budget) {
  Scene freed = scene;
  freed.model = withFreeingFaces(scene.model, overlaps);
  std::map<TilePair, JointFace> faces;
  for (std::size_t i = 0; i < freed.model.joints.size(); ++i) {
    const Joint& joint = freed.model.joints[i];
    if (joint.face == scene.model.joints[i].face) continue;
    faces[std::minmax(joint.a.tile, joint.b.tile)] = joint.face;
  }
  if (faces.empty()) return faces;
  for (const Penetration& overlap : overlapsAt(freed, assembleAtTarget(freed, budget).restPoses)) {
    faces.erase({overlap.brickA, overlap.brickB});
  }
  return faces;
}

/// A tile's brick of some thickness, and its pose with the bottom where it was.
struct ThinBrick {
  Brick brick;
  Pose pose;
};

// Its bottom stays where the tile is.
ThinBrick thinned(const Scene& scene, int tile, const Brick& brick, const Pose& pose,
                  double thickness) {
  BrickRule rule = scene.brick;
  rule.thickness = thickness;
  ThinBrick thin{makeBrick(scene.model.tiles[tile], rule), pose};
  // A thinner brick has its centre of mass nearer to the bottom.
  thin.pose.position += pose.rotation * (brick.bottom[0] - thin.brick.bottom[0]);
  return thin;
}

/// The joints of each pair of tiles, as if these two were the only ones: 0 the one with the smaller
/// number, 1 the other.
using JointsByPair = std::map<TilePair, std::vector<Joint>>;

JointsByPair jointsByPair(const Model& model) {
  JointsByPair joints;
  for (Joint joint : model.joints) {
    const TilePair pair = std::minmax(joint.a.tile, joint.b.tile);
    joint.a.tile = joint.a.tile == pair.first ? 0 : 1;
    joint.b.tile = 1 - joint.a.tile;
    joints[pair].push_back(joint);
  }
  return joints;
}

/// Whether two bricks would keep clear of each other if they were that thin.
bool isFree(const Scene& scene, const Penetration& overlap, const Poses& poses,
            const std::vector<Joint>& between, double thickness) {
  std::vector<Brick> bricks;
  Poses placed;
  for (const int tile : {overlap.brickA, overlap.brickB}) {
    const Brick brick = makeBrick(scene.model.tiles[tile], scene.brick);
    ThinBrick thin = thinned(scene, tile, brick, poses[tile], thickness);
    bricks.push_back(std::move(thin.brick));
    placed.push_back(thin.pose);
  }
  const Penetration left = deepestPenetrationOutsidePivots(bricks, makePivots(between, bricks),
                                                           scene.environment.pivotZone, placed);
  return left.depth <= kNegligibleDepth * tileSize(scene.model);
}

// The largest thickness tried that frees the pair, metres; 0 where none does.
double freeingThickness(const Scene& scene, const Penetration& overlap, const Poses& poses,
                        const std::vector<Joint>& between, SearchBudget& budget) {
  for (double share = kThinnerStep; share > kThinnest; share *= kThinnerStep) {
    const double thickness = share * scene.brick.thickness;
    budget.spend(kWorkOfPair);
    if (isFree(scene, overlap, poses, between, thickness)) return thickness;
  }
  return 0;
}

}  // namespace

std::vector<BlockingPair> blockingPairs(const Scene& scene, const Poses& atTarget,
                                        SearchBudget& budget) {
  std::vector<BlockingPair> pairs;
  if (atTarget.empty() || !sceneNeeds(scene).contacts.on) return pairs;
  const std::vector<Penetration> overlaps = overlapsAt(scene, atTarget);
  if (overlaps.empty()) return pairs;
  const std::map<TilePair, JointFace> faces = freeingFaces(scene, overlaps, budget);
  const JointsByPair joints = jointsByPair(scene.model);
  for (const Penetration& overlap : overlaps) {
    BlockingPair pair{overlap.brickA, overlap.brickB, overlap.depth, !budget.isSpent(), {}, 0};
    const auto face = faces.find({pair.tileA, pair.tileB});
    if (face != faces.end()) pair.freeingFace = face->second;
    const auto between = joints.find({pair.tileA, pair.tileB});
    if (pair.isExplained) {
      pair.freeingThickness = freeingThickness(
          scene, overlap, atTarget,
          between == joints.end() ? std::vector<Joint>{} : between->second, budget);
    }
    pairs.push_back(pair);
  }
  return pairs;
}

std::string describe(const BlockingPair& pair, int countsFrom) {
  std::vector<std::string> ways;
  if (pair.freeingFace) {
    ways.push_back(
        fmt::format("joints on the {}", *pair.freeingFace == JointFace::Top ? "top" : "bottom"));
  }
  if (pair.freeingThickness > 0) {
    ways.push_back(fmt::format("a thickness of {:.2g}", pair.freeingThickness));
  }
  return fmt::format("tiles {} and {} by {:.2g} ({})", countsFrom + pair.tileA,
                     countsFrom + pair.tileB, pair.overlap,
                     !pair.isExplained && ways.empty() ? "what frees them was not looked for"
                     : ways.empty()                    ? "the tiles themselves overlap"
                                    : fmt::format("free with {}", fmt::join(ways, " or ")));
}

}  // namespace kirireel
