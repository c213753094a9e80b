/// Files of other programs as models: meshes (OBJ, PLY), planar sheets and cut patterns, FOLD.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/model/model.h"
#include "sim/model/model_checks.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// Wavefront OBJ files: a sheet in one state, or a pair of files with the same faces in two states.

/// The file with the other state of a contracted one: NAME_deployed.obj beside NAME_contracted.obj
/// or NAME.obj; none when there is no such file.
std::optional<std::filesystem::path> deployedSibling(const std::filesystem::path& contracted);

/// Reads a sheet from its state at the start and, if given, at the target. Faces are tiles, vertex
/// numbers that faces share are joints; where no face shares any, corners that coincide in all
/// given states are. Comments "# joint A a B b FACE" and "# pull TILE", which writeObjPair leaves,
/// say more and then count instead. Statements that describe looks (vt, vn, g, o, s, usemtl,
/// mtllib) are passed over.
///
/// Throws InputError with file and line for numbers, faces and tiles that are wrong, and for states
/// whose faces differ; appends to warnings what a run can live with, and how many statements that
/// hold other geometry are not read.
Model readObjPair(const std::filesystem::path& start,
                  const std::optional<std::filesystem::path>& target,
                  std::vector<std::string>& warnings, const ReadSettings& settings = {});

/// Writes the start to `file` and the target, if there is one, to its sibling NAME_deployed.obj, so
/// that reading gives the same model to the last bit. Throws InputError for a model with links or
/// fixed joints, which the format cannot hold, OutputError when writing fails.
void writeObjPair(const Model& model, const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------------
// PLY meshes of sheets in one state.

/// Reads a sheet from a PLY file (Turk 1994), ASCII or binary of either byte order: faces are
/// tiles, vertex numbers that faces share are joints, so that faces with a common edge are hinged;
/// where no face shares any, corners that coincide are. Other elements and properties are passed
/// over.
///
/// Throws InputError for headers and numbers that are wrong, files that end early, and tiles that
/// make no bricks.
/// Coordinates are in the file's unit. There is no target. A file as large as kMostTextBytes is
/// read whole into memory.
Model readPly(const std::filesystem::path& file, std::vector<std::string>& warnings,
              const ReadSettings& settings = {});

// ------------------------------------------------------------------------------------------------
// Planar sheets in files: vertices and joints in files of numbers, and cut patterns.

// ------------------------------------------------------------------------------------------------
// The files of a planar model, which lie beside each other and are known by their names.
//
// NAME_vertices.txt holds the tiles. Of the text files beside it whose name begins with NAME,
// those with the word "constraints" are lists of joints (NAME_constraints.txt, NAME_expansion_
// constraints.txt, NAME_constraints2.txt), those with "hull" the corners of the outline for the
// list whose name has "constraints" in place of "hull". Where NAME of one model begins NAME of
// another, a file belongs to the longer one.

/// The files that were chosen.
struct PlanarPlace {
  std::filesystem::path vertices;  ///< the tiles
  std::filesystem::path joints;    ///< which corners are one
  std::optional<std::filesystem::path>
      hull;  ///< which corners are the hull's; absent: none is named
  std::vector<std::filesystem::path> otherJoints;  ///< lists that were not chosen, by name
  std::vector<std::filesystem::path> otherHulls;   ///< likewise
};

/// Whether a file's name is that of a planar model's tiles, joints or hull.
bool isPlanarName(const std::filesystem::path& file);

/// Whether a file's name is that of a planar model's joints.
bool isJointList(const std::filesystem::path& file);

/// The file of vertices of the model that a file is part of, by its name. Throws InputError where
/// there is none.
std::filesystem::path planarVertices(const std::filesystem::path& file);

/// Chooses the files of the model that `named` is part of. `jointsFile`, a path or the name of a
/// file beside, says which list of joints; where it is empty, `named` itself does when it is a list
/// or a hull, else NAME_constraints.txt, else the only one. Throws InputError where there is none,
/// or several to choose from.
PlanarPlace planarPlace(const std::filesystem::path& named,
                        const std::filesystem::path& jointsFile);

/// Lists of joints beside a file of vertices, by name.
std::vector<std::filesystem::path> jointLists(const std::filesystem::path& vertices);

/// "a.txt, b.txt".
std::string fileNames(const std::vector<std::filesystem::path>& files);

// ------------------------------------------------------------------------------------------------
// The planar files of the quasicrystal kirigami simulator (Liu, Choi and Mahadevan 2022).

/// Whether a file of vertices holds "x y" pairs rather than "x y z": an even count of numbers on
/// every line that is not always a multiple of 3 above 6, and no joint beside it that names its
/// face.
bool holdsPlanarModel(const std::filesystem::path& vertices);

/// Reads a planar model, of which `named` is any file (see readPlanarModel). The vertices' file
/// holds one tile a line, "x y" for each vertex, in either sense; a list of joints "tile vertex
/// tile vertex" a line, counted from 1; a hull "tile vertex" a line, counted from 0. Vertices that
/// coincide as far as the file's digits can tell become joints on both faces, others keep their
/// distance as links.
///
/// Throws InputError with file and line for numbers that are wrong and tiles that make no bricks.
Model readPlanarFiles(const std::filesystem::path& named, const ReadSettings& settings,
                      std::vector<std::string>& warnings);

/// Writes a planar model as such files: `vertices` and, beside it, its joints and its hull, if it
/// has one. Throws InputError for a start that is not flat, and for fixed joints; OutputError when
/// writing fails.
void writePlanarFiles(const Model& model, const std::filesystem::path& vertices);

// ------------------------------------------------------------------------------------------------
// Cut patterns: what a cutter follows, as a model.

/// Reads a sheet from a drawing (SVG, DXF) of its outline and cuts, at true size in metres, in the
/// plane z = 0: tiles, and joints on both faces at the necks of material between them. There is no
/// target. Patterns that `export --format svg,dxf` left, with layers named cuts, slits and hinges,
/// come back as they were; of others, one line of what was found is appended to the warnings.
///
/// Slits are open lines that stop short of a line: the extension is a neck, its end the joint.
/// Slots are closed outlines of removed material, whose centre lines are read as slits.
///
/// Throws InputError with the place in the drawing's own coordinates for open outlines, pieces that
/// hang by nothing, strips between parallel cuts, and tiles that make no bricks.
Model readCutPattern(const std::filesystem::path& file, const ReadSettings& settings,
                     std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// FOLD files (github.com/edemaine/fold, versions 1.0 to 1.2): JSON, a sheet in one frame or
// several.

/// Reads a sheet: the first frame with coordinates and with faces or edges is the start, further
/// states of the same sheet are waypoints and the target. Faces are tiles, without their slits, and
/// one tile if J edges join them; without a list of faces they are found from the edges. Vertices
/// that faces share are joints, so that faces with a common edge are hinged, unless the edge is a
/// cut. A flat sheet in one state goes where its angles or letters fold it, and springs at folds
/// rest at these angles. Keys of Kirireel's own, which writeFold leaves, say more.
///
/// Throws InputError for text that is no JSON, wrong numbers, tiles that make no bricks, frames and
/// folds that are not in the file, and two edges of the same two faces that fold by different
/// angles. Coordinates are in the file's unit; `declaredUnit` is its frame_unit. Appends to
/// warnings what is not read, what letters decide, and what a run can live with: tiles of a target
/// that are not congruent, angles that do not close.
Model readFold(const std::filesystem::path& file, const ReadSettings& settings,
               std::vector<std::string>& warnings);

/// The tiles at one time of a run.
struct FoldState {
  std::string title;        ///< of its frame
  std::vector<Tile> tiles;  ///< in the order of the model's file
};

/// The text of a FOLD 1.2 file: the model with its edges, letters and angles, so that origami
/// programs fold it and reading gives it back to the last bit. Vertices, edges, letters and angles
/// of the model's own FOLD file stay as they are. `samples`: states of a run, the first being the
/// model's start, as frames in place of the targets, which have a key of our own then.
std::string foldText(const Model& model, const std::vector<FoldState>& samples = {});

/// Writes this text. An existing file is replaced. Throws OutputError.
void writeFold(const Model& model, const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------------
// What FOLD says of edges: which faces they hinge, fix or cut apart, and by how much they fold.
//
// Assignments (FOLD 1.2): B boundary, M mountain, V valley, F flat, U unassigned: hinges where two
// faces share the edge; C cut: no hinge, and at its inner ends the two sides part; J join: the two
// faces are one rigid piece. Fold angles are signed dihedral angles in degrees, 0 flat, positive
// where the two faces turn towards their upper side (valley).

/// The joints of faces that share vertices, as jointsOfSharedNumbers gives them, but for creases
/// that cut or fix. `tiles` has the faces at the start.
/// Edges that `creases` does not list count as unassigned, that is as hinges. Fixed joints come
/// last.
std::vector<Joint> jointsOfCreases(const CornerNumbers& faces, const std::vector<Crease>& creases,
                                   const std::vector<Tile>& tiles);

/// The normal of the plane in which all tiles lie, on the side from which most of their area runs
/// anticlockwise: the upper side of a crease pattern. None if they lie in no plane.
std::optional<Vector3> sheetNormal(const Model& model);

/// The tiles of a crease pattern with this normal, folded along all hinges with an angle: face 0 of
/// each connected piece stays. None where no angle differs from 0.
/// Angles that contradict each other round a loop are not noticed here.
std::optional<std::vector<Tile>> foldedTiles(const CornerNumbers& faces,
                                             const std::vector<Crease>& creases,
                                             const std::vector<Tile>& tiles, const Vector3& normal);

/// The angles of the folds between two faces, as Model::foldAngles has them: of all edges that two
/// faces share and a crease gives an angle, but for cuts and joins. `model` has the faces as tiles.
/// `normal`: of a crease pattern, whose angles count seen from there as in foldedTiles(). None:
/// they count seen from the face with the lower number as in creasesOf(). Throws InputError, which
/// names the file, where two edges of the same faces have different angles.
std::map<std::pair<int, int>, double> foldAnglesOf(const CornerNumbers& faces,
                                                   const std::vector<Crease>& creases,
                                                   const Model& model,
                                                   const std::optional<Vector3>& normal,
                                                   const std::filesystem::path& file);

/// The edges of all faces, each once: boundary where one face has it, else mountain, valley or flat
/// with the angle by which `state`, the folded faces, turns about it.
/// Edges come in the order of their vertex numbers. Where more than two faces share one, the angle
/// is that between the first two.
std::vector<Crease> creasesOf(const CornerNumbers& faces, const std::vector<Tile>& state);

/// Those that the model's file is written with: a crease pattern with this normal folds to its
/// target, others are as they stand, and Model::foldAngles come before both. `faces` number the
/// corners in the order of the model's own file.
std::vector<Crease> creasesOf(const CornerNumbers& faces, const Model& model,
                              const std::optional<Vector3>& normal);

}  // namespace kirireel::model
