/// Prints accuracy, speed and stability of the joint solver, and of Bullet in the same run.
#include <algorithm>
#include <cstdio>

#include <CLI/CLI.hpp>

#include "sim/base/error.h"
#include "tests/bench/joint_tables.h"

namespace {

using namespace kirireel;
using namespace kirireel::bench;

std::vector<NamedScene> scenesIn(const std::string& models) {
  std::vector<NamedScene> scenes = modelScenes(KIRIREEL_SOURCE_DIR "/data");
  if (models.empty()) return scenes;
  for (NamedScene& scene : modelScenes(models)) scenes.push_back(std::move(scene));
  return scenes;
}

/// One sheet in space, and the published models in this folder.
std::vector<NamedScene> stabilityScenes(const std::vector<NamedScene>& models) {
  std::vector<NamedScene> scenes{
      {"sheet 4 x 4", sheetScene(4, true, scene::SolverKind::Direct)},
      {"sheet 4 x 4 in space", sheetScene(4, false, scene::SolverKind::Direct)}};
  for (const NamedScene& model : models) {
    if (model.name == "square2disk" || model.name == "partialSphere") scenes.push_back(model);
  }
  return scenes;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Tables of the joint solver's accuracy, speed and stability. CPU times are of one "
      "thread; ratios are taken within one run.");
  std::string folder;
  std::vector<std::string> only;
  const std::vector<std::string> names{"gap",     "tessellation", "speed",
                                       "step",    "path",         "large",
                                       "contact", "stability",    "stability-with-contacts",
                                       "shares"};
  app.add_option("models", folder, "a folder of model folders, in addition to data/")
      ->check(CLI::ExistingDirectory);
  app.add_option("--only", only, "tables to print; all by default")->check(CLI::IsMember(names));
  CLI11_PARSE(app, argc, argv);
  const auto isRequested = [&](const char* name) {
    return only.empty() || std::find(only.begin(), only.end(), name) != only.end();
  };
  try {
    const std::vector<NamedScene> models = scenesIn(folder);
    if (isRequested("gap")) printGapTable(models);
    if (isRequested("tessellation")) printTessellationTable();
    if (isRequested("speed")) printSpeedTable();
    if (isRequested("step")) printLargestStepTable();
    if (isRequested("path")) printPathTable(models);
    if (isRequested("large")) printLargeSheetTable();
    if (isRequested("contact")) printContactTable(models);
    if (isRequested("stability")) printStabilityTable(stabilityScenes(models), false);
    if (isRequested("stability-with-contacts")) printStabilityTable(stabilityScenes(models), true);
    if (isRequested("shares")) printShareTable();
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
