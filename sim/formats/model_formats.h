/// Reads and writes models in other programs' formats: OBJ, PLY, planar files, cut patterns, FOLD.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/formats/read_settings.h"
#include "sim/formats/shared_corners.h"
#include "sim/model/model.h"

namespace kirireel::formats {

/// The kinds of paths that are models, for help and messages.
inline constexpr const char* kModelForms =
    "a folder with vertices.txt, a planar NAME_vertices.txt, a .fold, .obj or .ply file, or a cut "
    "pattern (.svg, .dxf)";

// ------------------------------------------------------------------------------------------------
// Wavefront OBJ files: a sheet in one state, or two files with the same faces in two states.

/// The file with the deployed state: NAME_deployed.obj in the folder of NAME_contracted.obj or
/// NAME.obj. Absent if there is no such file.
std::optional<std::filesystem::path> deployedSibling(const std::filesystem::path& contracted);

/// Reads a sheet from its state at the start and optionally at the target. Faces are tiles. Vertex
/// numbers that faces share are joints, see meshNumbers(). Comments "# joint A a B b FACE" and "#
/// pull TILE", written by writeObjPair, replace this rule. Groups and materials name tiles. Other
/// statements about appearance (vt, vn, s, mtllib) are ignored.
///
/// Throws InputError with file and line for invalid numbers, faces and tiles, and for states with
/// different faces. Adds warnings for harmless faults, and for the number of ignored statements
/// with other geometry.
model::Model readObjPair(const std::filesystem::path& start,
                         const std::optional<std::filesystem::path>& target,
                         std::vector<std::string>& warnings, const ReadSettings& settings = {});

/// Writes the start to `file` and an existing target to its sibling NAME_deployed.obj. Reading
/// gives the same model to the last bit. Throws InputError for a model with links or fixed joints,
/// which OBJ cannot hold, and OutputError if writing fails.
void writeObjPair(const model::Model& model, const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------------
// PLY meshes of sheets in one state.

/// Reads a sheet from a PLY file (Turk 1994), ASCII or binary with either byte order. Faces are
/// tiles. Vertex numbers that faces share are joints, see meshNumbers(), so faces with a common
/// edge are hinged. Other elements and properties are ignored.
///
/// Throws InputError for invalid headers and numbers, files that end early, and tiles that cannot
/// be bricks. Coordinates are in the file's unit. There is no target. The whole file is read into
/// memory, at most kMaxTextBytes.
model::Model readPly(const std::filesystem::path& file, std::vector<std::string>& warnings,
                     const ReadSettings& settings = {});

// ------------------------------------------------------------------------------------------------
// The files of a planar model lie in one folder, and their names show which belong together.
//
// NAME_vertices.txt holds the tiles. Text files in the same folder whose name begins with NAME have
// other parts. Names with the word "constraints" are lists of joints (such as NAME_constraints.txt,
// NAME_expansion_constraints.txt, NAME_constraints2.txt). The name of a list with "hull" in place
// of "constraints" has the outline's corners. If the NAME of one model begins that of another, a
// file belongs to the longer one.

/// The selected files.
struct PlanarPlace {
  std::filesystem::path vertices;  ///< the tiles
  std::filesystem::path joints;    ///< the list of joints
  std::optional<std::filesystem::path>
      hull;  ///< the corners of the hull; absent if there is no such file
  std::vector<std::filesystem::path> otherJoints;  ///< lists that were not selected, by name
  std::vector<std::filesystem::path> otherHulls;   ///< the same for hulls
};

/// Whether a file name is that of a planar model's tiles, joints or hull.
bool isPlanarName(const std::filesystem::path& file);

/// Whether a file name is that of a planar model's joints.
bool isJointList(const std::filesystem::path& file);

/// The file of vertices of the model that a file belongs to by its name. Throws InputError if there
/// is none.
std::filesystem::path planarVertices(const std::filesystem::path& file);

/// Selects the files of the model that `named` belongs to. `jointsFile`, a path or the name of a
/// file in the same folder, selects the list of joints. If it is empty, `named` selects it if it is
/// a list or a hull, else NAME_constraints.txt, else the only list. Throws InputError if there is
/// no list or the selection is ambiguous.
PlanarPlace planarPlace(const std::filesystem::path& named,
                        const std::filesystem::path& jointsFile);

/// Lists of joints in the folder of a file of vertices, by name.
std::vector<std::filesystem::path> jointLists(const std::filesystem::path& vertices);

/// "a.txt, b.txt".
std::string fileNames(const std::vector<std::filesystem::path>& files);

// ------------------------------------------------------------------------------------------------
// The planar files of the quasicrystal kirigami simulator (Liu, Choi and Mahadevan 2022).

/// Whether a file of vertices holds "x y" pairs and not "x y z". Each line then has an even count
/// of numbers, the counts above 6 are not all multiples of 3, and no joint in its folder has a
/// face.
bool holdsPlanarModel(const std::filesystem::path& vertices);

/// Reads a planar model, given any of its files. The file of vertices has one tile per line, "x y"
/// for each vertex, in either orientation. A list of joints has "tile vertex tile vertex" per line,
/// one-based. A hull has "tile vertex" per line, zero-based. Vertices that coincide within the
/// precision of the file's digits become joints on both faces. Others become links.
///
/// Throws InputError with file and line for invalid numbers and tiles that cannot be bricks.
model::Model readPlanarFiles(const std::filesystem::path& named, const ReadSettings& settings,
                             std::vector<std::string>& warnings);

/// Writes a planar model: `vertices`, and in the same folder its joints and its hull if it has one.
/// Throws InputError for a start that is not flat and for fixed joints. Throws OutputError if
/// writing fails.
void writePlanarFiles(const model::Model& model, const std::filesystem::path& vertices);

/// The first `dimensions` coordinates of all vertices, a line per tile.
std::string tilesText(const std::vector<model::Tile>& tiles, int dimensions);

/// Lines "tile vertex", zero-based.
std::string hullText(const std::vector<model::Corner>& hull);

// ------------------------------------------------------------------------------------------------
// Cut patterns, drawings for a cutter.

/// Reads a sheet from a drawing (SVG, DXF) of its outline and cuts, at true size in metres, in the
/// plane z = 0. It gives tiles, and joints on both faces at the necks of material between them.
/// There is no target. Patterns of `export --format svg,dxf` with layers cuts, slits and hinges
/// give the same model again. For others, a warning summarises the result in one line.
///
/// Slits are open lines that end before another line. The extension is a neck, and its end the
/// joint. Slots are closed outlines of removed material. Their centre lines are read as slits.
///
/// Throws InputError with the position in the drawing's coordinates for open outlines, pieces
/// without connection, strips between parallel cuts, and tiles that cannot be bricks.
model::Model readCutPattern(const std::filesystem::path& file, const ReadSettings& settings,
                            std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// FOLD files (github.com/edemaine/fold, versions 1.0 to 1.2): JSON with a sheet in one or more
// frames.

/// Reads a sheet. The first frame with coordinates and with faces or edges is the start. Further
/// states of the same sheet, by coordinates or by fold angles of a flat start, are waypoints and
/// the target. Faces are tiles without their slits. Faces with a common J edge form one tile.
/// Without a list of faces, they are found from the edges. Vertices that faces share are joints, so
/// faces with a common edge are hinged, except at cuts. A flat sheet in one state has its folded
/// state as target, and fold springs rest at these angles. Kirireel's own keys, written by
/// writeFold, add details.
///
/// Throws InputError for invalid JSON, wrong numbers, tiles that cannot be bricks, missing frames
/// or folds, and two edges of the same two faces with different angles. Coordinates are in the
/// file's unit, which is `declaredUnit` (frame_unit). Adds warnings for unread data, for decisions
/// by letters, and for harmless faults: tiles of a target that are not congruent, angles that do
/// not close.
model::Model readFold(const std::filesystem::path& file, const ReadSettings& settings,
                      std::vector<std::string>& warnings);

/// The tiles at one time of a run.
struct FoldState {
  std::string title;               ///< title of its frame
  std::vector<model::Tile> tiles;  ///< in the order of the model's file
};

/// The text of a FOLD 1.2 file: the model with its edges, letters and angles. Origami programs can
/// fold it, and reading gives the same model to the last bit. Vertices, edges, letters and angles
/// of the model's own FOLD file are kept. `samples`: states of a run as frames, the first is the
/// model's start. They replace the targets, which then have Kirireel's own key.
std::string foldText(const model::Model& model, const std::vector<FoldState>& samples = {});

/// Writes this text and replaces an existing file. Throws OutputError.
void writeFold(const model::Model& model, const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------------
// Edges in FOLD: which faces they hinge, fix or separate, and their fold angles.
//
// Assignments (FOLD 1.2): B boundary; M mountain, V valley, F flat, U unassigned: a hinge if two
// faces share the edge; C cut: no hinge, the two sides separate at its inner ends; J join: the two
// faces are one rigid piece. Fold angles are signed dihedral angles in degrees, 0 flat, positive if
// the two faces turn towards their upper side (valley).

/// The joints of faces that share vertices, as in jointsOfSharedNumbers, except at creases that cut
/// or fix. `tiles` are the faces at the start. Edges that are not in `creases` count as unassigned,
/// which means hinges. Fixed joints come last.
std::vector<model::Joint> jointsOfCreases(const CornerNumbers& faces,
                                          const std::vector<model::Crease>& creases,
                                          const std::vector<model::Tile>& tiles);

/// The normal of the common plane of all tiles, on the side from which most of their area is
/// anticlockwise: the upper side of a crease pattern. Absent if there is no common plane.
std::optional<Vector3> sheetNormal(const model::Model& model);

/// The tiles of a crease pattern with this normal, folded along all hinges with an angle. Face 0 of
/// each connected piece is fixed. Absent if all angles are 0. Angles that contradict each other
/// around a loop are not detected here.
std::optional<std::vector<model::Tile>> foldedTiles(const CornerNumbers& faces,
                                                    const std::vector<model::Crease>& creases,
                                                    const std::vector<model::Tile>& tiles,
                                                    const Vector3& normal);

/// The fold angles between two faces, as in Model::foldAngles, of all common edges with an angle in
/// a crease, except cuts and joins. The faces are the tiles of `model`. `normal`: of a crease
/// pattern, whose angles count from there as in foldedTiles(). Absent: they count from the face
/// with the lower number as in creasesOf(). Throws InputError with the file name if edges of the
/// same two faces have different angles.
std::map<std::pair<int, int>, double> foldAnglesOf(const CornerNumbers& faces,
                                                   const std::vector<model::Crease>& creases,
                                                   const model::Model& model,
                                                   const std::optional<Vector3>& normal,
                                                   const std::filesystem::path& file);

/// The edges of all faces, each once: boundary edges of one face, else mountain, valley or flat,
/// with the fold angle in `state`, the folded faces. Edges are in the order of their vertex
/// numbers. If more than two faces share an edge, the angle is that between the first two.
std::vector<model::Crease> creasesOf(const CornerNumbers& faces,
                                     const std::vector<model::Tile>& state);

/// The edges for the model's file. A crease pattern with this normal has its target's angles. Other
/// models have their current angles. Model::foldAngles have priority. `faces` number the corners in
/// the order of the model's own file.
std::vector<model::Crease> creasesOf(const CornerNumbers& faces, const model::Model& model,
                                     const std::optional<Vector3>& normal);

}  // namespace kirireel::formats
