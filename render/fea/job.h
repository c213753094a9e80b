/// Jobs for CalculiX and Abaqus on the decks of a sheet, and the supports that they need.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "render/fea/deck.h"
#include "render/fea/element_mesh.h"
#include "sim/base/geometry.h"

namespace kirireel::fea {

// ------------------------------------------------------------------------------------------------
// Jobs for CalculiX and Abaqus on the decks of a sheet.

/// A job on a mesh deck.
struct DeckJob {
  std::string sets;  ///< node sets that the job needs at the end of its mesh deck: readers of
                     ///< meshes know sets only next to their nodes
  std::string text;  ///< of the job itself, which includes the mesh deck
};

/// A job that includes the mesh deck of this name and runs as it is: the sheet is held
/// only by leastSupports and pulled apart, along its longest axis, by 1 N at each end (the nodes
/// of XMIN and XMAX, or of another axis, that are not held). The force passes its joints.
/// Asks for displacements, stresses, strains and reactions. A template to be edited. `meshFile` is
/// written into *INCLUDE as it is. Throws what leastSupports throws. The cost is that of
/// leastSupports, a sparse factorisation of six unknowns a tile.
DeckJob staticJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                  const std::string& meshFile);

/// The same supports, but the ends pushed together: a *BUCKLE step that finds the first five
/// multiples of 1 N at which the sheet buckles. Needs the sets of staticJob. Factors are forces in
/// newtons, because the load is 1 N. Throws what leastSupports throws.
DeckJob bucklingJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                    const std::string& meshFile);

/// How tiles moved from the state of a mesh on.
struct TileHistory {
  std::vector<double> times;  ///< seconds from that state, rising from 0
  std::vector<Poses> poses;   ///< one entry a time, the mesh's own first
};

/// Throws InputError for a choice that names tiles that a model with so many does not have, or one
/// twice. `countsFrom` is the number of its first tile.
void requireDrivable(const DriveChoice& choice, std::size_t tiles, int countsFrom);

/// The tiles that a choice names, from 0. Throws what requireDrivable throws.
std::vector<int> drivenTiles(const ElementMesh& mesh, const DriveChoice& choice);

/// A job that follows a deployment with large displacements: the driven tiles are moved
/// by displacements of their nodes (tileDisplacements) as the trajectory moved them, by
/// *AMPLITUDE, and so is what their motion leaves free of the joints' mechanisms (leastSupports).
/// The time of its step is the deployment's. Prints the reactions at NDRIVE in every increment,
/// with CalculiX the strain energy too. `history` has at least two times and one set of poses for
/// each; samples are left out where a deck would hold more than 200,000 pairs. Throws what
/// requireDrivable and tileDisplacements throw.
DeckJob driveJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                 const std::string& meshFile, const TileHistory& history);

/// A job that takes a mesh to a later state of the same sheet in one step with large displacements:
/// every node that follows no other is moved to where `later`, whose nodes have the same numbers,
/// has it. Tiles turn and strain nothing: the mesh's own state is stress-free and the
/// nodes' displacements are the map from one state to the other: steps that follow start from
/// there. Throws InputError for shells and plane elements, whose nodes' turns are not known.
/// `later` is made by the same rule as `mesh`.
DeckJob stateMapJob(const ElementMesh& mesh, const ElementMesh& later, const DeckSettings& settings,
                    const DeckOrigin& origin, const std::string& meshFile);

/// A job on a sheet that repeats (periodicity()), one cell of an infinite sheet. Three linear steps
/// strain it by a thousandth: stretched along x, free to widen along y; sheared; compressed along y
/// without strain along x. Prints the displacements and reactions of the control nodes, with CalculiX the
/// strain energy too. Throws what periodicity throws.
DeckJob periodicJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                    const std::string& meshFile);

// ------------------------------------------------------------------------------------------------
// Which displacements to hold for a static step of a sheet of hinged tiles.

/// A displacement of a node along an axis of the world.
struct NodeDisplacement {
  int node = 0;  ///< from 0
  int axis = 0;  ///< 0, 1, 2: x, y, z
  int tile = 0;  ///< that the node belongs to

  auto operator<=>(const NodeDisplacement&) const = default;
};

/// For each of these tiles displacements of its nodes that fix it as a rigid body: six, which
/// strain nothing, or where no six do so in all turns, all nine of three nodes. They lie on nodes
/// that follow no others and belong to no joint: what holds or drives them acts through the
/// joints on the other tiles; where a tile has no such nodes, on nodes of joints. Plane elements
/// have three. `turns` are the rotations that the tiles will have from the mesh's state on, one
/// list a tile, or none. Throws InputError when even these do not fix a tile: all of them follow
/// others. `tiles` counts from 0; one list of displacements a tile, in their order.
std::vector<std::vector<NodeDisplacement>> tileDisplacements(
    const ElementMesh& mesh, const std::vector<int>& tiles,
    const std::vector<std::vector<Quaternion>>& turns = {});

/// The fewest displacements that leave the sheet no way to move without strain, were its tiles
/// rigid: six for the motions of the whole and one for each mechanism of the first order. None of
/// them takes load from another; the reactions follow only from equilibrium. With springs at all
/// hinges no mechanism is left. `fixedTiles` are held by other means already; `loadedNodes` are held
/// only if there are no others, since what loads a held node counts among its reactions. Sorted.
/// Throws InputError as tileDisplacements does. Costs a sparse QR factorisation of six unknowns a tile
/// (job.h).
std::vector<NodeDisplacement> leastSupports(const ElementMesh& mesh,
                                            const std::vector<int>& fixedTiles = {},
                                            const std::vector<int>& loadedNodes = {});

// ------------------------------------------------------------------------------------------------
// Which unknowns of a sparse system of equations between pairs of tiles can be chosen freely.

/// Equations between the six unknowns of one tile and those of another, or the same: first u_first
/// + second u_second = 0.
struct PairEquations {
  /// Six columns, at most six rows.
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, 6, 6>;

  int firstTile = 0;   ///< its number, from 0
  int secondTile = 0;  ///< its number, from 0; it may be the first
  Rows first;          ///< (equations x 6), at most six
  Rows second;         ///< as many
};

/// An unknown: one of the six of a tile.
struct FreeColumn {
  int tile = 0;     ///< its number, from 0
  int unknown = 0;  ///< 0 to 5
};

/// The unknowns without which the equations have only the solution zero, as many as the matrix has
/// nullity. A column counts as free where elimination leaves it shorter than `tolerance`, in the
/// equations' own measure. Tiles that are fixed have no unknowns. Each tile's together, in the
/// order of elimination. `isFixed` has tileCount entries. The tolerance has the unit of the
/// equations' rows. Work is that of a sparse QR factorisation in an order of minimum degree.
std::vector<FreeColumn> freeColumns(int tileCount, const std::vector<PairEquations>& equations,
                                    const std::vector<bool>& isFixed, double tolerance);

}  // namespace kirireel::fea
