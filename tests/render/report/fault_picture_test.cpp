#include <cmath>

#include <gtest/gtest.h>

#include "render/picture/style.h"
#include "render/report/inspection.h"

namespace kirireel {
namespace {

bool isNear(const picture::Colour& a, const picture::Colour& b) {
  constexpr int kShade = 25;
  return std::abs(a.red - b.red) < kShade && std::abs(a.green - b.green) < kShade &&
         std::abs(a.blue - b.blue) < kShade;
}

// A rectangle of 4 x 2 m with the fault at a quarter of its width and three quarters of its height.
TEST(FaultPicture, HasADotAtTheFault) {
  formats::DrawnPath outline;
  outline.points = {{0, 0}, {4, 0}, {4, 2}, {0, 2}};
  outline.isClosed = true;
  formats::DrawnPath slit;
  slit.points = {{3, 0}, {3, 1}};
  const formats::DrawingFault fault(InputError("error"), {outline, slit}, {{1, 1.5}});
  constexpr int kSize = 1200;  // lines are some pixels wide
  const picture::Frame frame = report::faultPicture(fault, {kSize, kSize});
  const picture::Style style;
  Eigen::AlignedBox2d lines;
  Eigen::Vector2d dots(0, 0);
  int count = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const Eigen::Vector2d at(x, -y);
      if (isNear(frame.at(x, y), style.edge)) lines.extend(at);
      if (!isNear(frame.at(x, y), style.mark)) continue;
      dots += at;
      ++count;
    }
  }
  ASSERT_GT(count, 200);  // 0.03 of the picture wide
  const Eigen::Vector2d share = (dots / count - lines.min()).cwiseQuotient(lines.sizes());
  EXPECT_NEAR(share.x(), 0.25, 0.02);
  EXPECT_NEAR(share.y(), 0.75, 0.02);
  EXPECT_NEAR(lines.sizes().x() / lines.sizes().y(), 2, 0.1);
}

}  // namespace
}  // namespace kirireel
