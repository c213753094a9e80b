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

std::vector<std::string> parseWords(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream list(text);
  for (std::string word; std::getline(list, word, ',');) words.push_back(word);
  return words;
}

std::vector<picture::PageFormat> parsePages(const scene::TypedValue& value,
                                            const scene::Choices<picture::PageFormat>& choices) {
  std::vector<picture::PageFormat> pages;
  for (const std::string& word : parseWords(value.text)) {
    const auto format = scene::parseChoice<picture::PageFormat>({value.name, word}, choices);
    if (std::ranges::find(pages, format) == pages.end()) pages.push_back(format);
  }
  return pages;
}

namespace {

/// As in a scene file: "svg,pdf" in quotation marks.
std::string pagesText(const std::vector<picture::PageFormat>& pages) {
  std::string text;
  for (const picture::PageFormat page : pages) {
    text +=
        (text.empty() ? "" : ",") + std::string(page == picture::PageFormat::Svg ? "svg" : "pdf");
  }
  return scene::quotedText(text);
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
  group
      .value("--width", "MM", "by --size",
             "width of the grid in print, such as 180mm; at --dpi, else 300 dpi",
             [&](const scene::TypedValue& typed) {
               settings.gridWidth = parseLength(typed, "mm", {1, 10000});
             })
      .serializedAs(
          [&] { return settings.gridWidth ? scene::numberText(*settings.gridWidth) : ""; });
  group
      .value("--font-size", "PT", "7pt; without --width by the pictures' size",
             "size of the grid's text in print",
             [&](const scene::TypedValue& typed) {
               settings.fontPoints = parseLength(typed, "pt", {1, 200});
             })
      .serializedAs(
          [&] { return settings.fontPoints ? scene::numberText(*settings.fontPoints) : ""; });
  group
      .value("--font", "NAME", "DejaVu Sans", "family of all text, from fc-list",
             [&](const scene::TypedValue& typed) { settings.font = typed.text; })
      .serializedAs([&] { return scene::quotedText(settings.font); });
  group
      .value("--letters", "[WORD]", "none",
             "letters (a), (b), ... above the grid's pictures; WORD a, (a) or A: bold; in a figure "
             "of several runs one per row",
             [&](const scene::TypedValue& typed) { settings.letters = parseLetters(typed); })
      .serializedAs([&] { return lettersText(settings.letters); });
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
  group
      .value("--size", "WxH", "1280x720", "size of each picture, pixels",
             [&](const scene::TypedValue& typed) { settings.size = parseSize(typed); })
      .serializedAs([&] { return sizeText(settings.size); });
  group
      .value("--grid", "RxC", "3x3", "rows and columns of the snapshot grid",
             [&](const scene::TypedValue& typed) { settings.grid = parseGrid(typed); })
      .serializedAs([&] { return gridText(settings.grid); });
  group
      .value("--captions", "PARTS", "progress, at real pace time",
             "captions of the grid's pictures, and if given of the video: progress, time, angle, "
             "error, gap; or none",
             [&](const scene::TypedValue& typed) { settings.captions = parseCaption(typed); })
      .serializedAs([&] { return settings.captions ? captionText(*settings.captions) : ""; });
  group.flag("--scale-bar", settings.scaleBar,
             "a bar of length below the grid and the video; needs a parallel projection");
  group.choice<record::SnapshotSpacing>(
      "--snapshots", settings.spacing,
      {{"progress", record::SnapshotSpacing::Progress}, {"time", record::SnapshotSpacing::Time}},
      "spacing of the grid's pictures, in equal steps of motion or of time");
  group.flag("--arrows", settings.arrows,
             "arrows from each of the grid's pictures to the next in its row");
  group
      .value(
          "--column-heads", "LIST", "none",
          "headers of the grid's columns instead of captions, separated by commas: flat,half,open",
          [&](const scene::TypedValue& typed) { settings.columnHeads = parseWords(typed.text); })
      .serializedAs([&] {
        return scene::quotedText(fmt::format("{}", fmt::join(settings.columnHeads, ",")));
      });
}

void addPictureOptions(CLI::App& command, record::PictureSettings& settings) {
  OptionGroup group(command, "Pictures", "recording");
  addGridOptions(group, settings);
  addPrintOptions(group, settings);
  group
      .value("--figure", "LIST", "none",
             "also write the grid as vector graphics: svg, pdf, in snapshots.svg, snapshots.pdf",
             [&](const scene::TypedValue& typed) {
               settings.pages = parsePages(
                   typed, {{"svg", picture::PageFormat::Svg}, {"pdf", picture::PageFormat::Pdf}});
             })
      .serializedAs([&] { return pagesText(settings.pages); });
  group.flag("--frames", settings.frames, "write every frame of the video as a PNG into frames/");
  group
      .value(
          "--frames-at", "LIST", "none",
          "the same for some moments only: seconds, or fractions of the motion, such as "
          "0,1.5,50%,100%",
          [&](const scene::TypedValue& typed) { settings.chosenFrames = parseFrameChoices(typed); })
      .serializedAs([&] { return frameChoicesText(settings.chosenFrames); });
  group.flag("--no-snapshots", settings.snapshots, "no snapshots.png", false);
  group.flag("--svg", settings.svg,
             "the grid's pictures as snapshot_01.svg ..., hidden surfaces removed");
  group
      // The number of painters changes no byte, so it is not part of the fingerprint.
      .value("--painters", "COUNT", "one for each core",
             "threads that paint frames at the same time",
             [&](const scene::TypedValue& typed) {
               settings.painterCount = static_cast<int>(scene::parseInteger(typed, {1, 64}));
             })
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

/// "" for the colour of the theme.
std::string serializedColour(const std::optional<picture::Colour>& colour) {
  return colour ? colourText(*colour) : "";
}

/// The quantity of the colours, and their scale.
void addScaleOptions(OptionGroup& group, picture::Appearance& appearance) {
  // Measures of single bricks need a scale, "plain" and "shape" do not.
  group.choice<picture::Colouring>("--colour", appearance.colouring,
                                   {{"plain", picture::Colouring::Plain},
                                    {"shape", picture::Colouring::Shape},
                                    {"state", picture::Colouring::State},
                                    {"error", picture::Colouring::TargetError},
                                    {"displacement", picture::Colouring::Displacement},
                                    {"rotation", picture::Colouring::Rotation},
                                    {"gap", picture::Colouring::JointGap},
                                    {"moment", picture::Colouring::Moment},
                                    {"energy", picture::Colouring::Energy}},
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
  group
      .value("--brick-colour", "COLOUR", "80AEDC",
             "colour of all bricks, with --colour plain; a name such as teal, or RRGGBB",
             [&appearance](const scene::TypedValue& typed) {
               appearance.brickColour = parseColour(typed);
             })
      .serializedAs([&appearance] { return serializedColour(appearance.brickColour); });
  group
      .value("--back-colour", "COLOUR", "7E92A6", "colour of their other side, with --colour plain",
             [&appearance](const scene::TypedValue& typed) {
               appearance.backColour = parseColour(typed);
             })
      .serializedAs([&appearance] { return serializedColour(appearance.backColour); });
  group
      .values("--tile-colour", "[NAME:]TILES=COLOUR",
              "colour of some tiles, as in 3,7,10-15=teal, or \"hinge row:3,7=teal\" for a name in "
              "the legend; with --colour plain, shape or state",
              [&appearance](const scene::TypedValue& typed) {
                appearance.tileColours.push_back(parseTileColour(typed));
              })
      .serializedAs([&appearance] { return tileColoursText(appearance.tileColours); });
  group.number("--opacity", appearance.opacity, {0, 1}, "SHARE",
               "opacity of all bricks, 0 hides them; their hidden sides are not drawn");
  group
      .values("--tile-opacity", "TILES=SHARE",
              "opacity of some tiles, as in 3,7,10-15=0.3, with any --colour",
              [&appearance](const scene::TypedValue& typed) {
                appearance.tileOpacities.push_back(parseTileOpacity(typed));
              })
      .serializedAs([&appearance] { return tileOpacitiesText(appearance.tileOpacities); });
  group
      .value("--outline-colour", "COLOUR", "263242", "colour of the lines on the edges of tiles",
             [&appearance](const scene::TypedValue& typed) {
               appearance.outlineColour = parseColour(typed);
             })
      .serializedAs([&appearance] { return serializedColour(appearance.outlineColour); });
  group
      .value("--background", "COLOUR", "by --theme", "colour of the background",
             [&appearance](const scene::TypedValue& typed) {
               appearance.background = parseColour(typed);
             })
      .serializedAs([&appearance] { return serializedColour(appearance.background); });
}

/// "0.5pt", "0.5pt,0.75pt", or a factor of the default widths. A single width is that between
/// tiles; the other one has the default ratio to it.
picture::OutlineWidths parseOutlineWidths(const scene::TypedValue& value) {
  picture::OutlineWidths widths;
  const double ratio = widths.silhouettes / widths.slits;
  const std::vector<std::string> words = parseWords(value.text);
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
  group
      .value(
          "--outline-width", "PT[,PT]", "0.5pt,0.75pt",
          "width in print of the lines between tiles, and of other lines; a number without pt is "
          "a factor",
          [&appearance](const scene::TypedValue& typed) {
            appearance.outlineWidths = parseOutlineWidths(typed);
          })
      .serializedAs([&appearance] {
        return scene::quotedText(scene::numberText(appearance.outlineWidths.slits) + "pt," +
                                 scene::numberText(appearance.outlineWidths.silhouettes) + "pt");
      });
  group.flag("--mark-joints", appearance.jointMarks, "a dot on each joint");
  group.flag("--target-lines", appearance.targetLines,
             "the target's tiles as lines, dashed where bricks hide them");
  group
      .values("--trail", "TILE,VERTEX",
              "path of this vertex until each picture, as a line, dashed where bricks hide it",
              [&appearance](const scene::TypedValue& typed) {
                const auto corner = parseIndices(typed, 2, "tile, vertex, as in 3,0");
                appearance.trails.push_back({corner[0], corner[1]});
              })
      .serializedAs([&appearance] {
        std::vector<std::array<int, 2>> corners;
        for (const auto& [tile, vertex] : appearance.trails) corners.push_back({tile, vertex});
        return listsText(corners);
      });
  group.choice<picture::Ghost>("--ghost", appearance.ghost,
                               {picture::kGhosts.begin(), picture::kGhosts.end()},
                               "state drawn with every picture as pale transparent bricks");
  group
      .value("--depth-cue", "SHARE", "0",
             "share of the background's colour in the farthest tiles of the run, 0 to 1",
             [&appearance](const scene::TypedValue& typed) {
               appearance.depthCue = scene::parseNumber(typed, {0, 1});
             })
      .serializedAs([&appearance] {
        return appearance.depthCue > 0 ? scene::numberText(appearance.depthCue) : "";
      });
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

/// "45,30": the shortest degrees that read back to the same angles.
std::string anglesText(const picture::ViewAngles& view) {
  const auto degrees = [](double angle) {
    return scene::numberText(
        scene::numberReadAs(angle, angle / kDegree, [](double typed) { return typed * kDegree; }));
  };
  return degrees(view.azimuth) + "," + degrees(view.elevation) +
         (view.roll != 0 ? "," + degrees(view.roll) : "");
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
  group
      .value(
          "--view", "WORD|AZ,EL[,ROLL]", "auto",
          fmt::format(
              "position of the camera: {}; auto shows most of the tiles over the motion; or "
              "azimuth, elevation and roll in degrees, -90,0 is from the front, -90,90 from above",
              scene::listWords(scene::choiceNames(views))),
          [&camera, views](const scene::TypedValue& typed) {
            camera.view = parseView(typed, views);
          })
      .serializedAs([&camera, views] {
        const std::string name = scene::nameOfChoice(views, camera.view);
        return scene::quotedText(name.empty() ? anglesText(*camera.view) : name);
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
  group
      .value("--orbit", "DEGREES", "0", "rotation of the camera about z over the run",
             [&camera](const scene::TypedValue& typed) {
               camera.orbit = scene::parseNumber(typed, {-36000, 36000}) * kDegree;
             })
      .serializedAs([&camera] {
        return scene::numberText(
            scene::numberReadAs(camera.orbit, camera.orbit / kDegree,
                                [](double degrees) { return degrees * kDegree; }));
      });
  group
      .value("--camera-keys", "TIME:YAW:PITCH:ZOOM,...", "",
             "views of the camera at given times (seconds, degrees)",
             [&camera](const scene::TypedValue& typed) { camera.keys = parseCameraKeys(typed); })
      .serializedAs([&camera] { return cameraKeysText(camera.keys); });
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
std::string withLineFeeds(std::string text) {
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
      .value("--hold", "SECONDS", "0.5 at an even pace, else 0",
             "show the first and the last frame longer",
             [&](const scene::TypedValue& typed) {
               settings.hold = scene::parseNumber(typed, {0, 60});
             })
      .serializedAs([&] { return scene::numberText(settings.heldSeconds()); });
}

}  // namespace

void addVideoOptions(CLI::App& command, record::PictureSettings& settings) {
  OptionGroup group(command, "Video", "recording");
  group
      .value("--video", "NAME", settings.videoFile,
             "file name; its ending gives the format: .mp4 (H.264), .webm (VP9), .gif, .apng, .mkv "
             "(FFV1, lossless), .mov (ProRes 4444)",
             [&](const scene::TypedValue& typed) { settings.videoFile = parseFileName(typed); })
      .serializedAs([&] { return scene::quotedText(settings.videoFile); });
  group.flag("--no-video", settings.video, "no video", false);
  addPaceOptions(group, settings);
  group
      .value("--title", "TEXT", "", "a card before the video, 2 s; \\n begins a new line",
             [&](const scene::TypedValue& typed) { settings.title = withLineFeeds(typed.text); })
      .serializedAs([&] { return scene::quotedText(settings.title); });
  group
      .value("--subtitle", "TEXT", "", "smaller lines below the title",
             [&](const scene::TypedValue& typed) { settings.subtitle = withLineFeeds(typed.text); })
      .serializedAs([&] { return scene::quotedText(settings.subtitle); });
  group.flag("--progress-bar", settings.progressBar,
             "a bar under the frames that fills with the motion");
  group
      .value("--inset", "CURVE", "none",
             "a curve in a corner of the frames, with a dot at their time: target_error, radius, "
             "theta, ..., as in kirireel curves --curves",
             [&](const scene::TypedValue& typed) { settings.inset = typed.text; })
      .serializedAs([&] { return scene::quotedText(settings.inset); });
  group
      .value("--crf", "NUMBER", "18 H.264, 24 VP9", "quality, 0 is best, to 51 (H.264) or 63 (VP9)",
             [&](const scene::TypedValue& typed) {
               settings.crf = static_cast<int>(scene::parseInteger(typed, {0, 63}));
             })
      .serializedAs([&] { return settings.crf ? fmt::format("{}", *settings.crf) : ""; });
  group
      .value("--preset", "WORD", settings.preset,
             "preset of x264: ultrafast to placebo (smallest file); auto is a quick veryfast",
             [&](const scene::TypedValue& typed) { settings.preset = typed.text; })
      .serializedAs([&] { return scene::quotedText(settings.preset); });
  group
      .value("--encoder", "NAME", "by the format", "another encoder of FFmpeg's libavcodec",
             [&](const scene::TypedValue& typed) { settings.encoder = typed.text; })
      .serializedAs([&] { return scene::quotedText(settings.encoder); });
}

}  // namespace kirireel::cli
