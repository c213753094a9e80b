/// Faces of a mesh as tiles: outlines without slits, faces joined to one tile, faces of a drawing.
#pragma once

#include <filesystem>
#include <functional>
#include <set>
#include <utility>
#include <vector>

#include "sim/formats/shared_corners.h"
#include "sim/model/model.h"

namespace kirireel::formats {

/// The corners of a face without those that enclose nothing: neighbours for which `isSame` holds
/// (repeated vertices, a last corner that closes the polygon), and slits that go to a vertex and
/// back. Costs O(n) for each removed corner.
std::vector<int> faceOutline(std::vector<int> corners,
                             const std::function<bool(int, int)>& isSame = std::equal_to<int>());

/// Two faces, the smaller number first.
using FacePairs = std::vector<std::pair<int, int>>;

/// Faces after some were joined.
struct JoinedFaces {
  CornerNumbers tiles;      ///< vertex numbers round each tile, by its lowest face
  std::vector<int> tileOf;  ///< of each face
};

/// Joins faces that pairs connect to one tile each. Faces stay separate if the outline of all of
/// them is not one closed polygon, or has more than kMaxTileVertices vertices.
JoinedFaces joinFaces(const CornerNumbers& faces, const FacePairs& pairs);

/// Neighbours across an edge that lie in one plane in every state. All states have the tiles of
/// `faces`. `edges`: only across these, by the smaller vertex first; null: across all.
FacePairs coplanarFaces(const CornerNumbers& faces,
                        const std::vector<const std::vector<model::Tile>*>& states,
                        const std::set<std::pair<int, int>>* edges = nullptr);

/// For each point the lowest number of a point at the same position, see samePlaceTolerance().
std::vector<int> numbersByPlace(const std::vector<Vector3>& points);

/// The faces that the edges of a flat drawing enclose, anticlockwise seen from above. Vertices at
/// one position are one. A region that boundary edges (B) separate from the sheet is a hole. Throws
/// InputError that names the file if the drawing is not flat, if edges cross without a vertex, if
/// they enclose no face, and if a face has a separate drawing inside.
CornerNumbers planarFaces(const std::vector<Vector3>& points,
                          const std::vector<model::Crease>& edges,
                          const std::filesystem::path& file);

}  // namespace kirireel::formats
