/// The files of a planar model, which lie beside each other and are known by their names.
///
/// NAME_vertices.txt holds the tiles. Of the text files beside it whose name begins with NAME,
/// those with the word "constraints" are lists of joints (NAME_constraints.txt, NAME_expansion_
/// constraints.txt, NAME_constraints2.txt), those with "hull" the corners of the outline for the
/// list whose name has "constraints" in place of "hull". Where NAME of one model begins NAME of
/// another, a file belongs to the longer one.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kirireel {

/// The files that were chosen.
struct PlanarPlace {
  std::filesystem::path vertices;
  std::filesystem::path joints;
  std::optional<std::filesystem::path> hull;
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

}  // namespace kirireel
