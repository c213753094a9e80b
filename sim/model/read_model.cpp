#include "sim/model/read_model.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/model/fold_file.h"
#include "sim/model/folder.h"
#include "sim/model/obj_pair.h"
#include "sim/model/planar_files.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

const std::string kFormats = "a folder with vertices.txt, a .fold or .obj file";

std::string endingOf(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char letter) { return std::tolower(letter); });
  return ending;
}

Model readFile(const fs::path& path, const std::optional<fs::path>& target,
               std::vector<std::string>& warnings) {
  const std::string ending = endingOf(path);
  if (ending == ".fold") return readFold(path, warnings);
  if (ending == ".obj") {
    return readObjPair(path, target ? std::nullopt : deployedSibling(path), warnings);
  }
  if (path.filename().string().ends_with("vertices.txt")) return readPlanarFiles(path, warnings);
  throw inputErrorAt({path}, fmt::format("'{}' is no model's ending; give {}", ending, kFormats));
}

bool isPlanarFolder(const fs::path& folder) {
  const fs::path vertices = folder / "vertices.txt";
  return fs::is_regular_file(vertices) && holdsPlanarModel(vertices);
}

void requireSameTiles(const Model& model, const Model& other, const fs::path& path) {
  const auto same = [](const Tile& a, const Tile& b) {
    return a.vertices.size() == b.vertices.size();
  };
  if (std::equal(model.tiles.begin(), model.tiles.end(), other.tiles.begin(), other.tiles.end(),
                 same)) {
    return;
  }
  throw inputErrorAt({path}, fmt::format("the target has {} tiles of other vertex counts than the "
                                         "model's {}; give the same tiles in the same order",
                                         other.tiles.size(), model.tiles.size()));
}

}  // namespace

Model readModel(const fs::path& path, const std::optional<fs::path>& target,
                std::vector<std::string>& warnings) {
  const bool isFile = fs::is_regular_file(path);
  Model model = isFile                 ? readFile(path, target, warnings)
                : isPlanarFolder(path) ? readPlanarFiles(path / "vertices.txt", warnings)
                                       : readModelFolder(path, warnings);
  if (!target) return model;
  std::vector<std::string> ignored;
  const Model other = readModel(*target, std::nullopt, ignored);
  requireSameTiles(model, other, *target);
  model.target = other.tiles;
  return model;
}

std::vector<Tile> readTarget(const fs::path& path, const Model& model,
                             std::vector<std::string>& warnings) {
  if (endingOf(path) == ".txt") return readTargetFile(path, model, warnings);
  std::vector<std::string> ignored;
  Model other = readModel(path, std::nullopt, ignored);
  requireSameTiles(model, other, path);
  return std::move(other.tiles);
}

void writeModel(const Model& model, const fs::path& path) {
  const std::string ending = endingOf(path);
  if (ending == ".fold") return writeFold(model, path);
  if (ending == ".obj") return writeObjPair(model, path);
  if (ending.empty()) return writeModelFolder(model, path);
  throw inputErrorAt({path}, fmt::format("there is no format '{}'; give an ending .fold or .obj, "
                                         "or none for a folder",
                                         ending));
}

}  // namespace kirireel
