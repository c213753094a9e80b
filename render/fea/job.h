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
// Jobs for CalculiX and Abaqus that use the decks of a sheet.

/// A job on a mesh deck.
struct DeckJob {
  std::string sets;  ///< node sets for the end of the job's mesh deck: programs read sets of nodes
                     ///< only next to the nodes
  std::string text;  ///< text of the job, which includes the mesh deck
};

/// A job that includes the mesh deck `meshFile` and runs without editing. Only minSupports hold the
/// sheet. A force of 1 N on each end of its longest axis (XMIN and XMAX, or of another axis) pulls
/// it along the line between the middles of these ends. The force passes through its joints.
/// Requests displacements, stresses, strains and reactions. The user can edit it as a template.
/// *INCLUDE gets `meshFile` unchanged. Throws like minSupports and costs as much: a sparse
/// factorisation of six unknowns per tile.
DeckJob staticJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                  const std::string& meshFile);

/// The same supports with compressed ends: a *BUCKLE step that computes the first five multiples of
/// 1 N at which the sheet buckles. Needs the sets of staticJob. Factors are forces in newtons,
/// because the load is 1 N. Throws like minSupports.
DeckJob bucklingJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                    const std::string& meshFile);

/// Motion of tiles since the state of a mesh.
struct TileHistory {
  std::vector<double> times;  ///< seconds since that state, ascending from 0
  std::vector<Poses> poses;   ///< one entry per time, the first is the mesh's own
};

/// Throws InputError for a choice with duplicate tiles or with tiles outside a model of `tiles`
/// tiles. `countsFrom` is the number of the first tile.
void requireDrivable(const DriveChoice& choice, std::size_t tiles, int countsFrom);

/// The chosen tiles, zero-based. Throws like requireDrivable.
std::vector<int> drivenTiles(const ElementMesh& mesh, const DriveChoice& choice);

/// A job that follows a deployment with large displacements. *AMPLITUDE moves nodes of the driven
/// tiles (tileDisplacements) as in the trajectory. It also moves the remaining mechanisms of the
/// joints (minSupports). The time of its step is the deployment's time. Prints the reactions at
/// NDRIVE in every increment, in CalculiX also the strain energy. `history` has at least two times
/// and one set of poses for each. Samples are skipped if a deck would have more than 200,000 pairs.
/// Throws like requireDrivable and tileDisplacements.
DeckJob driveJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                 const std::string& meshFile, const TileHistory& history);

/// A job that moves a mesh to a later state of the same sheet in one step with large displacements.
/// Every independent node moves to its position in `later`, which has the same node numbers. Tiles
/// only rotate, without strain: the mesh's own state is stress-free, and the displacements are the
/// map from one state to the other. Later steps can start there. Throws InputError for shells and
/// plane elements, whose nodal rotations are unknown. `later` must have the same rule as `mesh`.
DeckJob stateMapJob(const ElementMesh& mesh, const ElementMesh& later, const DeckSettings& settings,
                    const DeckOrigin& origin, const std::string& meshFile);

/// A job on one cell of an infinite periodic sheet (periodicity()). Three linear steps apply a
/// strain of a thousandth: tension along x, free to widen along y and to shear; shear, free to
/// widen along y; compression along y without strain along x and shear. Prints the displacements
/// and reactions of the control nodes, in CalculiX also the strain energy. Throws like periodicity.
DeckJob periodicJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                    const std::string& meshFile);

// ------------------------------------------------------------------------------------------------
// Supports for a static step of a sheet of hinged tiles.

/// A displacement of a node along a world axis.
struct NodeDisplacement {
  int node = 0;  ///< zero-based
  int axis = 0;  ///< 0, 1, 2: x, y, z
  int tile = 0;  ///< the node's tile

  auto operator<=>(const NodeDisplacement&) const = default;
};

/// For each of these tiles, displacements of its nodes that fix it as a rigid body. Six cause no
/// strain. If no six are sufficient at all rotations, all nine of three nodes. Plane elements need
/// three. The nodes are independent and belong to no joint, so supports and drives act on other
/// tiles only through joints. A tile without such nodes uses nodes of joints. `turns`: the tiles'
/// rotations since the mesh's state, one list per tile, or empty. Throws InputError if no
/// displacements fix a tile because all its nodes are dependent. `tiles` is zero-based; returns one
/// list per tile, in their order.
std::vector<std::vector<NodeDisplacement>> tileDisplacements(
    const ElementMesh& mesh, const std::vector<int>& tiles,
    const std::vector<std::vector<Quaternion>>& turns = {});

/// The minimum set of displacements that prevents all motions of rigid tiles: six for the whole and
/// one for each first-order mechanism. They carry no load from each other, so reactions follow from
/// equilibrium. Springs at all hinges leave no mechanism. `fixedTiles` are already held by other
/// means. `loadedNodes` are held only if there are no others, since the load on a held node is part
/// of its reaction. Sorted. Throws InputError like tileDisplacements. Costs a sparse QR
/// factorisation of six unknowns per tile (job.h).
std::vector<NodeDisplacement> minSupports(const ElementMesh& mesh,
                                          const std::vector<int>& fixedTiles = {},
                                          const std::vector<int>& loadedNodes = {});

// ------------------------------------------------------------------------------------------------
// Free unknowns of a sparse system of equations between pairs of tiles.

/// Equations between six unknowns each of two tiles, possibly the same: first u_first + second
/// u_second = 0.
struct PairEquations {
  /// Six columns, at most six rows.
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, 6, 6>;

  int firstTile = 0;   ///< number, zero-based
  int secondTile = 0;  ///< number, zero-based; may equal the first
  Rows first;          ///< (equations x 6), at most six rows
  Rows second;         ///< the same size
};

/// One of the six unknowns of a tile.
struct FreeColumn {
  int tile = 0;     ///< number, zero-based
  int unknown = 0;  ///< 0 to 5
};

/// The unknowns without which the equations have only the zero solution. Their count is the nullity
/// of the matrix. A column is free if elimination leaves it shorter than `tolerance`, in the units
/// of the equations' rows. Of several unknowns that could be held, those that move most are free.
/// Fixed tiles have no unknowns. The result is in the order of elimination. `isFixed` has tileCount
/// entries. Rows are about 1 long. The work is that of a sparse QR factorisation with minimum
/// degree ordering.
std::vector<FreeColumn> freeColumns(int tileCount, const std::vector<PairEquations>& equations,
                                    const std::vector<bool>& isFixed, double tolerance);

}  // namespace kirireel::fea
