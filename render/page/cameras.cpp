// A page's canvas may have any shape, but a camera that shows the whole run depends on it. So for
// each view five cameras are computed here, by the fit of our own pictures, and the page takes the
// widest whose aspect its canvas holds; a wider canvas shows more at the sides.
//
// A camera is eye, centre and up (metres, world axes) with either the vertical field of view
// (radians) or the height of what is in sight (metres).
#include "render/page/cameras.h"

#include <array>
#include <utility>

namespace kirireel {
namespace {

/// Sizes whose aspects canvases are taken for: a telephone upright to a wide screen. The last is
/// that of our pictures.
constexpr std::array<FrameSize, 5> kSizes = {
    {{450, 800}, {600, 800}, {800, 800}, {800, 600}, {1280, 720}}};

/// Metres and radians.
Json cameraJson(const Camera& camera, double aspect) {
  return {{"aspect", aspect},
          {"eye", vectorJson(camera.eye)},
          {"centre", vectorJson(camera.centre)},
          {"up", vectorJson(camera.up)},
          {"orthographic", camera.orthographic},
          {"field_of_view", camera.fieldOfView},
          {"view_height", camera.viewHeight}};
}

/// From the narrowest canvas to the widest.
Json viewJson(const char* name, const Look& look, const Motif& motif) {
  Json fits = Json::array();
  for (const FrameSize size : kSizes) {
    const Stage stage(look, motif, size);
    fits.push_back(cameraJson(stage.camera({0, motif.start, {}}), size.aspect()));
  }
  return {{"name", name}, {"fits", std::move(fits)}};
}

}  // namespace

Json camerasJson(const Look& look, const Motif& motif) {
  Json views = {viewJson("Usual", look, motif)};
  const std::pair<const char*, ViewAngles> others[] = {
      {"Top", kTopView}, {"Front", kFrontView}, {"Side", kRightView}, {"Corner", kIsometricView}};
  for (const auto& [name, view] : others) {
    Look other = look;
    other.camera.view = view;
    views.push_back(viewJson(name, other, motif));
  }
  return views;
}

}  // namespace kirireel
