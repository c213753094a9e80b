// A scene with grips. Its sheet is created: in the plane with three coordinates per tile, or in
// space as bars and hinges. Its equilibria are followed from load 0 to 1 (load_path.cpp). The
// resulting states are played back like a kinematic path. Features that equilibria do not support
// are rejected, with a message that names them: time, contacts, gravity, links, drives.
#include "sim/statics/loading.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>

#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"
#include "sim/base/words.h"
#include "sim/brick/stiffness.h"
#include "sim/mechanics/load_path.h"
#include "sim/model/convex_parts.h"
#include "sim/run/assembled_state.h"
#include "sim/run/dynamics.h"
#include "sim/run/geometric_path.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/path_evaluation.h"
#include "sim/scene/scene_needs.h"
#include "sim/scene/scene_parts.h"
#include "sim/statics/bar_hinge_sheet.h"
#include "sim/statics/elastic_sheet.h"

namespace kirireel::statics {
namespace {

/// The tiles that are pinned at the start. The timeline may contain nothing else.
std::vector<int> pinnedTiles(const scene::Scene& scene) {
  std::vector<int> tiles;
  for (const scene::TimelineEntry& entry : scene.timeline) {
    const auto* pin = std::get_if<scene::timeline::Pin>(&entry.action);
    if (!pin || entry.when.value != 0) {
      throw inputErrorAt(
          entry.where,
          "grips use equilibria without time, so this entry has no effect. Remove it or the grips");
    }
    tiles.insert(tiles.end(), pin->tiles.begin(), pin->tiles.end());
  }
  return tiles;
}

/// Throws if a piece of the model has no grip and no pin: nothing would hold it.
void requireHeldPieces(const scene::Scene& scene) {
  const std::vector<int> pieces = model::piecesOf(scene.model);
  std::vector<int> sizes(1 + *std::ranges::max_element(pieces), 0);
  for (const int piece : pieces) ++sizes[piece];
  std::vector<bool> isHeld(sizes.size(), false);
  for (const int tile : pinnedTiles(scene)) isHeld[pieces[tile]] = true;
  for (const scene::GripSetting& grip : scene.grips) {
    for (const int tile : grip.tiles) isHeld[pieces[tile]] = true;
  }
  const auto loose = std::ranges::find(isHeld, false);
  if (sizes.size() == 1 || loose == isHeld.end()) return;
  const auto piece = static_cast<int>(loose - isHeld.begin());
  const auto tile = std::ranges::find(pieces, piece) - pieces.begin();
  throw InputError(fmt::format(
      "error: the model has {} pieces, and nothing holds the piece of tile {} ({} of {} tiles). "
      "Hold each piece with grips or `pin`",
      sizes.size(), scene.model.fileOrder.countsFrom + tile, sizes[piece], pieces.size()));
}

// Each message names the feature to remove.
void requireEquilibria(const scene::Scene& scene) {
  scene::Scene bare = scene;
  // Features that the checks below allow are removed: isQuasiStatic() then reports only the rest.
  bare.timeline.clear();
  bare.hinges = {};
  if (!bare.model.target) bare.model.target = bare.model.tiles;  // grips hold unjoined tiles
  bare.actuation.drive = scene::defaultDrive(bare.model);
  std::string reason;
  if (!scene::isQuasiStatic(bare, reason)) {
    throw InputError(fmt::format(
        "error: grips support scenes in equilibrium only, but {}. Remove it or the grips", reason));
  }
  if (scene.path.kind != scene::PathKind::Auto &&
      scene.path.kind != scene::PathKind::Continuation) {
    throw InputError(
        "error: grips follow equilibria instead of a path. Remove `path` or the grips");
  }
  const scene::ContactFilter contacts = scene.environment.contacts;
  if (contacts == scene::ContactFilter::All || contacts == scene::ContactFilter::Unjoined) {
    throw InputError(
        "error: equilibria under grips have no contacts. Remove `contacts` or the grips");
  }
  if (const scene::Need planar = scene::sceneNeeds(scene).planar;
      !planar.on && !scene.hinges.panels) {
    throw InputError(
        fmt::format("error: grips load rigid tiles only in the plane, but {}. Let the tiles bend "
                    "(`panels`) or remove the grips",
                    scene.solver.planar ? "`planar` is off" : planar.reason));
  }
  for (const model::Joint& joint : scene.model.joints) {
    if (joint.kind == model::JointKind::Pivot || joint.kind == model::JointKind::Fixed) continue;
    throw InputError(
        fmt::format("error: grips do not support joints of the kind {0}. Remove "
                    "`{0}` or the grips",
                    model::kindName(joint)));
  }
}

/// The points that a grip holds: its corners, or the centres of its tiles.
std::vector<GripHandle> handlesOf(const GripOrder& grip, const std::vector<brick::Brick>& bricks) {
  std::vector<GripHandle> points;
  for (const model::Corner& corner : grip.setting->corners) {
    const brick::Brick& brick = bricks[static_cast<std::size_t>(corner.tile)];
    points.push_back({corner.tile, brick.bottom[static_cast<std::size_t>(corner.vertex)]});
  }
  if (!points.empty()) return points;
  for (const int tile : grip.setting->tiles) {
    points.push_back(
        {tile, meanPoint(bricks[static_cast<std::size_t>(tile)].bottom), grip.name.isTurn});
  }
  return points;
}

/// The grips of a scene, one per direction.
std::vector<GripOrder> gripsOf(const scene::Scene& scene) {
  std::vector<GripOrder> found;
  for (std::size_t k = 0; k < scene.grips.size(); ++k) {
    const scene::GripSetting& setting = scene.grips[k];
    const auto add = [&](const std::optional<double>& amount, const Vector3& direction,
                         const char* word) {
      if (!amount) return;
      const bool isTurn = direction.isZero();
      found.push_back(
          {&setting, direction, *amount, {fmt::format("grip {} {}", k + 1, word), isTurn}, word});
    };
    add(setting.x, setting.axes.col(0), "x");
    add(setting.y, setting.axes.col(1), "y");
    add(setting.z, setting.axes.col(2), "z");
    add(setting.turn, Vector3::Zero(), "turn");
  }
  return found;
}

/// A load that has several of x, y and z: its direction, and the sum over the grips of these axes.
struct DirectedLoad {
  GripOrder order;
  mechanics::GripSum sum;
};

std::vector<DirectedLoad> directedLoads(const std::vector<GripOrder>& grips) {
  std::vector<DirectedLoad> found;
  for (std::size_t first = 0; first < grips.size();) {
    DirectedLoad load{grips[first], {}};
    Vector3 whole = Vector3::Zero();
    double square = 0;
    std::size_t g = first;
    for (; g < grips.size() && grips[g].setting == grips[first].setting; ++g) {
      const double amount = grips[g].amount;
      if (grips[g].name.isTurn || amount == 0) continue;
      load.sum.push_back({g, amount});
      whole += amount * grips[g].direction;
      square += amount * amount;
    }
    first = g;
    if (load.sum.size() < 2) continue;
    load.order.amount = std::sqrt(square);
    load.order.direction = whole.normalized();
    load.order.axis = "along";
    std::string& name = load.order.name.name;
    name = name.substr(0, name.rfind(' ') + 1) + load.order.axis;
    for (mechanics::GripShare& share : load.sum) share.share /= load.order.amount;
    found.push_back(std::move(load));
  }
  return found;
}

/// The first load: the index of its grip, or the number of grips plus that of its direction.
std::size_t leadingOf(const std::vector<GripOrder>& grips,
                      const std::vector<DirectedLoad>& directed) {
  const auto leading =
      std::ranges::find_if(grips, [](const GripOrder& grip) { return grip.amount != 0; });
  if (leading == grips.end()) {
    throw inputErrorAt(grips.front().setting->where,
                       "no grip moves or pushes. Set an amount other than 0 for one of them, for "
                       "example move = {x = 0.1}");
  }
  for (std::size_t k = 0; k < directed.size() && !leading->name.isTurn; ++k) {
    if (directed[k].order.setting == leading->setting) return grips.size() + k;
  }
  return static_cast<std::size_t>(leading - grips.begin());
}

/// For example "x of tile 3 (grip 2)".
std::string held(const scene::Scene& scene, const GripOrder& grip) {
  std::vector<std::string> parts;
  const int first = scene.model.fileOrder.countsFrom;
  for (const model::Corner& corner : grip.setting->corners) {
    parts.push_back(fmt::format("tile {} vertex {}", first + corner.tile, corner.vertex));
  }
  if (parts.empty()) {
    for (const int tile : grip.setting->tiles) parts.push_back(fmt::format("{}", first + tile));
    return fmt::format("{} of tile{} {}", grip.axis, parts.size() == 1 ? "" : "s",
                       fmt::join(parts, ", "));
  }
  return fmt::format("{} of {}", grip.axis, fmt::join(parts, ", "));
}

constexpr double kBlocked = 1e-6;  // smaller blocked moves are rounding, relative to all moves

/// The part of the grips' moves that joints, pins and other grips do not allow, to first order at
/// the start: the residual of a least-squares fit of the moves by motions of the sheet.
Eigen::VectorXd blockedMoves(const mechanics::LoadedSheet& sheet) {
  using Matrix = mechanics::LoadedSheet::Matrix;
  constexpr double kFirm = 1e-9;  // relative to the squares of the rows
  const Matrix rows = sheet.jacobian(sheet.startCoordinates());
  Eigen::VectorXd missing = sheet.motion();
  if (missing.size() == 0 || missing.isZero(0)) return missing;
  Matrix firm(rows.cols(), rows.cols());
  firm.setIdentity();
  const Matrix square = Matrix(rows.transpose() * rows) + kFirm * firm;
  const Eigen::SimplicialLDLT<Matrix> factor(square);
  // Each round corrects the error of the added diagonal.
  for (int round = 0; round < 5; ++round) {
    missing -= rows * factor.solve(Eigen::VectorXd(rows.transpose() * missing));
  }
  return missing;
}

/// Throws InputError for contradicting grips: the joints do not allow their combined moves. If the
/// joints block a single [[grip]], this is not an error, because the path reports it at its end.
/// All axes of a [[grip]] count as one move.
void requireAgreement(const scene::Scene& scene, const std::vector<GripOrder>& grips,
                      const mechanics::LoadedSheet& sheet) {
  const Eigen::VectorXd blocked = blockedMoves(sheet);
  if (blocked.norm() <= kBlocked * sheet.motion().norm()) return;
  std::vector<std::string> names;
  const GripOrder* last = nullptr;
  bool areSeveral = false;
  for (std::size_t g = 0; g < grips.size(); ++g) {
    const auto [first, count] = sheet.rowsOf(g);
    if (!(blocked.segment(first, count).norm() > kBlocked * blocked.norm())) continue;
    const GripOrder& grip = grips[g];
    names.push_back(fmt::format("{} by {:g} ({})", held(scene, grip), grip.amount, grip.name.name));
    areSeveral |= last && (last->setting != grip.setting || last->name.isTurn != grip.name.isTurn);
    last = &grip;
  }
  if (!areSeveral) return;
  throw inputErrorAt(last->setting->where,
                     fmt::format("grips contradict each other: the joints do not allow {} "
                                 "together. Remove one of these grips or change its move",
                                 fmt::join(names, ", ")));
}

/// Whether a direction is the normal of the sheet: the z axis of the scene.
bool isNormal(const Vector3& direction) {
  constexpr double kRounding = 1e-9;
  return direction.head<2>().norm() <= kRounding;
}

/// The directions among x, y and z that a grip names, in the plane of the sheet.
struct NamedDirections {
  std::vector<int> axes;       ///< columns of GripSetting::axes
  Eigen::MatrixXd directions;  ///< their parts in the plane, one per row
  Eigen::VectorXd amounts;     ///< at load 1
  /// Projection of amounts or forces along these directions onto those of vectors in the plane. Its
  /// rank is that of the directions.
  Eigen::MatrixXd projection;
  int rank = 0;

  bool areDependent() const { return rank < static_cast<int>(axes.size()); }
  /// The row of an axis.
  Eigen::Index rowOf(int axis) const { return std::ranges::find(axes, axis) - axes.begin(); }
};

// Singular values below the tolerance of the sheet's plane are rounding of the file. Without them,
// dependent directions are exactly dependent.
NamedDirections namedDirections(const scene::GripSetting& grip) {
  constexpr double kDependent = 1e-7;  // of the largest singular value
  NamedDirections named;
  const std::optional<double>* const amounts[] = {&grip.x, &grip.y, &grip.z};
  for (int k = 0; k < 3; ++k) {
    if (*amounts[k]) named.axes.push_back(k);
  }
  const auto count = static_cast<Eigen::Index>(named.axes.size());
  named.directions.resize(count, 2);
  named.amounts.resize(count);
  for (Eigen::Index row = 0; row < count; ++row) {
    const int axis = named.axes[static_cast<std::size_t>(row)];
    named.directions.row(row) = grip.axes.col(axis).head<2>();
    named.amounts[row] = **amounts[axis];
  }
  if (count == 0) return named;
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(named.directions,
                                        Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(kDependent);
  named.rank = static_cast<int>(svd.rank());
  const Eigen::MatrixXd range = svd.matrixU().leftCols(named.rank);
  named.projection = range * range.transpose();
  if (named.areDependent()) named.directions = named.projection * named.directions;
  return named;
}

/// Throws InputError if a grip names the normal of the sheet, has amounts that no move in the plane
/// has, or has a force out of the plane.
void requireInPlane(const scene::GripSetting& grip) {
  constexpr double kRounding = 1e-9;
  const NamedDirections named = namedDirections(grip);
  if (named.axes.empty()) return;
  for (const int axis : named.axes) {
    if (!isNormal(grip.axes.col(axis))) continue;
    throw inputErrorAt(
        grip.where,
        fmt::format(
            "grips load this sheet only in its plane. Remove {} or let the tiles bend (`panels`)",
            "xyz"[axis]));
  }
  double out = (named.projection * named.amounts - named.amounts).norm();
  if (grip.isForce) {
    out = 0;
    for (std::size_t k = 0; k < named.axes.size(); ++k) {
      out += named.amounts[static_cast<Eigen::Index>(k)] * grip.axes.col(named.axes[k]).z();
    }
  }
  if (std::abs(out) <= kRounding * named.amounts.norm()) return;
  throw inputErrorAt(grip.where,
                     "this grip moves out of the plane of the sheet. Set x, y and z of a direction "
                     "in the plane, or let the tiles bend (`panels`)");
}

/// The sheet with three coordinates per tile.
std::unique_ptr<mechanics::LoadedSheet> planarSheet(const scene::Scene& scene,
                                                    const std::vector<brick::Brick>& bricks,
                                                    const scene::Ties& ties,
                                                    const std::vector<GripOrder>& grips) {
  for (const scene::GripSetting& grip : scene.grips) requireInPlane(grip);
  std::vector<Grip> held;
  for (const GripOrder& grip : grips) {
    held.push_back({handlesOf(grip, bricks), Vector3::Zero(), grip.amount, grip.setting->isForce});
    if (grip.name.isTurn) continue;
    const NamedDirections named = namedDirections(*grip.setting);
    const Eigen::Index row = named.rowOf(grip.axis.front() - 'x');
    held.back().direction.head<2>() = named.directions.row(row);
    if (!named.areDependent()) continue;
    // gripsOf() lists the axes of a setting consecutively.
    const std::size_t first = held.size() - 1 - static_cast<std::size_t>(row);
    for (Eigen::Index k = 0; k < named.projection.cols(); ++k) {
      held.back().force.push_back({first + static_cast<std::size_t>(k), named.projection(row, k)});
    }
  }
  return std::make_unique<ElasticSheet>(bricks, brick::startPoses(scene.model.tiles, bricks),
                                        ties.pairForces, ties.pivots, pinnedTiles(scene),
                                        std::move(held));
}

/// The states as a path for playback.
run::GeometricPath playbackPath(const std::vector<brick::Brick>& bricks,
                                const mechanics::LoadPath& loaded, bool isSoft) {
  run::GeometricPath result;
  result.hasCompliantJoints = isSoft;
  result.contactReason = "equilibria under grips have no contacts";
  result.reason = "equilibria under grips";
  for (const mechanics::Equilibrium& state : loaded.states) {
    run::MechanismPath& path = result.path;
    const double length =
        path.states.empty()
            ? 0
            : path.lengths.back() + run::pathDistance(bricks, path.states.back(), state.poses);
    path.states.push_back(state.poses);
    path.lengths.push_back(length);
  }
  return result;
}

/// The time of a state in the playback, which takes so many seconds.
double timeOf(const run::MechanismPath& path, std::size_t state, double seconds) {
  return path.length() > 0 ? seconds * path.lengths[state] / path.length() : 0;
}

// Folds within this angle of a half turn are closed, radians. Beyond it angles jump.
constexpr double kClosedFold = 1e-3;

/// The equilibria of bars and hinges, at their times in the playback.
std::shared_ptr<const trajectory::LoadedPanels> panelsOf(const BarHingeSheet& sheet,
                                                         const mechanics::LoadPath& loaded,
                                                         const run::MechanismPath& path,
                                                         double seconds) {
  trajectory::LoadedPanels panels = sheet.panels();
  for (std::size_t k = 0; k < loaded.states.size(); ++k) {
    panels.states.push_back(sheet.panelState(loaded.states[k].coordinates));
    panels.states.back().time = timeOf(path, k, seconds);
  }
  return std::make_shared<const trajectory::LoadedPanels>(std::move(panels));
}

/// Adds limit points and bifurcations as events, at their time in the playback.
void noteTurnings(const mechanics::LoadCurve& curve, const run::MechanismPath& path, double seconds,
                  const LengthUnit& unit, run::DeploymentResult& result) {
  const mechanics::GripName& leading = curve.grips[curve.leading];
  std::vector<trajectory::Event> events;
  for (std::size_t k = 0; k < curve.states.size(); ++k) {
    const mechanics::Equilibrium& state = curve.states[k];
    if (state.turning == mechanics::Turning::None) continue;
    const double time = timeOf(path, k, seconds);
    const double moved = state.displacements[curve.leading];
    events.push_back(
        {time,
         fmt::format("{} at the load {:.6g}: {} {}, {} {:.6g} {}",
                     mechanics::toString(state.turning), state.load, leading.name,
                     leading.isTurn ? fmt::format("{:.6g} rad", moved) : lengthText(moved, unit, 6),
                     leading.isTurn ? "moment" : "force", state.forces[curve.leading],
                     leading.isTurn ? "N m" : "N")});
  }
  result.trajectory.events.insert(result.trajectory.events.begin(), events.begin(), events.end());
}

/// Whether a grip moves a part of the sheet away from its centre.
bool movesOutwards(const std::vector<brick::Brick>& bricks, const Poses& start,
                   const GripOrder& grip) {
  Vector3 middle = Vector3::Zero(), place = Vector3::Zero();
  for (const Pose& pose : start) middle += pose.position / static_cast<double>(start.size());
  const std::vector<GripHandle> handles = handlesOf(grip, bricks);
  for (const GripHandle& handle : handles) {
    place += start[static_cast<std::size_t>(handle.brick)].apply(handle.point) /
             static_cast<double>(handles.size());
  }
  return grip.amount * grip.direction.dot(place - middle) >= 0;
}

/// The fold at which two triangles lie on each other in the last state, or null.
const trajectory::Fold* closedFold(const trajectory::LoadedPanels& panels) {
  const std::vector<double>& angles = panels.states.back().angles;
  for (std::size_t k = 0; k < angles.size(); ++k) {
    if (std::abs(angles[k]) > std::numbers::pi - kClosedFold) return &panels.folds[k];
  }
  return nullptr;
}

/// Why a path ends at a fold that is closed.
std::string closedFoldText(const trajectory::Fold& fold, double load, int countsFrom) {
  const auto [a, b] = fold.tiles;
  const std::string tiles =
      a == b ? fmt::format("tile {} lies on itself", countsFrom + a)
             : fmt::format("tiles {} and {} lie on each other", countsFrom + std::min(a, b),
                           countsFrom + std::max(a, b));
  return fmt::format("{} at the load {:.4g}: their fold is closed", tiles, load);
}

/// How the path ended, its stability, and its faults.
void noteEnd(const scene::Scene& scene, const std::vector<brick::Brick>& bricks,
             const mechanics::LoadPath& loaded, const GripOrder& leading,
             run::DeploymentResult& result) {
  const mechanics::Equilibrium& last = loaded.states.back();
  const int modes = last.unstableModes;
  const trajectory::Fold* closed =
      result.trajectory.panels ? closedFold(*result.trajectory.panels) : nullptr;
  result.outcome = loaded.arrives ? run::Outcome::Settled : run::Outcome::Locked;
  if (loaded.arrives) {
    result.reason = modes == 0 ? "reached, stable" : "reached, " + counted(modes, "unstable mode");
    result.reason += fmt::format(", through {} equilibria", loaded.states.size());
  } else if (closed) {
    result.reason = closedFoldText(*closed, last.load, scene.model.fileOrder.countsFrom);
  } else if (loaded.extent && !leading.name.isTurn) {
    const bool isOut = movesOutwards(bricks, loaded.states.front().poses, leading);
    result.reason = fmt::format("fully {} at {}, at the load {:.4g}", isOut ? "extended" : "closed",
                                lengthText(*loaded.extent, scene.model.unit, 4), last.load);
  } else {
    result.reason = loaded.trouble;
  }
  if (!loaded.arrives) result.shortfall = result.reason;
  if (loaded.arrives && modes > 0) {
    result.warnings.push_back(
        fmt::format("the last equilibrium is unstable: the sheet would leave it in {}",
                    counted(modes, "independent direction")));
  }
  // Poses of bending tiles are only fits: their overlaps do not count.
  const double tile = model::tileSize(scene.model);
  const double grown = scene.hinges.panels ? 0 : result.accuracy.penetrationGrownMax;
  if (grown > run::kAllowedOverlap * tile) {
    result.outcome = run::Outcome::Locked;
    const std::string overlap = fmt::format(
        "tiles overlap by up to {}. Equilibria under grips have no contacts, so the sheet can pass "
        "through itself",
        model::lengthInTiles(grown, scene.model));
    result.reason += "; " + overlap;
    result.shortfall = loaded.arrives ? overlap : result.reason;
  }
  result.trajectory.events.back().text = run::endText(result.outcome, result.reason);
}

}  // namespace

run::DeploymentResult followGrips(const scene::Scene& scene, double sampleInterval,
                                  const run::SampleObserver& observer) {
  requireEquilibria(scene);
  requireHeldPieces(scene);
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const scene::Ties ties = scene::loadedTies(scene, bricks);
  const std::vector<GripOrder> grips = gripsOf(scene);
  const std::vector<DirectedLoad> directed = directedLoads(grips);
  const std::size_t leading = leadingOf(grips, directed);
  const std::unique_ptr<BarHingeSheet> panels =
      scene.hinges.panels
          ? makeBarHingeSheet(scene, bricks, ties.pairForces, pinnedTiles(scene), grips)
          : nullptr;
  const std::unique_ptr<mechanics::LoadedSheet> rigid =
      panels ? nullptr : planarSheet(scene, bricks, ties, grips);
  const mechanics::LoadedSheet& sheet = panels ? *panels : *rigid;
  requireAgreement(scene, grips, sheet);
  const bool isSoft = scene.hinges.panels || ties.pairForces.replaceJoints();
  mechanics::LoadPathSettings settings;
  settings.minStates = scene.path.loadSteps;
  for (const DirectedLoad& load : directed) settings.sums.push_back(load.sum);
  const mechanics::LoadPath loaded = mechanics::followLoad(sheet, leading, settings, {});
  const run::GeometricPath path = playbackPath(bricks, loaded, isSoft);
  Poses last;
  const run::SampleObserver watch = [&](const trajectory::Sample& sample) {
    last = sample.poses;
    return !observer || observer(sample);
  };
  run::DeploymentResult result =
      run::playBack(scene, path, run::assembleAtTarget(scene), sampleInterval, watch);
  result.loadCurve = mechanics::LoadCurve{{}, leading, loaded.states};
  for (const GripOrder& grip : grips) result.loadCurve->grips.push_back(grip.name);
  for (const DirectedLoad& load : directed) {
    result.loadCurve->grips.push_back(load.order.name);
  }
  for (mechanics::Equilibrium& state : result.loadCurve->states) state.coordinates.resize(0);
  const double seconds = std::min(scene.path.playTime, scene.stop.duration);
  if (panels) {
    result.trajectory.panels = panelsOf(*panels, loaded, path.path, seconds);
  }
  if (!ties.pairForces.empty() || result.trajectory.panels) {
    result.elasticity = brick::elasticityOf(ties.pairForces, loaded.states.front().poses, last);
  }
  if (result.trajectory.panels) {
    trajectory::setElasticity(*result.trajectory.panels, *result.elasticity);
  }
  result.atTarget.reset();
  noteTurnings(*result.loadCurve, path.path, seconds, scene.model.unit, result);
  if (result.outcome == run::Outcome::Interrupted) return result;
  noteEnd(scene, bricks, loaded,
          leading < grips.size() ? grips[leading] : directed[leading - grips.size()].order, result);
  return result;
}

// ------------------------------------------------------------------------------------------------
// A scene's tiles as bars and hinges (bar_hinge_sheet.h).
//
// Joined corners become one node at the mean of their positions. Each tile is divided into
// triangles. Every side of a triangle is a bar. Its area is the sum over the triangles at this side
// (stiffness.h): a bar between two tiles carries load for both. A tile bends at a side between two
// of its triangles. A side between triangles of two tiles is a fold.

namespace {

/// The node of each corner of each tile. Joined corners have the same node.
std::vector<std::vector<int>> nodesOfTiles(const model::Model& model, int& count) {
  std::vector<std::vector<int>> corners;
  // Numbers all corners, tile by tile.
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
  int wing = 0;          // index of its third node
  std::array<int, 3> corners{};
};

/// The two triangles at a fold.
struct FoldSides {
  PanelSide left;
  PanelSide right;
};

using Edge = std::pair<int, int>;
using Edges = std::map<Edge, std::vector<PanelSide>>;

// Edges by their two nodes, the lower index first, with the triangles at each edge.
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

/// Builds the sheet of bars and hinges.
class BarHingeMaker {
 public:
  BarHingeMaker(const scene::Scene& scene, const std::vector<brick::Brick>& bricks)
      : scene_(scene), material_(*scene.hinges.panels), thickness_(scene.brick.thickness) {
    int count = 0;
    made_.tiles = nodesOfTiles(scene.model, count);
    made_.start = brick::startPoses(scene.model.tiles, bricks);
    placeNodes(count);
    edges_ = edgesOf(scene.model, made_.tiles);
    for (const auto& [edge, sides] : edges_) addBar(edge, sides);
    for (const auto& [edge, sides] : edges_) addBends(sides);
  }

  /// Springs at hinges of the scene. Each common edge of the two tiles has a share by its length.
  void addFolds(const std::vector<brick::HingeSpring>& springs) {
    for (const brick::HingeSpring& spring : springs) {
      const std::vector<FoldSides> shared = sidesBetween(spring.hinge.brickA, spring.hinge.brickB);
      double length = 0;
      for (const auto& [left, right] : shared) length += lengthOf({left.from, left.to});
      for (const auto& [left, right] : shared) {
        const double share = lengthOf({left.from, left.to}) / length;
        addFold(left, right, share * spring.stiffness).rest = spring.rest;
      }
    }
  }

  // Fixes all nodes of these tiles.
  void fix(const std::vector<int>& tiles) {
    for (const int tile : tiles) {
      const std::vector<int>& nodes = made_.tiles[static_cast<std::size_t>(tile)];
      made_.fixed.insert(made_.fixed.end(), nodes.begin(), nodes.end());
    }
    std::ranges::sort(made_.fixed);
    made_.fixed.erase(std::unique(made_.fixed.begin(), made_.fixed.end()), made_.fixed.end());
  }

  NodeGrip gripOf(const GripOrder& order) const {
    if (order.name.isTurn) {
      throw inputErrorAt(order.setting->where,
                         "bending tiles have no rotation. Hold or move their vertices");
    }
    NodeGrip grip{{}, order.direction, order.amount, order.setting->isForce};
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

  BarHingeModel take() { return std::move(made_); }

 private:
  /// Places each node at the mean of its corners.
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
      area += brick::barArea({at(a), at(b), at(c)}, thickness_, material_.poisson);
    }
    const double length = lengthOf(edge);
    // Stiffness of a bar: E A / l.
    made_.bars.push_back({edge.first, edge.second, length, material_.youngs * area / length});
  }

  /// A tile bends between two of its triangles.
  void addBends(const std::vector<PanelSide>& sides) {
    for (std::size_t b = 1; b < sides.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const PanelSide &left = sides[a], &right = sides[b];
        if (left.tile != right.tile) continue;
        const std::array<Vector3, 4> corners = {at(left.from), at(right.wing), at(left.to),
                                                at(left.wing)};
        addFold(left, right,
                brick::bendStiffness(corners, (corners[2] - corners[0]).norm(), material_.youngs,
                                     material_.poisson, thickness_));
      }
    }
  }

  Fold& addFold(const PanelSide& left, const PanelSide& right, double stiffness) {
    Fold fold{{left.from, left.to, left.wing, right.wing}, stiffness, 0, {left.tile, right.tile}};
    // Without a given rest angle, a fold is at rest at its start angle.
    fold.rest = foldAngle({at(left.from), at(left.to), at(left.wing), at(right.wing)});
    return made_.folds.emplace_back(fold);
  }

  /// The triangles of two tiles at each edge that they share.
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
    throw InputError(
        fmt::format("error: bending tiles need common edges, but tiles {} and {} have none. Split "
                    "the tile with the longer edge at the corner of the other",
                    first + a, first + b));
  }

  const scene::Scene& scene_;
  const scene::PanelMaterial& material_;
  double thickness_;
  BarHingeModel made_;
  Edges edges_;
};

void requireNodes(const model::Model& model) {
  for (const model::Joint& joint : model.joints) {
    if (joint.kind != model::JointKind::Pivot) {
      throw InputError(
          "error: bending tiles can only be joined at corners. Remove `fix` and `link`, or "
          "`panels`");
    }
    if (joint.face == model::JointFace::Both) {
      throw InputError(
          "error: bending tiles must be joined at one face, not at both. Set the face of each "
          "joint to 1 (bottom), or remove `panels`");
    }
  }
}

/// Throws for forces other than springs at hinges: those need rigid bricks.
void requireOnlySprings(const brick::PairForces& forces) {
  for (const std::shared_ptr<const brick::PairForce>& force : forces) {
    if (force->hingeSprings()) continue;
    throw InputError(fmt::format(
        "error: bending tiles (`panels`) support springs at hinges, but no {}. Remove one of them",
        force->name().counted));
  }
}

}  // namespace

std::unique_ptr<BarHingeSheet> makeBarHingeSheet(const scene::Scene& scene,
                                                 const std::vector<brick::Brick>& bricks,
                                                 const brick::PairForces& pairForces,
                                                 const std::vector<int>& pinned,
                                                 const std::vector<GripOrder>& grips) {
  requireNodes(scene.model);
  requireOnlySprings(pairForces);
  BarHingeMaker maker(scene, bricks);
  maker.addFolds(brick::hingeSpringsOf(pairForces));
  maker.fix(pinned);
  std::vector<NodeGrip> held;
  for (const GripOrder& grip : grips) held.push_back(maker.gripOf(grip));
  return std::make_unique<BarHingeSheet>(maker.take(), std::move(held));
}

}  // namespace kirireel::statics
