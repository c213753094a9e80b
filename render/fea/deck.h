/// Abaqus and CalculiX decks of bricks.
#pragma once

#include <string>

#include "render/fea/element_mesh.h"

namespace kirireel {

/// A number in at most 20 characters, which is all that CalculiX and Abaqus read of it: the
/// shortest text that reads back to the same double where it fits, else 14 digits.
std::string deckNumber(double value);

/// The text of NAME_mesh.inp: nodes, elements (C3D8, C3D6, C3D20, C3D15), sets, surfaces and what
/// holds the joints together, but no material and no step. `title` is one line for the header.
///
/// Names count from 0 in the model's order: element sets TILE_00000 and EALL; node sets
/// TILE_00000_N, _BOT, _TOP, JOINT_00000_A and _B, NJOINT, NALL and NHOLD (corners that a boundary
/// condition may hold: none of them follows other nodes); surfaces TILE_00000_SBOT and _STOP.
std::string meshDeck(const ElementMesh& mesh, const std::string& title);

/// The text of a job that includes that deck and runs as it is: a made-up material, every tile held
/// at its corners, its own weight as the load. A template to be edited.
std::string jobDeck(const ElementMesh& mesh, const std::string& meshFile);

}  // namespace kirireel
