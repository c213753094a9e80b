/// kirireel: options, checks, read the model, describe the scene, record it, summary.
#include <exception>
#include <filesystem>

#include <fmt/format.h>

#include "render/cli/command_line.h"
#include "render/cli/interrupt.h"
#include "render/cli/report.h"
#include "render/record/record.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/model/alignment.h"
#include "sim/model/folder.h"
#include "sim/model/tessellation.h"
#include "sim/scene/scene.h"

namespace kirireel {
namespace {

constexpr int kDone = 0;
constexpr int kRunFailed = 1;
constexpr int kInputWrong = 2;

/// A model named as it stands in data/, as PyKirigami's users do, is found there.
std::filesystem::path findModel(const std::filesystem::path& named) {
  const std::filesystem::path inData = "data" / named;
  const bool onlyInData = !std::filesystem::exists(named) && std::filesystem::exists(inData);
  return onlyInData ? inData : named;
}

Model readModel(const std::filesystem::path& folder) {
  std::vector<std::string> warnings;
  Model model = readModelFolder(folder, warnings);
  for (const std::string& warning : warnings) {
    fmt::print(stderr, "kirireel: {}\n", warning);
  }
  alignStartToTarget(model);
  return model;
}

int exitCode(Outcome outcome) {
  return outcome == Outcome::Settled || outcome == Outcome::OutOfTime ? kDone : kRunFailed;
}

int carryOut(const RecordOrder& order) {
  noteSignals();
  Scene scene = order.scene;
  scene.model = readModel(findModel(order.model));
  if (scene.environment.ground) scene.environment.ground->height = lowestPoint(scene);
  RecordSettings settings = order.settings;
  if (settings.folder.empty()) settings.folder = std::filesystem::path("out") / scene.model.name;

  RunSummary summary;
  {
    ProgressLine line;
    summary = record(scene, settings, [&line](const Progress& progress) {
      line.show(progress);
      return !takeInterrupt();
    });
  }
  fmt::print("{}", order.printJson ? summaryJson(scene, settings, summary)
                                   : describeRun(scene, settings, summary));
  return exitCode(summary.outcome);
}

int carryOut(const GenerateOrder& order) {
  const Model model = makeTessellation(order.shape);
  writeModelFolder(model, order.folder);
  fmt::print("{}: {} tiles, {} joints\n", order.folder.string(), model.tiles.size(),
             model.joints.size());
  return kDone;
}

int carryOut(const PrintOrder& order) {
  fmt::print("{}", order.text);
  return kDone;
}

}  // namespace
}  // namespace kirireel

int main(int argumentCount, char** arguments) {
  using namespace kirireel;
  try {
    const Order order = parseCommandLine({arguments + 1, arguments + argumentCount});
    return std::visit([](const auto& wanted) { return carryOut(wanted); }, order);
  } catch (const InputError& error) {
    fmt::print(stderr, "kirireel: {}\n", error.what());
    return kInputWrong;
  } catch (const std::exception& error) {
    fmt::print(stderr, "kirireel: {}\n", error.what());
    return kRunFailed;
  }
}
