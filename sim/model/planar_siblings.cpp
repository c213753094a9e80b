// Which files beside each other make one planar model.
//
// Programs leave many files in one folder, told apart by their names alone. The part of a name
// before "vertices" is the prefix of a model; every other file belongs to the model with the
// longest prefix that begins its name. Of several lists of joints the one is chosen that the user
// named, directly or by the hull that goes with it; else the one that is called as the vertices
// are; else the only one. Nothing is guessed beyond that: several lists without a usual name are
// refused with their names.
#include "sim/model/planar_siblings.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVertices = "vertices";
constexpr const char* kConstraints = "constraints";
constexpr const char* kHull = "hull";

bool hasWord(const fs::path& file, const std::string& word) {
  return file.extension() == ".txt" && file.stem().string().find(word) != std::string::npos;
}

/// NAME_hull_tiles.txt lists tiles, not corners.
bool isHull(const fs::path& file) {
  return hasWord(file, kHull) && !hasWord(file, "tiles");
}

/// The part of a name before one of the three words: "penrose_" of penrose_vertices.txt.
std::string prefixOf(const fs::path& vertices) {
  const std::string stem = vertices.stem().string();
  return stem.substr(0, stem.rfind(kVertices));
}

// All text files in the folder of this one, by name.
std::vector<fs::path> textFilesBeside(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::vector<fs::path> files;
  // A folder that cannot be listed counts as empty: opening the named file gives a better message.
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() != ".txt" || !entry.is_regular_file(ignored)) continue;
    files.push_back(file.parent_path() / entry.path().filename());
  }
  // The system lists files in any order.
  std::sort(files.begin(), files.end());
  return files;
}

/// Of the files of vertices the one whose prefix begins the name, the longest of them.
std::optional<fs::path> ownerOf(const fs::path& file, const std::vector<fs::path>& beside) {
  std::optional<fs::path> owner;
  for (const fs::path& vertices : beside) {
    if (!hasWord(vertices, kVertices)) continue;
    if (!file.filename().string().starts_with(prefixOf(vertices))) continue;
    if (!owner || prefixOf(vertices).size() > prefixOf(*owner).size()) owner = vertices;
  }
  return owner;
}

template <typename Test>
std::vector<fs::path> partsOfModel(const fs::path& vertices, const Test& isPart) {
  const std::vector<fs::path> beside = textFilesBeside(vertices);
  std::vector<fs::path> parts;
  for (const fs::path& file : beside) {
    if (isPart(file) && !hasWord(file, kVertices) && ownerOf(file, beside) == vertices) {
      parts.push_back(file);
    }
  }
  return parts;
}

/// The same name with another word in place of one of the three.
fs::path withWord(const fs::path& file, const std::string& word, const std::string& other) {
  std::string name = file.filename().string();
  const std::size_t at = name.rfind(word);
  if (at != name.npos) name.replace(at, word.size(), other);
  return file.parent_path() / name;
}

bool contains(const std::vector<fs::path>& files, const fs::path& file) {
  return std::find(files.begin(), files.end(), file) != files.end();
}

/// The list that the user named: a path, or the name of one beside the vertices.
fs::path namedList(const fs::path& jointsFile, const fs::path& vertices) {
  const fs::path beside = vertices.parent_path() / jointsFile;
  return fs::exists(jointsFile) || !fs::exists(beside) ? jointsFile : beside;
}

// What the user named, else what goes with it, else the usual name, else the only one.
fs::path chosenList(const fs::path& named, const fs::path& vertices,
                    const std::vector<fs::path>& lists) {
  if (hasWord(named, kConstraints) && !hasWord(named, kVertices)) return named;
  if (isHull(named)) {
    const fs::path partner = withWord(named, kHull, kConstraints);
    if (contains(lists, partner)) return partner;
  }
  const fs::path usual = withWord(vertices, kVertices, kConstraints);
  if (contains(lists, usual)) return usual;
  if (lists.size() == 1) return lists.front();
  if (lists.empty()) {
    throw inputErrorAt({vertices}, fmt::format("there is no list of joints beside it; write {}, or "
                                               "name one with --joints-file",
                                               usual.filename().string()));
  }
  throw inputErrorAt({vertices}, fmt::format("there are {} lists of joints beside it: {}; choose "
                                             "one with --joints-file",
                                             lists.size(), fileNames(lists)));
}

std::optional<fs::path> chosenHull(const fs::path& named, const fs::path& joints,
                                   const std::vector<fs::path>& hulls) {
  if (isHull(named) && !hasWord(named, kVertices)) return named;
  const fs::path partner = withWord(joints, kConstraints, kHull);
  if (contains(hulls, partner)) return partner;
  if (hulls.size() == 1) return hulls.front();
  return std::nullopt;
}

void remove(std::vector<fs::path>& files, const fs::path& file) {
  std::erase(files, file);
}

}  // namespace

std::string fileNames(const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  for (const fs::path& file : files) names.push_back(file.filename().string());
  return fmt::format("{}", fmt::join(names, ", "));
}

bool isPlanarName(const fs::path& file) {
  return hasWord(file, kVertices) || hasWord(file, kConstraints) || isHull(file);
}

fs::path planarVertices(const fs::path& file) {
  if (hasWord(file, kVertices)) return file;
  const std::optional<fs::path> owner = ownerOf(file, textFilesBeside(file));
  if (owner) return *owner;
  throw inputErrorAt({file},
                     "no file of vertices beside it has a name that begins like this one; "
                     "put NAME_vertices.txt there");
}

std::vector<fs::path> jointLists(const fs::path& vertices) {
  return partsOfModel(vertices, [](const fs::path& file) { return hasWord(file, kConstraints); });
}

PlanarPlace planarPlace(const fs::path& named, const fs::path& jointsFile) {
  PlanarPlace place;
  place.vertices = planarVertices(named);
  place.otherJoints = jointLists(place.vertices);
  place.otherHulls = partsOfModel(place.vertices, isHull);
  place.joints = jointsFile.empty() ? chosenList(named, place.vertices, place.otherJoints)
                                    : namedList(jointsFile, place.vertices);
  place.hull = chosenHull(named, place.joints, place.otherHulls);
  remove(place.otherJoints, place.joints);
  if (place.hull) remove(place.otherHulls, *place.hull);
  return place;
}

}  // namespace kirireel
