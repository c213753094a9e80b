#include "render/cli/picture_options.h"

#include <CLI/CLI.hpp>

#include "render/cli/look_options.h"
#include "render/cli/option_group.h"

namespace kirireel {

void addPictureOptions(CLI::App& command, PictureSettings& settings) {
  OptionGroup group(command, "Pictures");
  group.value("--size", "WxH", "1280x720", "of each picture, pixels",
              [&](const OptionValue& typed) { settings.size = parseSize(typed); });
  group.value("--grid", "RxC", "3x3", "rows and columns of the snapshot grid",
              [&](const OptionValue& typed) { settings.grid = parseGrid(typed); });
  group.value("--captions", "PARTS", "time",
              "under the grid's pictures: time, angle, error, gap; or none",
              [&](const OptionValue& typed) { settings.captions = parseCaption(typed); });
  group.flag("--scale-bar", "a length under the grid; needs a parallel projection",
             [&settings] { settings.scaleBar = true; });
  group.value("--dpi", "COUNT", "not noted", "dots per inch noted in PNG files, for print",
              [&](const OptionValue& typed) {
                settings.dotsPerInch = parseNumber(typed, {1, 100000});
              });
  group.choice<SnapshotSpacing>(
      "--snapshots", settings.spacing,
      {{"progress", SnapshotSpacing::Progress}, {"time", SnapshotSpacing::Time}},
      "spacing of the grid's pictures, in equal shares of way or of time");
  group.flag("--frames", "write every frame of the video as a PNG into frames/",
             [&settings] { settings.frames = true; });
  group.value("--frames-at", "LIST", "none",
              "the same of these moments: seconds, or shares of the way, such as 0,1.5,50%,100%",
              [&](const OptionValue& typed) { settings.chosenFrames = parseFrameChoices(typed); });
  group.flag("--no-snapshots", "no snapshots.png", [&settings] { settings.snapshots = false; });
  group.flag("--svg", "the grid's pictures as snapshot_01.svg ..., hidden surfaces removed",
             [&settings] { settings.svg = true; });
  group.choice<std::optional<GraphicsLibrary>>(
      "--gl", settings.graphics,
      {{"auto", std::nullopt}, {"osmesa", GraphicsLibrary::Osmesa}, {"egl", GraphicsLibrary::Egl}},
      "library that draws off screen");
  addLookOptions(command, settings.look);
}

}  // namespace kirireel
