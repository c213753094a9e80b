// A scene with grips: its sheet is made, in the plane with three coordinates a tile or in space as
// bars and hinges, its equilibria are followed from the load 0 to 1 (load_path.cpp), and the states
// found are walked as a path of the mechanism is. Everything that equilibria do not know is refused
// with what to leave away: time, contacts, gravity, links, drives.
#include "sim/deploy/loading.h"

#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/bar_hinge_scene.h"
#include "sim/deploy/geometric_path.h"
#include "sim/deploy/neck_ties.h"
#include "sim/equilibrium/elastic_sheet.h"
#include "sim/equilibrium/load_path.h"
#include "sim/scene/hinge_springs.h"

namespace kirireel {
namespace {

/// The tiles that are pinned from the start, which is all that the timeline may ask for.
std::vector<int> pinnedTiles(const Scene& scene) {
  std::vector<int> tiles;
  for (const TimelineEntry& entry : scene.timeline) {
    const auto* pin = std::get_if<timeline::Pin>(&entry.action);
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
void requireEquilibria(const Scene& scene) {
  Scene bare = scene;
  // What the checks below allow by themselves is taken out, so that isQuasiStatic() speaks of the
  // rest.
  bare.timeline.clear();
  bare.hinges = {};
  if (!bare.model.target) bare.model.target = bare.model.tiles;  // grips hold what no joint does
  bare.actuation.drive = defaultDrive(bare.model);
  std::string reason;
  if (!isQuasiStatic(bare, reason)) {
    throw InputError(fmt::format(
        "error: grips are followed through equilibria, but {}; leave that away, or the grips",
        reason));
  }
  if (scene.path.kind != PathKind::Auto && scene.path.kind != PathKind::Continuation) {
    throw InputError(
        "error: grips are followed through equilibria; leave --path away, or the grips");
  }
  const ContactFilter contacts = scene.environment.contacts;
  if (contacts == ContactFilter::All || contacts == ContactFilter::Unjoined) {
    throw InputError(
        "error: equilibria under grips are without contacts; leave --contacts away, or the grips");
  }
  if (const Need planar = sceneNeeds(scene).planar; !planar.on && !scene.hinges.panels) {
    throw InputError(fmt::format(
        "error: grips load rigid tiles in the plane alone, but {}; let the tiles bend (--panels), "
        "or leave the grips away",
        planar.reason));
  }
  const auto isLink = [](const Joint& joint) { return joint.kind == JointKind::Link; };
  if (std::ranges::any_of(scene.model.joints, isLink)) {
    throw InputError(
        "error: grips load sheets of tiles and joints, not of links; leave --link "
        "away, or the grips");
  }
}

/// What a grip holds of its tiles: its corners, or the tiles' middles.
std::vector<GripHandle> handlesOf(const GripOrder& grip, const std::vector<Brick>& bricks) {
  std::vector<GripHandle> points;
  for (const Corner& corner : grip.setting->corners) {
    const Brick& brick = bricks[static_cast<std::size_t>(corner.tile)];
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
std::vector<GripOrder> gripsOf(const Scene& scene) {
  std::vector<GripOrder> found;
  for (std::size_t k = 0; k < scene.grips.size(); ++k) {
    const GripSetting& setting = scene.grips[k];
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
std::unique_ptr<LoadedSheet> planarSheet(const Scene& scene, const std::vector<Brick>& bricks,
                                         const std::vector<HingeSpring>& springs, const Ties& ties,
                                         const std::vector<GripOrder>& grips) {
  std::vector<Grip> held;
  for (const GripOrder& grip : grips) {
    if (grip.setting->z) {
      throw inputErrorAt(grip.setting->where,
                         "grips load this sheet in its plane; leave z away, or let the tiles bend "
                         "(--panels)");
    }
    held.push_back({handlesOf(grip, bricks), grip.direction, grip.amount, grip.setting->isForce});
  }
  return std::make_unique<ElasticSheet>(bricks, startPoses(scene.model.tiles, bricks), springs,
                                        ties.pivots, pinnedTiles(scene), std::move(held),
                                        ties.ligaments);
}

/// The states as a path to be walked.
GeometricPath walkable(const std::vector<Brick>& bricks, const LoadPath& loaded, bool isSoft) {
  GeometricPath walked;
  walked.hasCompliantJoints = isSoft;
  walked.contactReason = "equilibria under grips are without contacts";
  walked.reason = "equilibria under grips";
  for (const Equilibrium& state : loaded.states) {
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
void noteTurnings(const LoadCurve& curve, const MechanismPath& path, double seconds,
                  DeploymentResult& result) {
  std::vector<Event> events;
  for (std::size_t k = 0; k < curve.states.size(); ++k) {
    const Equilibrium& state = curve.states[k];
    if (state.turning == Turning::None) continue;
    const double time = path.length() > 0 ? seconds * path.lengths[k] / path.length() : 0;
    events.push_back(
        {time, fmt::format(
                   "{} at the load {:.6g}: {} {:.6g} {}, {} {:.6g} {}", toString(state.turning),
                   state.load, curve.grips[curve.leading].name, state.displacements[curve.leading],
                   curve.grips[curve.leading].isTurn ? "rad" : "m",
                   curve.grips[curve.leading].isTurn ? "moment" : "force",
                   state.forces[curve.leading], curve.grips[curve.leading].isTurn ? "N m" : "N")});
  }
  result.trajectory.events.insert(result.trajectory.events.begin(), events.begin(), events.end());
}

}  // namespace

DeploymentResult followGrips(const Scene& scene, double sampleInterval,
                             const SampleObserver& observer) {
  requireEquilibria(scene);
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  const std::vector<HingeSpring> springs = hingeSprings(scene, bricks);
  const std::vector<GripOrder> grips = gripsOf(scene);
  const std::size_t leading = leadingOf(grips);
  const Ties ties = scene.hinges.panels ? Ties{} : tiesOf(scene, bricks, springs);
  const std::unique_ptr<LoadedSheet> sheet =
      scene.hinges.panels ? makeBarHingeSheet(scene, bricks, springs, pinnedTiles(scene), grips)
                          : planarSheet(scene, bricks, springs, ties, grips);
  const bool isSoft = scene.hinges.panels || !ties.ligaments.empty();
  LoadPathSettings settings;
  settings.leastStates = scene.path.loadSteps;
  settings.mostStates = std::max(settings.mostStates, 20 * scene.path.loadSteps);
  const LoadPath loaded = followLoad(*sheet, leading, settings, {});
  const GeometricPath path = walkable(bricks, loaded, isSoft);
  Poses last;
  const SampleObserver watch = [&](const Sample& sample) {
    last = sample.poses;
    return !observer || observer(sample);
  };
  DeploymentResult result = walk(scene, path, assembleAtTarget(scene), sampleInterval, watch);
  result.loadCurve = LoadCurve{{}, leading, loaded.states};
  for (const GripOrder& grip : grips) result.loadCurve->grips.push_back(grip.name);
  result.elasticity = elasticityOf(springs, loaded.states.front().poses, last);
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

}  // namespace kirireel
