// Writes jobs: a heading, the mesh by *INCLUDE, material and section, supports, one step. Every job
// runs as it is.
//
//     *HEADING           one line
//     **                 origin, what the job does, what to replace
//     *INCLUDE           the mesh deck
//     *MATERIAL          E (Pa or MPa), Poisson's ratio, density; *SOLID or *SHELL SECTION
//     *BOUNDARY          node, first axis, last axis (1 to 3): displacements held at zero
//     *STEP              *STATIC, *BUCKLE, loads, what is printed
//     *END STEP
//
// Supports. A sheet of tiles on ideal hinges is a mechanism; a program that factorises its
// stiffness finds it singular, or worse, nearly so, and ends without a warning with displacements
// of 1e9 m. leastSupports (supports.h) holds six motions of the whole and one displacement for each
// mechanism, which is the least that makes the problem have one solution, and what is held carries
// no load but what equilibrium asks for.
//
// Driven jobs. Tile t has the pose (R(s), x(s)) at the time s (seconds) and (R(0), x(0)) in the
// mesh. A node at p moves by
//
//     u(s) = R(s) R(0)^T (p - x(0)) + x(s) - p,
//
// and components of u at six displacements of a tile, by *AMPLITUDE, move it as the trajectory did
// (NLGEOM). Amplitudes are linear between samples. Prescribed rotations (*RIGID BODY of whole
// tiles) would be shorter to write but make tiles rigid, whose strain is what is asked for.
//
// Periodic jobs. Control nodes carry the displacement of one end against the other; see
// periodic.cpp.
#include "render/fea/job.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "render/fea/boundary_sets.h"
#include "render/fea/contact_pairs.h"
#include "render/fea/deck.h"
#include "render/fea/patch_deck.h"
#include "render/fea/periodic.h"
#include "render/fea/supports.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// Shells with an offset have a section for each set; all others one for EALL. Plane elements give
/// their thickness in the section's line of data, solids give none.
void appendSection(std::string& text, const ElementMesh& mesh, const DeckSettings& settings,
                   double thickness) {
  const UnitScale scale = unitScale(settings.unit);
  append(text, "*MATERIAL, NAME=SHEET\n*ELASTIC\n{}, {}\n*DENSITY\n{}\n",
         deckNumber(scale.stress * settings.material.youngs), deckNumber(settings.material.poisson),
         deckNumber(scale.density * settings.material.density));
  const bool isShell = mesh.rule.family == ElementFamily::Shell;
  const std::vector<ShellOffset> offsets =
      isShell ? shellOffsets(mesh) : std::vector<ShellOffset>();
  for (const ShellOffset& shells : offsets) {
    append(text, "*SHELL SECTION, ELSET={}, MATERIAL=SHEET, OFFSET={}\n{}\n", shells.set,
           deckNumber(shells.offset), deckNumber(scale.length * thickness));
  }
  if (!offsets.empty()) return;
  append(text, "*{} SECTION, ELSET=EALL, MATERIAL=SHEET\n", isShell ? "SHELL" : "SOLID");
  if (mesh.rule.family == ElementFamily::Solid) return;
  append(text, "{}\n", deckNumber(scale.length * thickness));
}

/// A row for each displacement: node, axis, axis.
void appendSupports(std::string& text, const std::vector<NodeDisplacement>& supports) {
  text += "*BOUNDARY\n";
  for (const NodeDisplacement& held : supports) {
    append(text, "{0}, {1}, {1}\n", held.node + 1, held.axis + 1);
  }
}

/// Rising and each once, because supports are sorted by node.
std::vector<int> nodesOf(const std::vector<NodeDisplacement>& supports) {
  std::vector<int> nodes;
  for (const NodeDisplacement& held : supports) {
    if (nodes.empty() || nodes.back() != held.node) nodes.push_back(held.node);
  }
  return nodes;
}

/// The nodes farthest along an axis (`sign` 1) or against it (-1) that are neither held nor follow
/// others.
std::vector<int> outermost(const ElementMesh& mesh, const std::vector<int>& held, int axis,
                           double sign) {
  const std::vector<bool> follows = followers(mesh);
  std::vector<std::pair<double, int>> free;
  for (int k = 0; k < static_cast<int>(mesh.nodes.size()); ++k) {
    const bool isFree = !follows[k] && !std::ranges::binary_search(held, k);
    if (isFree) free.emplace_back(-sign * mesh.nodes[k][axis], k);
  }
  // The farthest first. Only those with exactly the coordinate of the first are taken.
  std::ranges::sort(free);
  std::vector<int> nodes;
  for (const auto& [place, node] : free) {
    if (place == free.front().first) nodes.push_back(node);
  }
  return nodes;
}

/// GRIP_XMIN and GRIP_XMAX, or of another axis: the nodes at the sheet's two ends that are not
/// held, or where all are, those next to them. Programs would count what is applied at held nodes
/// among the reactions.
std::vector<NamedNodes> gripSets(const ElementMesh& mesh, const std::vector<int>& held) {
  const std::vector<NamedNodes> ends = boundarySets(mesh);
  std::vector<NamedNodes> grips;
  for (const int end : {0, 1}) {
    const std::size_t place = 2 * longestAxis(mesh) + end;
    NamedNodes& grip = grips.emplace_back();
    grip.name = "GRIP_" + ends[place].name;
    // Both lists rise.
    std::ranges::set_difference(ends[place].nodes, held, std::back_inserter(grip.nodes));
    if (grip.nodes.empty()) {
      grip.nodes = outermost(mesh, held, longestAxis(mesh), end == 0 ? -1 : 1);
    }
  }
  return grips;
}

/// Equal forces on the nodes of both grips, 1 N in sum at each: apart with sign 1, together with
/// -1.
void appendGripForces(std::string& text, const std::vector<NamedNodes>& grips, int axis,
                      double sign) {
  text += "*CLOAD\n";
  for (const NamedNodes& grip : grips) {
    // The first grip is the MIN end, so sign 1 pulls it in the negative direction.
    sign = -sign;
    append(text, "{}, {}, {}\n", grip.name, axis + 1,
           deckNumber(sign / static_cast<double>(grip.nodes.size())));
  }
}

/// Displacements, reactions, stresses and strains in the program's own result file, and what is
/// said of the held or driven nodes, with the sum of their reactions, in NAME.dat. `set` names
/// nodes in the mesh deck, `printed` is U, RF or both.
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
  append(text, "*NODE PRINT, NSET={}, TOTALS=YES\n{}\n", set, printed);
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
  // The path is as given: both programs look for it in the folder that they were started in.
  append(text, "*INCLUDE, INPUT={}\n", meshFile);
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

/// What a sheet is held and gripped by.
struct HeldSheet {
  std::vector<NodeDisplacement> supports;
  std::vector<NamedNodes> grips;
  std::string sets;  ///< NHOLD and those of the grips
};

HeldSheet heldSheet(const ElementMesh& mesh) {
  HeldSheet held{leastSupports(mesh), {}, {}};
  held.grips = gripSets(mesh, nodesOf(held.supports));
  held.sets = "** What the job holds and grips.\n";
  appendNodeSet(held.sets, "NHOLD", nodesOf(held.supports));
  for (const NamedNodes& grip : held.grips) appendNodeSet(held.sets, grip.name, grip.nodes);
  return held;
}

/// Displacements from the mesh's state on, at each time, of the point that a node is of its tile.
/// In metres, along the driven axis, an entry a sample; the first is 0 up to rounding.
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

/// Every so many samples, the first and the last among them, so that amplitudes stay readable:
/// CalculiX 2.20 crashes on decks with 300,000 pairs in them; it reads 220,000.
TileHistory thinned(const TileHistory& history, std::size_t driven) {
  constexpr std::size_t kMostPairs = 200'000;
  const std::size_t count = history.times.size();
  // The last sample is added in any case, for the end state is what is looked at.
  const std::size_t step = driven * count / kMostPairs + 1;
  TileHistory kept;
  for (std::size_t k = 0; k + 1 < count; k += step) {
    kept.times.push_back(history.times[k]);
    kept.poses.push_back(history.poses[k]);
  }
  kept.times.push_back(history.times.back());
  kept.poses.push_back(history.poses.back());
  return kept;
}

/// *AMPLITUDE, four pairs of time and value a line. Values are multiplied by `scale`; times are
/// seconds in all units.
void appendAmplitude(std::string& text, const std::string& name, const std::vector<double>& times,
                     const std::vector<double>& values, double scale) {
  append(text, "*AMPLITUDE, NAME={}\n", name);
  for (std::size_t k = 0; k < times.size(); ++k) {
    const bool endsLine = k % 4 == 3 || k + 1 == times.size();
    append(text, "{}, {}{}", deckNumber(times[k]), deckNumber(scale * values[k]),
           endsLine ? "\n" : ", ");
  }
}

/// How each of these tiles turns from the mesh's state on.
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

/// What residual forces are compared with. Tiles on ideal hinges move without any force, so that
/// programs, which compare with the mean force, would wait for rounding to vanish. The numbers are
/// those of *CONTROLS in both programs: R_n = 0.005, the share of the mean force below which
/// residuals have converged, C_n = 0.01 for corrections, q_0 and q_u, the mean force at the start
/// and throughout, here E t^2 / 10^6 (N), R_P = 0.02, and the share below which forces count as
/// zero.
void appendForceMeasure(std::string& text, const DeckSettings& settings, double thickness) {
  const UnitScale scale = unitScale(settings.unit);
  const double force = 1e-6 * settings.material.youngs * thickness * thickness * scale.stress *
                       scale.length * scale.length;
  append(text,
         "** Residual forces count from a millionth of E t^2 on: ideal hinges move without "
         "any.\n"
         "*CONTROLS, PARAMETERS=FIELD, FIELD=DISPLACEMENT\n0.005, 0.01, {0}, {0}, 0.02, 0.005\n",
         deckNumber(force));
}

/// A<node>_<axis>, both from 1, which is unique in a deck.
std::string amplitudeName(const NodeDisplacement& driven) {
  return fmt::format("A{}_{}", driven.node + 1, driven.axis + 1);
}

/// The tiles with nodes at either end of the longest axis.
std::vector<int> tilesAtEnds(const ElementMesh& mesh) {
  const std::vector<NamedNodes> sets = boundarySets(mesh);
  std::vector<bool> isAtEnd(mesh.nodes.size());
  for (const int end : {0, 1}) {
    const std::size_t place = 2 * longestAxis(mesh) + end;
    for (const int node : sets[place].nodes) {
      // Reference nodes of patches count on after the mesh's own and belong to no tile.
      if (static_cast<std::size_t>(node) < isAtEnd.size()) isAtEnd[node] = true;
    }
  }
  std::vector<int> tiles;
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
    const std::vector<int>& nodes = mesh.tiles[t].nodes;
    if (std::ranges::any_of(nodes, [&](int node) { return isAtEnd[node]; })) {
      tiles.push_back(static_cast<int>(t));
    }
  }
  return tiles;
}

void requireMappable(const ElementRule& rule) {
  if (rule.family == ElementFamily::Solid) return;
  throw InputError(
      "error: --state-map moves solids; shells and plane elements have turns that it does not "
      "know: "
      "leave out --shells");
}

/// The model with what is held before its step.
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
  // Supports in the plane: two displacements and a turn.
  const std::size_t rigid = mesh.rule.family == ElementFamily::Plane ? 3 : 6;
  append(text,
         "** A job to start from: the sheet is pulled apart at both ends, 1 N each, through its "
         "joints.\n"
         "** Held are {} displacements: {} rigid motions and {} mechanisms of ideal hinges, each "
         "by\n"
         "** one displacement, so that nothing else is strained. Holding less leaves a mechanism, "
         "on\n"
         "** which a linear static step gives huge displacements and no warning: look at the "
         "largest |U|.\n"
         "** Replace material, supports and loads by yours. Its weight would be\n"
         "**   *DLOAD\n**   EALL, GRAV, {}, 0., 0., -1.\n",
         held.supports.size(), rigid, held.supports.size() - rigid,
         deckNumber(9.81 * unitScale(settings.unit).length));
  appendHeldModel(text, mesh, settings, origin, meshFile, held);
  text += "*STEP\n*STATIC\n";
  appendGripForces(text, held.grips, longestAxis(mesh), 1);
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
  appendGripForces(text, held.grips, longestAxis(mesh), -1);
  text +=
      settings.solver == Solver::Calculix ? "*NODE FILE\nU\n" : "*OUTPUT, FIELD\n*NODE OUTPUT\nU\n";
  return {held.sets, text + "*END STEP\n"};
}

void requireDrivable(const DriveChoice& choice, std::size_t tiles, int countsFrom) {
  std::vector<int> named = choice.tiles;
  std::ranges::sort(named);
  // Sorted numbers put what is named twice side by side.
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
  // Six displacements a tile, nine at worst, each with an amplitude of its own.
  const TileHistory history = thinned(allSamples, 6 * tiles.size());
  std::vector<NodeDisplacement> driven;
  const std::vector<std::vector<Quaternion>> turns = turnsOf(tiles, history);
  for (const auto& own : tileDisplacements(mesh, tiles, turns)) {
    driven.insert(driven.end(), own.begin(), own.end());
  }
  // What the driven tiles leave free moves as the trajectory had it, too: held at rest it would
  // block the mechanism.
  const std::vector<NodeDisplacement> rest = leastSupports(mesh, tiles);
  driven.insert(driven.end(), rest.begin(), rest.end());
  std::ranges::sort(driven);

  std::string text = heading(origin, "driven");
  appendOrigin(text, origin, settings.unit);
  append(
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
  // A twentieth of the time an increment at first and at most, a millionth at least: linear paths
  // between samples are followed closely enough, and CalculiX cuts increments where it must.
  const double end = history.times.back();
  append(text, "*STEP, NLGEOM, INC=100000\n*STATIC\n{}, {}, {}, {}\n", deckNumber(end / 20),
         deckNumber(end), deckNumber(end / 1e6), deckNumber(end / 20));
  if (mesh.rule.joints != JointStyle::Neck) appendForceMeasure(text, settings, origin.thickness);
  appendSpringMoments(text, mesh, settings);
  for (const NodeDisplacement& one : driven) {
    append(text, "*BOUNDARY, AMPLITUDE={0}\n{1}, {2}, {2}, 1.\n", amplitudeName(one), one.node + 1,
           one.axis + 1);
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
  // Followers cannot be prescribed; they go where their leaders do.
  const std::vector<bool> follows = followers(mesh);
  const double scale = unitScale(settings.unit).length;
  const auto appendMove = [&](int node, const Vector3& move) {
    for (int axis = 0; axis < 3; ++axis) {
      append(text, "{0}, {1}, {1}, {2}\n", node + 1, axis + 1, deckNumber(scale * move[axis]));
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
  // Small enough that a linear step is right, large against rounding of coordinates.
  constexpr double kStrain = 1e-3;
  const Periodicity periodic = periodicity(mesh);
  // The supports must know of ties, or they would hold motions that these stop already.
  ElementMesh tied = mesh;
  tied.ties = periodic.ties;
  const std::vector<NodeDisplacement> supports = leastSupports(tied);
  // As meshDeck numbers them: after the mesh's nodes and those of patches.
  const int control =
      static_cast<int>(mesh.nodes.size() + PatchDeck(mesh, settings.solver).nodes().size());
  const int axis = periodic.axes[0] ? 0 : 1;
  std::string text = heading(origin, "periodic");
  appendOrigin(text, origin, settings.unit);
  append(text,
         "** Opposite ends move alike but for the control nodes NCONTROL, whose displacements are "
         "those of\n"
         "** one end against the other and whose reactions are the forces on it. Here the sheet is "
         "strained\n"
         "** by {} along {}, and free to widen across. Held besides are {} displacements: what "
         "moves while\n"
         "** the control nodes rest.\n",
         kStrain, axis == 0 ? "x" : "y", supports.size());
  appendJointWarnings(text, mesh);
  appendModel(text, mesh, settings, origin, meshFile);
  appendTies(text, periodic, mesh, control);
  appendSupports(text, supports);
  const int directions = mesh.rule.family == ElementFamily::Plane ? 2 : 3;
  const bool hasBoth = periodic.axes[0] && periodic.axes[1];
  for (int direction = 0; direction < directions; ++direction) {
    // Shear of the sheet is held: the control nodes move along their own axes alone.
    if (direction != axis) append(text, "{0}, {1}, {1}\n", control + 1, direction + 1);
    if (hasBoth && direction != 1) append(text, "{0}, {1}, {1}\n", control + 2, direction + 1);
  }
  append(text, "*STEP\n*STATIC\n*BOUNDARY\n{0}, {1}, {1}, {2}\n", control + 1, axis + 1,
         deckNumber(kStrain * periodic.period[axis] * unitScale(settings.unit).length));
  appendSpringMoments(text, mesh, settings);
  appendRequests(text, settings.solver, "NCONTROL", "U, RF");
  if (settings.solver == Solver::Calculix) {
    text +=
        "** CalculiX leaves the forces of equations out of RF: the force is twice the energy by "
        "the displacement.\n"
        "*EL PRINT, ELSET=EALL, TOTALS=ONLY\nELSE\n";
  }
  return {{}, text + "*END STEP\n"};
}

}  // namespace kirireel
