#include "render/cli/record_command.h"

#include <CLI/CLI.hpp>

#include "render/cli/exit_codes.h"
#include "render/cli/export_command.h"
#include "render/cli/interrupt.h"
#include "render/cli/option_group.h"
#include "render/cli/picture_options.h"
#include "render/cli/report.h"
#include "render/cli/run_options.h"
#include "render/cli/video_options.h"
#include "render/record/summary.h"
#include "sim/model/alignment.h"
#include "sim/model/folder.h"

namespace kirireel {
namespace {

void addFolderOptions(CLI::App& command, RecordOrder& order) {
  OptionGroup group(command, "Output");
  group.value("--out", "FOLDER", "out/NAME of the model", "where the files go",
              [&order](const OptionValue& typed) { order.settings.folder = typed.text; });
  group.flag("--json", "print the summary as JSON", [&order] { order.printJson = true; });
}

void addFaceOptions(CLI::App& command, RecordOrder& order) {
  OptionGroup group(command, "Joints");
  group.choice<std::optional<FaceRule>>(
      "--faces", order.faces,
      {{"model", std::nullopt}, {"fold", FaceRule::Fold}, {"pykirigami", FaceRule::PyKirigami}},
      "face of each joint, the model's or by the target's folds");
  group.flag("--auto-detect-connections", "the same as --faces pykirigami",
             [&order] { order.faces = FaceRule::PyKirigami; });
}

void addRunOptions(CLI::App& command, RecordOrder& order) {
  addPlace(command, "MODEL", order.model,
           "folder with vertices.txt, constraints.txt and optionally target.txt, pull.txt");
  addFolderOptions(command, order);
  OptionGroup(command, "Output")
      .integer("--fps", order.settings.framesPerSecond, {1, 240}, "COUNT",
               "frames, and samples, a simulated second");
  addFaceOptions(command, order);
  addSceneOptions(command, order.scene);
  addExportOptions(command, "--export", order.settings.exports);
}

constexpr const char* kPeerNote =
    "Lengths are metres, times simulated seconds, masses kilograms. PyKirigami's spellings work\n"
    "too: --model, --brick_thickness, --spring_stiffness, --force_damping, --ground_plane,\n"
    "--no_collision (the same as --contacts unjoined), -ss, -fd, -bt, -gp, -gf. --headless is\n"
    "accepted and does nothing: no window is ever opened.";

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
  return outcome == Outcome::Settled || outcome == Outcome::OutOfTime ? kExitDone : kExitRunFailed;
}

}  // namespace

CLI::App* addRecordCommand(CLI::App& program, RecordOrder& order) {
  CLI::App* command =
      program.add_subcommand("record", "deploy a model; leave video, pictures, meshes, summary");
  addRunOptions(*command, order);
  addPictureOptions(*command, order.settings);
  addVideoOptions(*command, order.settings);
  OptionGroup(*command, "Output").flag("--no-meshes", "no OBJ and PLY files", [&order] {
    order.settings.meshes = false;
  });
  command->footer(
      fmt::format("Examples:\n"
                  "  kirireel record data/tessellation_4x4\n"
                  "  kirireel record data/tessellation_4x4 --out out/figure --grid 2x3 --view top "
                  "--size 800x600\n"
                  "  kirireel record MODEL --ground --gravity -9.81 --spring-stiffness 25\n\n{}",
                  kPeerNote));
  return command;
}

CLI::App* addSimulateCommand(CLI::App& program, RecordOrder& order) {
  CLI::App* command =
      program.add_subcommand("simulate", "deploy a model; leave the end state and the summary");
  addRunOptions(*command, order);
  RecordSettings& settings = order.settings;
  settings.video = settings.snapshots = settings.meshes = false;
  command->footer(fmt::format(
      "Example:\n  kirireel simulate data/tessellation_4x4 --solver bullet --json\n\n{}",
      kPeerNote));
  return command;
}

int carryOut(const RecordOrder& order) {
  noteSignals();
  Scene scene = order.scene;
  scene.model = readModel(findModel(order.model));
  if (order.faces) chooseJointFaces(scene.model, *order.faces);
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

}  // namespace kirireel
