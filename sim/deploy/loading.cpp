// A scene with grips: its sheet is made, in the plane with three coordinates a tile or in space as
// bars and hinges, its equilibria are followed from the load 0 to 1 (load_path.cpp), and the states
// found are walked as a path of the mechanism is. Everything that equilibria do not know is refused
// with what to leave away: time, contacts, gravity, links, drives.
#include "sim/deploy/loading.h"

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/geometric_path.h"
#include "sim/mechanics/bar_hinge_sheet.h"
#include "sim/mechanics/elastic_sheet.h"
#include "sim/mechanics/load_path.h"
#include "sim/model/convex_parts.h"
#include "sim/model/stiffness.h"
#include "sim/scene/scene_needs.h"
#include "sim/scene/scene_parts.h"

namespace kirireel::deploy {
namespace {

/// The tiles that are pinned from the start, which is all that the timeline may ask for.
std::vector<int> pinnedTiles(const scene::Scene& scene) {
  std::vector<int> tiles;
  for (const scene::TimelineEntry& entry : scene.timeline) {
    const auto* pin = std::get_if<scene::timeline::Pin>(&entry.action);
    if (!pin || entry.when.value != 0) {
      throw inputErrorAt(entry.where,
                         "grips are followed through equilibria, which know no time; "
                         "leave this away, or the grips");
    }
    tiles.insert(tiles.end(), pin->tiles.begin(), pin->tiles.end());
  }
  return tiles;
}

// Each message says what to leave away.
void requireEquilibria(const scene::Scene& scene) {
  scene::Scene bare = scene;
  // What the checks below allow by themselves is taken out, so that isQuasiStatic() speaks of the
  // rest.
  bare.timeline.clear();
  bare.hinges = {};
  if (!bare.model.target) bare.model.target = bare.model.tiles;  // grips hold what no joint does
  bare.actuation.drive = scene::defaultDrive(bare.model);
  std::string reason;
  if (!scene::isQuasiStatic(bare, reason)) {
    throw InputError(fmt::format(
        "error: grips are followed through equilibria, but {}; leave that away, or the grips",
        reason));
  }
  if (scene.path.kind != scene::PathKind::Auto &&
      scene.path.kind != scene::PathKind::Continuation) {
    throw InputError("error: grips are followed through equilibria; remove `path` or the grips");
  }
  const scene::ContactFilter contacts = scene.environment.contacts;
  if (contacts == scene::ContactFilter::All || contacts == scene::ContactFilter::Unjoined) {
    throw InputError(
        "error: equilibria under grips have no contacts; remove `contacts` or the grips");
  }
  if (const scene::Need planar = scene::sceneNeeds(scene).planar;
      !planar.on && !scene.hinges.panels) {
    throw InputError(
        fmt::format("error: grips load rigid tiles only in the plane, but {}; let the tiles bend "
                    "(`panels`), or remove the grips",
                    scene.solver.planar ? "`planar` is off" : planar.reason));
  }
  const auto isLink = [](const model::Joint& joint) {
    return joint.kind == model::JointKind::Link;
  };
  if (std::ranges::any_of(scene.model.joints, isLink)) {
    throw InputError(
        "error: grips load sheets of tiles and joints, not of links; remove `link` or the grips");
  }
}

/// What a grip holds of its tiles: its corners, or the tiles' middles.
std::vector<mechanics::GripHandle> handlesOf(const GripOrder& grip,
                                             const std::vector<model::Brick>& bricks) {
  std::vector<mechanics::GripHandle> points;
  for (const model::Corner& corner : grip.setting->corners) {
    const model::Brick& brick = bricks[static_cast<std::size_t>(corner.tile)];
    points.push_back({corner.tile, brick.bottom[static_cast<std::size_t>(corner.vertex)]});
  }
  if (!points.empty()) return points;
  for (const int tile : grip.setting->tiles) {
    points.push_back(
        {tile, meanPoint(bricks[static_cast<std::size_t>(tile)].bottom), grip.name.isTurn});
  }
  return points;
}

/// The grips of a scene, one for each direction that it names.
std::vector<GripOrder> gripsOf(const scene::Scene& scene) {
  std::vector<GripOrder> found;
  for (std::size_t k = 0; k < scene.grips.size(); ++k) {
    const scene::GripSetting& setting = scene.grips[k];
    const auto add = [&](const std::optional<double>& amount, const Vector3& direction,
                         const char* word) {
      if (!amount) return;
      const bool isTurn = direction.isZero();
      found.push_back(
          {&setting, direction, *amount, {fmt::format("grip {} {}", k + 1, word), isTurn}});
    };
    add(setting.x, Vector3::UnitX(), "x");
    add(setting.y, Vector3::UnitY(), "y");
    add(setting.z, Vector3::UnitZ(), "z");
    add(setting.turn, Vector3::Zero(), "turn");
  }
  return found;
}

/// The first grip that moves or pushes.
std::size_t leadingOf(const std::vector<GripOrder>& grips) {
  const auto leading =
      std::ranges::find_if(grips, [](const GripOrder& grip) { return grip.amount != 0; });
  if (leading == grips.end()) {
    throw inputErrorAt(grips.front().setting->where,
                       "no grip moves or pushes anything; give one of them move = {x = 0.1} or "
                       "another amount that is not 0");
  }
  return static_cast<std::size_t>(leading - grips.begin());
}

/// The sheet in three coordinates a tile.
std::unique_ptr<mechanics::LoadedSheet> planarSheet(const scene::Scene& scene,
                                                    const std::vector<model::Brick>& bricks,
                                                    const scene::Ties& ties,
                                                    const std::vector<GripOrder>& grips) {
  std::vector<mechanics::Grip> held;
  for (const GripOrder& grip : grips) {
    if (grip.setting->z) {
      throw inputErrorAt(
          grip.setting->where,
          "grips load this sheet in its plane; remove z, or let the tiles bend (`panels`)");
    }
    held.push_back({handlesOf(grip, bricks), grip.direction, grip.amount, grip.setting->isForce});
  }
  return std::make_unique<mechanics::ElasticSheet>(
      bricks, model::startPoses(scene.model.tiles, bricks), ties.pairForces, ties.pivots,
      pinnedTiles(scene), std::move(held));
}

/// The states as a path to be walked.
GeometricPath walkable(const std::vector<model::Brick>& bricks, const mechanics::LoadPath& loaded,
                       bool isSoft) {
  GeometricPath walked;
  walked.hasCompliantJoints = isSoft;
  walked.contactReason = "equilibria under grips are without contacts";
  walked.reason = "equilibria under grips";
  for (const mechanics::Equilibrium& state : loaded.states) {
    MechanismPath& path = walked.path;
    const double length =
        path.states.empty()
            ? 0
            : path.lengths.back() + pathDistance(bricks, path.states.back(), state.poses);
    path.states.push_back(state.poses);
    path.lengths.push_back(length);
  }
  return walked;
}

/// What happened on the way, each at its time in the walk.
void noteTurnings(const mechanics::LoadCurve& curve, const MechanismPath& path, double seconds,
                  DeploymentResult& result) {
  std::vector<trajectory::Event> events;
  for (std::size_t k = 0; k < curve.states.size(); ++k) {
    const mechanics::Equilibrium& state = curve.states[k];
    if (state.turning == mechanics::Turning::None) continue;
    const double time = path.length() > 0 ? seconds * path.lengths[k] / path.length() : 0;
    events.push_back(
        {time, fmt::format("{} at the load {:.6g}: {} {:.6g} {}, {} {:.6g} {}",
                           mechanics::toString(state.turning), state.load,
                           curve.grips[curve.leading].name, state.displacements[curve.leading],
                           curve.grips[curve.leading].isTurn ? "rad" : "m",
                           curve.grips[curve.leading].isTurn ? "moment" : "force",
                           state.forces[curve.leading],
                           curve.grips[curve.leading].isTurn ? "N m" : "N")});
  }
  result.trajectory.events.insert(result.trajectory.events.begin(), events.begin(), events.end());
}

}  // namespace

DeploymentResult followGrips(const scene::Scene& scene, double sampleInterval,
                             const SampleObserver& observer) {
  requireEquilibria(scene);
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const scene::Ties ties = scene::loadedTies(scene, bricks);
  const std::vector<GripOrder> grips = gripsOf(scene);
  const std::size_t leading = leadingOf(grips);
  const std::unique_ptr<mechanics::LoadedSheet> sheet =
      scene.hinges.panels
          ? makeBarHingeSheet(scene, bricks, ties.pairForces, pinnedTiles(scene), grips)
          : planarSheet(scene, bricks, ties, grips);
  const bool isSoft = scene.hinges.panels || ties.pairForces.replaceJoints();
  mechanics::LoadPathSettings settings;
  settings.leastStates = scene.path.loadSteps;
  settings.mostStates = std::max(settings.mostStates, 20 * scene.path.loadSteps);
  const mechanics::LoadPath loaded = mechanics::followLoad(*sheet, leading, settings, {});
  const GeometricPath path = walkable(bricks, loaded, isSoft);
  Poses last;
  const SampleObserver watch = [&](const trajectory::Sample& sample) {
    last = sample.poses;
    return !observer || observer(sample);
  };
  DeploymentResult result = walk(scene, path, assembleAtTarget(scene), sampleInterval, watch);
  result.loadCurve = mechanics::LoadCurve{{}, leading, loaded.states};
  for (const GripOrder& grip : grips) result.loadCurve->grips.push_back(grip.name);
  if (!ties.pairForces.empty()) {
    result.elasticity = model::elasticityOf(ties.pairForces, loaded.states.front().poses, last);
  }
  result.atTarget.reset();
  noteTurnings(*result.loadCurve, path.path, std::min(scene.path.walkTime, scene.stop.duration),
               result);
  if (result.outcome == Outcome::Interrupted) return result;
  result.outcome = loaded.arrives ? Outcome::Settled : Outcome::Locked;
  result.reason = loaded.arrives ? fmt::format("the load is reached through {} equilibria",
                                               loaded.states.size())
                                 : loaded.trouble;
  result.trajectory.events.back().text =
      fmt::format("{}: {}", toString(result.outcome), result.reason);
  return result;
}

// ------------------------------------------------------------------------------------------------
// A scene's tiles as bars and hinges (bar_hinge_sheet.h).
//
// Corners that joints hold together, in groups, become nodes: the mean of their places. Each tile
// is divided into triangles; every side of a triangle is a bar, with the areas of the triangles on
// its sides added up (stiffness.h), so that a bar between two tiles carries for both. A side
// between two triangles of one tile is where the tile bends, one between triangles of two tiles a
// fold.

namespace {

/// The node of each corner of each tile: corners that joints hold together have one.
std::vector<std::vector<int>> nodesOfTiles(const model::Model& model, int& count) {
  std::vector<std::vector<int>> corners;
  // Numbers of all corners, tile after tile.
  int next = 0;
  for (const model::Tile& tile : model.tiles) {
    corners.emplace_back(tile.vertices.size());
    std::iota(corners.back().begin(), corners.back().end(), next);
    next += static_cast<int>(tile.vertices.size());
  }
  DisjointSets nodes(static_cast<std::size_t>(next));
  const auto cornerAt = [&](const model::Corner& corner) {
    return corners[static_cast<std::size_t>(corner.tile)][static_cast<std::size_t>(corner.vertex)];
  };
  for (const model::Joint& joint : model.joints) nodes.unite(cornerAt(joint.a), cornerAt(joint.b));
  const std::vector<int> numbers = nodes.numbers();
  for (std::vector<int>& tile : corners) {
    for (int& corner : tile) corner = numbers[static_cast<std::size_t>(corner)];
  }
  count = numbers.empty() ? 0 : 1 + *std::ranges::max_element(numbers);
  return corners;
}

/// One triangle at an edge.
struct PanelSide {
  int tile = 0;
  int from = 0, to = 0;  // anticlockwise in the triangle
  int wing = 0;          // its third node
  std::array<int, 3> corners{};
};

/// The two triangles at a fold.
struct FoldSides {
  PanelSide left;
  PanelSide right;
};

using Edge = std::pair<int, int>;
using Edges = std::map<Edge, std::vector<PanelSide>>;

// By their two nodes, the lower first, with the triangles on their sides.
Edges edgesOf(const model::Model& model, const std::vector<std::vector<int>>& nodes) {
  Edges edges;
  for (std::size_t t = 0; t < model.tiles.size(); ++t) {
    for (const std::array<int, 3>& triangle : model::tileTriangles(model.tiles[t])) {
      std::array<int, 3> n{};
      for (std::size_t k = 0; k < 3; ++k) {
        n[k] = nodes[t][static_cast<std::size_t>(triangle[k])];
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const int from = n[k], to = n[(k + 1) % 3];
        edges[std::minmax(from, to)].push_back({static_cast<int>(t), from, to, n[(k + 2) % 3], n});
      }
    }
  }
  return edges;
}

/// A sheet in the making.
class BarHingeMaker {
 public:
  BarHingeMaker(const scene::Scene& scene, const std::vector<model::Brick>& bricks)
      : scene_(scene), material_(*scene.hinges.panels), thickness_(scene.brick.thickness) {
    int count = 0;
    made_.tiles = nodesOfTiles(scene.model, count);
    made_.start = model::startPoses(scene.model.tiles, bricks);
    placeNodes(count);
    edges_ = edgesOf(scene.model, made_.tiles);
    for (const auto& [edge, sides] : edges_) addBar(edge, sides);
    for (const auto& [edge, sides] : edges_) addBends(sides);
  }

  /// Springs at hinges of the scene: each edge that the two tiles share has its part by length.
  void addFolds(const std::vector<model::HingeSpring>& springs) {
    for (const model::HingeSpring& spring : springs) {
      const std::vector<FoldSides> shared = sidesBetween(spring.hinge.brickA, spring.hinge.brickB);
      double length = 0;
      for (const auto& [left, right] : shared) length += lengthOf({left.from, left.to});
      for (const auto& [left, right] : shared) {
        const double share = lengthOf({left.from, left.to}) / length;
        addFold(left, right, share * spring.stiffness).rest = spring.rest;
      }
    }
  }

  // All nodes of these tiles.
  void fix(const std::vector<int>& tiles) {
    for (const int tile : tiles) {
      const std::vector<int>& nodes = made_.tiles[static_cast<std::size_t>(tile)];
      made_.fixed.insert(made_.fixed.end(), nodes.begin(), nodes.end());
    }
    std::ranges::sort(made_.fixed);
    made_.fixed.erase(std::unique(made_.fixed.begin(), made_.fixed.end()), made_.fixed.end());
  }

  mechanics::NodeGrip gripOf(const GripOrder& order) const {
    if (order.name.isTurn) {
      throw inputErrorAt(order.setting->where,
                         "tiles that bend have no turn of their own; hold or move their vertices");
    }
    mechanics::NodeGrip grip{{}, order.direction, order.amount, order.setting->isForce};
    for (const model::Corner& corner : order.setting->corners) {
      grip.handles.push_back({made_.tiles[static_cast<std::size_t>(corner.tile)]
                                         [static_cast<std::size_t>(corner.vertex)]});
    }
    if (!grip.handles.empty()) return grip;
    for (const int tile : order.setting->tiles) {
      grip.handles.push_back(made_.tiles[static_cast<std::size_t>(tile)]);
    }
    return grip;
  }

  mechanics::BarHingeModel take() { return std::move(made_); }

 private:
  /// Each node where its corners are on the average.
  void placeNodes(int count) {
    made_.nodes.assign(static_cast<std::size_t>(count), Vector3::Zero());
    std::vector<double> corners(static_cast<std::size_t>(count), 0);
    for (std::size_t t = 0; t < made_.tiles.size(); ++t) {
      for (std::size_t k = 0; k < made_.tiles[t].size(); ++k) {
        const auto node = static_cast<std::size_t>(made_.tiles[t][k]);
        made_.nodes[node] += scene_.model.tiles[t].vertices[k];
        ++corners[node];
      }
    }
    for (std::size_t n = 0; n < made_.nodes.size(); ++n) made_.nodes[n] /= corners[n];
  }

  const Vector3& at(int node) const { return made_.nodes[static_cast<std::size_t>(node)]; }
  double lengthOf(const Edge& edge) const { return (at(edge.second) - at(edge.first)).norm(); }

  // One bar for all triangles at the edge.
  void addBar(const Edge& edge, const std::vector<PanelSide>& sides) {
    double area = 0;
    for (const PanelSide& side : sides) {
      const auto& [a, b, c] = side.corners;
      area += model::barArea({at(a), at(b), at(c)}, thickness_, material_.poisson);
    }
    const double length = lengthOf(edge);
    // Stiffness of a bar: E A / l.
    made_.bars.push_back({edge.first, edge.second, length, material_.youngs * area / length});
  }

  /// Where a tile bends: between two of its triangles.
  void addBends(const std::vector<PanelSide>& sides) {
    for (std::size_t b = 1; b < sides.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const PanelSide &left = sides[a], &right = sides[b];
        if (left.tile != right.tile) continue;
        const std::array<Vector3, 4> corners = {at(left.from), at(right.wing), at(left.to),
                                                at(left.wing)};
        addFold(left, right,
                model::bendStiffness(corners, (corners[2] - corners[0]).norm(), material_.youngs,
                                     material_.poisson, thickness_));
      }
    }
  }

  mechanics::Fold& addFold(const PanelSide& left, const PanelSide& right, double stiffness) {
    mechanics::Fold fold{{left.from, left.to, left.wing, right.wing}, stiffness, 0};
    // Without a rest angle of its own a fold rests as it stands.
    fold.rest = mechanics::foldAngle({at(left.from), at(left.to), at(left.wing), at(right.wing)});
    return made_.folds.emplace_back(fold);
  }

  /// The triangles of two tiles on both sides of each edge that they share.
  std::vector<FoldSides> sidesBetween(int a, int b) const {
    std::vector<FoldSides> found;
    for (const auto& [edge, sides] : edges_) {
      for (const PanelSide& left : sides) {
        for (const PanelSide& right : sides) {
          if (left.tile == a && right.tile == b) found.push_back({left, right});
        }
      }
    }
    if (found.empty()) refuseHinge(a, b);
    return found;
  }

  [[noreturn]] void refuseHinge(int a, int b) const {
    const int first = scene_.model.fileOrder.countsFrom;
    throw InputError(fmt::format(
        "error: tiles that bend fold about edges that two of them have in common, but tiles {} and "
        "{} have none; split the tile with the longer edge at the corner of the other",
        first + a, first + b));
  }

  const scene::Scene& scene_;
  const scene::PanelMaterial& material_;
  double thickness_;
  mechanics::BarHingeModel made_;
  Edges edges_;
};

void requireNodes(const model::Model& model) {
  for (const model::Joint& joint : model.joints) {
    if (joint.kind != model::JointKind::Pivot) {
      throw InputError(
          "error: tiles that bend are joined at corners; remove `fix` and `link`, or `panels`");
    }
    if (joint.face == model::JointFace::Both) {
      throw InputError(
          "error: tiles that bend are joined at one face, not at both as hinges through their "
          "thickness are; set the face of each joint to 1 (bottom), or remove `panels`");
    }
  }
}

/// Tiles that bend have springs at their folds; other forces need bricks that are rigid.
void requireSpringsAlone(const model::PairForces& forces) {
  for (const std::shared_ptr<const model::PairForce>& force : forces) {
    if (force->hingeSprings()) continue;
    throw InputError(
        fmt::format("error: tiles that bend (`panels`) have springs at hinges, but no {}; remove "
                    "one of the two",
                    force->name().counted));
  }
}

}  // namespace

std::unique_ptr<mechanics::LoadedSheet> makeBarHingeSheet(const scene::Scene& scene,
                                                          const std::vector<model::Brick>& bricks,
                                                          const model::PairForces& pairForces,
                                                          const std::vector<int>& pinned,
                                                          const std::vector<GripOrder>& grips) {
  requireNodes(scene.model);
  requireSpringsAlone(pairForces);
  BarHingeMaker maker(scene, bricks);
  maker.addFolds(model::hingeSpringsOf(pairForces));
  maker.fix(pinned);
  std::vector<mechanics::NodeGrip> held;
  for (const GripOrder& grip : grips) held.push_back(maker.gripOf(grip));
  return std::make_unique<mechanics::BarHingeSheet>(maker.take(), std::move(held));
}

}  // namespace kirireel::deploy
