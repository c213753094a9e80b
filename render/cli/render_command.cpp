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

namespace kirireel {

CLI::App* addRenderCommand(CLI::App& program, RenderOrder& order) {
  CLI::App* command = program.add_subcommand(
      "render", "make pictures and video of a recorded run again, without simulating");
  addPlace(*command, "TRAJECTORY", order.trajectory,
           "a trajectory.h5 as record and simulate leave it, or the folder it is in");
  OptionGroup output(*command, "Output");
  output.value("--out", "FOLDER", "that of TRAJECTORY", "where the files go",
               [&order](const OptionValue& typed) { order.settings.folder = typed.text; });
  output.integer("--fps", order.settings.framesPerSecond, {1, 240}, "COUNT",
                 "frames in a second of video");
  addPictureOptions(*command, order.settings);
  addVideoOptions(*command, order.settings);
  command->footer(
      "States between two samples are interpolated, with their joints closed.\n\n"
      "Examples:\n"
      "  kirireel render out/tessellation_4x4 --view iso --out out/again\n"
      "  kirireel render out/tessellation_4x4 --format gif --fps 25 --speed 0.5");
  return command;
}

void completeOrder(const CLI::App& command, RenderOrder& order) {
  requireGiven(order.trajectory, "TRAJECTORY", command);
  if (std::filesystem::is_directory(order.trajectory)) order.trajectory /= output::kTrajectory;
  requireConsistentPace(command);
}

int carryOut(const RenderOrder& order) {
  noteSignals();
  PictureSettings settings = order.settings;
  if (settings.folder.empty()) settings.folder = order.trajectory.parent_path();
  if (settings.folder.empty()) settings.folder = ".";
  PictureReport report;
  {
    ProgressLine line;
    report = render(order.trajectory, settings, [&line](const Progress& progress) {
      line.show(progress);
      return takeInterrupt();
    });
  }
  fmt::print("{}", describePictures(settings, report));
  return report.stoppedAt ? kExitInterrupted : kExitDone;
}

}  // namespace kirireel
