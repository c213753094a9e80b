/// Abaqus and CalculiX decks of bricks.
#pragma once

#include <string>

#include "render/fea/deck_text.h"
#include "render/fea/element_mesh.h"

namespace kirireel {

/// The text of NAME_mesh.inp: nodes, elements (C3D20R; C3D20 in tiles that are one element wide;
/// C3D8I when linear; shells S8R or S4, plane elements CPS8R or CPS4), sets, surfaces and what
/// holds the joints together, but no material and no step.
///
/// Names count from 0 in the model's order, as those in other exports do: element sets TILE_00000,
/// NECK_00000 and EALL; node sets TILE_00000_N, _BOT, _TOP, JOINT_00000_A and _B, NJOINT, NALL and
/// those of boundarySets; surfaces TILE_00000_SBOT, _STOP, _SIDE and, on each edge of the tile,
/// _S0, _S1 and so on. With contact the surfaces of appendContactSurfaces; for periodic jobs the
/// control nodes NCONTROL, after all others. All is built in memory: about 70 bytes of text a node
/// and up to 170 an element. Throws what contactPairs and periodicity throw, where the settings ask
/// for these, and Interrupted when the user stops the program.
std::string meshDeck(const ElementMesh& mesh, const DeckSettings& settings,
                     const DeckOrigin& origin);

/// Shells that lie on one face, with the set that names them.
struct ShellOffset {
  const char* set;
  double offset = 0;       ///< of OFFSET: from the middle to the nodes, in thicknesses
  std::vector<int> tiles;  ///< from 0
};

/// The shells by their offset; none where all lie in the middle. From the bottom to the top. The
/// mesh must be of shells.
std::vector<ShellOffset> shellOffsets(const ElementMesh& mesh);

/// What a deck names an element. The same word in CalculiX and Abaqus.
const char* elementType(const TileElements& tile, const ElementRule& rule);

}  // namespace kirireel
