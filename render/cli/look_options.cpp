// Options of colours, drawing and camera. Angles are typed in degrees and kept in radians; lengths
// are metres. A typed value is written back (saidAs) as the shortest number that reads to the same
// double, so that a scene file made from an order gives the same pictures to the last bit.
//
// Two ways to say a view write into one place: --view with a word or azimuth and elevation, and
// --yaw and --pitch as PyKirigami has them, where yaw 0 looks from the front and pitch -90 from
// above (PyBullet's resetDebugVisualizerCamera). The later of two counts. Written back is the word
// where there is one, else yaw and pitch.
#include "render/cli/look_options.h"

#include <cmath>

#include <CLI/CLI.hpp>

#include "render/cli/option_group.h"
#include "sim/base/geometry.h"

namespace kirireel {
namespace {

/// PyBullet's first view, where one of yaw and pitch is given alone.
constexpr double kUsualYaw = 50 * kDegree;
constexpr double kUsualPitch = -35 * kDegree;

/// "" where the colour is that of the theme.
std::string saidColour(const std::optional<Colour>& colour) {
  return colour ? colourText(*colour) : "";
}

/// Colours are names of CSS or six hexadecimal digits.
void addColourOptions(OptionGroup& group, Look& look) {
  // Measures of single bricks are coloured by a scale, "plain" and "shape" need none.
  group.choice<Colouring>("--colour", look.colouring,
                          {{"plain", Colouring::Plain},
                           {"shape", Colouring::Shape},
                           {"state", Colouring::State},
                           {"error", Colouring::TargetError},
                           {"displacement", Colouring::Displacement},
                           {"rotation", Colouring::Rotation},
                           {"gap", Colouring::JointGap},
                           {"moment", Colouring::Moment},
                           {"energy", Colouring::Energy}},
                          "what the bricks' colours say");
  group.choice<ColourMap>("--colour-map", look.map,
                          {{"viridis", ColourMap::Viridis},
                           {"cividis", ColourMap::Cividis},
                           {"coolwarm", ColourMap::CoolWarm}},
                          "scale of colours for a measure, coolwarm is a diverging one");
  group
      .value("--colour-least", "VALUE", "0", "value at the first end of the scale",
             [&look](const TypedValue& typed) {
               look.colourLeast = parseNumber(typed, {-1e12, 1e12});
             })
      .saidAs([&look] { return look.colourLeast ? numberText(*look.colourLeast) : ""; });
  group
      .value("--colour-most", "VALUE", "the largest of the run",
             "value at the other end of the scale, in the unit of the measure",
             [&look](const TypedValue& typed) {
               look.colourMost = parseNumber(typed, {1e-15, 1e12});
             })
      .saidAs([&look] { return look.colourMost ? numberText(*look.colourMost) : ""; });
  group
      .value("--brick-colour", "COLOUR", "80AEDC",
             "of all bricks, with --colour plain; a name such as teal, or RRGGBB",
             [&look](const TypedValue& typed) { look.brickColour = parseColour(typed); })
      .saidAs([&look] { return saidColour(look.brickColour); });
  group
      .value("--back-colour", "COLOUR", "F4BE74", "of their other side, with --colour plain",
             [&look](const TypedValue& typed) { look.backColour = parseColour(typed); })
      .saidAs([&look] { return saidColour(look.backColour); });
  group
      .values(
          "--tile-colour", "TILES=COLOUR",
          "of some tiles, as in 3,7,10-15=teal; with --colour plain, shape or state",
          [&look](const TypedValue& typed) { look.tileColours.push_back(parseTileColour(typed)); })
      .saidAs([&look] { return tileColoursText(look.tileColours); });
  group
      .value("--outline-colour", "COLOUR", "263242", "of the lines on the edges of tiles",
             [&look](const TypedValue& typed) { look.outlineColour = parseColour(typed); })
      .saidAs([&look] { return saidColour(look.outlineColour); });
  group
      .value("--background", "COLOUR", "that of --theme", "of the page",
             [&look](const TypedValue& typed) { look.background = parseColour(typed); })
      .saidAs([&look] { return saidColour(look.background); });
}

/// What decides a picture but not its camera.
void addDrawingOptions(CLI::App& command, Look& look) {
  OptionGroup group(command, "Look", "style");
  group.choice<Theme>("--theme", look.theme, {{"light", Theme::Light}, {"dark", Theme::Dark}},
                      "page that the pictures are for");
  addColourOptions(group, look);
  group.choice<GroundLook>(
      "--ground-look", look.ground,
      {{"auto", GroundLook::Auto},
       {"plate", GroundLook::Plate},
       {"shadow", GroundLook::Shadow},
       {"none", GroundLook::None}},
      "under the bricks, auto is a plate with a shadow when there is a ground");
  group.flag("--transparent", look.transparent, "no background in PNG files");
  group.flag("--no-outlines", look.outlines, "no lines on the edges of tiles", false);
  group.number("--outline-width", look.outlineWidth, {0.1, 20}, "FACTOR",
               "of the lines on the edges of tiles, times the usual");
  group.flag("--mark-joints", look.jointMarks, "a dot on each joint");
  group.flag("--target-lines", look.targetLines,
             "the target's tiles as lines, dashed where bricks hide them");
  group
      .value("--occlusion", "SHARE", "0.6",
             "brightness that creases and gaps between bricks lose, 0 to 1; in part where colours "
             "stand for values",
             [&look](const TypedValue& typed) {
               look.occlusion = parseNumber(typed, {0, 1});
             })
      .saidAs([&look] { return look.occlusion ? numberText(*look.occlusion) : ""; });
}

/// One of the words, or "45,30".
std::optional<ViewAngles> parseView(const TypedValue& value,
                                    const Choices<std::optional<ViewAngles>>& views) {
  // Words have no comma.
  const std::size_t comma = value.text.find(',');
  if (comma == std::string::npos) return parseChoice(value, views);
  const auto degrees = [&value](const std::string& text, double most) {
    return parseNumber({value.name, text}, {-most, most}) * kDegree;
  };
  // Azimuth may be any number of turns, elevation is from -90 to 90 degrees.
  return ViewAngles{degrees(value.text.substr(0, comma), 3600),
                    degrees(value.text.substr(comma + 1), 90)};
}

/// `views` is kept by the readers, so it is copied into each.
void addViewOptions(OptionGroup& group, CameraChoice& camera) {
  const Choices<std::optional<ViewAngles>> views = {
      {"auto", std::nullopt}, {"top", kTopView},       {"bottom", kBottomView},
      {"front", kFrontView},  {"back", kBackView},     {"side", kRightView},
      {"left", kLeftView},    {"iso", kIsometricView}, {"oblique", kObliqueView}};
  group
      .value("--view", "WORD|AZ,EL", "auto",
             fmt::format("where the camera stands: {}, auto is top for a flat model, else iso; or "
                         "azimuth and elevation in degrees, -90,0 is from the front, -90,90 from "
                         "above",
                         listWords(choiceNames(views))),
             [&camera, views](const TypedValue& typed) { camera.view = parseView(typed, views); })
      .saidAs([&camera, views] { return quotedText(nameOfChoice(views, camera.view)); });
  // A view with a name is said by that.
  const auto angles = [&camera, views]() -> std::optional<TypedView> {
    return nameOfChoice(views, camera.view).empty() ? std::optional(typedView(*camera.view))
                                                    : std::nullopt;
  };
  // The first of --yaw and --pitch sets both to PyBullet's start, so that one alone means what it
  // does there.
  const auto usual = [&camera] {
    if (!camera.view) camera.view = viewFromYawPitch(kUsualYaw, kUsualPitch);
  };
  group
      .value("--yaw", "DEGREES", "50 with --pitch",
             "turns the camera about z, 0 is from the front, as in PyKirigami",
             [&camera, usual](const TypedValue& typed) {
               usual();
               // viewFromYawPitch turns both; only the one that was typed is taken over.
               const double yaw = parseNumber(typed, {-3600, 3600}) * kDegree;
               camera.view->azimuth = viewFromYawPitch(yaw, 0).azimuth;
             })
      .saidAs([angles] { return angles() ? numberText(angles()->yaw) : ""; });
  group
      .value("--pitch", "DEGREES", "-35 with --yaw",
             "-90 is from above, 0 from the side, as in PyKirigami",
             [&camera, usual](const TypedValue& typed) {
               usual();
               const double pitch = parseNumber(typed, {-90, 90}) * kDegree;
               camera.view->elevation = viewFromYawPitch(0, pitch).elevation;
             })
      .saidAs([angles] { return angles() ? numberText(angles()->pitch) : ""; });
}

/// Lengths in metres, angles in degrees.
void addCameraOptions(CLI::App& command, Look& look) {
  OptionGroup group(command, "Camera", "camera");
  CameraChoice& camera = look.camera;
  addViewOptions(group, camera);
  group.choice<std::optional<bool>>(
      "--projection", camera.orthographic,
      {{"auto", std::nullopt}, {"parallel", true}, {"perspective", false}},
      "auto is parallel along an axis, else perspective");
  group.number("--zoom", camera.zoom, {1e-3, 1e3}, "FACTOR", "enlarges the middle");
  group.number("--margin", camera.margin, {0, 0.45}, "SHARE",
               "of the picture left free on each side");
  group
      .value("--distance", "METRES", "as it fits", "of the eye, in perspective",
             [&camera](const TypedValue& typed) {
               camera.distance = parseNumber(typed, {1e-9, 1e12});
             })
      .saidAs([&camera] { return camera.distance ? numberText(*camera.distance) : ""; });
  group.choice<FitScope>(
      "--fit", look.fit,
      {{"auto", FitScope::Auto}, {"run", FitScope::Run}, {"ends", FitScope::Ends}},
      "what stays in sight, the whole run or its start and target");
  group
      .value("--orbit", "DEGREES", "0", "the camera turns about z over the run",
             [&camera](const TypedValue& typed) {
               camera.orbit = parseNumber(typed, {-36000, 36000}) * kDegree;
             })
      .saidAs([&camera] {
        return numberText(numberReadAs(camera.orbit, camera.orbit / kDegree,
                                       [](double degrees) { return degrees * kDegree; }));
      });
  group
      .value("--camera-keys", "TIME:YAW:PITCH:ZOOM,...", "",
             "the camera passes here at these times (seconds, degrees)",
             [&camera](const TypedValue& typed) { camera.keys = parseCameraKeys(typed); })
      .saidAs([&camera] { return cameraKeysText(camera.keys); });
}

}  // namespace

void addLookOptions(CLI::App& command, Look& look) {
  addDrawingOptions(command, look);
  addCameraOptions(command, look);
}

}  // namespace kirireel
