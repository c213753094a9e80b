/// Jobs for CalculiX and Abaqus on the decks of a sheet.
#pragma once

#include <string>

#include "render/fea/deck_text.h"
#include "render/fea/element_mesh.h"
#include "sim/base/geometry.h"

namespace kirireel {

/// The text of a job that includes the mesh deck of this name and runs as it is: the sheet is held
/// by leastSupports alone and pulled apart, along its longest axis, by 1 N at each end (the nodes
/// of XMIN and XMAX, or of another axis, that are not held), so that the force passes its joints.
/// Asks for displacements, stresses, strains and reactions. A template to be edited.
std::string staticJob(const ElementMesh& mesh, const DeckSettings& settings,
                      const DeckOrigin& origin, const std::string& meshFile);

/// The same supports, but the ends pushed together: a *BUCKLE step that finds the first five
/// multiples of 1 N at which the sheet buckles.
std::string bucklingJob(const ElementMesh& mesh, const DeckSettings& settings,
                        const DeckOrigin& origin, const std::string& meshFile);

/// How tiles moved from the state of a mesh on.
struct TileHistory {
  std::vector<double> times;  ///< seconds from that state, rising from 0
  std::vector<Poses> poses;   ///< one entry a time, the mesh's own first
};

/// Throws InputError for a choice that names tiles that a model with so many does not have, or one
/// twice.
void requireDrivable(const DriveChoice& choice, std::size_t tiles);

/// The tiles that a choice names. Throws what requireDrivable throws.
std::vector<int> drivenTiles(const ElementMesh& mesh, const DriveChoice& choice);

/// The text of a job that follows a deployment with large displacements: the driven tiles are moved
/// by displacements of their nodes (tileDisplacements) as the trajectory moved them, by
/// *AMPLITUDE, and so is what their motion leaves free of the joints' mechanisms (leastSupports).
/// The time of its step is the deployment's. Prints the reactions at NDRIVE in every increment,
/// with CalculiX the strain energy too.
std::string driveJob(const ElementMesh& mesh, const DeckSettings& settings,
                     const DeckOrigin& origin, const std::string& meshFile,
                     const TileHistory& history);

}  // namespace kirireel
