// Options of the video: file and format, pace, title, quality. Ranges of quality depend on the
// format, which may be given after it, so requireValidSettings() checks them once all is known.
#include "render/cli/video_options.h"

#include <CLI/CLI.hpp>

#include "render/cli/option_group.h"
#include "sim/base/spelling.h"

namespace kirireel {
namespace {

/// A bare name: the folder is --out's.
std::string parseFileName(const TypedValue& value) {
  const std::filesystem::path name = value.text;
  // UTF-8 that is valid, since the name goes into summary.json.
  const bool isName = name.has_filename() && !name.has_parent_path();
  if (isName && codePoints(value.text)) return value.text;
  throw valueError(value, "the name of a file, for example talk.webm; --out gives its folder");
}

/// Shells leave "\n" as it is typed. A backslash before an n is two characters on the command line.
std::string withLineFeeds(std::string text) {
  for (std::size_t at = 0; (at = text.find("\\n", at)) != std::string::npos;) {
    text.replace(at, 2, "\n");
  }
  return text;
}

/// --length and --speed choose the pace that they belong to, and only the one in use is written
/// down.
void addPaceOptions(OptionGroup& group, PictureSettings& settings) {
  group.choice<Pace>("--pace", settings.pace, {{"even", Pace::Even}, {"real", Pace::Real}},
                     "every frame brings the same motion, or the same simulated time");
  group
      .value("--length", "SECONDS", numberText(settings.length),
             "of a video at an even pace, without its title",
             [&](const TypedValue& typed) {
               settings.length = parseNumber(typed, {0.1, 36000});
               settings.pace = Pace::Even;
             })
      .saidAs([&] { return settings.pace == Pace::Even ? numberText(settings.length) : ""; });
  group
      .value("--speed", "FACTOR", numberText(settings.speed),
             "real pace, with so many simulated seconds in a second of video; below 1 is slow "
             "motion",
             [&](const TypedValue& typed) {
               settings.speed = parseNumber(typed, {1e-3, 1e3});
               settings.pace = Pace::Real;
             })
      .saidAs([&] { return settings.pace == Pace::Real ? numberText(settings.speed) : ""; });
  group
      .value("--hold", "SECONDS", "0.5 at an even pace, else 0",
             "show the first and the last frame longer",
             [&](const TypedValue& typed) {
               settings.hold = parseNumber(typed, {0, 60});
             })
      .saidAs([&] { return numberText(settings.heldSeconds()); });
}

}  // namespace

void addVideoOptions(CLI::App& command, PictureSettings& settings) {
  OptionGroup group(command, "Video", "recording");
  group
      .value("--video", "NAME", settings.videoFile,
             "file name; its ending gives the format: .mp4 (H.264), .webm (VP9), .gif, .apng, .mkv "
             "(FFV1, lossless)",
             [&](const TypedValue& typed) { settings.videoFile = parseFileName(typed); })
      .saidAs([&] { return quotedText(settings.videoFile); });
  group
      .value("--format", "WORD", "mp4", "the same as --video deployment.WORD",
             [&](const TypedValue& typed) {
               settings.videoFile = parseFileName({typed.name, "deployment." + typed.text});
             })
      .decidesNothing();  // --video says it
  group.flag("--no-video", settings.video, "no video", false);
  addPaceOptions(group, settings);
  group
      .value("--title", "TEXT", "", "a card before the video, 2 s; \\n begins a new line",
             [&](const TypedValue& typed) { settings.title = withLineFeeds(typed.text); })
      .saidAs([&] { return quotedText(settings.title); });
  group
      .value("--subtitle", "TEXT", "", "smaller lines below the title",
             [&](const TypedValue& typed) { settings.subtitle = withLineFeeds(typed.text); })
      .saidAs([&] { return quotedText(settings.subtitle); });
  group.flag("--progress-bar", settings.progressBar,
             "a bar under the frames that fills with the motion");
  group
      .value("--crf", "NUMBER", "18 H.264, 24 VP9", "quality, 0 is best, to 51 (H.264) or 63 (VP9)",
             [&](const TypedValue& typed) {
               settings.crf = static_cast<int>(parseInteger(typed, {0, 63}));
             })
      .saidAs([&] { return settings.crf ? fmt::format("{}", *settings.crf) : ""; });
  group
      .value("--preset", "WORD", settings.preset,
             "of x264: ultrafast to placebo (smallest file); auto is a quick veryfast",
             [&](const TypedValue& typed) { settings.preset = typed.text; })
      .saidAs([&] { return quotedText(settings.preset); });
  group
      .value("--encoder", "NAME", "that of the format", "another encoder of FFmpeg's libavcodec",
             [&](const TypedValue& typed) { settings.encoder = typed.text; })
      .saidAs([&] { return quotedText(settings.encoder); });
}

}  // namespace kirireel
