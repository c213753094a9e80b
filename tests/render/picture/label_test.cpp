#include "render/picture/label.h"

#include <cstdlib>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/render/picture/colours.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using test::kBlack;
using test::kWhite;

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

TEST(LabelWriter, WritesOnItsBaselineWithinItsWidth) {
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
  // In DejaVu Sans capital alpha has the shape of A, and a letter with an accent has the width of
  // the letter.
  picture::Frame greek = picture::makeFrame({60, 40}, kWhite);
  picture::Frame latin = greek;
  writer.draw(greek, "\u0391", 10, 30, kBlack);
  writer.draw(latin, "A", 10, 30, kBlack);
  EXPECT_EQ(greek.pixels, latin.pixels);
  EXPECT_EQ(writer.width("\u00e9\u00fc"), writer.width("eu"));
  EXPECT_GT(writer.width("30\u00b0"), writer.width("30"));
  EXPECT_LT(writer.width("30\u00b0"), writer.width("30") + 20);  // one sign, not two bytes
}

TEST(LabelWriter, ReportsWhichGlyphsItsFontLacks) {
  const picture::LabelWriter writer(20);
  EXPECT_FALSE(writer.missingGlyph(U"Caf\u00e9 30\u00b0 \u03b1\u03a9 \u00e4\u00f6\u00fc"));
  EXPECT_EQ(writer.missingGlyph(U"a\U0010fffd\u4e2d"), U'\U0010fffd');  // of no script
  EXPECT_NO_THROW(writer.width("\xff"));                                // not UTF-8: the font's box
}

picture::Frame pictureOf(const std::string& text) {
  picture::Frame frame = picture::makeFrame({400, 60}, kWhite);
  picture::LabelWriter(30).draw(frame, text, 10, 40, kBlack);
  return frame;
}

/// Glyphs of a text in one run.
std::vector<unsigned> glyphsOf(const std::string& text) {
  std::vector<unsigned> numbers;
  for (const picture::TextRun& run : picture::LabelWriter(30).shape(text).runs) {
    for (const picture::PlacedGlyph& glyph : run.glyphs) numbers.push_back(glyph.number);
  }
  return numbers;
}

TEST(Shaping, IsThatOfHarfBuzz) {
  if (!test::hasProgram("hb-shape")) {
    GTEST_SKIP() << "no hb-shape here; scripts/setup --with-tools installs libharfbuzz-bin";
  }
  // hb-shape counts in units of the font; DejaVu Sans has 2048 per em.
  const picture::LabelWriter writer(2048);
  for (const char* text : {"سلام", "لا إله", "שלום", "AVATAR office", "αβγ"}) {
    const bool isSimple = text[0] == 'A';
    const std::string expected = test::outputOf(fmt::format(
        "LC_ALL=C.UTF-8 hb-shape --no-glyph-names --no-clusters --shaper=ot {} {} '{}'",
        isSimple ? "--features=-kern,-liga,-clig" : "", picture::findFont().string(), text));
    ASSERT_FALSE(expected.empty()) << text;
    std::vector<unsigned> numbers;
    double width = 0;
    for (std::size_t at = 0; at != std::string::npos; at = expected.find('|', at + 1)) {
      numbers.push_back(static_cast<unsigned>(std::stoul(expected.substr(at + 1))));
      width += std::stod(expected.substr(expected.find('+', at)));
    }
    EXPECT_EQ(glyphsOf(text), numbers) << text << ' ' << expected;
    EXPECT_NEAR(writer.shape(text).width, width, 1) << text;  // measured: equal
  }
}

TEST(Shaping, JoinsArabicLetters) {
  const std::vector<unsigned> word = glyphsOf("بيت");
  ASSERT_EQ(word.size(), 3U);
  // From left to right the last letter is first.
  EXPECT_NE(word[0], glyphsOf("ت")[0]);
  EXPECT_NE(word[1], glyphsOf("ي")[0]);
  EXPECT_NE(word[2], glyphsOf("ب")[0]);
  EXPECT_EQ(glyphsOf("دار").size(), 3U);
  EXPECT_EQ(glyphsOf("لا").size(), 1U);  // a ligature that the script requires
}

TEST(Shaping, WritesHebrewFromTheRight) {
  picture::Frame expected = picture::makeFrame({400, 60}, kWhite);
  const picture::LabelWriter writer(30);
  int pen = 10;
  for (const char* letter : {"ם", "ו", "ל", "ש"}) {
    writer.draw(expected, letter, pen, 40, kBlack);
    pen += writer.width(letter);
  }
  EXPECT_EQ(pictureOf("שלום").pixels, expected.pixels);
  EXPECT_EQ(writer.width("שלום"), pen - 10);
}

TEST(Shaping, OrdersMixedLines) {
  // The override of U+202D keeps the order on the page. Expected orders: Unicode Standard Annex 9.
  const auto onPage = [](const std::string& text) { return pictureOf("\u202d" + text).pixels; };
  EXPECT_EQ(pictureOf("abc אבג 12").pixels, onPage("abc 12 גבא"));
  EXPECT_EQ(pictureOf("אבג abc").pixels, onPage("abc גבא"));
  EXPECT_EQ(pictureOf("אבג (abc) 12").pixels, onPage("12 (abc) גבא"));
  EXPECT_EQ(pictureOf("a אב cd גד e").pixels, onPage("a בא cd דג e"));
  EXPECT_NE(pictureOf("אבג abc").pixels, onPage("אבג abc"));
  EXPECT_TRUE(picture::LabelWriter(30).shape("12 אבג abc").isRightToLeft);
  EXPECT_FALSE(picture::LabelWriter(30).shape("12 abc אבג").isRightToLeft);
}

TEST(Shaping, KeepsPlainText) {
  const picture::LabelWriter writer(20);
  EXPECT_TRUE(writer.shape("AVATAR office, \u03b1 = 30\u00b0").isPlain);
  EXPECT_FALSE(writer.shape("שלום").isPlain);
  EXPECT_EQ(writer.shape("").width, 0);
  EXPECT_EQ(writer.width("AV"), writer.width("A") + writer.width("V"));
  EXPECT_EQ(writer.width("a\u0301"), writer.width("\u00e1"));  // a mark has no width
}

/// The characters of a run, from left to right.
std::string textOf(const picture::TextRun& run) {
  std::string text;
  for (const picture::GlyphCluster& cluster : run.clusters) text += cluster.text;
  return text;
}

TEST(Shaping, HasTheCharactersOfEachGlyph) {
  const picture::LabelWriter writer(20);
  EXPECT_EQ(textOf(writer.shape("بيت").runs[0]), "تيب");
  EXPECT_EQ(textOf(writer.shape("بلا").runs[0]), "لاب");  // the ligature is one cluster
  EXPECT_EQ(textOf(writer.shape("e\u0301a").runs[0]), "e\u0301a");
  EXPECT_EQ(textOf(writer.shape("\xff").runs[0]), "\ufffd");
  for (const char* text : {"سلام abc لا", "שָׁלוֹם", "e\u0301a"}) {
    for (const picture::TextRun& run : writer.shape(text).runs) {
      int glyphs = 0;
      for (const picture::GlyphCluster& cluster : run.clusters) glyphs += cluster.glyphs;
      EXPECT_EQ(glyphs, static_cast<int>(run.glyphs.size())) << text;
    }
  }
}

TEST(Fallback, HasTheCharactersThatTheFontLacks) {
  const picture::LabelWriter writer(30);
  if (writer.missingGlyph(U"日本語")) GTEST_SKIP() << "no Japanese font here";
  const picture::ShapedLine line = writer.shape("a日本語b");
  ASSERT_EQ(line.runs.size(), 3U);
  EXPECT_EQ(line.runs[0].font.path, picture::findFont());
  EXPECT_NE(line.runs[1].font.path, picture::findFont());
  EXPECT_EQ(line.runs[2].font.path, picture::findFont());
  EXPECT_EQ(textOf(line.runs[1]), "日本語");
  for (const picture::PlacedGlyph& glyph : line.runs[1].glyphs) EXPECT_NE(glyph.number, 0U);
  // Chinese and Japanese characters fill a square of one em.
  EXPECT_NEAR(writer.width("日本語"), 90, 1);  // measured: 90 with IPAGothic
  EXPECT_GT(inkBox(pictureOf("日")).sizes().x(), 10);
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

TEST(LabelWriter, ReportsHowToGetAFont) {
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
