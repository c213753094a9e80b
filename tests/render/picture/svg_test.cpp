#include <cstdlib>

#include <gtest/gtest.h>

#include "render/picture/canvas.h"
#include "render/picture/painter.h"
#include "render/picture/png.h"
#include "sim/base/files.h"
#include "tests/render/picture/sample_bricks.h"
#include "tests/support/files.h"
#include "tests/support/png.h"
#include "tests/support/polygons.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

constexpr picture::FrameSize kSize = {480, 320};

struct Scenery {
  SampleBricks sample;
  picture::Style style;
  picture::PictureItems items;
  picture::Camera camera;

  explicit Scenery(SampleBricks bricks, const picture::CameraFit& fit = {})
      : sample(std::move(bricks)) {
    items.poses = sample.poses;
    picture::CameraFit fitted = fit;
    fitted.aspect = kSize.aspect();
    camera = picture::fitCamera(picture::brickCorners(sample.bricks, sample.poses), fitted);
  }

  picture::Frame painted() const {
    return picture::Painter(kSize, sample.bricks, style).paint(items, camera);
  }

  std::string svg() const {
    picture::PictureGeometry geometry;
    picture::GeometryBuilder(sample.bricks, style).draw(items, camera, geometry);
    const std::unique_ptr<picture::Canvas> page =
        picture::makeCanvas(picture::PageFormat::Svg,
                            {.size = kSize,
                             .background = style.background,
                             .outlines = {.colour = style.edge,
                                          .slitWidth = style.slitWidth * kSize.height,
                                          .silhouetteWidth = style.silhouetteWidth * kSize.height},
                             .fontFamily = "DejaVu Sans"});
    picture::drawGeometry(geometry, camera, kSize, {0, 0}, "", *page);
    return page->finish();
  }
};

/// The SVG as librsvg draws it.
picture::Frame rasterised(const std::string& svg) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "figure.svg", svg);
  const std::string command = "rsvg-convert " + (folder / "figure.svg").string() + " -o " +
                              (folder / "figure.png").string();
  EXPECT_EQ(std::system(command.c_str()), 0);
  return test::readPng(folder / "figure.png");
}

struct Difference {
  double mean = 0;   ///< levels
  double share = 0;  ///< of the pixels that differ by more than 40 levels in a channel
};

Difference difference(const picture::Frame& a, const picture::Frame& b) {
  Difference result;
  for (std::size_t pixel = 0; pixel < a.pixels.size(); pixel += 4) {
    int largest = 0;
    for (int k = 0; k < 4; ++k) {
      const int levels = std::abs(a.pixels[pixel + k] - b.pixels[pixel + k]);
      largest = std::max(largest, levels);
      result.mean += levels;
    }
    result.share += largest > 40 ? 1 : 0;
  }
  const double pixels = static_cast<double>(a.pixels.size()) / 4;
  return {result.mean / (4 * pixels), result.share / pixels};
}

class SvgAgainstPainter : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::hasProgram("rsvg-convert")) {
      GTEST_SKIP() << "no rsvg-convert here; scripts/setup --with-tools installs librsvg2-bin";
    }
  }

  static Difference differenceOf(const Scenery& scenery) {
    const picture::Frame drawn = rasterised(scenery.svg());
    const picture::Frame painted = scenery.painted();
    EXPECT_EQ(drawn.size, painted.size);
    return difference(drawn, painted);
  }

  static void expectAlike(Scenery scenery) {
    const Difference withOutlines = differenceOf(scenery);
    EXPECT_LT(withOutlines.mean, 2);
    EXPECT_LT(withOutlines.share, 0.03);
    scenery.style.slitWidth = 0;
    const Difference faces = differenceOf(scenery);
    EXPECT_LT(faces.mean, 1);
    EXPECT_LT(faces.share, 0.012);
  }
};

TEST_F(SvgAgainstPainter, TurnedBricks) {
  expectAlike(Scenery(tumbledBricks()));
}

TEST_F(SvgAgainstPainter, BricksThatCross) {
  SampleBricks sample = tumbledBricks();
  for (Pose& pose : sample.poses) pose.position *= 0.4;
  expectAlike(Scenery(sample));
}

TEST_F(SvgAgainstPainter, ConcaveBricks) {
  SampleBricks sample = sampleBricks({test::starShape(5, 2, 0.7), test::lShape(3, 1, 2, 0)}, 0.3);
  sample.poses[1].rotation = rotationFromVector(Vector3(0.4, 0.2, 0.3));
  expectAlike(Scenery(sample));
}

TEST_F(SvgAgainstPainter, TranslucentBricks) {
  Scenery scenery(tumbledBricks());
  for (std::size_t k = 0; k < scenery.sample.bricks.size(); ++k) {
    scenery.items.colours.push_back(
        picture::withOpacity(scenery.style.brick, std::array{1.0, 0.5, 0.0, 0.3}[k % 4]));
  }
  expectAlike(scenery);
}

/// Three beams, each above the next and below the previous one: no order of whole faces is right.
TEST_F(SvgAgainstPainter, BeamsInACircle) {
  const SampleBricks flat = sampleBricks(
      {rectangleTile(0, 0, 4, 0.4), rectangleTile(0, 0, 4, 0.4), rectangleTile(0, 0, 4, 0.4)}, 0.1);
  SampleBricks sample = flat;
  for (int k = 0; k < 3; ++k) {
    const Quaternion turn = rotationFromVector(Vector3(0, 0, 2 * M_PI / 3 * k));
    sample.poses[k].position = turn * Vector3(0.4, 0.7, 0);
    sample.poses[k].rotation = turn * rotationFromVector(Vector3(0, 0.12, 0));
  }
  picture::CameraFit fit;
  fit.view = picture::kTopView;
  expectAlike(Scenery(sample, fit));
}

TEST_F(SvgAgainstPainter, GroundShadowDotsAndLines) {
  Scenery scenery(tumbledBricks());
  scenery.style.plate =
      picture::groundUnder(picture::brickCorners(scenery.sample.bricks, scenery.sample.poses), -1);
  scenery.items.marks = {Vector3(1, 1, 0.5), Vector3(3, 1, 0.5)};
  scenery.items.overlay = {rectangleTile(0, 0, 3, 2)};
  scenery.items.pinned = {5};
  expectAlike(scenery);
}

TEST_F(SvgAgainstPainter, TransparentPageWithShadow) {
  Scenery scenery(tumbledBricks());
  scenery.style.slitWidth = 0;
  scenery.style.background.alpha = 0;
  scenery.style.shadow = {0, 0, 0, 56};
  scenery.style.plate =
      picture::groundUnder(picture::brickCorners(scenery.sample.bricks, scenery.sample.poses), -1);
  scenery.style.plate->visible = false;
  const picture::Frame drawn = rasterised(scenery.svg());
  const picture::Frame painted = scenery.painted();
  // Colours of transparent pixels differ and have no meaning.
  double mean = 0;
  for (std::size_t alpha = 3; alpha < drawn.pixels.size(); alpha += 4) {
    mean += std::abs(drawn.pixels[alpha] - painted.pixels[alpha]);
  }
  // Measured 1.03: the ten steps of a soft shadow are blended in bytes, one over the other.
  EXPECT_LT(mean / (drawn.pixels.size() / 4.0), 1.2);
}

TEST_F(SvgAgainstPainter, FacesHaveTheVerySameColours) {
  const Scenery scenery(tumbledBricks());
  const picture::Frame drawn = rasterised(scenery.svg());
  const picture::Frame painted = scenery.painted();
  // If the painter's picture has one colour for two pixels around, librsvg has the same bytes,
  // except one or two levels where a face was cut.
  int flat = 0, equal = 0, near = 0;
  const auto isNear = [](picture::Colour a, picture::Colour b) {
    return std::abs(a.red - b.red) < 3 && std::abs(a.green - b.green) < 3 &&
           std::abs(a.blue - b.blue) < 3;
  };
  for (int y = 2; y < kSize.height - 2; ++y) {
    for (int x = 2; x < kSize.width - 2; ++x) {
      bool isFlat = true;
      for (int dy = -2; dy <= 2 && isFlat; ++dy) {
        for (int dx = -2; dx <= 2; ++dx) isFlat &= painted.at(x + dx, y + dy) == painted.at(x, y);
      }
      flat += isFlat ? 1 : 0;
      equal += isFlat && drawn.at(x, y) == painted.at(x, y) ? 1 : 0;
      near += isFlat && isNear(drawn.at(x, y), painted.at(x, y)) ? 1 : 0;
    }
  }
  EXPECT_GT(flat, 80000);
  EXPECT_GT(static_cast<double>(equal) / flat, 0.997);  // measured 0.9983
  EXPECT_GT(static_cast<double>(near) / flat, 0.9997);
}

TEST(Svg, IsTheSameEveryTime) {
  const Scenery scenery(tumbledBricks());
  EXPECT_EQ(scenery.svg(), scenery.svg());
}

TEST(Svg, HoldsOnlyWhatThePictureShows) {
  const std::string svg = Scenery(tumbledBricks()).svg();
  EXPECT_EQ(svg.find("ground"), std::string::npos);
  EXPECT_EQ(svg.find("shadow"), std::string::npos);
  EXPECT_EQ(svg.find("overlay"), std::string::npos);
  EXPECT_NE(svg.find("id=\"bricks\""), std::string::npos);
}

/// The outline of a concave face is also a closed line, which editors restyle with the others.
TEST(Svg, OutlinesOfConcaveFacesAreLines) {
  picture::CameraFit fit;
  fit.view = picture::kTopView;
  fit.orthographic = true;
  const Scenery scenery(sampleBricks({test::starShape(5, 2, 0.7), test::lShape(3, 1, 3, 0)}, 0.3),
                        fit);
  const std::string svg = scenery.svg();
  const std::string edge = "fill=\"#263242\"";  // the style's colour of outlines
  EXPECT_EQ(svg.find(edge), std::string::npos);
  // The ten corners of the star and the six of the L, each closed.
  std::vector<int> corners;
  std::size_t line = svg.find("<path class=\"outline");
  while (line != std::string::npos) {
    const std::string path = svg.substr(line, svg.find("/>", line) - line);
    EXPECT_EQ(path.back(), '"');
    EXPECT_EQ(path[path.size() - 2], 'Z') << path;
    EXPECT_EQ(std::ranges::count(path, 'M'), 1) << path;
    corners.push_back(static_cast<int>(std::ranges::count(path, 'L')) + 1);
    line = svg.find("<path class=\"outline", line + 1);
  }
  EXPECT_EQ(corners, (std::vector<int>{10, 6}));
}

/// A face drawn after an outline would cover the half of the line that lies on it.
TEST(Svg, OutlinesAreOverAllFaces) {
  Scenery scenery(tumbledBricks());
  const std::string svg = scenery.svg();
  const std::size_t layer = svg.find("<g id=\"outlines\"");
  ASSERT_NE(layer, std::string::npos);
  EXPECT_LT(svg.rfind("class=\"face\""), layer);
  EXPECT_GT(svg.find("<path class=\"outline"), layer);
  scenery.style.slitWidth = 0;
  EXPECT_EQ(scenery.svg().find("outlines"), std::string::npos);
}

// Oracle: the same page by Cairo.
TEST(Svg, OutlinesBelongToTheirPart) {
  if (!test::hasProgram("rsvg-convert")) GTEST_SKIP() << "install librsvg2-bin to draw SVG files";
  constexpr picture::Colour kBlack = {0, 0, 0}, kBlue = {0, 0, 255}, kWhite = {255, 255, 255};
  const picture::PageSettings settings = {.size = {60, 30},
                                          .outlines = {.colour = kBlack, .slitWidth = 2}};
  const auto drawn = [&](picture::PageFormat format) {
    const std::unique_ptr<picture::Canvas> page = picture::makeCanvas(format, settings);
    page->begin("blue");
    page->setOutlines({.colour = kBlue, .slitWidth = 8, .silhouetteWidth = 9});
    EXPECT_EQ(page->silhouetteWidth(), 9);
    page->begin("inner");
    page->outlines({{{10, 0}, {10, 30}}}, picture::Canvas::Line::Slit);
    page->end();
    page->end();
    page->begin("black");
    EXPECT_EQ(page->silhouetteWidth(), 1.5);
    page->outlines({{{40, 0}, {40, 30}}}, picture::Canvas::Line::Slit);
    page->end();
    return page->finish();
  };
  const test::TemporaryFolder folder;
  writeTextFile(folder / "page.png", drawn(picture::PageFormat::Png));
  for (const picture::Frame& frame :
       {rasterised(drawn(picture::PageFormat::Svg)), test::readPng(folder / "page.png")}) {
    EXPECT_EQ(frame.at(10, 15), kBlue);
    EXPECT_EQ(frame.at(12, 15), kBlue);
    EXPECT_EQ(frame.at(40, 15), kBlack);
    EXPECT_EQ(frame.at(43, 15), kWhite);
  }
}

}  // namespace
}  // namespace kirireel
