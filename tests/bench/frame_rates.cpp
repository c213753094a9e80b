// Checks that only samples depend on the sample rate: every model of a folder, deployed at eight
// rates, contacts auto, none and all. Prints a row for each model. Exit code 1 if a run differs
// from the one at 60 samples per second.
//
//     build/release/tests/bench/frame_rates [MODELS] [--dynamic] [--search-effort FACTOR]

#include <algorithm>
#include <filesystem>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/state_tape.h"
#include "sim/deploy/deployment.h"
#include "sim/formats/read_model.h"
#include "sim/model/isometry.h"

namespace kirireel {
namespace {

constexpr double kRates[] = {1, 7, 24, 25, 30, 50, 240};

/// All values that must be the same, as numbers.
std::vector<double> figuresOf(const scene::Scene& scene, double rate,
                              run::DeploymentResult& result) {
  result = deploy::deploy(scene, 1 / rate, nullptr);
  StateTape tape;
  tape.transfer(result.outcome, result.reason, result.accuracy, result.assembledError, result.cost,
                result.path.kind, result.path.openTime, result.path.guideTime,
                result.path.jointRatio, result.trajectory.events, result.trajectory.figureStates,
                result.trajectory.samples.back().poses);
  return tape.numbers();
}

/// Returns whether all runs agree.
bool compareRates(const std::string& name, const scene::Scene& scene, const char* contacts) {
  run::DeploymentResult reference;
  const std::vector<double> figures = figuresOf(scene, 60, reference);
  std::string differing;
  for (const double rate : kRates) {
    run::DeploymentResult result;
    if (figuresOf(scene, rate, result) != figures) differing += fmt::format(" {:g}", rate);
  }
  fmt::print("{:<32} {:<5} {:<12} {:>6} steps  {}\n", name, contacts,
             run::toString(reference.outcome), reference.cost.took.steps,
             differing.empty() ? "same" : "differs at" + differing);
  std::fflush(stdout);
  return differing.empty();
}

std::vector<std::filesystem::path> modelsIn(const std::filesystem::path& folder) {
  if (std::filesystem::exists(folder / "vertices.txt")) return {folder};
  std::vector<std::filesystem::path> models;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (std::filesystem::exists(entry.path() / "vertices.txt")) models.push_back(entry.path());
  }
  std::ranges::sort(models);
  return models;
}

int compareModels(const std::filesystem::path& folder, scene::Scene scene) {
  bool same = true;
  const std::pair<const char*, scene::ContactFilter> filters[] = {
      {"auto", scene::ContactFilter::Auto},
      {"none", scene::ContactFilter::None},
      {"all", scene::ContactFilter::All}};
  for (const std::filesystem::path& path : modelsIn(folder)) {
    std::vector<std::string> warnings;
    scene.model = formats::readModel(path, std::nullopt, warnings);
    model::alignStartToTarget(scene.model);
    for (const auto& [name, filter] : filters) {
      scene.environment.contacts = filter;
      same = compareRates(path.filename().string(), scene, name) && same;
    }
  }
  return same ? 0 : 1;
}

}  // namespace
}  // namespace kirireel

int main(int count, char** arguments) {
  CLI::App program{"Runs every model of a folder at eight sample rates and compares the runs"};
  std::string folder = KIRIREEL_SOURCE_DIR "/data";
  kirireel::scene::Scene scene = kirireel::scene::openScene();
  bool isDynamic = false;
  program.add_option("models", folder, "a model, or a folder of models");
  program.add_option("--search-effort", scene.path.searchEffort, "work relative to the default");
  program.add_flag("--dynamic", isDynamic, "springs that move masses, instead of the default path");
  CLI11_PARSE(program, count, arguments);
  if (isDynamic) scene.path.kind = kirireel::scene::PathKind::Dynamic;
  try {
    return kirireel::compareModels(folder, scene);
  } catch (const kirireel::Error& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
