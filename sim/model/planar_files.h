/// Planar sheets in files: vertices and joints in files of numbers, and cut patterns.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/model/model.h"
#include "sim/model/model_checks.h"

namespace kirireel {

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

/// Reads a planar model, of which `named` is any file (see planar_files.h). The vertices' file
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
// Cut patterns as models again: the SVG and DXF files that `export --format svg,dxf` leaves.

/// Reads the sheet that a cut pattern was drawn from: tiles, vertices and hinges, at true size in
/// metres, in the plane z = 0 (an SVG knows no origin: its sheet begins near (0, 0)). Layers or
/// groups are named cuts, slits and hinges, see render/export/flat_sheet.h. Tiles come in the order
/// of their first line; joints are on both faces. There is no target.
///
/// Throws InputError for files that hold no such lines, lines that end nowhere, and tiles that make
/// no bricks.
Model readCutPattern(const std::filesystem::path& file, std::vector<std::string>& warnings);

}  // namespace kirireel
