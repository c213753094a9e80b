#include "render/cli/order_fingerprint.h"


#include <iterator>
#include <variant>

#include <fmt/format.h>

#include "render/digest/digest.h"
#include "render/record/versions.h"
#include "sim/base/input_file.h"

namespace kirireel {
namespace {

/// Changes nothing but where a run goes and what is printed.
bool isAside(const std::string& argument) {
  return argument == "--resume" || argument == "--json" || argument.starts_with("--out=");
}

std::string textOf(const std::vector<std::string>& arguments) {
  std::string text;
  for (std::size_t k = 0; k < arguments.size(); ++k) {
    if (arguments[k] == "--out") {
      ++k;
    } else if (!isAside(arguments[k])) {
      text += fmt::format("{}:{}\n", arguments[k].size(), arguments[k]);
    }
  }
  return text;
}

std::string textOf(const std::vector<Tile>& tiles) {
  std::string text = fmt::format("{} tiles\n", tiles.size());
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      text += fmt::format("{} {} {} ", vertex.x(), vertex.y(), vertex.z());
    }
    text += '\n';
  }
  return text;
}

std::string textOf(const Model& model) {
  std::string text = textOf(model.tiles);
  if (model.target) text += textOf(*model.target);
  for (const Joint& joint : model.joints) {
    text += fmt::format("{} {} {} {} {} {}\n", joint.a.tile, joint.a.vertex, joint.b.tile,
                        joint.b.vertex, static_cast<int>(joint.face), static_cast<int>(joint.kind));
  }
  for (const int tile : model.pulledTiles.value_or(std::vector<int>{})) {
    text += fmt::format("pulled {}\n", tile);
  }
  return text;
}

/// Targets that the timeline heads for.
std::string textOf(const Timeline& timeline) {
  std::string text;
  for (const TimelineEntry& entry : timeline) {
    if (const auto* target = std::get_if<timeline::GoTo>(&entry.action)) {
      text += textOf(target->tiles);
    }
  }
  return text;
}

}  // namespace

std::string orderFingerprint(const std::vector<std::string>& arguments,
                             const std::filesystem::path& sceneFile, const Scene& scene) {
  std::ifstream file = openInputFile(sceneFile);
  const std::string sceneText{std::istreambuf_iterator<char>(file), {}};
  return sha256(fmt::format("{}\n{}\n{}\n{}\n{}", versionText(), textOf(arguments), sceneText,
                            textOf(scene.model), textOf(scene.timeline)));
}

}  // namespace kirireel
