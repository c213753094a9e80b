// Reads a model as `record` would, aligns its start to its target, and prints counts, mobility, and
// what does not fit. Nothing runs.
#include "render/cli/inspect_command.h"

#include <CLI/CLI.hpp>

#include "render/cli/exit_codes.h"
#include "render/cli/model_place.h"
#include "render/cli/option_group.h"
#include "render/cli/report.h"
#include "render/inspect/inspection.h"
#include "render/inspect/numbered_picture.h"
#include "render/png/png.h"
#include "sim/model/alignment.h"
#include "sim/model/tile_checks.h"

namespace kirireel {
namespace {

// Pixels of each of the two states.
constexpr FrameSize kStateSize{1200, 1200};

/// The rank of the constraints takes long in large sheets, so the line says what is at work.
Inspection inspectWithProgress(const Scene& scene) {
  ProgressLine line;
  return inspect(scene, [&line](const char* what) { line.show(what); });
}

/// Reads the model; of a tile that cannot be meant a picture is left before the error goes on.
Model readOrDraw(const InspectOrder& order) {
  try {
    return readModelAt(order.model, order.target, order.reading);
  } catch (const CrossedTile& error) {
    if (!order.picture.empty()) {
      writePng(crossingPicture(error.tile(), error.place(), kStateSize), order.picture);
    }
    throw;
  }
}

}  // namespace

CLI::App* addInspectCommand(CLI::App& program, InspectOrder& order) {
  CLI::App* command = program.add_subcommand(
      "inspect", "tell what a model is: tiles, joints, mobility, what fits and what does not");
  addPlace(*command, "MODEL", order.model, kModelHelp);
  OptionGroup group(*command, "Model");
  addTargetOption(group, order.target);
  addReadOptions(group, order.reading);
  // The default has to stand in the scene before the option is added, which shows it in the help.
  order.scene.brick.thickness = openScene().brick.thickness;
  group.setting(sceneSetting("thickness"), order.scene);
  OptionGroup output(*command, "Output");
  output.flag("--json", "print as JSON", [&order] { order.printJson = true; });
  output.value("--picture", "FILE", "",
               "paint both states with numbers into a PNG file, what was mended marked; or a tile "
               "that crosses itself",
               [&order](const TypedValue& typed) { order.picture = typed.text; });
  command->footer("Example:\n  kirireel inspect data/tessellation_4x4 --picture numbers.png");
  return command;
}

void completeOrder(const CLI::App& command, InspectOrder& order) {
  requireGiven(order.model, "MODEL", command);
}

int carryOut(const InspectOrder& order) {
  Scene scene = order.scene;
  scene.model = readOrDraw(order);
  fillFromModel(scene);
  // What a run needs depends on where its start stands.
  alignStartToTarget(scene.model);
  const Inspection inspection = inspectWithProgress(scene);
  fmt::print("{}", order.printJson ? inspectionJson(inspection) : inspectionText(inspection));
  if (!order.picture.empty()) writePng(numberedPicture(scene, kStateSize), order.picture);
  return kExitDone;
}

}  // namespace kirireel
