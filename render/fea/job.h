/// Jobs for CalculiX and Abaqus on the decks of a sheet.
#pragma once

#include <string>

#include "render/fea/deck_text.h"
#include "render/fea/element_mesh.h"
#include "sim/base/geometry.h"

namespace kirireel {

/// A job on a mesh deck.
struct DeckJob {
  std::string sets;  ///< node sets that the job needs at the end of its mesh deck: readers of
                     ///< meshes know sets beside their nodes alone
  std::string text;  ///< of the job itself, which includes the mesh deck
};

/// A job that includes the mesh deck of this name and runs as it is: the sheet is held
/// by leastSupports alone and pulled apart, along its longest axis, by 1 N at each end (the nodes
/// of XMIN and XMAX, or of another axis, that are not held), so that the force passes its joints.
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
/// has it. Tiles turn and strain nothing, so that the mesh's own state is stress-free and the
/// nodes' displacements are the map from one state to the other: steps that follow start from
/// there. Throws InputError for shells and plane elements, whose nodes' turns are not known.
/// `later` is made by the same rule as `mesh`.
DeckJob stateMapJob(const ElementMesh& mesh, const ElementMesh& later, const DeckSettings& settings,
                    const DeckOrigin& origin, const std::string& meshFile);

/// A job on a sheet that repeats (periodicity()): its opposite ends are tied to each other by
/// *EQUATION with control nodes, it is strained by a thousandth along the first axis that is tied
/// and free to widen across. Prints the displacements and reactions of the control nodes,
/// with CalculiX the strain energy too. Throws what periodicity throws. The strain is 0.001 times
/// the period, so that the force is in proportion to it.
DeckJob periodicJob(const ElementMesh& mesh, const DeckSettings& settings, const DeckOrigin& origin,
                    const std::string& meshFile);

}  // namespace kirireel
