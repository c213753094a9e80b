/// States as sheets of flat tiles, without thickness.
#pragma once

#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// The bottoms of all bricks as an OBJ of polygons, as PyKirigami exports it: "# n vertices m
/// faces", one face a tile in the model's order, no vertex shared, no groups. Coordinates read back
/// to the same doubles. Lengths in metres.
std::string planarObjText(const std::vector<Tile>& tiles);

/// A sheet at one time.
struct SheetState {
  double time = 0;  ///< seconds
  std::vector<Tile> tiles;
};

/// The text of a FOLD 1.1 file: the first state as its own frame, the others in `file_frames`,
/// which inherit all but the coordinates. Vertices that joints of the bottom (or of both faces)
/// hold together are one vertex, at the mean of its corners; edges of one tile are boundaries
/// ("B"), of two flat folds ("F"). `kirireel:joints` holds the model's joints as rows of tile,
/// vertex, tile, vertex, face. At least one state; all have the model's tiles in its order.
std::string foldText(const Model& model, const std::vector<SheetState>& states);

}  // namespace kirireel
