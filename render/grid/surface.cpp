// Boxes are drawn from the pixel nearest to their upper left corner to the one nearest to their
// lower right corner, each rounded by itself, so that boxes side by side neither overlap nor leave
// a gap. A font is loaded for each text; captions are few.
#include "render/grid/surface.h"

#include <algorithm>
#include <cmath>

#include "render/grid/label.h"

namespace kirireel {
namespace {

int nearestPixel(double length) {
  return static_cast<int>(std::lround(length));
}

}  // namespace

void FrameSurface::box(double left, double upper, double width, double height, Colour colour) {
  const int right = std::min(nearestPixel(left + width), frame_.size.width);
  const int lower = std::min(nearestPixel(upper + height), frame_.size.height);
  for (int y = std::max(nearestPixel(upper), 0); y < lower; ++y) {
    for (int x = std::max(nearestPixel(left), 0); x < right; ++x) frame_.set(x, y, colour);
  }
}

void FrameSurface::text(const std::string& line, double left, double baseline, int em,
                        Colour colour) {
  LabelWriter(em).draw(frame_, line, nearestPixel(left), nearestPixel(baseline), colour);
}

}  // namespace kirireel
