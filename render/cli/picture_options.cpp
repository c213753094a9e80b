// Options that `record` and `render` share. Sizes are pixels; --width and --font-size are of the
// printed page (mm, points of 1/72 inch), from which grid/ computes pixels at --dpi.
#include <algorithm>
#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>

#include "render/cli/option_group.h"
#include "render/cli/scene_options.h"
#include "sim/base/error.h"
#include "sim/base/geometry.h"

namespace kirireel::cli {

std::vector<std::string> parseWords(const scene::TypedValue& value) {
  std::vector<std::string> words;
  std::istringstream list(value.text);
  for (std::string word; std::getline(list, word, ',');) words.push_back(word);
  return words;
}

std::vector<picture::PageFormat> parsePages(const scene::TypedValue& value,
                                            const scene::Choices<picture::PageFormat>& choices) {
  std::vector<picture::PageFormat> pages;
  for (const std::string& word : parseWords(value)) {
    const auto format = scene::parseChoice<picture::PageFormat>({value.name, word}, choices);
    if (std::ranges::find(pages, format) == pages.end()) pages.push_back(format);
  }
  return pages;
}

namespace {

/// All but the first, png.
const scene::Choices<picture::PageFormat>& vectorFormats() {
  static const scene::Choices<picture::PageFormat> choices(picture::kPageFormats.begin() + 1,
                                                           picture::kPageFormats.end());
  return choices;
}

/// As in a scene file: "svg,pdf" in quotation marks.
std::string pagesText(const std::vector<picture::PageFormat>& pages) {
  std::vector<std::string> words;
  for (const picture::PageFormat page : pages) {
    words.push_back(scene::nameOfChoice(vectorFormats(), page));
  }
  return wordsText(words);
}

/// The value of `--letters` without a word; true in a scene file.
const scene::Choices<picture::PanelLetters>& letterChoices() {
  static const scene::Choices<picture::PanelLetters> choices = {
      {"a", picture::PanelLetters::Small},
      {"(a)", picture::PanelLetters::Bracketed},
      {"A", picture::PanelLetters::Capital}};
  return choices;
}

picture::PanelLetters parseLetters(const scene::TypedValue& value) {
  if (value.text == "true" || value.text == "True") return picture::PanelLetters::Plain;
  if (value.text == "false" || value.text == "False") return picture::PanelLetters::None;
  return scene::parseChoice<picture::PanelLetters>(value, letterChoices());
}

std::string lettersText(picture::PanelLetters letters) {
  if (letters == picture::PanelLetters::None) return "";
  if (letters == picture::PanelLetters::Plain) return "true";
  return scene::quotedText(scene::nameOfChoice(letterChoices(), letters));
}

}  // namespace

void addPrintOptions(OptionGroup& group, record::PictureSettings& settings) {
  group.stored("--width", settings.gridWidth, "MM", "by --size",
               "width of the grid in print, such as 180mm; at --dpi, else 300 dpi",
               lengthIn("mm", {1, 10000}), scene::numberText);
  group.stored("--font-size", settings.fontPoints, "PT",
               "7pt; without --width by the pictures' size", "size of the grid's text in print",
               lengthIn("pt", {1, 200}), scene::numberText);
  group.stored("--font", settings.font, "NAME", "DejaVu Sans", "family of all text, from fc-list",
               asTyped, scene::quotedText);
  group.stored("--letters", settings.letters, "[WORD]", "none",
               "letters (a), (b), ... above the grid's pictures; WORD a, (a) or A: bold; in a "
               "figure of several runs one per row",
               parseLetters, lettersText);
  group.number("--dpi", settings.dotsPerInch, {1, 100000}, "COUNT", "not stored",
               "dots per inch stored in PNG files, for print");
}

void addRowOptions(OptionGroup& group, record::PictureSettings& settings) {
  group.flag("--same-view", settings.sameView,
             "the view of the first run for all rows; else each row has its own");
  group.flag("--same-scale", settings.sameScale,
             "the same scale of length for all rows; needs a parallel projection");
}

void addGridOptions(OptionGroup& group, record::PictureSettings& settings) {
  group.stored("--size", settings.size, "WxH", "1280x720", "size of each picture, pixels",
               parseSize, sizeText);
  group.stored("--grid", settings.grid, "RxC", "3x3", "rows and columns of the snapshot grid",
               parseGrid, gridText);
  group.stored("--captions", settings.captions, "PARTS", "progress, at real pace time",
               "captions of the grid's pictures, and if given of the video: progress, time, angle, "
               "error, gap; or none",
               parseCaption, captionText);
  group.flag("--scale-bar", settings.scaleBar,
             "a bar of length below the grid and the video; needs a parallel projection");
  group.choice<record::SnapshotSpacing>(
      "--snapshots", settings.spacing,
      {{"progress", record::SnapshotSpacing::Progress}, {"time", record::SnapshotSpacing::Time}},
      "spacing of the grid's pictures, in equal steps of motion or of time");
  group.flag("--arrows", settings.arrows,
             "arrows from each of the grid's pictures to the next in its row");
  group.stored(
      "--column-heads", settings.columnHeads, "LIST", "none",
      "headers of the grid's columns instead of captions, separated by commas: flat,half,open",
      parseWords, wordsText);
}

void addPictureOptions(CLI::App& command, record::PictureSettings& settings) {
  OptionGroup group(command, "Pictures", "recording");
  addGridOptions(group, settings);
  addPrintOptions(group, settings);
  group.stored(
      "--figure", settings.pages, "LIST", "none",
      "also write the grid as vector graphics: svg, pdf, in snapshots.svg, snapshots.pdf",
      [](const scene::TypedValue& typed) { return parsePages(typed, vectorFormats()); }, pagesText);
  group.flag("--frames", settings.frames, "write every frame of the video as a PNG into frames/");
  group.stored("--frames-at", settings.chosenFrames, "LIST", "none",
               "the same for some moments only: seconds, or fractions of the motion, such as "
               "0,1.5,50%,100%",
               parseFrameChoices, frameChoicesText);
  group.flag("--no-snapshots", settings.snapshots, "no snapshots.png", false);
  group.flag("--svg", settings.svg,
             "the grid's pictures as snapshot_01.svg ..., hidden surfaces removed");
  group
      // The number of painters changes no byte, so it is not part of the fingerprint.
      .stored("--painters", settings.painterCount, "COUNT", "one for each core",
              "threads that paint frames at the same time", integerIn({1, 64}), scene::numberText)
      .excludeFromFingerprint();
  // Both libraries draw the same.
  group
      .choice<std::optional<picture::GraphicsLibrary>>(
          "--gl", settings.graphics,
          {{"auto", std::nullopt},
           {"osmesa", picture::GraphicsLibrary::Osmesa},
           {"egl", picture::GraphicsLibrary::Egl}},
          "library that draws off screen")
      .excludeFromFingerprint();
  addAppearanceOptions(command, settings.appearance);
}

// ------------------------------------------------------------------------------------------------
// Options of colours, drawing and camera. Angles are typed in degrees and stored in radians;
// lengths are metres. A value is written (serializedAs) as the shortest number that reads back to
// the same double. A scene file made from an order gives the same pictures to the last bit.

namespace {

/// The quantity of the colours, and their scale.
void addScaleOptions(OptionGroup& group, picture::Appearance& appearance) {
  group.choice<picture::Colouring>("--colour", appearance.colouring,
                                   {picture::kColourings.begin(), picture::kColourings.end()},
                                   "quantity shown by the bricks' colours");
  group.choice<picture::ColourMap>("--colour-map", appearance.map,
                                   {{"viridis", picture::ColourMap::Viridis},
                                    {"cividis", picture::ColourMap::Cividis},
                                    {"coolwarm", picture::ColourMap::CoolWarm}},
                                   "scale of colours for a measure, coolwarm is diverging");
  group.number("--colour-least", appearance.colourLeast, {-1e12, 1e12}, "VALUE", "0",
               "value at the first end of the scale");
  group.number("--colour-most", appearance.colourMost, {1e-15, 1e12}, "VALUE",
               "the largest of the run",
               "value at the other end of the scale, in the unit of the measure");
}

/// Colours are names of CSS or six hexadecimal digits.
void addColourOptions(OptionGroup& group, picture::Appearance& appearance) {
  const auto colour = [&group](const char* name, std::optional<picture::Colour>& target,
                               const char* defaultText, const char* help) {
    group.stored(name, target, "COLOUR", defaultText, help, parseColour, colourText);
  };
  colour("--brick-colour", appearance.brickColour, "80AEDC",
         "colour of all bricks, with --colour plain; a name such as teal, or RRGGBB");
  colour("--back-colour", appearance.backColour, "7E92A6",
         "colour of their other side, with --colour plain");
  group.appended(
      "--tile-colour", appearance.tileColours, "[NAME:]TILES=COLOUR",
      "colour of some tiles, as in 3,7,10-15=teal, or \"hinge row:3,7=teal\" for a name in "
      "the legend; with --colour plain, shape or state",
      parseTileColour, tileColoursText);
  group.number("--opacity", appearance.opacity, {0, 1}, "SHARE",
               "opacity of all bricks, 0 hides them; their hidden sides are not drawn");
  group.appended("--tile-opacity", appearance.tileOpacities, "TILES=SHARE",
                 "opacity of some tiles, as in 3,7,10-15=0.3, with any --colour", parseTileOpacity,
                 tileOpacitiesText);
  colour("--outline-colour", appearance.outlineColour, "263242",
         "colour of the lines on the edges of tiles");
  colour("--background", appearance.background, "by --theme", "colour of the background");
}

/// "0.5pt", "0.5pt,0.75pt", or a factor of the default widths. A single width is that between
/// tiles; the other one has the default ratio to it.
picture::OutlineWidths parseOutlineWidths(const scene::TypedValue& value) {
  picture::OutlineWidths widths;
  const double ratio = widths.silhouettes / widths.slits;
  const std::vector<std::string> words = parseWords(value);
  if (words.size() < 2 && scene::readNumber(value.text)) {
    const double factor = scene::parseNumber(value, {0.1, 20});
    return {factor * widths.slits, factor * widths.silhouettes};
  }
  if (words.size() > 2) {
    throw scene::valueError(value, "one or two widths, for example 0.5pt or 0.5pt,0.75pt");
  }
  widths.slits = parseLength({value.name, words[0]}, "pt", {0.01, 100});
  widths.silhouettes = words.size() == 2 ? parseLength({value.name, words[1]}, "pt", {0.01, 100})
                                         : ratio * widths.slits;
  return widths;
}

/// Options of a picture except its camera.
void addDrawingOptions(CLI::App& command, picture::Appearance& appearance) {
  OptionGroup group(command, "Style", "style");
  group.choice<picture::Theme>("--theme", appearance.theme,
                               {{"light", picture::Theme::Light}, {"dark", picture::Theme::Dark}},
                               "page for which the pictures are made");
  addScaleOptions(group, appearance);
  addColourOptions(group, appearance);
  group.choice<picture::GroundLook>(
      "--ground-look", appearance.ground,
      {picture::kGroundLooks.begin(), picture::kGroundLooks.end()},
      "ground below the bricks; auto is a plate with a shadow if the scene has a ground");
  group.flag("--transparent", appearance.transparent,
             "no background in PNG files and in videos with alpha");
  group.flag("--no-outlines", appearance.outlines, "no lines on the edges of tiles", false);
  group.stored(
      "--outline-width", appearance.outlineWidths, "PT[,PT]", "0.5pt,0.75pt",
      "width in print of the lines between tiles, and of other lines; a number without pt is "
      "a factor",
      parseOutlineWidths, [](const picture::OutlineWidths& widths) {
        return fmt::format("\"{}pt,{}pt\"", widths.slits, widths.silhouettes);
      });
  group.flag("--mark-joints", appearance.jointMarks, "a dot on each joint");
  group.flag("--target-lines", appearance.targetLines,
             "the target's tiles as lines, dashed where bricks hide them");
  group.appended(
      "--trail", appearance.trails, "TILE,VERTEX",
      "path of this vertex until each picture, as a line, dashed where bricks hide it",
      [](const scene::TypedValue& typed) {
        const auto corner = parseIndices(typed, 2, "tile, vertex, as in 3,0");
        return picture::TracedVertex{corner[0], corner[1]};
      },
      [](const std::vector<picture::TracedVertex>& trails) {
        std::vector<std::array<int, 2>> corners;
        for (const auto& [tile, vertex] : trails) corners.push_back({tile, vertex});
        return listsText(corners);
      });
  group.choice<picture::Ghost>("--ghost", appearance.ghost,
                               {picture::kGhosts.begin(), picture::kGhosts.end()},
                               "state drawn with every picture as pale transparent bricks");
  group.stored("--depth-cue", appearance.depthCue, "SHARE", "0",
               "share of the background's colour in the farthest tiles of the run, 0 to 1",
               numberIn({0, 1}), positiveText);
  group.number(
      "--occlusion", appearance.occlusion, {0, 1}, "SHARE", "0.6",
      "loss of brightness in creases and gaps between bricks, 0 to 1; less if colours show "
      "values");
}

/// One of the words, or "45,30", or "45,30,10".
std::optional<picture::ViewAngles> parseView(
    const scene::TypedValue& value,
    const scene::Choices<std::optional<picture::ViewAngles>>& views) {
  // Words have no comma.
  const std::size_t comma = value.text.find(',');
  if (comma == std::string::npos) {
    std::vector<std::string> allowed = scene::choiceNames(views);
    if (has(allowed, value.text)) return scene::parseChoice(value, views);
    allowed.emplace_back("AZIMUTH,ELEVATION[,ROLL] in degrees");
    throw scene::valueError(value, scene::listWords(allowed));
  }
  const auto degrees = [&value](const std::string& text, double most) {
    return scene::parseNumber({value.name, text}, {-most, most}) * kDegree;
  };
  const std::size_t second = std::min(value.text.find(',', comma + 1), value.text.size());
  // Azimuth and roll may be any number of turns; elevation is in [-90, 90] degrees.
  picture::ViewAngles view{degrees(value.text.substr(0, comma), 3600),
                           degrees(value.text.substr(comma + 1, second - comma - 1), 90)};
  if (second < value.text.size()) view.roll = degrees(value.text.substr(second + 1), 3600);
  return view;
}

/// The shortest degrees that read back to the same angle.
std::string degreesText(double angle) {
  return scene::numberText(
      scene::numberReadAs(angle, angle / kDegree, [](double typed) { return typed * kDegree; }));
}

/// "45,30", or "45,30,10".
std::string anglesText(const picture::ViewAngles& view) {
  return degreesText(view.azimuth) + "," + degreesText(view.elevation) +
         (view.roll != 0 ? "," + degreesText(view.roll) : "");
}

/// Each reader keeps its own copy of `views`.
void addViewOptions(OptionGroup& group, picture::CameraChoice& camera) {
  const scene::Choices<std::optional<picture::ViewAngles>> views = {
      {"auto", std::nullopt},
      {"top", picture::kTopView},
      {"bottom", picture::kBottomView},
      {"front", picture::kFrontView},
      {"back", picture::kBackView},
      {"side", picture::kRightView},
      {"left", picture::kLeftView},
      {"iso", picture::kIsometricView},
      {"oblique", picture::kObliqueView}};
  group.stored(
      "--view", camera.view, "WORD|AZ,EL[,ROLL]", "auto",
      fmt::format(
          "position of the camera: {}; auto shows most of the tiles over the motion; or "
          "azimuth, elevation and roll in degrees, -90,0 is from the front, -90,90 from above",
          scene::listWords(scene::choiceNames(views))),
      [views](const scene::TypedValue& typed) { return parseView(typed, views); },
      [views](const std::optional<picture::ViewAngles>& view) {
        const std::string name = scene::nameOfChoice(views, view);
        return scene::quotedText(name.empty() ? anglesText(*view) : name);
      });
}

/// Lengths in the model's unit, angles in degrees.
void addCameraOptions(CLI::App& command, picture::Appearance& appearance) {
  OptionGroup group(command, "Camera", "camera");
  picture::CameraChoice& camera = appearance.camera;
  addViewOptions(group, camera);
  group.choice<std::optional<bool>>(
      "--projection", camera.orthographic,
      {{"auto", std::nullopt}, {"parallel", true}, {"perspective", false}},
      "projection; auto is parallel along an axis and for flat motions, else perspective");
  group.number("--zoom", camera.zoom, {1e-3, 1e3}, "FACTOR", "enlarges the middle");
  group.number("--margin", camera.margin, {0, 0.45}, "SHARE",
               "fraction of the picture left free on each side");
  group.number("--distance", camera.distance, {1e-9, 1e12}, "LENGTH", "fitted",
               "distance of the eye, in perspective");
  group.choice<picture::FitScope>("--fit", appearance.fit,
                                  {{"auto", picture::FitScope::Auto},
                                   {"run", picture::FitScope::Run},
                                   {"ends", picture::FitScope::Ends}},
                                  "part that stays in view, the whole run or its start and target");
  group.stored(
      "--orbit", camera.orbit, "DEGREES", "0", "rotation of the camera about z over the run",
      [](const scene::TypedValue& typed) {
        return scene::parseNumber(typed, {-36000, 36000}) * kDegree;
      },
      degreesText);
  group.stored("--camera-keys", camera.keys, "TIME:YAW:PITCH:ZOOM,...", "",
               "views of the camera at given times (seconds, degrees)", parseCameraKeys,
               cameraKeysText);
}

}  // namespace

void addAppearanceOptions(CLI::App& command, picture::Appearance& appearance) {
  addDrawingOptions(command, appearance);
  addCameraOptions(command, appearance);
}

// ------------------------------------------------------------------------------------------------
// Options of the video: file and format, pace, title, quality. The range of the quality depends on
// the format, which may be given later, so requireValidSettings() checks it after parsing.

namespace {

/// A name without a folder: --out is the folder.
std::string parseFileName(const scene::TypedValue& value) {
  const std::filesystem::path name = value.text;
  // Valid UTF-8, because the name is stored in summary.json.
  const bool isName = name.has_filename() && !name.has_parent_path();
  if (isName && codePoints(value.text)) return value.text;
  throw scene::valueError(value,
                          "the name of a file, for example talk.webm; --out gives its folder");
}

/// Replaces a typed "\n", two characters in most shells, by a line feed.
std::string withLineFeeds(const scene::TypedValue& value) {
  std::string text = value.text;
  for (std::size_t at = 0; (at = text.find("\\n", at)) != std::string::npos;) {
    text.replace(at, 2, "\n");
  }
  return text;
}

/// --length and --speed each select a pace. Only the one in use is written.
void addPaceOptions(OptionGroup& group, record::PictureSettings& settings) {
  group.choice<record::Pace>(
      "--pace", settings.pace, {{"even", record::Pace::Even}, {"real", record::Pace::Real}},
      "each frame has an equal part of the motion, or of the simulated time");
  group
      .value("--length", "SECONDS", scene::numberText(settings.length),
             "length of a video at an even pace, without its title",
             [&](const scene::TypedValue& typed) {
               settings.length = scene::parseNumber(typed, {0.1, 36000});
               settings.pace = record::Pace::Even;
             })
      .serializedAs([&] {
        return settings.pace == record::Pace::Even ? scene::numberText(settings.length) : "";
      });
  group
      .value("--speed", "FACTOR", scene::numberText(settings.speed),
             "real pace, with this number of simulated seconds per second of video; below 1 is "
             "slow motion",
             [&](const scene::TypedValue& typed) {
               settings.speed = scene::parseNumber(typed, {1e-3, 1e3});
               settings.pace = record::Pace::Real;
             })
      .serializedAs([&] {
        return settings.pace == record::Pace::Real ? scene::numberText(settings.speed) : "";
      });
  group
      .stored("--hold", settings.hold, "SECONDS", "0.5 at an even pace, else 0",
              "show the first and the last frame longer", numberIn({0, 60}), scene::numberText)
      .serializedAs([&] { return scene::numberText(settings.heldSeconds()); });
}

}  // namespace

void addVideoOptions(CLI::App& command, record::PictureSettings& settings) {
  OptionGroup group(command, "Video", "recording");
  group.stored("--video", settings.videoFile, "NAME", settings.videoFile,
               "file name; its ending gives the format: .mp4 (H.264), .webm (VP9), .gif, .apng, "
               ".mkv (FFV1, lossless), .mov (ProRes 4444)",
               parseFileName, scene::quotedText);
  group.flag("--no-video", settings.video, "no video", false);
  addPaceOptions(group, settings);
  group.stored("--title", settings.title, "TEXT", "",
               "a card before the video, 2 s; \\n begins a new line", withLineFeeds,
               scene::quotedText);
  group.stored("--subtitle", settings.subtitle, "TEXT", "", "smaller lines below the title",
               withLineFeeds, scene::quotedText);
  group.flag("--progress-bar", settings.progressBar,
             "a bar under the frames that fills with the motion");
  group.stored("--inset", settings.inset, "CURVE", "none",
               "a curve in a corner of the frames, with a dot at their time: target_error, radius, "
               "theta, ..., as in kirireel curves --curves",
               asTyped, scene::quotedText);
  group.stored("--crf", settings.crf, "NUMBER", "18 H.264, 24 VP9",
               "quality, 0 is best, to 51 (H.264) or 63 (VP9)", integerIn({0, 63}),
               scene::numberText);
  group.stored("--preset", settings.preset, "WORD", settings.preset,
               "preset of x264: ultrafast to placebo (smallest file); auto is a quick veryfast",
               asTyped, scene::quotedText);
  group.stored("--encoder", settings.encoder, "NAME", "by the format",
               "another encoder of FFmpeg's libavcodec", asTyped, scene::quotedText);
}

}  // namespace kirireel::cli
