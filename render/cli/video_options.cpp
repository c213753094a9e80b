#include "render/cli/video_options.h"

#include <CLI/CLI.hpp>

#include "render/cli/option_group.h"
#include "sim/base/spelling.h"

namespace kirireel {
namespace {

/// A bare name: the folder is --out's.
std::string parseFileName(const OptionValue& value) {
  const std::filesystem::path name = value.text;
  const bool isName = name.has_filename() && !name.has_parent_path();
  if (isName && codePoints(value.text)) return value.text;
  throw valueError(value, "the name of a file, for example talk.webm; --out gives its folder");
}

}  // namespace

void addVideoOptions(CLI::App& command, PictureSettings& settings) {
  OptionGroup group(command, "Video");
  group
      .value("--video", "NAME", settings.videoFile,
             "file name; its ending gives the format: .mp4 (H.264), .webm (VP9), .gif, .apng, .mkv "
             "(FFV1, lossless)",
             [&](const OptionValue& typed) { settings.videoFile = parseFileName(typed); })
      .saidAs([&] { return quotedText(settings.videoFile); });
  group
      .value("--format", "WORD", "mp4", "the same as --video deployment.WORD",
             [&](const OptionValue& typed) {
               settings.videoFile = parseFileName({typed.name, "deployment." + typed.text});
             })
      .decidesNothing();  // --video says it
  group.flag("--no-video", settings.video, "no video", false);
  group.number("--speed", settings.speed, {1e-3, 1e3}, "FACTOR",
               "simulated seconds in a second of video, below 1 is slow motion");
  group.number("--hold", settings.hold, {0, 60}, "SECONDS",
               "show the first and the last frame longer");
  group
      .value("--title", "TEXT", "", "a card before the video, 2 s",
             [&](const OptionValue& typed) { settings.title = typed.text; })
      .saidAs([&] { return quotedText(settings.title); });
  group
      .value("--crf", "NUMBER", "18 H.264, 24 VP9", "quality, 0 is best, to 51 (H.264) or 63 (VP9)",
             [&](const OptionValue& typed) {
               settings.crf = static_cast<int>(parseInteger(typed, {0, 63}));
             })
      .saidAs([&] { return settings.crf ? fmt::format("{}", *settings.crf) : ""; });
  group
      .value("--preset", "WORD", settings.preset, "of x264: ultrafast to placebo (smallest file)",
             [&](const OptionValue& typed) { settings.preset = typed.text; })
      .saidAs([&] { return quotedText(settings.preset); });
  group
      .value("--encoder", "NAME", "that of the format", "another encoder of FFmpeg's libavcodec",
             [&](const OptionValue& typed) { settings.encoder = typed.text; })
      .saidAs([&] { return quotedText(settings.encoder); });
}

}  // namespace kirireel
