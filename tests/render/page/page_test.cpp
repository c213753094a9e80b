#include "render/page/page.h"

#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "render/picture/style.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/opening_squares.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using test::TemporaryFolder;
using ::testing::HasSubstr;
using ::testing::Not;

/// Four hinged squares that open. The model's name is not valid HTML.
trajectory::Trajectory opening() {
  trajectory::Trajectory run = test::openingSquares();
  run.model.name = "a <b> & \"c\"";
  run.events = {{1, "settled: all is open"}};
  run.findings = R"({"warnings": ["the <target> is open"], "path": {"reason": "a straight pull"}})";
  return run;
}

class WebPage : public testing::Test {
 protected:
  WebPage() {
    test::writeTrajectory(opening(), file_);
    settings_.states.samples = 5;
  }
  void SetUp() override {
    if (!page::canMakePages()) GTEST_SKIP() << "built without three.js";
  }

  std::string text() const { return page::pageText({file_}, settings_); }

  /// The data within a page.
  static Json dataOf(const std::string& page) {
    const std::string begin = "id=\"data\">";
    const std::size_t first = page.find(begin) + begin.size();
    return Json::parse(page.substr(first, page.find("</script>", first) - first));
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "trajectory.h5";
  page::WebPageSettings settings_;
};

TEST_F(WebPage, LoadsNoOtherFiles) {
  const std::string page = text();
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  // Elements before the scripts: all their references are inside.
  const std::string elements = page.substr(0, page.find("<script>\n"));
  const std::regex reference("\\b(src|href|action|poster)\\s*=\\s*\"(?!data:)");
  EXPECT_FALSE(std::regex_search(elements, reference));
  EXPECT_THAT(elements, Not(HasSubstr("@import")));
}

TEST_F(WebPage, IsSmallComparedWithItsData) {
  const Json data = dataOf(text());
  EXPECT_LT(text().size() - data.dump().size(), 1'500'000U);  // measured 0.93 MB
}

TEST_F(WebPage, HasTheColoursAndLightsOfOurPictures) {
  const Json data = dataOf(text());
  const picture::Style style = picture::darkStyle();
  EXPECT_EQ(data["dark"]["edge"], Json({style.edge.red, style.edge.green, style.edge.blue}));
  EXPECT_EQ(data["dark"]["measure_edge"], data["dark"]["edge"]);
  EXPECT_NE(data["light"]["measure_edge"], data["light"]["edge"]);
  EXPECT_EQ(data["dark"]["lights"]["ambient"], style.ambient);
  EXPECT_EQ(data["light"]["lights"]["key"]["strength"], picture::Style().key.strength);
  EXPECT_EQ(data["light"]["brick"][1], Json({128, 174, 220}));
  EXPECT_EQ(data["light"]["slit_width"], picture::OutlineWidths().slits);
}

TEST_F(WebPage, TakesColoursAndOpacitiesOfSingleTiles) {
  const Json plain = dataOf(text());
  settings_.appearance.tileColours = {{{0, 3}, {0, 128, 128}, "hinge row"}};
  settings_.appearance.tileOpacities = {{{1}, 0.3}};
  EXPECT_EQ(dataOf(text())["light"], plain["light"]);
  settings_.appearance.tileOpacities = {{{4}, 0.3}};
  EXPECT_THAT([&] { text(); },
              testing::ThrowsMessage<InputError>("error: --tile-opacity: the model has no tile "
                                                 "4. Give tiles from 0 to 3"));
}

TEST_F(WebPage, ShowsStatesAtEqualStepsOfMotion) {
  const Json states = dataOf(text())["runs"][0]["states"];
  ASSERT_EQ(states["progress"].size(), 5U);
  EXPECT_EQ(states["progress"][1], 0.25);
  EXPECT_EQ(states["times"][0], 0.0);
  EXPECT_EQ(states["times"][4], 1.0);
  EXPECT_EQ(states["poses"]["entries"]["count"], 5 * 7 * 4);
  settings_.states.samples = 0;
  EXPECT_EQ(dataOf(text())["runs"][0]["states"]["times"].size(), 11U);
}

TEST_F(WebPage, DescribesTheRunInWords) {
  const std::string page = text();
  EXPECT_THAT(page, HasSubstr("<title>a &lt;b&gt; &amp; &quot;c&quot;</title>"));
  EXPECT_THAT(page, HasSubstr("<dd>4 tiles, 4 joints</dd>"));
  EXPECT_THAT(page, HasSubstr("<dd>settled: all is open</dd>"));
  EXPECT_THAT(page, HasSubstr("<dd>a straight pull</dd>"));
  EXPECT_THAT(page, HasSubstr("<p class=\"warning\">the &lt;target&gt; is open</p>"));
  EXPECT_THAT(page, HasSubstr("src=\"data:image/png;base64,iVBORw0KGgo"));
}

TEST_F(WebPage, HasTheSameBytesEachTime) {
  EXPECT_EQ(text(), text());
}

TEST_F(WebPage, HoldsTwoRuns) {
  const std::string page = page::pageText({file_, file_}, settings_);
  EXPECT_THAT(page, HasSubstr("data-count=\"2\""));
  EXPECT_EQ(dataOf(page)["runs"].size(), 2U);
}

TEST_F(WebPage, IsRefusedAboveItsSize) {
  settings_.maxMegabytes = 0.1;
  settings_.states.exact = true;
  try {
    text();
    FAIL() << "a page of any size";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr(" MB and may have 0.1; give no --exact, or a larger --most-size"));
  }
  // The number of states in the message is small enough.
  settings_.states = {.samples = 400};
  settings_.maxMegabytes = 25;
  settings_.maxMegabytes = 1e-6 * static_cast<double>(text().size()) - 0.005;
  try {
    settings_.states.samples = 1000;
    text();
    FAIL() << "a page of any size";
  } catch (const InputError& error) {
    std::smatch number;
    const std::string message = error.what();
    ASSERT_TRUE(std::regex_search(message, number, std::regex("--samples (\\d+) or fewer")));
    settings_.states.samples = std::stoi(number[1]);
    EXPECT_NO_THROW(text()) << message;
  }
}

TEST_F(WebPage, HoldsFilesOfTheRun) {
  writeTextFile(folder_ / "a.mp4", "abc");
  writeTextFile(folder_ / "b.obj", "v 0 0 0");
  settings_.embedded = {"a.mp4", "b.obj"};
  const std::string page = text();
  EXPECT_THAT(page, HasSubstr("<video controls loop src=\"data:video/mp4;base64,YWJj\""));
  EXPECT_THAT(page,
              HasSubstr("<a download=\"b.obj\" href=\"data:application/octet-stream;base64,"));
  settings_.embedded = {"none.png"};
  EXPECT_THROW(text(), InputError);
}

TEST_F(WebPage, IsListedInItsFolder) {
  settings_.folder = folder_ / "out";
  page::writePage({file_}, settings_);
  EXPECT_TRUE(std::filesystem::exists(settings_.folder / "page.html"));
  EXPECT_TRUE(std::filesystem::exists(settings_.folder / "contents.json"));
}

}  // namespace
}  // namespace kirireel
