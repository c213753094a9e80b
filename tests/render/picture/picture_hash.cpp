/// Prints a hash of a picture, for a test that compares processes with different environments. Use:
/// picture_hash [egl]
#include <cstdint>
#include <cstdio>
#include <string_view>

#include "render/picture/gl_context.h"
#include "render/picture/painter.h"
#include "tests/render/picture/sample_bricks.h"

int main(int count, char** arguments) {
  using namespace kirireel;
  if (count > 1 && std::string_view(arguments[1]) == "egl") {
    picture::setGraphicsLibrary(picture::GraphicsLibrary::Egl);
  }
  const SampleBricks sample = tumbledBricks();
  const picture::FrameSize size{640, 360};
  picture::CameraFit fit;
  fit.aspect = size.aspect();
  const picture::Camera camera =
      picture::fitCamera(picture::brickCorners(sample.bricks, sample.poses), fit);
  picture::Style style;
  style.plate = picture::groundUnder(picture::brickCorners(sample.bricks, sample.poses), -1);
  const picture::Frame frame =
      picture::Painter(size, sample.bricks, style).paint(sample.poses, camera);
  std::uint64_t hash = 14695981039346656037U;  // FNV-1a
  for (const std::uint8_t byte : frame.pixels) hash = (hash ^ byte) * 1099511628211U;
  std::printf("%016llx\n", static_cast<unsigned long long>(hash));
}
