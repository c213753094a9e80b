#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/state_painter.h"
#include "render/sweep/collect.h"
#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;

TEST(ContactLayout, RowsEndWhereSeriesDo) {
  EXPECT_EQ(sweep::layOutContacts(40, 20).shape, (picture::GridShape{8, 5}));
  EXPECT_EQ(sweep::layOutContacts(21, 7).shape, (picture::GridShape{3, 7}));
  EXPECT_EQ(sweep::layOutContacts(60, 2).shape, (picture::GridShape{8, 8}));
  // One or thirteen columns of 26 pictures would be no page. A series has equal pictures.
  EXPECT_EQ(sweep::layOutContacts(2 * 31, 31).shape, (picture::GridShape{8, 8}));
  EXPECT_EQ(sweep::layOutContacts(13, 13).shape, (picture::GridShape{4, 4}));
  EXPECT_EQ(sweep::layOutContacts(7, 1).shape, (picture::GridShape{3, 3}));
}

TEST(ContactLayout, OfTooManyChoosesWholeSeries) {
  const sweep::ContactLayout layout = sweep::layOutContacts(200, 10);
  EXPECT_EQ(layout.shape, (picture::GridShape{10, 10}));
  ASSERT_EQ(layout.chosen.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(layout.chosen[i] % 10, i % 10);
  EXPECT_EQ(layout.chosen.front(), 0U);
  EXPECT_EQ(layout.chosen.back(), 199U);
  EXPECT_EQ(sweep::layOutContacts(100'000, 1000).chosen.back(), 99'999U);
  EXPECT_EQ(sweep::layOutContacts(101, 101).chosen.back(), 100U);
  EXPECT_THAT(sweep::layOutContacts(3, 3).chosen, ElementsAre(0, 1, 2));
}

class ContactSheet : public testing::Test {
 protected:
  /// A brick on its edge. Its thickness is visible from above.
  sweep::ContactPicture upright(double thickness, const std::string& value) const {
    std::ofstream(file()) << "0 0 0 1 0 0 1 0 1 0 0 1\n";
    return {file(), thickness, {value}};
  }

  std::filesystem::path file() const { return folder_ / "final_vertices.txt"; }

  /// The upper left picture of a page.
  static picture::Frame firstOf(const picture::Frame& page) {
    const picture::GridLayout layout = picture::layOutGrid({320, 240}, {1, 1});
    picture::Frame part = picture::makeFrame({320, 240}, {});
    for (int y = 0; y < 240; ++y) {
      const auto start = page.pixels.begin() +
                         static_cast<std::ptrdiff_t>(page.rowStart(layout.upper(0) + y)) +
                         std::ptrdiff_t{4} * layout.left(0);
      std::copy_n(start, 4 * 320,
                  part.pixels.begin() + static_cast<std::ptrdiff_t>(part.rowStart(y)));
    }
    return part;
  }

  picture::Frame studioPicture(double thickness) const {
    model::Model model;
    model.tiles = formats::readTileFile(file());
    brick::BrickRule rule;
    rule.thickness = thickness;
    const picture::PictureContent content = picture::makeContent(model, rule, std::nullopt);
    return picture::StatePainter({320, 240}, {}, content).paint({0, content.start, {}});
  }

  const test::TemporaryFolder folder_;
};

TEST_F(ContactSheet, ShowsBricksAsThickAsTheyAre) {
  for (const double thickness : {0.1, 0.4}) {
    const sweep::ContactPicture picture = upright(thickness, "1");
    EXPECT_EQ(firstOf(sweep::composeContactSheet({"k"}, {picture})).pixels,
              studioPicture(thickness).pixels);
  }
  EXPECT_NE(studioPicture(0.1).pixels, studioPicture(0.4).pixels);
}

TEST_F(ContactSheet, HasEmptyCellsForFailedRuns) {
  const picture::Frame page =
      sweep::composeContactSheet({"k"}, {{{}, 0, {"1"}}, upright(0.1, "2")});
  EXPECT_EQ(firstOf(page).pixels,
            picture::makeFrame({320, 240}, picture::Style().background).pixels);
  EXPECT_NE(sweep::composeContactSheet({"k"}, {{{}, 0, {"1"}}}).pixels,
            sweep::composeContactSheet({"k"}, {{{}, 0, {"2"}}}).pixels);
}

TEST_F(ContactSheet, IsNotMadeOfNothing) {
  EXPECT_THAT(
      [] { sweep::composeContactSheet({"k"}, {}); },
      testing::ThrowsMessage<InputError>("error: no run is finished, so there is nothing to show"));
}

}  // namespace
}  // namespace kirireel
