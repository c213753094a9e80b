/// The lower bound of the painter: a loop that draws the same triangles from a buffer filled once,
/// averages the same samples and reads them back.
#pragma once

#include <memory>
#include <vector>

#include "render/picture/camera.h"
#include "render/picture/frame.h"
#include "sim/brick/brick.h"

namespace kirireel::bench {

/// Of every picture of this benchmark, pixels.
inline constexpr picture::FrameSize kSize = {1280, 720};

/// Half-open squares, seen from a corner.
struct PaintedSheet {
  std::vector<brick::Brick> bricks;
  Poses poses;
  picture::Camera camera;

  explicit PaintedSheet(int side);
};

/// Use it only in the thread that makes it.
class BareLoop {
 public:
  explicit BareLoop(const PaintedSheet& sheet);
  ~BareLoop();
  BareLoop(const BareLoop&) = delete;
  BareLoop& operator=(const BareLoop&) = delete;

  /// Draws and reads a picture.
  void frame();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kirireel::bench
