/// Prints how exact, fast and stable the joint solver is, beside Bullet in the same run.
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

/// One sheet that may move in space, and the published models that are here.
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
  app.add_option("models", folder, "a folder of model folders, beside data/")
      ->check(CLI::ExistingDirectory);
  app.add_option("--only", only, "tables to print; all by default")->check(CLI::IsMember(names));
  CLI11_PARSE(app, argc, argv);
  const auto wanted = [&](const char* name) {
    return only.empty() || std::find(only.begin(), only.end(), name) != only.end();
  };
  try {
    const std::vector<NamedScene> models = scenesIn(folder);
    if (wanted("gap")) printGapTable(models);
    if (wanted("tessellation")) printTessellationTable();
    if (wanted("speed")) printSpeedTable();
    if (wanted("step")) printLargestStepTable();
    if (wanted("path")) printPathTable(models);
    if (wanted("large")) printLargeSheetTable();
    if (wanted("contact")) printContactTable(models);
    if (wanted("stability")) printStabilityTable(stabilityScenes(models), false);
    if (wanted("stability-with-contacts")) printStabilityTable(stabilityScenes(models), true);
    if (wanted("shares")) printShareTable();
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
