// Writes jobs: a heading, the mesh by *INCLUDE, material and section, supports, one step. Every job
// runs without editing.
//
//     *HEADING           one line
//     **                 origin, description of the job, parts to replace
//     *INCLUDE           the mesh deck
//     *MATERIAL          E (Pa or MPa), Poisson's ratio, density; *SOLID or *SHELL SECTION
//     *BOUNDARY          node, first axis, last axis (1 to 3): displacements held at zero
//     *STEP              *STATIC, *BUCKLE, loads, printed quantities
//     *END STEP
//
// Supports. A sheet of tiles on ideal hinges is a mechanism. Its stiffness matrix is singular or,
// worse, nearly singular. A program may then end without a warning with displacements of 1e9 m.
// minSupports (job.h) holds six motions of the whole and one displacement per mechanism. This is
// the minimum for a unique solution, and the supports carry only the load that equilibrium
// requires.
//
// Driven jobs. Tile t has the pose (R(s), x(s)) at the time s (seconds) and (R(0), x(0)) in the
// mesh. A node at p has the displacement
//
//     u(s) = R(s) R(0)^T (p - x(0)) + x(s) - p,
//
// Components of u at six displacements of a tile, by *AMPLITUDE, move it as in the trajectory
// (NLGEOM). Amplitudes are linear between samples. Prescribed rotations (*RIGID BODY of whole
// tiles) would be shorter but make tiles rigid, while the strain is the requested result.
//
// Periodic jobs. Control nodes carry the relative displacement of opposite ends; see deck.cpp.
#include "render/fea/job.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>

#include <Eigen/Dense>
#include <Eigen/QR>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/mechanics/block_cholesky.h"

namespace kirireel::fea {
namespace {

/// Shells with an offset have one section per set, all other elements one section for EALL. Plane
/// elements have their thickness in the section's data line, solids have none.
void appendSection(std::string& text, const ElementMesh& mesh, const DeckSettings& settings,
                   double thickness) {
  const UnitScale scale = unitScale(settings.unit);
  appendText(text, "*MATERIAL, NAME=SHEET\n*ELASTIC\n{}, {}\n*DENSITY\n{}\n",
             deckNumber(scale.stress * settings.material.youngs),
             deckNumber(settings.material.poisson),
             deckNumber(scale.density * settings.material.density));
  const bool isShell = mesh.rule.family == ElementFamily::Shell;
  const std::vector<ShellOffset> offsets =
      isShell ? shellOffsets(mesh) : std::vector<ShellOffset>();
  for (const ShellOffset& shells : offsets) {
    appendText(text, "*SHELL SECTION, ELSET={}, MATERIAL=SHEET, OFFSET={}\n{}\n", shells.set,
               deckNumber(shells.offset), deckNumber(scale.length * thickness));
  }
  if (!offsets.empty()) return;
  appendText(text, "*{} SECTION, ELSET=EALL, MATERIAL=SHEET\n", isShell ? "SHELL" : "SOLID");
  if (mesh.rule.family == ElementFamily::Solid) return;
  appendText(text, "{}\n", deckNumber(scale.length * thickness));
}

/// One row per displacement: node, axis, axis.
void appendSupports(std::string& text, const std::vector<NodeDisplacement>& supports) {
  text += "*BOUNDARY\n";
  for (const NodeDisplacement& held : supports) {
    appendText(text, "{0}, {1}, {1}\n", held.node + 1, held.axis + 1);
  }
}

/// Ascending and unique, because supports are sorted by node.
std::vector<int> nodesOf(const std::vector<NodeDisplacement>& supports) {
  std::vector<int> nodes;
  for (const NodeDisplacement& held : supports) {
    if (nodes.empty() || nodes.back() != held.node) nodes.push_back(held.node);
  }
  return nodes;
}

/// An end of a sheet and the consistent forces of 1 N on it.
struct GripLoad {
  std::string name;  ///< of the set of its nodes, such as GRIP_XMIN
  std::vector<NodeShare> shares;
};

/// GRIP_XMIN and GRIP_XMAX, or those of another axis: the two ends of the sheet's longest axis.
std::vector<GripLoad> gripsOf(const ElementMesh& mesh) {
  std::vector<GripLoad> grips;
  for (const int end : {0, 1}) {
    const int place = 2 * mesh.ends.longest + end;
    grips.push_back({"GRIP_" + boundarySets(mesh)[place].name, endShares(mesh, place)});
  }
  return grips;
}

/// The nodes of all grips.
std::vector<int> nodesOf(const std::vector<GripLoad>& grips) {
  std::vector<int> nodes;
  for (const GripLoad& grip : grips) {
    for (const NodeShare& share : grip.shares) nodes.push_back(share.node);
  }
  return nodes;
}

/// A uniform traction of 1 N on each grip: tension with sign 1, compression with -1. Both forces
/// lie on the line between the middles of the grips, so they are in balance.
void appendGripForces(std::string& text, const ElementMesh& mesh,
                      const std::vector<GripLoad>& grips, double sign) {
  constexpr double kRounding = 1e-9;
  // The first grip is the MIN end.
  const auto sideOf = [&](const GripLoad& grip) { return &grip == &grips.front() ? -1.0 : 1.0; };
  Vector3 along = Vector3::Zero();
  for (const GripLoad& grip : grips) {
    for (const auto& [node, share] : grip.shares) along += sideOf(grip) * share * mesh.nodes[node];
  }
  along.normalize();
  along = (along.array().abs() < kRounding).select(0, along);
  text += "*CLOAD\n";
  for (const GripLoad& grip : grips) {
    for (const auto& [node, share] : grip.shares) {
      for (int axis = 0; axis < 3; ++axis) {
        const double force = sign * sideOf(grip) * share * along[axis];
        if (force == 0) continue;
        appendText(text, "{}, {}, {}\n", node + 1, axis + 1, deckNumber(force));
      }
    }
  }
}

/// Requests displacements, reactions, stresses and strains in the program's own result file.
/// NAME.dat gets the results of the supported or driven nodes and the sum of their reactions. `set`
/// is a node set of the mesh deck. `printed` is U, RF or both.
void appendRequests(std::string& text, Solver solver, const char* set, const char* printed) {
  if (solver == Solver::Calculix) {
    text +=
        "*NODE FILE\nU, RF\n"
        "*EL FILE\nS, E\n"
        "** Viewers of .frd files compute the von Mises stress from S.\n";
  } else {
    text +=
        "*OUTPUT, FIELD\n*NODE OUTPUT\nU, RF\n"
        "*ELEMENT OUTPUT\nS, E, MISES\n";
  }
  appendText(text, "*NODE PRINT, NSET={}, TOTALS=YES\n{}\n", set, printed);
}

void appendJointWarnings(std::string& text, const ElementMesh& mesh) {
  if (hasEquations(mesh)) {
    text +=
        "** WARNING: nodes that follow in *EQUATION cannot be held, and CalculiX leaves the forces "
        "of\n"
        "** equations out of RF: hold nodes that no joint touches, as here.\n";
  }
  if (mesh.rule.joints == JointStyle::Patch) {
    text += "** WARNING: nodes of rigid patches cannot be held; hold their reference nodes.\n";
  }
}

/// The mesh and the material.
void appendModel(std::string& text, const ElementMesh& mesh, const DeckSettings& settings,
                 const DeckOrigin& origin, const std::string& meshFile) {
  // The path is unchanged: both programs resolve it in their working folder.
  appendText(text, "*INCLUDE, INPUT={}\n", meshFile);
  appendSection(text, mesh, settings, origin.thickness);
  if (!settings.contactFriction) return;
  appendContactCards(text, contactPairs(mesh).size(), settings, origin.thickness);
}

/// Moments of springs that are not at rest.
void appendSpringMoments(std::string& text, const ElementMesh& mesh, const DeckSettings& settings) {
  std::string moments;
  PatchDeck(mesh, settings.solver).appendMoments(moments, settings.unit);
  if (!moments.empty())
    text += "** What springs pull with in the state of the mesh.\n*CLOAD\n" + moments;
}

/// The supports and grips of a sheet.
struct HeldSheet {
  std::vector<NodeDisplacement> supports;
  std::vector<GripLoad> grips;
  std::string sets;  ///< NHOLD and those of the grips
};

HeldSheet heldSheet(const ElementMesh& mesh) {
  HeldSheet held{{}, gripsOf(mesh), {}};
  held.supports = minSupports(mesh, {}, nodesOf(held.grips));
  held.sets = "** What the job holds and grips.\n";
  appendNodeSet(held.sets, "NHOLD", nodesOf(held.supports));
  for (const GripLoad& grip : held.grips) appendNodeSet(held.sets, grip.name, nodesOf({grip}));
  return held;
}

/// Displacement of a node's material point since the mesh's state, one entry per sample. In metres,
/// along the driven axis; the first is 0 up to rounding.
std::vector<double> displacementsOf(const NodeDisplacement& driven, const ElementMesh& mesh,
                                    const TileHistory& history) {
  const Vector3& start = mesh.nodes[driven.node];
  const Pose& first = history.poses[0][driven.tile];
  const Vector3 inTile = first.rotation.conjugate() * (start - first.position);
  std::vector<double> displacements;
  for (const Poses& poses : history.poses) {
    displacements.push_back((poses[driven.tile].apply(inTile) - start)[driven.axis]);
  }
  return displacements;
}

/// Displacement of the driven tiles of one half of the sheet relative to those of the other, along
/// an axis. Metres, one entry per sample; empty if all tiles are in one half.
std::vector<double> openingsOf(const Vector3& axis, const std::vector<int>& tiles,
                               const TileHistory& history) {
  std::vector<double> places;
  for (const int tile : tiles) places.push_back(axis.dot(history.poses[0][tile].position));
  const auto [least, most] = std::ranges::minmax(places);
  std::vector<double> openings;
  for (const Poses& poses : history.poses) {
    std::array<double, 2> sums{}, counts{};
    for (std::size_t k = 0; k < tiles.size(); ++k) {
      const std::size_t half = 2 * places[k] > least + most ? 1 : 0;
      sums[half] += axis.dot(poses[tiles[k]].position) - places[k];
      ++counts[half];
    }
    if (counts[0] > 0 && counts[1] > 0) {
      openings.push_back(sums[1] / counts[1] - sums[0] / counts[0]);
    }
  }
  return openings;
}

/// Every n-th sample, including the first and the last. This limits the amplitudes: CalculiX 2.20
/// crashes on decks with 300,000 pairs, and reads 220,000.
TileHistory thinned(const TileHistory& history, std::size_t driven) {
  constexpr std::size_t kMaxPairs = 200'000;
  const std::size_t count = history.times.size();
  // The last sample is always added, because the end state matters most.
  const std::size_t step = driven * count / kMaxPairs + 1;
  TileHistory kept;
  for (std::size_t k = 0; k + 1 < count; k += step) {
    kept.times.push_back(history.times[k]);
    kept.poses.push_back(history.poses[k]);
  }
  kept.times.push_back(history.times.back());
  kept.poses.push_back(history.poses.back());
  return kept;
}

/// *AMPLITUDE, four pairs of time and value per line. Values are multiplied by `scale`. Times are
/// in seconds in all units.
void appendAmplitude(std::string& text, const std::string& name, const std::vector<double>& times,
                     const std::vector<double>& values, double scale) {
  appendText(text, "*AMPLITUDE, NAME={}\n", name);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const bool endsLine = k % 4 == 3 || k + 1 == times.size();
    appendText(text, "{}, {}{}", deckNumber(times[k]), deckNumber(scale * values[k]),
               endsLine ? "\n" : ", ");
  }
}

/// Rotations of each of these tiles since the mesh's state.
std::vector<std::vector<Quaternion>> turnsOf(const std::vector<int>& tiles,
                                             const TileHistory& history) {
  std::vector<std::vector<Quaternion>> turns;
  for (const int tile : tiles) {
    std::vector<Quaternion>& own = turns.emplace_back();
    const Quaternion back = history.poses[0][tile].rotation.conjugate();
    for (const Poses& poses : history.poses) own.push_back(poses[tile].rotation * back);
  }
  return turns;
}

/// Reference force for residual forces. Tiles on ideal hinges move without any force. Programs
/// compare residuals with the mean force, so without a reference they would wait for rounding
/// errors to vanish. The numbers are those of *CONTROLS in both programs: R_n = 0.005, the fraction
/// of the mean force for convergence of residuals, C_n = 0.01 for corrections, q_0 and q_u, the
/// mean force at the start and throughout, here E t^2 / 10^6 (N), R_P = 0.02, and the fraction
/// below which forces count as zero.
void appendForceMeasure(std::string& text, const DeckSettings& settings, double thickness) {
  const UnitScale scale = unitScale(settings.unit);
  const double force = 1e-6 * settings.material.youngs * thickness * thickness * scale.stress *
                       scale.length * scale.length;
  appendText(
      text,
      "** Residual forces count from a millionth of E t^2 on: ideal hinges move without "
      "any.\n"
      "*CONTROLS, PARAMETERS=FIELD, FIELD=DISPLACEMENT\n0.005, 0.01, {0}, {0}, 0.02, 0.005\n",
      deckNumber(force));
}

/// A<node>_<axis>, both one-based, unique in a deck.
std::string amplitudeName(const NodeDisplacement& driven) {
  return fmt::format("A{}_{}", driven.node + 1, driven.axis + 1);
}

/// The tiles at both ends of the longest axis: those with faces there. If no edge is an end, those
/// with nodes there.
std::vector<int> tilesAtEnds(const ElementMesh& mesh) {
  const std::vector<NamedNodes> sets = boundarySets(mesh);
  std::vector<bool> isAtEnd(mesh.tiles.size());
  for (const int end : {0, 1}) {
    const int place = 2 * mesh.ends.longest + end;
    const std::vector<ElementFace>& faces = mesh.ends.faces[place];
    for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
      const TileElements& tile = mesh.tiles[t];
      const bool hasFace = std::ranges::any_of(faces, [&](const ElementFace& face) {
        const int number = face.element - tile.firstElement;
        return number >= 0 && number < tile.elementCount;
      });
      // Reference nodes of patches are numbered after the mesh's own and belong to no tile.
      const bool hasNode = faces.empty() && std::ranges::any_of(sets[place].nodes, [&](int node) {
                             return std::ranges::binary_search(tile.nodes, node);
                           });
      if (hasFace || hasNode) isAtEnd[t] = true;
    }
  }
  std::vector<int> tiles;
  for (std::size_t t = 0; t < isAtEnd.size(); ++t) {
    if (isAtEnd[t]) tiles.push_back(static_cast<int>(t));
  }
  return tiles;
}

void requireMappable(const ElementRule& rule) {
  if (rule.family == ElementFamily::Solid) return;
  throw InputError(
      "error: --state-map moves solids only, because nodes of shells and plane elements also "
      "rotate. Remove --shells and --plane-stress");
}

/// The model with the supports before its step.
void appendHeldModel(std::string& text, const ElementMesh& mesh, const DeckSettings& settings,
                     const DeckOrigin& origin, const std::string& meshFile, const HeldSheet& held) {
  appendJointWarnings(text, mesh);
  appendModel(text, mesh, settings, origin, meshFile);
  appendSupports(text, held.supports);
}

}  // namespace

DeckJob staticJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                  const std::string& meshFile) {
  const HeldSheet held = heldSheet(mesh);
  std::string text = heading(origin, "pulled at both ends");
  appendOrigin(text, origin, settings.unit);
  // Supports in the plane: two displacements and one rotation.
  const std::size_t rigid = mesh.rule.family == ElementFamily::Plane ? 3 : 6;
  appendText(
      text,
      "** A job to start from: the sheet is pulled apart at both ends, 1 N each, through its "
      "joints.\n"
      "** The nodal forces are those of an even traction on the end's faces, along the line "
      "between the\n"
      "** middles of both ends: they are in balance.\n"
      "** Held are {} displacements: {} rigid motions and {} mechanisms of ideal hinges, each "
      "by\n"
      "** one displacement, without strains elsewhere. With fewer supports the sheet is a "
      "mechanism,\n"
      "** and a linear static step gives huge displacements without a warning. Check the largest "
      "|U|.\n"
      "** Replace material, supports and loads by yours. Its weight would be\n"
      "**   *DLOAD\n**   EALL, GRAV, {}, 0., 0., -1.\n",
      held.supports.size(), rigid, held.supports.size() - rigid,
      deckNumber(9.81 * unitScale(settings.unit).length));
  appendHeldModel(text, mesh, settings, origin, meshFile, held);
  text += "*STEP\n*STATIC\n";
  appendGripForces(text, mesh, held.grips, 1);
  appendSpringMoments(text, mesh, settings);
  appendRequests(text, settings.solver, "NHOLD", "RF");
  return {held.sets, text + "*END STEP\n"};
}

DeckJob bucklingJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                    const std::string& meshFile) {
  const HeldSheet held = heldSheet(mesh);
  std::string text = heading(origin, "buckling");
  appendOrigin(text, origin, settings.unit);
  text +=
      "** Both ends are pushed together by 1 N each; the buckling factors are forces in N. The "
      "supports\n"
      "** hold mechanisms of ideal hinges too: replace them by those of your test.\n";
  appendHeldModel(text, mesh, settings, origin, meshFile, held);
  // Five factors, the smallest first.
  text += "*STEP\n*BUCKLE\n5\n";
  appendGripForces(text, mesh, held.grips, -1);
  text +=
      settings.solver == Solver::Calculix ? "*NODE FILE\nU\n" : "*OUTPUT, FIELD\n*NODE OUTPUT\nU\n";
  return {held.sets, text + "*END STEP\n"};
}

void requireDrivable(const DriveChoice& choice, std::size_t tiles, int countsFrom) {
  std::vector<int> named = choice.tiles;
  std::ranges::sort(named);
  // In sorted order, duplicates are adjacent.
  for (std::size_t k = 0; k < named.size(); ++k) {
    const int last = static_cast<int>(tiles) - 1 + countsFrom;
    if (named[k] < countsFrom || named[k] > last) {
      throw InputError(fmt::format("error: --drive names tile {}, but the model has tiles {} to {}",
                                   named[k], countsFrom, last));
    }
    if (k > 0 && named[k] == named[k - 1]) {
      throw InputError(
          fmt::format("error: --drive names tile {} twice, which would prescribe its displacements "
                      "twice; leave one out",
                      named[k]));
    }
  }
}

std::vector<int> drivenTiles(const ElementMesh& mesh, const DriveChoice& choice) {
  requireDrivable(choice, mesh.tiles.size(), mesh.rule.countsFrom);
  if (choice.kind == DriveChoice::Edge) return tilesAtEnds(mesh);
  std::vector<int> tiles = choice.tiles;
  for (int& tile : tiles) tile -= mesh.rule.countsFrom;
  if (choice.kind == DriveChoice::All) {
    tiles.resize(mesh.tiles.size());
    std::iota(tiles.begin(), tiles.end(), 0);
  }
  std::ranges::sort(tiles);
  return tiles;
}

DeckJob driveJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                 const std::string& meshFile, const TileHistory& allSamples) {
  const std::vector<int> tiles = drivenTiles(mesh, settings.drive);
  // Six displacements per tile, nine at most, each with its own amplitude.
  TileHistory history = thinned(allSamples, 6 * tiles.size());
  for (Poses& poses : history.poses) {
    for (Pose& pose : poses) pose = {mesh.turn * pose.position, mesh.turn * pose.rotation};
  }
  std::vector<NodeDisplacement> driven;
  const std::vector<std::vector<Quaternion>> turns = turnsOf(tiles, history);
  for (const auto& own : tileDisplacements(mesh, tiles, turns)) {
    driven.insert(driven.end(), own.begin(), own.end());
  }
  // The remaining free motions also follow the trajectory. Holding them at rest would block the
  // mechanism.
  const std::vector<NodeDisplacement> rest = minSupports(mesh, tiles);
  driven.insert(driven.end(), rest.begin(), rest.end());
  std::ranges::sort(driven);

  std::string text = heading(origin, "driven");
  appendOrigin(text, origin, settings.unit);
  appendText(
      text,
      "** {} tiles are moved as in the trajectory, each by displacements of its nodes; so "
      "are {}\n"
      "** displacements more, which the joints' mechanisms would leave free. Between samples the "
      "path of\n"
      "** a node is a straight line. Time is that of the deployment.\n",
      tiles.size(), rest.size());
  appendJointWarnings(text, mesh);
  appendModel(text, mesh, settings, origin, meshFile);
  const double scale = unitScale(settings.unit).length;
  for (const NodeDisplacement& one : driven) {
    appendAmplitude(text, amplitudeName(one), history.times, displacementsOf(one, mesh, history),
                    scale);
  }
  const Vector3 axis = mesh.ends.axes.col(mesh.ends.longest);
  if (const auto openings = openingsOf(axis, tiles, history); !openings.empty()) {
    appendText(text,
               "** How far the driven tiles of both halves move apart along the longest axis, for "
               "scripts/force-curve.\n** Opening along, {}, {}, {}\n",
               deckNumber(axis.x()), deckNumber(axis.y()), deckNumber(axis.z()));
    appendAmplitude(text, "OPENING", history.times, openings, scale);
  }
  // The initial and maximum increment is a twentieth of the time, the minimum a millionth. Linear
  // paths between samples are followed closely enough, and CalculiX reduces increments as needed.
  const double end = history.times.back();
  appendText(text, "*STEP, NLGEOM, INC=100000\n*STATIC\n{}, {}, {}, {}\n", deckNumber(end / 20),
             deckNumber(end), deckNumber(end / 1e6), deckNumber(end / 20));
  if (mesh.rule.joints != JointStyle::Neck) appendForceMeasure(text, settings, origin.thickness);
  appendSpringMoments(text, mesh, settings);
  for (const NodeDisplacement& one : driven) {
    appendText(text, "*BOUNDARY, AMPLITUDE={0}\n{1}, {2}, {2}, 1.\n", amplitudeName(one),
               one.node + 1, one.axis + 1);
  }
  appendRequests(text, settings.solver, "NDRIVE", "U, RF");
  if (settings.solver == Solver::Calculix) text += "*EL PRINT, ELSET=EALL, TOTALS=ONLY\nELSE\n";
  std::string sets = "** What the drive moves.\n";
  appendNodeSet(sets, "NDRIVE", nodesOf(driven));
  return {sets, text + "*END STEP\n"};
}

DeckJob stateMapJob(const ElementMesh& mesh, const ElementMesh& later, const DeckSettings& settings,
                    const DeckOrigin& origin, const std::string& meshFile) {
  requireMappable(mesh.rule);
  std::string text = heading(origin, "mapped");
  appendOrigin(text, origin, settings.unit);
  text +=
      "** The mesh of an earlier state is moved to this one: the displacements are the map between "
      "them,\n"
      "** and stresses are counted from the earlier state, in which the tiles are free of them. "
      "Add steps\n"
      "** that follow, with *BOUNDARY, OP=NEW, to load this state.\n";
  appendJointWarnings(text, mesh);
  appendModel(text, mesh, settings, origin, meshFile);
  text += "*STEP, NLGEOM, INC=1000\n*STATIC\n1., 1., 1e-6, 1.\n";
  appendForceMeasure(text, settings, origin.thickness);
  text += "*BOUNDARY\n";
  // Dependent nodes cannot be prescribed; they move with their leaders.
  const std::vector<bool> follows = followers(mesh);
  const double scale = unitScale(settings.unit).length;
  const auto appendMove = [&](int node, const Vector3& move) {
    for (int axis = 0; axis < 3; ++axis) {
      appendText(text, "{0}, {1}, {1}, {2}\n", node + 1, axis + 1, deckNumber(scale * move[axis]));
    }
  };
  for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
    if (!follows[k]) appendMove(static_cast<int>(k), later.nodes[k] - mesh.nodes[k]);
  }
  for (std::size_t c = 0; c < mesh.clusters.size() && !hasEquations(mesh); ++c) {
    appendMove(referenceNode(mesh, c), referencePosition(later, c) - referencePosition(mesh, c));
  }
  appendRequests(text, settings.solver, "NALL", "U");
  return {{}, text + "*END STEP\n"};
}

DeckJob periodicJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                    const std::string& meshFile) {
  // Small enough for linear theory, large relative to the rounding of coordinates.
  constexpr double kStrain = 1e-3;
  const Periodicity periodic = periodicity(mesh);
  // The supports must include the ties. Otherwise they would hold motions that ties already
  // prevent.
  ElementMesh tied = mesh;
  tied.ties = periodic.ties;
  const std::vector<NodeDisplacement> supports = minSupports(tied);
  // Numbered as in meshDeck: after the mesh's nodes.
  const int control = static_cast<int>(mesh.nodes.size());
  const double scale = unitScale(settings.unit).length;
  std::string text = heading(origin, "periodic");
  appendOrigin(text, origin, settings.unit);
  appendText(
      text,
      "** An infinite sheet, of which the mesh is a cell of {} x {}. Joints across its border tie "
      "the cell\n"
      "** to copies of itself; slits are open. The control nodes NCONTROL carry the mean strain: "
      "with H the\n"
      "** displacement gradient, the first has the displacements H e_x {}, the second H e_y {}, "
      "along the\n"
      "** sheet's axes e_x = ({}, {}, {}), e_y = ({}, {}, {}). Their reactions are the forces on "
      "the cell's sides.\n"
      "** Steps are linear: all displacements change their sign with the strain's. Held besides "
      "are "
      "{}\n"
      "** displacements: what moves while the control nodes rest.\n",
      deckNumber(scale * periodic.period[0]), deckNumber(scale * periodic.period[1]),
      deckNumber(scale * periodic.period[0]), deckNumber(scale * periodic.period[1]),
      deckNumber(periodic.axes(0, 0)), deckNumber(periodic.axes(1, 0)),
      deckNumber(periodic.axes(2, 0)), deckNumber(periodic.axes(0, 1)),
      deckNumber(periodic.axes(1, 1)), deckNumber(periodic.axes(2, 1)), supports.size());
  appendJointWarnings(text, mesh);
  appendModel(text, mesh, settings, origin, meshFile);
  appendTies(text, periodic, mesh, control);
  appendSupports(text, supports);
  const int directions = mesh.rule.family == ElementFamily::Plane ? 2 : 3;
  if (directions == 3) appendText(text, "{0}, 3, 3\n{1}, 3, 3\n", control + 1, control + 2);
  // Components of H prescribed by each step. They stay prescribed in later steps. Steps are linear:
  // the opposite sign gives the same energy.
  struct Strain {
    const char* words;
    double xx;
    std::optional<double> shear, yy;
  };
  const Strain strains[] = {
      {"stretched along x, free to widen along y and to shear", kStrain, std::nullopt,
       std::nullopt},
      {"sheared, of the same length along x, free to widen along y", 0, kStrain, std::nullopt},
      {"compressed along y, of the same length along x, without shear", 0, 0, -kStrain}};
  for (const Strain& strain : strains) {
    appendText(text, "** The sheet is {}.\n*STEP\n*STATIC\n*BOUNDARY\n", strain.words);
    const auto prescribe = [&](int node, int axis, double component) {
      appendText(text, "{0}, {1}, {1}, {2}\n", control + node + 1, axis + 1,
                 deckNumber(component * periodic.period[node] * scale));
    };
    prescribe(0, 0, strain.xx);
    // The second displacement of the first control node prevents a rotation.
    prescribe(0, 1, 0.5 * strain.shear.value_or(0));
    if (strain.shear) prescribe(1, 0, 0.5 * *strain.shear);
    if (strain.yy) prescribe(1, 1, *strain.yy);
    appendRequests(text, settings.solver, "NCONTROL", "U, RF");
    if (settings.solver == Solver::Calculix) {
      text +=
          "** CalculiX leaves the forces of equations out of RF: the force is twice the energy by "
          "the displacement.\n"
          "*EL PRINT, ELSET=EALL, TOTALS=ONLY\nELSE\n";
    }
    text += "*END STEP\n";
  }
  return {{}, text};
}

// ------------------------------------------------------------------------------------------------
// The unknowns are six displacements u_t of nodes of each tile t, which fix it as a rigid body. A
// point p of the tile moves by R(p) B_t^-1 u_t. R(p) = [1, -[p - c]x] maps velocity and spin to the
// point, and B_t has the rows of R for u_t. A joint requires that two tiles have the same motion at
// its middle. If it goes through the thickness along d, both must also rotate its line equally, s w
// x d with a length s of the tiles' size: J u = 0. (Two points a thickness apart would be
// equivalent. However, they are so weak for thin bricks that a held motion would count as free.)
//
// The null space of J contains the first-order motions of rigid tiles. The search finds as many
// unknowns as its dimension, and holding these removes all motions (compare C. Farhat, M. Geradin,
// On the general solution by a direct method of a large-scale singular system of linear equations,
// Int. J. Numer. Meth. Engng. 41, 1998).
//
// Elimination leaves of a column |J u| for a motion u with this unknown at 1. For a motion without
// strain this is rounding times |u|. If corners have a gap g, J has the error g / s, and it is up
// to g / s |u|. |u| is about the root of the number of unknowns n. Columns below
// root(n) (1e-8 + g / s) are therefore free, but never those above 1e-3: a motion that opens joints
// by more than a thousandth of its size is not a mechanism, for any g.

namespace {

/// Motion of a tile's points by its six displacements. Spins are multiplied by `size`. All six
/// unknowns are then lengths, and rows are comparable.
struct TileMotion {
  std::vector<NodeDisplacement> displacements;
  Vector3 centre;
  double size = 1;  ///< metres, scale of spins
  Matrix6 fromDisplacements;

  /// The rows that map velocity and spin to the motion of a point.
  Eigen::Matrix<double, 3, 6> motionOf(const Vector3& point) const {
    Eigen::Matrix<double, 3, 6> rows;
    rows << Matrix3::Identity(), -crossMatrix(point - centre) / size;
    return rows;
  }
};

/// Minimum for six displacements to fix a tile at any rotation: smallest singular value of their
/// equations, with spins scaled by the tile's size. Tiles below it are driven by nine
/// displacements.
constexpr double kMinGrip = 0.1;
/// Number of a tile's rotations that are checked.
constexpr std::size_t kTurnsLookedAt = 24;

/// Evenly distributed, including the first and the last.
std::vector<Matrix3> someOf(const std::vector<Quaternion>& turns) {
  std::vector<Matrix3> some;
  const std::size_t step = turns.size() / kTurnsLookedAt + 1;
  for (std::size_t k = 0; k < turns.size(); k += step) some.push_back(turns[k].toRotationMatrix());
  if (!turns.empty()) some.push_back(turns.back().toRotationMatrix());
  return some;
}

/// Selects the displacements of tiles one by one.
class MotionFinder {
 public:
  /// `others` are nodes to avoid, like those of joints.
  explicit MotionFinder(const ElementMesh& mesh, const std::vector<int>& others = {})
      : mesh_(mesh), isJoint_(jointNodesOf(mesh)), follows_(followers(mesh)) {
    for (const int node : others) isJoint_[node] = true;
  }

  /// Tries in this order: bottom nodes far from necks, bottom nodes without joints, all independent
  /// bottom nodes, all nodes of the tile. Displacements at joints would act directly on the
  /// neighbours.
  TileMotion of(int tile, const std::vector<Quaternion>& turns = {}) const {
    const TileElements& elements = mesh_.tiles[tile];
    std::vector<int> apart;
    std::vector<int> leading;
    for (const int node : elements.bottom) {
      if (!follows_[node]) leading.push_back(node);
      if (!follows_[node] && !isJoint_[node]) apart.push_back(node);
    }
    for (const std::vector<int>& nodes :
         {farFromNecks(apart, elements), apart, leading, leadingNodes(elements)}) {
      TileMotion motion;
      if (!choose(nodes, Matrix3::Identity(), motion)) continue;
      if (!turns.empty()) keepGrip(nodes, someOf(turns), motion);
      for (NodeDisplacement& displacement : motion.displacements) displacement.tile = tile;
      return motion;
    }
    throw InputError(
        fmt::format("error: all nodes of tile {} follow joints, so nothing can hold or drive it; "
                    "use more elements per edge",
                    tile + mesh_.rule.countsFrom));
  }

 private:
  std::vector<int> leadingNodes(const TileElements& elements) const {
    std::vector<int> nodes;
    std::ranges::copy_if(elements.nodes, std::back_inserter(nodes),
                         [this](int node) { return !follows_[node]; });
    return nodes;
  }

  /// Nodes at least half as far from the tile's necks as the farthest one. Elastic tiles deform at
  /// the ends of slits. Nodes held there would stiffen necks and distort small elements. Empty for
  /// meshes without necks.
  std::vector<int> farFromNecks(const std::vector<int>& nodes, const TileElements& elements) const {
    std::vector<int> far;
    if (mesh_.rule.joints != JointStyle::Neck) return far;
    std::vector<double> distances;
    for (const int node : nodes) {
      double& least = distances.emplace_back(std::numeric_limits<double>::infinity());
      for (const int other : elements.bottom) {
        if (!isJoint_[other]) continue;
        least = std::min(least, (mesh_.nodes[node] - mesh_.nodes[other]).norm());
      }
    }
    const double most = distances.empty() ? 0 : std::ranges::max(distances);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      if (distances[k] >= 0.5 * most) far.push_back(nodes[k]);
    }
    return far;
  }

  bool isPlane() const { return mesh_.rule.family == ElementFamily::Plane; }

  /// Whether displacements of these nodes fix the tile at this rotation. Selects the first columns
  /// of a pivoted QR factorisation of all their rows. Column k of the 6 x 3n matrix is the effect
  /// of the tile's six motions on one displacement of one node. The first six pivots are the
  /// best-conditioned greedy choice.
  bool choose(const std::vector<int>& nodes, const Matrix3& turn, TileMotion& motion) const {
    if (nodes.size() < 3) return false;
    Eigen::AlignedBox3d box;
    for (const int node : nodes) box.extend(mesh_.nodes[node]);
    motion.centre = box.center();
    motion.size = 0.5 * box.sizes().norm();
    Eigen::Matrix<double, 6, Eigen::Dynamic> rows(6, 3 * nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      auto own = rows.middleCols<3>(static_cast<Eigen::Index>(3 * k));
      own = motion.motionOf(turned(nodes[k], turn, motion)).transpose();
      // Plane elements have no displacement along z.
      if (isPlane()) own.col(2).setZero();
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(rows);
    // Relative to the largest pivot: collinear nodes give rank 5.
    factors.setThreshold(1e-6);
    const int count = isPlane() ? 3 : 6;
    if (factors.rank() < count) return false;
    motion.displacements.clear();
    for (int k = 0; k < count; ++k) {
      const int column = static_cast<int>(factors.colsPermutation().indices()[k]);
      motion.displacements.push_back({nodes[column / 3], column % 3});
    }
    if (!isPlane()) motion.fromDisplacements = rowsOf(motion, turn).inverse();
    return true;
  }

  /// Position of a node after rotation of the tile about its centre.
  Vector3 turned(int node, const Matrix3& turn, const TileMotion& motion) const {
    return motion.centre + turn * (mesh_.nodes[node] - motion.centre);
  }

  /// The rows of a motion's displacements.
  Eigen::MatrixXd rowsOf(const TileMotion& motion, const Matrix3& turn) const {
    Eigen::MatrixXd rows(motion.displacements.size(), 6);
    for (std::size_t k = 0; k < motion.displacements.size(); ++k) {
      const NodeDisplacement& one = motion.displacements[k];
      rows.row(static_cast<Eigen::Index>(k)) =
          motion.motionOf(turned(one.node, turn, motion)).row(one.axis);
    }
    return rows;
  }

  /// Conditioning of the displacements in the worst rotation of the tile: the smallest singular
  /// value of the rows. 1 is as good as velocity and spin themselves. 0 means that some motion
  /// affects none of the displacements.
  double gripOf(const TileMotion& motion, const std::vector<Matrix3>& turns) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Matrix3& turn : turns) {
      const Eigen::VectorXd values = singularValuesOf(rowsOf(motion, turn));
      least = std::min(least, values[isPlane() ? 2 : 5]);
    }
    return least;
  }

  /// Replaces displacements that do not fix the tile at some rotation (all collinear with the
  /// motion that they should prevent). Tries the best choice for each rotation and keeps the one
  /// with the best worst case. If none is sufficient, uses all displacements of three nodes.
  void keepGrip(const std::vector<int>& nodes, const std::vector<Matrix3>& turns,
                TileMotion& motion) const {
    double best = gripOf(motion, turns);
    for (const Matrix3& turn : turns) {
      if (best >= kMinGrip) return;
      TileMotion other;
      if (!choose(nodes, turn, other)) continue;
      const double grip = gripOf(other, turns);
      if (grip > best) motion = other;
      best = std::max(best, grip);
    }
    if (best < kMinGrip) motion.displacements = allOfThree(nodes);
  }

  /// All displacements of a node, of the node farthest from it, and of the node farthest from their
  /// line.
  std::vector<NodeDisplacement> allOfThree(const std::vector<int>& nodes) const {
    const auto farthest = [&](const auto& distance) {
      return *std::ranges::max_element(nodes, {},
                                       [&](int node) { return distance(mesh_.nodes[node]); });
    };
    const Vector3& start = mesh_.nodes[nodes[0]];
    const int first = farthest([&](const Vector3& at) { return (at - start).norm(); });
    const Vector3& from = mesh_.nodes[first];
    const int second = farthest([&](const Vector3& at) { return (at - from).norm(); });
    const Vector3 along = mesh_.nodes[second] - from;
    const int third = farthest([&](const Vector3& at) { return (at - from).cross(along).norm(); });
    std::vector<NodeDisplacement> all;
    for (const int node : {first, second, third}) {
      for (int axis = 0; axis < (isPlane() ? 2 : 3); ++axis) all.push_back({node, axis});
    }
    return all;
  }

  const ElementMesh& mesh_;
  std::vector<bool> isJoint_;
  std::vector<bool> follows_;
};

/// The normal of a tile's bottom, by its first element.
Vector3 normalOf(const ElementMesh& mesh, const TileElements& tile) {
  const auto at = [&](int k) { return mesh.nodes[mesh.elements[tile.firstElement].nodes[k]]; };
  return (at(2) - at(0)).cross(at(3) - at(1)).normalized();
}

/// The equations of a joint between two tiles.
PairEquations equationsOf(const ElementMesh& mesh, const JointNodes& joint,
                          const std::vector<TileMotion>& motions) {
  // The middle of both tiles' nodes: at a gap the joint lies halfway.
  const auto at = [&](std::size_t k) {
    return Vector3(0.5 * (mesh.nodes[joint.a[k]] + mesh.nodes[joint.b[k]]));
  };
  const Vector3 bottom = at(0);
  const Vector3 top = at(joint.a.size() - 1);
  // A shell's joint has one node; its line is the tile's normal.
  const Vector3 line = joint.a.size() > 1 ? Vector3((top - bottom).normalized())
                                          : normalOf(mesh, mesh.tiles[joint.tileA]);
  const double size = 0.5 * (motions[joint.tileA].size + motions[joint.tileB].size);
  const auto rowsOf = [&](const TileMotion& motion, double sign) {
    PairEquations::Rows rows = PairEquations::Rows::Zero(joint.isHinge ? 6 : 3, 6);
    rows.topRows<3>() = motion.motionOf(0.5 * (bottom + top));
    if (joint.isHinge) {
      // s (w x d): a rotation about d itself has no effect. These three rows have rank 2.
      rows.bottomRightCorner<3, 3>() = -size / motion.size * crossMatrix(line);
    }
    return PairEquations::Rows(sign * rows * motion.fromDisplacements);
  };
  return {joint.tileA, joint.tileB, rowsOf(motions[joint.tileA], 1),
          rowsOf(motions[joint.tileB], -1)};
}

/// The equations of a fixed joint: equal motion and rotation of both tiles.
PairEquations equationsOf(const JoinedTiles& joined, const std::vector<TileMotion>& motions) {
  const Vector3 point = 0.5 * (motions[joined.tileA].centre + motions[joined.tileB].centre);
  const double size = 0.5 * (motions[joined.tileA].size + motions[joined.tileB].size);
  const auto rowsOf = [&](const TileMotion& motion, double sign) {
    PairEquations::Rows rows = PairEquations::Rows::Zero(6, 6);
    rows.topRows<3>() = motion.motionOf(point);
    rows.bottomRightCorner<3, 3>() = size / motion.size * Matrix3::Identity();
    return PairEquations::Rows(sign * rows * motion.fromDisplacements);
  };
  return {joined.tileA, joined.tileB, rowsOf(motions[joined.tileA], 1),
          rowsOf(motions[joined.tileB], -1)};
}

/// The equations of ties with control nodes at rest, u_node = u_leader. `motions` has one entry for
/// a single body.
std::vector<PairEquations> tieEquations(const ElementMesh& mesh,
                                        const std::vector<TileMotion>& motions) {
  std::vector<int> owner(mesh.nodes.size());
  for (std::size_t t = 0; t < mesh.tiles.size() && motions.size() > 1; ++t) {
    for (const int node : mesh.tiles[t].nodes) owner[node] = static_cast<int>(t);
  }
  std::vector<PairEquations> equations;
  for (const PeriodicTie& tie : mesh.ties) {
    const auto rowsOf = [&](int node, double sign) {
      const TileMotion& motion = motions[owner[node]];
      return PairEquations::Rows(sign * motion.motionOf(mesh.nodes[node]) *
                                 motion.fromDisplacements);
    };
    equations.push_back(
        {owner[tie.node], owner[tie.leader], rowsOf(tie.node, 1), rowsOf(tie.leader, -1)});
  }
  return equations;
}

/// Whether all hinges have springs: no mechanism is left.
bool hasSpringsEverywhere(const ElementMesh& mesh) {
  std::vector<bool> hasSpring(mesh.clusters.size());
  for (const PatchSpring& spring : mesh.springs) hasSpring[spring.cluster] = true;
  return !mesh.springs.empty() && std::ranges::find(hasSpring, false) == hasSpring.end();
}

/// Tolerance for columns without remainder, see above: min(1e-3, sqrt(n) (1e-8 + g / s)).
double nothingLeft(const ElementMesh& mesh, const std::vector<TileMotion>& motions) {
  constexpr double kColumnRounding = 1e-8;
  constexpr double kShortestColumn = 1e-3;
  const double least = std::ranges::min(motions, {}, &TileMotion::size).size;
  const auto unknowns = static_cast<double>(6 * motions.size());
  return std::min(kShortestColumn,
                  std::sqrt(unknowns) * (kColumnRounding + mesh.largestGap / least));
}

}  // namespace

std::vector<std::vector<NodeDisplacement>> tileDisplacements(
    const ElementMesh& mesh, const std::vector<int>& tiles,
    const std::vector<std::vector<Quaternion>>& turns) {
  const MotionFinder finder(mesh);
  std::vector<std::vector<NodeDisplacement>> displacements;
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    displacements.push_back(
        (turns.empty() ? finder.of(tiles[k]) : finder.of(tiles[k], turns[k])).displacements);
  }
  return displacements;
}

std::vector<NodeDisplacement> minSupports(const ElementMesh& mesh,
                                          const std::vector<int>& fixedTiles,
                                          const std::vector<int>& loadedNodes) {
  const MotionFinder finder(mesh, loadedNodes);
  const bool isOneBody = mesh.rule.joints == JointStyle::Neck || hasSpringsEverywhere(mesh);
  // A fixed tile already holds a single body.
  if (isOneBody && !fixedTiles.empty()) return {};
  std::vector<NodeDisplacement> held;
  if (isOneBody && mesh.ties.empty()) {
    // Six displacements of any tile hold a single body.
    held = finder.of(0).displacements;
    std::ranges::sort(held);
    return held;
  }
  // A planar sheet with tied ends cannot rotate: two displacements are left.
  if (mesh.rule.family == ElementFamily::Plane) {
    const NodeDisplacement first = finder.of(0).displacements[0];
    return {{first.node, 0, 0}, {first.node, 1, 0}};
  }
  std::vector<TileMotion> motions;
  for (std::size_t t = 0; t < (isOneBody ? 1 : mesh.tiles.size()); ++t) {
    motions.push_back(finder.of(static_cast<int>(t)));
  }
  std::vector<PairEquations> equations = tieEquations(mesh, motions);
  for (const JointNodes& joint : mesh.joints) {
    if (!isOneBody) equations.push_back(equationsOf(mesh, joint, motions));
  }
  for (const JoinedTiles& joined : mesh.joined) {
    if (!isOneBody) equations.push_back(equationsOf(joined, motions));
  }
  std::vector<bool> isFixed(motions.size());
  for (const int tile : fixedTiles) isFixed[tile] = true;
  for (const FreeColumn& column : freeColumns(static_cast<int>(motions.size()), equations, isFixed,
                                              nothingLeft(mesh, motions))) {
    held.push_back(motions[column.tile].displacements[column.unknown]);
  }
  std::ranges::sort(held);
  return held;
}

// ------------------------------------------------------------------------------------------------
// A multifrontal QR factorisation of J with column pivoting within each tile (T. A. Davis,
// Algorithm 915, SuiteSparseQR: multifrontal multithreaded rank-revealing sparse QR factorization,
// ACM Trans. Math. Softw. 38, 2011; the rank test is Heath's, section 2.6 there). Tiles are
// eliminated in the order and fronts of sim/mechanics/block_cholesky.h, which also apply to QR: J^T
// J has the graph of the tiles.
//
// A front has the equations that contain its own tiles F, and the remainders of its children.
// Householder reflections make F upper trapezoidal. The longest remaining column comes first:
//
//     [ F | G ] -> [ R S ] R: eliminated columns, complete
//                  [ 0 L ] L: remainder for the parent, at most as many rows as columns
//
// Columns of F shorter than the tolerance depend on earlier ones. Their unknowns are free, and the
// columns are left out, which holds them at zero. J is never squared: a column without strain has a
// remainder of rounding, 1e-16 times the length of its motion, and not the root of that.
//
// A short pivot makes a motion long: with R_kk = 1e-6, an unknown j at 1 may move the unknown k by
// R_kj / R_kk = 1e6. Holding j then barely holds that motion, and its remainder is as large as for
// a motion far longer than 1. Unknowns that others would move by more than kMaxGrowth are not
// eliminated but go to L (delayed pivots; I. S. Duff, J. K. Reid, The multifrontal solution of
// indefinite sparse symmetric linear equations, ACM Trans. Math. Softw. 9, 1983). The last front
// eliminates the longest columns first.

namespace {

constexpr Eigen::Index kUnknowns = 6;
/// An unknown moves an eliminated one by at most this many times itself, else elimination waits.
constexpr double kMaxGrowth = 2;

class FrontalElimination {
 public:
  FrontalElimination(int tileCount, const std::vector<PairEquations>& equations,
                     const std::vector<bool>& isFixed, double tolerance)
      : equations_(equations), isFixed_(isFixed), tolerance_(tolerance), tileAt_(tileCount) {
    std::vector<std::pair<int, int>> edges;
    // The graph has one vertex per tile and one edge per pair with equations. The fill is that of a
    // Cholesky factorisation of J^T J.
    for (const PairEquations& pair : equations) {
      if (pair.firstTile != pair.secondTile) edges.emplace_back(pair.firstTile, pair.secondTile);
    }
    plan_ = mechanics::planElimination(tileCount, edges);
    for (int tile = 0; tile < tileCount; ++tile) tileAt_[plan_.place[tile]] = tile;
    // An equation enters with its first eliminated tile.
    equationsAt_.resize(tileCount);
    for (std::size_t k = 0; k < equations.size(); ++k) {
      equationsAt_[std::min(place(equations[k].firstTile), place(equations[k].secondTile))]
          .push_back(k);
    }
    leftOver_.resize(plan_.supernodes.size());
  }

  std::vector<FreeColumn> run() {
    for (std::size_t s = 0; s < plan_.supernodes.size(); ++s) eliminate(s);
    return std::move(free_);
  }

 private:
  /// The contribution of a front to its parent.
  struct Remainder {
    Eigen::MatrixXd equations;
    std::vector<FreeColumn> delayed;  ///< of its first columns
  };

  int place(int tile) const { return plan_.place[tile]; }

  /// The equations of a front's own tiles, and the remainders of its children. The columns belong
  /// first to the front's own tiles, six each, then to unknowns that its children delayed, then to
  /// `node.rows`. The columns of a child's remainder belong to its delayed unknowns and to its own
  /// `rows`, whose positions here are in `childPlaces`.
  Eigen::MatrixXd assemble(const mechanics::Supernode& node, Eigen::Index delayed) {
    Eigen::Index rows = 0;
    for (const int child : node.children) rows += leftOver_[child].equations.rows();
    for (int c = 0; c < node.columnCount; ++c) {
      for (const std::size_t k : equationsAt_[node.firstColumn + c]) {
        rows += equations_[k].first.rows();
      }
    }
    const auto tiles = node.columnCount + static_cast<Eigen::Index>(node.rows.size());
    Eigen::MatrixXd front = Eigen::MatrixXd::Zero(rows, kUnknowns * tiles + delayed);
    Eigen::Index row = 0;
    Eigen::Index next = kUnknowns * node.columnCount;
    for (std::size_t c = 0; c < node.children.size(); ++c) {
      Remainder& part = leftOver_[node.children[c]];
      const Eigen::Index height = part.equations.rows();
      const auto waiting = static_cast<Eigen::Index>(part.delayed.size());
      front.block(row, next, height, waiting) = part.equations.leftCols(waiting);
      next += waiting;
      const std::vector<int>& places = node.childPlaces[c];
      for (std::size_t k = 0; k < places.size(); ++k) {
        front.block(row, columnOf(node, places[k], delayed), height, kUnknowns) =
            part.equations.middleCols<kUnknowns>(waiting +
                                                 kUnknowns * static_cast<Eigen::Index>(k));
      }
      row += height;
      // Memory is freed after each front, so only the remainders of one path are stored.
      part = {};
    }
    for (int c = 0; c < node.columnCount; ++c) {
      for (const std::size_t k : equationsAt_[node.firstColumn + c]) {
        const PairEquations& pair = equations_[k];
        place(front, row, node, delayed, pair.firstTile, pair.first);
        place(front, row, node, delayed, pair.secondTile, pair.second);
        row += pair.first.rows();
      }
    }
    return front;
  }

  /// The first column of a front's tile, by its position among the front's own tiles and rows.
  static Eigen::Index columnOf(const mechanics::Supernode& node, int position,
                               Eigen::Index delayed) {
    return kUnknowns * position + (position < node.columnCount ? 0 : delayed);
  }

  /// Adds one tile's columns of an equation.
  void place(Eigen::MatrixXd& front, Eigen::Index row, const mechanics::Supernode& node,
             Eigen::Index delayed, int tile, const PairEquations::Rows& block) const {
    if (isFixed_[tile]) return;
    // Own tiles are consecutive, the others are found in the sorted list of rows.
    int position = place(tile) - node.firstColumn;
    if (position >= node.columnCount) {
      const auto found = std::ranges::lower_bound(node.rows, place(tile));
      position = node.columnCount + static_cast<int>(found - node.rows.begin());
    }
    front.block(row, columnOf(node, position, delayed), block.rows(), kUnknowns) += block;
  }

  /// The columns that a front can eliminate, in the order of assemble().
  std::vector<FreeColumn> candidates(const mechanics::Supernode& node) const {
    std::vector<FreeColumn> columns;
    for (int c = 0; c < node.columnCount; ++c) {
      for (int k = 0; k < kUnknowns; ++k) columns.push_back({tileAt_[node.firstColumn + c], k});
    }
    for (const int child : node.children) {
      const std::vector<FreeColumn>& delayed = leftOver_[child].delayed;
      columns.insert(columns.end(), delayed.begin(), delayed.end());
    }
    return columns;
  }

  /// Fronts are ordered with children before their parents.
  void eliminate(std::size_t number) {
    const mechanics::Supernode& node = plan_.supernodes[number];
    std::vector<FreeColumn> columns = candidates(node);
    const auto count = static_cast<Eigen::Index>(columns.size());
    Eigen::MatrixXd front = assemble(node, count - kUnknowns * node.columnCount);
    const auto exchange = [&](Eigen::Index first, Eigen::Index second) {
      if (first == second) return;
      front.col(first).swap(front.col(second));
      std::swap(columns[first], columns[second]);
    };
    // Invariant: the first `done` rows and columns are complete.
    Eigen::Index done = 0;
    Eigen::VectorXd lengths;
    for (; done < count; ++done) {
      lengths = front.block(done, done, front.rows() - done, count - done).colwise().norm();
      Eigen::Index longest = 0;
      // Without rows all lengths are 0.
      const double length = lengths.maxCoeff(&longest);
      if (length <= tolerance_) break;
      // R_kk R_kj for all j. The last front of a sheet has no parent.
      const auto below = front.bottomRightCorner(front.rows() - done, front.cols() - done);
      if (!node.rows.empty() && (below.col(longest).transpose() * below).cwiseAbs().maxCoeff() >
                                    kMaxGrowth * length * length) {
        break;
      }
      exchange(done, done + longest);
      reflect(front, done, done);
    }
    // Free columns come before the delayed ones.
    Eigen::Index kept = done;
    for (Eigen::Index k = done; k < count; ++k) {
      if (lengths[k - done] > tolerance_) continue;
      if (!isFixed_[columns[k].tile]) free_.push_back(columns[k]);
      exchange(k, kept);
      std::swap(lengths[k - done], lengths[kept++ - done]);
    }
    Eigen::MatrixXd rest = front.bottomRightCorner(front.rows() - done, front.cols() - kept);
    // More rows than columns contain no further information: R of their QR has the same J^T J.
    if (rest.rows() > rest.cols()) {
      for (Eigen::Index k = 0; k < rest.cols(); ++k) {
        rest(k, k) = reflect(rest, k, k);
        rest.col(k).tail(rest.rows() - k - 1).setZero();
      }
      rest.conservativeResize(rest.cols(), Eigen::NoChange);
    }
    leftOver_[number] = {std::move(rest), {columns.begin() + kept, columns.end()}};
  }

  /// Zeroes one column below this row and updates the columns to its right. Returns the column's
  /// new entry in the row. The column itself keeps the reflection vector.
  double reflect(Eigen::MatrixXd& front, Eigen::Index row, Eigen::Index column) {
    auto below = front.col(column).tail(front.rows() - row);
    double factor = 0;
    double length = 0;
    below.makeHouseholderInPlace(factor, length);
    const Eigen::VectorXd essential = below.tail(below.size() - 1);
    work_.resize(front.cols());
    front.bottomRightCorner(front.rows() - row, front.cols() - column - 1)
        .applyHouseholderOnTheLeft(essential, factor, work_.data());
    return length;
  }

  const std::vector<PairEquations>& equations_;
  const std::vector<bool>& isFixed_;
  double tolerance_;
  mechanics::Elimination plan_;
  std::vector<int> tileAt_;                            ///< by place
  std::vector<std::vector<std::size_t>> equationsAt_;  ///< by place
  std::vector<Remainder> leftOver_;                    ///< by supernode, until its parent uses it
  Eigen::VectorXd work_;
  std::vector<FreeColumn> free_;
};

}  // namespace

std::vector<FreeColumn> freeColumns(int tileCount, const std::vector<PairEquations>& equations,
                                    const std::vector<bool>& isFixed, double tolerance) {
  return FrontalElimination(tileCount, equations, isFixed, tolerance).run();
}

}  // namespace kirireel::fea
