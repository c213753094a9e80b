#include "render/picture/shape_raster.h"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

constexpr picture::FrameSize kShapeFrame = {50, 45};
constexpr picture::Colour kPaper = {255, 255, 255};
constexpr picture::Colour kInk = {0, 0, 0};

using PolygonCorners = std::vector<Eigen::Vector2d>;

picture::Frame drawShape(const std::vector<PolygonCorners>& polygons, picture::Colour colour = kInk,
                         picture::Colour background = kPaper) {
  picture::ShapeRaster raster;
  raster.clear(kShapeFrame);
  raster.begin(colour);
  for (const PolygonCorners& corners : polygons) raster.add(corners);
  picture::Frame frame = picture::makeFrame(kShapeFrame, background);
  raster.draw(frame);
  return frame;
}

/// Covered area, pixels.
double coveredArea(const picture::Frame& frame) {
  double sum = 0;
  for (std::size_t k = 0; k < frame.pixels.size(); k += 4) sum += 1 - frame.pixels[k] / 255.0;
  return sum;
}

PolygonCorners regularCorners(const Eigen::Vector2d& centre, double radius, int sides,
                              double turn) {
  PolygonCorners corners;
  for (int k = 0; k < sides; ++k) {
    const double angle = turn + 2 * M_PI * k / sides;
    corners.emplace_back(centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return corners;
}

// Closed form: the area of a regular polygon. Sizes from below a pixel to most of the picture.
TEST(ShapeRaster, CoversTheAreaOfPolygons) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0, 1);
  for (int sides = 3; sides < 9; ++sides) {
    for (const double radius : {0.4, 2.0, 20.0}) {
      for (int trial = 0; trial < 20; ++trial) {
        const Eigen::Vector2d centre(24 + share(random), 22 + share(random));
        const double area = 0.5 * sides * radius * radius * std::sin(2 * M_PI / sides);
        const double covered =
            coveredArea(drawShape({regularCorners(centre, radius, sides, 7 * share(random))}));
        // A side is 1/32 pixel off at most, if it crosses many pixels.
        const double perimeter = 2 * sides * radius * std::sin(M_PI / sides);
        EXPECT_NEAR(covered, area, perimeter / 32) << sides << ' ' << radius;
      }
    }
  }
}

/// A line of half a point in a video of 1280 pixels, 160 mm wide.
TEST(ShapeRaster, LinesAreEquallyWideInAllDirections) {
  constexpr double kWidth = 1.411, kLength = 30;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(0, 1);
  for (int degrees = 0; degrees < 180; degrees += 5) {
    const double angle = degrees * M_PI / 180;
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d across = 0.5 * kWidth * Eigen::Vector2d(-along.y(), along.x());
    for (int trial = 0; trial < 20; ++trial) {
      const Eigen::Vector2d centre(24 + share(random), 22 + share(random));
      const Eigen::Vector2d from = centre - 0.5 * kLength * along, to = from + kLength * along;
      const double covered =
          coveredArea(drawShape({{from - across, to - across, to + across, from + across}}));
      EXPECT_NEAR(covered / kLength / kWidth, 1, 0.04) << degrees;  // 1/32 pixel is 0.022
    }
  }
}

TEST(ShapeRaster, MixesOverlapsOfOneShapeOnce) {
  const PolygonCorners square = {{10, 10}, {30, 10}, {30, 30}, {10, 30}};
  const PolygonCorners turned = {{10, 20}, {20, 10}, {30, 20}, {20, 30}};
  const picture::Frame frame = drawShape({square, turned, square}, {0, 0, 0, 128});
  EXPECT_EQ(frame.at(20, 20).red, 127);
  EXPECT_EQ(frame.at(11, 11).red, 127);
  EXPECT_EQ(frame.at(9, 11).red, 255);
}

TEST(ShapeRaster, DrawsShapesInTheirOrder) {
  const PolygonCorners square = {{10, 10}, {30, 10}, {30, 30}, {10, 30}};
  picture::ShapeRaster raster;
  picture::Frame frame = picture::makeFrame(kShapeFrame, kPaper);
  raster.clear(kShapeFrame);
  for (const picture::Colour colour : {picture::Colour{10, 20, 30}, {90, 80, 70}}) {
    raster.begin(colour);
    raster.add(square);
  }
  raster.draw(frame);
  EXPECT_EQ(frame.at(20, 20), (picture::Colour{90, 80, 70}));
  raster.clear(kShapeFrame);
  raster.begin(kInk);
  raster.draw(frame);
  EXPECT_EQ(frame.at(20, 20), (picture::Colour{90, 80, 70}));
}

TEST(ShapeRaster, ClipsShapesAtBorders) {
  EXPECT_EQ(coveredArea(drawShape({{{-100, -100}, {200, -100}, {200, 200}, {-100, 200}}})),
            50 * 45);
  EXPECT_EQ(coveredArea(drawShape({{{-100, 44}, {200, 44}, {200, 1e9}, {-100, 1e9}}})), 50);
  EXPECT_EQ(
      coveredArea(drawShape({{{60, 10}, {70, 10}, {70, 30}}, {{10, -30}, {20, -30}, {20, -9}}})),
      0);
}

TEST(ShapeRaster, KeepsTheColourOnTransparentPages) {
  const PolygonCorners half = {{10, 10}, {30.5, 10}, {30.5, 30}, {10, 30}};
  const picture::Frame frame = drawShape({half}, {40, 50, 60}, {255, 255, 255, 0});
  EXPECT_EQ(frame.at(20, 20), (picture::Colour{40, 50, 60}));
  EXPECT_EQ(frame.at(30, 20), (picture::Colour{40, 50, 60, 128}));
  EXPECT_EQ(frame.at(31, 20).alpha, 0);
}

}  // namespace
}  // namespace kirireel
