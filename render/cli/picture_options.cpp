#include "render/cli/picture_options.h"

#include <CLI/CLI.hpp>

#include "render/cli/option_group.h"

namespace kirireel {

void addPictureOptions(CLI::App& command, RecordSettings& settings) {
  OptionGroup group(command, "Pictures");
  group.value("--size", "WxH", "1280x720", "of each picture, pixels",
              [&](const OptionValue& typed) { settings.size = parseSize(typed); });
  group.choice<std::optional<ViewAngles>>(
      "--view", settings.view,
      {{"auto", std::nullopt},
       {"top", kTopView},
       {"front", kFrontView},
       {"iso", kIsometricView},
       {"oblique", kObliqueView}},
      "where the camera stands, auto is top for a flat model, else iso");
  group.value("--grid", "RxC", "3x3", "rows and columns of the snapshot grid",
              [&](const OptionValue& typed) { settings.grid = parseGrid(typed); });
  group.choice<SnapshotSpacing>(
      "--snapshots", settings.spacing,
      {{"progress", SnapshotSpacing::Progress}, {"time", SnapshotSpacing::Time}},
      "spacing of the grid's pictures, in equal shares of way or of time");
  group.flag("--frames", "write every frame of the video as a PNG into frames/",
             [&settings] { settings.frames = true; });
  group.flag("--no-video", "no deployment.mp4", [&settings] { settings.video = false; });
  group.flag("--no-snapshots", "no snapshots.png", [&settings] { settings.snapshots = false; });
  group.flag("--no-meshes", "no OBJ and PLY files", [&settings] { settings.meshes = false; });
}

}  // namespace kirireel
