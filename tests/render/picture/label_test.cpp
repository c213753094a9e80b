#include "render/picture/label.h"

#include <cstdlib>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr picture::Colour kWhite{255, 255, 255};
constexpr picture::Colour kBlack{0, 0, 0};

/// The box of all pixels that are not white.
Eigen::AlignedBox2i inkBox(const picture::Frame& frame) {
  Eigen::AlignedBox2i box;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x) {
      if (frame.at(x, y) != kWhite) box.extend(Eigen::Vector2i(x, y));
    }
  }
  return box;
}

TEST(LabelWriter, StandsOnItsBaselineWithinItsWidth) {
  picture::Frame frame = picture::makeFrame({200, 60}, kWhite);
  const picture::LabelWriter writer(32);
  writer.draw(frame, "EHE", 20, 45, kBlack);
  const Eigen::AlignedBox2i box = inkBox(frame);
  EXPECT_EQ(box.max().y(), 44);  // the last row above the baseline
  // Capitals of DejaVu Sans are 0.729 em high.
  EXPECT_NEAR(box.sizes().y() + 1, 0.729 * 32, 1);
  EXPECT_GE(box.min().x(), 20);
  EXPECT_LT(box.max().x(), 20 + writer.width("EHE"));
}

TEST(LabelWriter, WidensWithTheText) {
  const picture::LabelWriter writer(20);
  EXPECT_EQ(writer.width(""), 0);
  EXPECT_NEAR(writer.width("mmmm"), 4 * writer.width("m"), 4);
  EXPECT_NEAR(picture::LabelWriter(40).width("t = 1.25 s"), 2 * writer.width("t = 1.25 s"), 5);
}

TEST(LabelWriter, ReadsUtf8) {
  const picture::LabelWriter writer(20);
  // In DejaVu Sans capital alpha looks like A, and a letter with an accent is as wide as without.
  picture::Frame greek = picture::makeFrame({60, 40}, kWhite);
  picture::Frame latin = greek;
  writer.draw(greek, "\u0391", 10, 30, kBlack);
  writer.draw(latin, "A", 10, 30, kBlack);
  EXPECT_EQ(greek.pixels, latin.pixels);
  EXPECT_EQ(writer.width("\u00e9\u00fc"), writer.width("eu"));
  EXPECT_GT(writer.width("30\u00b0"), writer.width("30"));
  EXPECT_LT(writer.width("30\u00b0"), writer.width("30") + 20);  // one sign, not two bytes
}

TEST(LabelWriter, KnowsWhichGlyphsItsFontLacks) {
  const picture::LabelWriter writer(20);
  EXPECT_FALSE(writer.missingGlyph(U"Caf\u00e9 30\u00b0 \u03b1\u03a9 \u00e4\u00f6\u00fc"));
  EXPECT_EQ(writer.missingGlyph(U"a\u4e2d\u6587"), U'\u4e2d');
  EXPECT_NO_THROW(writer.width("\xff"));  // not UTF-8: the font's box
}

TEST(LabelWriter, CutsTextAtTheFrame) {
  picture::Frame frame = picture::makeFrame({30, 20}, kWhite);
  EXPECT_NO_THROW(picture::LabelWriter(40).draw(frame, "Wide text", -20, 25, kBlack));
  EXPECT_FALSE(inkBox(frame).isEmpty());
}

TEST(LabelWriter, WritesOnATransparentPicture) {
  picture::Frame frame = picture::makeFrame({60, 60}, {255, 255, 255, 0});
  picture::LabelWriter(50).draw(frame, "H", 5, 50, kBlack);
  const Eigen::AlignedBox2i box = inkBox(frame);
  const int middle = (box.min().y() + box.max().y()) / 2;
  EXPECT_EQ(frame.at(30 - 5, middle).alpha, 255);  // the bar of the H
  EXPECT_EQ(frame.at(0, 0).alpha, 0);
}

TEST(LabelWriter, SaysHowToGetAFont) {
  ::setenv("KIRIREEL_FONT", "/nowhere/font.ttf", 1);
  try {
    const picture::LabelWriter writer(20);
    ADD_FAILURE();
  } catch (const OutputError& error) {
    EXPECT_STREQ(error.what(),
                 "/nowhere/font.ttf: error: cannot be used as a font; install Debian's "
                 "fonts-dejavu-core or set KIRIREEL_FONT to a TrueType file");
  }
  ::unsetenv("KIRIREEL_FONT");
}

TEST(Font, IsFoundByItsFamily) {
  picture::setFont("dejavu sans");
  EXPECT_EQ(picture::findFont().filename(), "DejaVuSans.ttf");
  EXPECT_EQ(picture::fontFamily(), "DejaVu Sans");
  picture::setFont("");
}

TEST(Font, ThatIsMissingIsNamedWithTheNearest) {
  try {
    picture::setFont("No Such Font");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                ::testing::StartsWith("error: this machine has no font \"No Such Font\"; install "
                                      "it, or give a family from fc-list, the nearest is "));
  }
}

}  // namespace
}  // namespace kirireel
