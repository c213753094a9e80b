// Paints a recorded run again from trajectory.h5. The trajectory holds poses at samples; nothing is
// simulated, so that another camera, size or colour costs the painting alone. Several trajectories
// make one grid with a row each and the same camera and scale.
#include "render/cli/render_command.h"

#include <CLI/CLI.hpp>

#include "render/cli/contradictions.h"
#include "render/cli/exit_codes.h"
#include "render/cli/interrupt.h"
#include "render/cli/option_group.h"
#include "render/cli/picture_options.h"
#include "render/cli/report.h"
#include "render/cli/video_options.h"
#include "render/folder/output_folder.h"
#include "sim/base/error.h"

namespace kirireel {

CLI::App* addRenderCommand(CLI::App& program, RenderOrder& order) {
  CLI::App* command = program.add_subcommand(
      "render", "make pictures and video of a recorded run again, without simulating");
  command
      ->add_option("TRAJECTORY", order.trajectories,
                   "a trajectory.h5 as record and simulate leave it, or the folder it is in; of "
                   "several one grid is made, a row of states each, with one camera and scale")
      ->type_name("")
      ->expected(1, -1);
  OptionGroup output(*command, "Output");
  output.value("--out", "FOLDER", "that of TRAJECTORY", "where the files go",
               [&order](const TypedValue& typed) { order.settings.folder = typed.text; });
  output.integer("--fps", order.settings.framesPerSecond, {1, 240}, "COUNT",
                 "frames in a second of video");
  addPictureOptions(*command, order.settings);
  addVideoOptions(*command, order.settings);
  command->footer(
      "States between two samples are interpolated, with their joints closed.\n\n"
      "Examples:\n"
      "  kirireel render out/tessellation_4x4 --view iso --out out/again\n"
      "  kirireel render out/tessellation_4x4 --format gif --fps 25 --speed 0.5\n"
      "  kirireel render out/cylinder out/cap --grid 1x4 --width 180mm --font-size 7pt --out "
      "figure");
  return command;
}

void completeOrder(const CLI::App& command, RenderOrder& order) {
  requireGiven(order.trajectories.empty() ? "" : order.trajectories.front(), "TRAJECTORY", command);
  // A folder stands for the trajectory.h5 in it.
  for (std::filesystem::path& trajectory : order.trajectories) {
    if (std::filesystem::is_directory(trajectory)) trajectory /= output::kTrajectory;
  }
  requireConsistentPace(command);
  if (order.trajectories.size() > 1 && order.settings.folder.empty()) {
    throw InputError(
        "error: a figure of several runs belongs to none of their folders; give its own with "
        "--out");
  }
}

int carryOut(const RenderOrder& order) {
  noteSignals();
  PictureSettings settings = order.settings;
  // A figure has no video, so there is no progress to show.
  if (order.trajectories.size() > 1) {
    fmt::print("{}", describePictures(settings, renderFigure(order.trajectories, settings)));
    return kExitDone;
  }
  const std::filesystem::path& trajectory = order.trajectories.front();
  if (settings.folder.empty()) settings.folder = trajectory.parent_path();
  if (settings.folder.empty()) settings.folder = ".";
  PictureReport report;
  {
    ProgressLine line;
    report = render(trajectory, settings, [&line](const Progress& progress) {
      line.show(progress);
      return takeInterrupt();
    });
  }
  fmt::print("{}", describePictures(settings, report));
  return report.stoppedAt ? kExitInterrupted : kExitDone;
}

}  // namespace kirireel
