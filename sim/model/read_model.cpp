// The choice of a reader by what stands at a path, and the end that all readers share.
//
// A name's ending decides, in any case of its letters. Two things need a look into files: whether a
// vertices.txt holds points in the plane or in space, which both use the same names, and whether a
// path is a folder of one or the other. After reading, the last digit of the coordinates is found
// for later tolerances, strict reading refuses repairs, and the target of another model replaces
// the model's own.
#include "sim/model/read_model.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/model/cut_pattern_file.h"
#include "sim/model/fold_file.h"
#include "sim/model/folder.h"
#include "sim/model/obj_pair.h"
#include "sim/model/planar_files.h"
#include "sim/model/planar_siblings.h"
#include "sim/model/ply_file.h"
#include "sim/model/rounding.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

const std::string kFormats =
    "a folder with vertices.txt, a planar NAME_vertices.txt, a .fold, .obj or .ply file, or a cut "
    "pattern (.svg, .dxf)";

std::string endingOf(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char letter) { return std::tolower(letter); });
  return ending;
}

/// Another list of joints can only stand for one that is a file of its own.
void requireNoJointsFile(const fs::path& path, const ReadSettings& settings) {
  if (settings.jointsFile.empty()) return;
  throw inputErrorAt({path},
                     "this file has its joints within; leave --joints-file out, or convert "
                     "the model to a folder");
}

// A file by its ending.
Model readFile(const fs::path& path, const std::optional<fs::path>& target,
               const ReadSettings& settings, std::vector<std::string>& warnings) {
  const std::string ending = endingOf(path);
  if (ending == ".txt" && isPlanarName(path)) {
    const fs::path vertices = planarVertices(path);
    // The files of a folder in space have such names too.
    const bool isFolder = vertices.filename() == "vertices.txt" && !holdsPlanarModel(vertices);
    if (!isFolder) return readPlanarFiles(path, settings, warnings);
    const fs::path folder = vertices.has_parent_path() ? vertices.parent_path() : ".";
    ReadSettings own = settings;
    // A list that was named itself is the one to take: its own folder gives all else.
    const bool isList =
        path.filename() != "vertices.txt" && !path.stem().string().starts_with("hull");
    if (own.jointsFile.empty() && isList) own.jointsFile = path;
    return readModelFolder(folder, own, warnings);
  }
  requireNoJointsFile(path, settings);
  if (ending == ".fold") return readFold(path, warnings);
  if (ending == ".ply") return readPly(path, warnings);
  if (ending == ".svg" || ending == ".dxf") return readCutPattern(path, warnings);
  if (ending == ".obj") {
    // A target that was asked for makes the sibling superfluous, and what is wrong with it
    // harmless.
    return readObjPair(path, target ? std::nullopt : deployedSibling(path), warnings);
  }
  throw inputErrorAt({path}, fmt::format("'{}' is no model's ending; give {}", ending, kFormats));
}

bool isPlanarFolder(const fs::path& folder) {
  const fs::path vertices = folder / "vertices.txt";
  return fs::is_regular_file(vertices) && holdsPlanarModel(vertices);
}

// As many tiles, each with as many vertices, in the same order.
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

/// The start of another model in any format, vertex by vertex as the model has them.
std::vector<Tile> startOf(const fs::path& path, const Model& model) {
  // The warnings about another model's start are not about this model.
  std::vector<std::string> ignored;
  const Model other = readModel(path, std::nullopt, ignored);
  requireSameTiles(model, other, path);
  // Back to the order of the other model's file, which both models share, then to this model's
  // order.
  return inFileOrder(inFileOrder(other.tiles, other.fileOrder), model.fileOrder);
}

}  // namespace

Model readModel(const fs::path& path, const std::optional<fs::path>& target,
                std::vector<std::string>& warnings, const ReadSettings& settings) {
  const bool isFile = fs::is_regular_file(path);
  Model model = isFile                 ? readFile(path, target, settings, warnings)
                : isPlanarFolder(path) ? readPlanarFiles(path / "vertices.txt", settings, warnings)
                                       : readModelFolder(path, settings, warnings);
  model.rounding = roundingOf(model.tiles);
  if (settings.strict) {
    refuseMends(model);
    if (!model.hullFault.empty()) throw InputError(model.hullFault);
  }
  if (target) model.target = startOf(*target, model);
  return model;
}

std::vector<Tile> readTarget(const fs::path& path, const Model& model,
                             std::vector<std::string>& warnings) {
  if (endingOf(path) == ".txt") return readTargetFile(path, model, warnings);
  return startOf(path, model);
}

void writeModel(const Model& model, const fs::path& path) {
  const std::string ending = endingOf(path);
  if (ending == ".fold") return writeFold(model, path);
  if (ending == ".obj") return writeObjPair(model, path);
  if (ending.empty()) return writeModelFolder(model, path);
  if (path.filename().string().ends_with("vertices.txt")) return writePlanarFiles(model, path);
  throw inputErrorAt({path}, fmt::format("there is no format '{}'; give an ending .fold or .obj, "
                                         "a name that ends with vertices.txt for planar files, or "
                                         "no ending for a folder",
                                         ending));
}

}  // namespace kirireel
