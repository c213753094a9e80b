// Default deployments: every model of the given folders as `kirireel record` would deploy it, one a
// row. Prints where it ended, against the least error found, the path's length over its guide's,
// how deep bricks overlapped beyond the start, the largest joint gap, and CPU seconds.
//
//     build/release/tests/bench/deployments [FOLDER ...] [--search SECONDS] [--contacts auto]

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/deploy/deployment.h"
#include "sim/model/alignment.h"
#include "sim/model/read_model.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, ContactFilter> kFilters = {{"auto", ContactFilter::Auto},
                                                       {"none", ContactFilter::None},
                                                       {"unjoined", ContactFilter::Unjoined},
                                                       {"all", ContactFilter::All}};

std::vector<fs::path> modelsIn(const fs::path& folder) {
  if (fs::exists(folder / "vertices.txt") || fs::is_regular_file(folder)) return {folder};
  std::vector<fs::path> models;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (fs::exists(entry.path() / "vertices.txt")) models.push_back(entry.path());
  }
  std::ranges::sort(models);
  return models;
}

void printRow(const fs::path& path, Scene scene) {
  std::vector<std::string> warnings;
  scene.model = readModel(path, std::nullopt, warnings);
  alignStartToTarget(scene.model);
  fillFromModel(scene);
  const DeploymentResult result = deploy(scene, 1.0 / 30, nullptr);
  const double tile = tileSize(scene.model);
  const bool isWalked = result.path.kind == PathKind::Continuation;
  fmt::print(
      "{:<30} {:>4} {:<11} {:<12} error {:8.1e} least {:8.1e} overlap {:8.1e} gap {:8.1e} "
      "contacts {} {:6.2f} + {:6.2f} s  {}\n",
      path.filename().string(), scene.model.tiles.size(), toString(result.outcome),
      isWalked ? "continuation" : "dynamic", result.accuracy.targetErrorEnd / tile,
      result.assembledError / tile, result.accuracy.penetrationGrownMax / tile,
      result.accuracy.jointGapMax / tile, result.needs.contacts.on ? "on " : "off",
      result.cost.cpuSecondsSearch, result.cost.cpuSeconds,
      isWalked ? result.needs.contacts.reason : result.pathReason);
  std::fflush(stdout);
}

int deployAll(const std::vector<std::string>& folders, const Scene& scene) {
  for (const std::string& folder : folders) {
    for (const fs::path& path : modelsIn(folder)) {
      try {
        printRow(path, scene);
      } catch (const std::exception& error) {
        fmt::print("{:<30} {}\n", path.filename().string(), error.what());
      }
    }
  }
  return 0;
}

}  // namespace
}  // namespace kirireel

int main(int count, char** arguments) {
  CLI::App program{"Deploys models as a default run does"};
  std::vector<std::string> folders = {std::string(KIRIREEL_SOURCE_DIR) + "/data"};
  kirireel::Scene scene = kirireel::openScene();
  std::string contacts = "auto";
  program.add_option("folders", folders, "models, or folders of models");
  program.add_option("--search", scene.path.searchTime, "seconds of a reference core");
  program.add_option("--thickness", scene.brick.thickness, "metres; else from the model");
  program.add_option("--contacts", contacts, "auto, none, unjoined or all");
  CLI11_PARSE(program, count, arguments);
  scene.environment.contacts = kirireel::kFilters.at(contacts);
  return kirireel::deployAll(folders, scene);
}
