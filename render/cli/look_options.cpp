#include "render/cli/look_options.h"

#include <cmath>

#include <CLI/CLI.hpp>

#include "render/cli/option_group.h"

namespace kirireel {
namespace {

constexpr double kDegree = M_PI / 180;

/// PyBullet's first view, where one of yaw and pitch is given alone.
constexpr double kUsualYaw = 50 * kDegree;
constexpr double kUsualPitch = -35 * kDegree;

void addColourOptions(OptionGroup& group, Look& look) {
  group.choice<Colouring>("--colour", look.colouring,
                          {{"plain", Colouring::Plain},
                           {"shape", Colouring::Shape},
                           {"state", Colouring::State},
                           {"error", Colouring::TargetError},
                           {"displacement", Colouring::Displacement},
                           {"rotation", Colouring::Rotation},
                           {"gap", Colouring::JointGap}},
                          "what the bricks' colours say");
  group.choice<ColourMap>("--colour-map", look.map,
                          {{"viridis", ColourMap::Viridis}, {"cividis", ColourMap::Cividis}},
                          "scale of colours for a measure");
  group.value("--colour-most", "VALUE", "the largest to be expected",
              "value at the bright end of the scale, metres or degrees",
              [&look](const OptionValue& typed) {
                look.colourMost = parseNumber(typed, {1e-15, 1e12});
              });
  group.value("--brick-colour", "RRGGBB", "80AEDC", "of all bricks, with --colour plain",
              [&look](const OptionValue& typed) { look.brickColour = parseColour(typed); });
}

void addDrawingOptions(CLI::App& command, Look& look) {
  OptionGroup group(command, "Look");
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
  group.flag("--transparent", "no background in PNG files", [&look] { look.transparent = true; });
  group.flag("--no-outlines", "no lines on the edges of tiles", [&look] { look.outlines = false; });
  group.flag("--mark-joints", "a dot on each joint", [&look] { look.jointMarks = true; });
  group.flag("--target-lines", "the target's tiles as lines over everything",
             [&look] { look.targetLines = true; });
}

void addViewOptions(OptionGroup& group, CameraChoice& camera) {
  group.choice<std::optional<ViewAngles>>(
      "--view", camera.view,
      {{"auto", std::nullopt},
       {"top", kTopView},
       {"front", kFrontView},
       {"iso", kIsometricView},
       {"oblique", kObliqueView}},
      "where the camera stands, auto is top for a flat model, else iso");
  const auto usual = [&camera] {
    if (!camera.view) camera.view = viewFromYawPitch(kUsualYaw, kUsualPitch);
  };
  group.value("--yaw", "DEGREES", "50 with --pitch",
              "turns the camera about z, 0 is from the front, as in PyKirigami",
              [&camera, usual](const OptionValue& typed) {
                usual();
                const double yaw = parseNumber(typed, {-3600, 3600}) * kDegree;
                camera.view->azimuth = viewFromYawPitch(yaw, 0).azimuth;
              });
  group.value("--pitch", "DEGREES", "-35 with --yaw",
              "-90 is from above, 0 from the side, as in PyKirigami",
              [&camera, usual](const OptionValue& typed) {
                usual();
                const double pitch = parseNumber(typed, {-90, 90}) * kDegree;
                camera.view->elevation = viewFromYawPitch(0, pitch).elevation;
              });
}

void addCameraOptions(CLI::App& command, Look& look) {
  OptionGroup group(command, "Camera");
  CameraChoice& camera = look.camera;
  addViewOptions(group, camera);
  group.choice<std::optional<bool>>(
      "--projection", camera.orthographic,
      {{"auto", std::nullopt}, {"parallel", true}, {"perspective", false}},
      "auto is parallel from the top and the front, else perspective");
  group.number("--zoom", camera.zoom, {1e-3, 1e3}, "FACTOR", "enlarges the middle");
  group.number("--margin", camera.margin, {0, 0.45}, "SHARE",
               "of the picture left free on each side");
  group.value("--distance", "METRES", "as it fits", "of the eye, in perspective",
              [&camera](const OptionValue& typed) {
                camera.distance = parseNumber(typed, {1e-9, 1e12});
              });
  group.choice<FitScope>(
      "--fit", look.fit,
      {{"auto", FitScope::Auto}, {"run", FitScope::Run}, {"ends", FitScope::Ends}},
      "what stays in sight, the whole run or its start and target");
  group.value("--orbit", "DEGREES", "0", "the camera turns about z over the run",
              [&camera](const OptionValue& typed) {
                camera.orbit = parseNumber(typed, {-36000, 36000}) * kDegree;
              });
  group.value("--camera-keys", "TIME:YAW:PITCH:ZOOM,...", "",
              "the camera passes here at these times (seconds, degrees)",
              [&camera](const OptionValue& typed) { camera.keys = parseCameraKeys(typed); });
}

}  // namespace

void addLookOptions(CLI::App& command, Look& look) {
  addDrawingOptions(command, look);
  addCameraOptions(command, look);
}

}  // namespace kirireel
