// Page files of `kirireel figure`.
#include "render/cli/figure_command.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/cli/command_line.h"
#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class FigureFileTest : public testing::Test {
 protected:
  FigureFileTest() {
    for (const char* name : {"cap", "fan"}) {
      std::filesystem::create_directory(folder_ / name);
      std::ofstream(folder_ / name / "trajectory.h5") << "read later";
    }
  }

  record::FigurePage read(const std::string& text) const {
    std::ofstream(folder_ / "page.toml") << text;
    return cli::readFigurePage(folder_ / "page.toml");
  }

  /// The message without the folder.
  std::string refusal(const std::string& text) const {
    try {
      read(text);
    } catch (const InputError& error) {
      std::string message = error.what();
      const std::string place = folder_.path().string();
      for (std::size_t at = 0; (at = message.find(place)) != std::string::npos;) {
        message.replace(at, place.size(), "@");
      }
      return message;
    }
    return "accepted";
  }

  /// A page with one panel of these keys.
  static std::string one(const std::string& keys) {
    return "rows = [[\"a\"]]\n[panel.a]\nrun = \"cap\"\n" + keys;
  }

  test::TemporaryFolder folder_;
};

TEST_F(FigureFileTest, HasRowsOfPanels) {
  const record::FigurePage page = read(
      "width = \"90mm\"\nfont_size = \"8pt\"\nletters = \"(a)\"\ndpi = 600\n"
      "rows = [[\"pictures\"], [\"plot\", \"other\"]]\n"
      "[panel.pictures]\nrun = [\"cap\", \"fan/\"]\ngrid = \"1x4\"\nview = [30, 20]\n"
      "colour = \"error\"\nsame_scale = true\ntitle = \"Caps\"\nshare = 2\nheight = \"30mm\"\n"
      "tile_colour = [\"0=red\", \"1=teal\"]\n"
      "[panel.plot]\nrun = \"cap/trajectory.h5\"\ncurves = [\"radius\", \"theta\"]\n"
      "against = \"progress\"\ncolumn = \"data.csv:radius_m\"\n"
      "[panel.other]\nrun = \"cap\"\n");
  EXPECT_EQ(page.width, 90);
  EXPECT_EQ(page.fontPoints, 8);
  EXPECT_EQ(page.dotsPerInch, 600);
  EXPECT_EQ(page.letters, picture::PanelLetters::Bracketed);
  ASSERT_EQ(page.rows.size(), 2u);
  const record::FigurePanel& pictures = page.rows[0][0];
  EXPECT_THAT(pictures.runs,
              ElementsAre(folder_ / "cap/trajectory.h5", folder_ / "fan/trajectory.h5"));
  EXPECT_EQ(pictures.pictures.grid, (picture::GridShape{1, 4}));
  EXPECT_EQ(pictures.pictures.appearance.colouring, picture::Colouring::TargetError);
  EXPECT_NEAR(pictures.pictures.appearance.camera.view->azimuth, 30 * kDegree, 1e-15);
  EXPECT_EQ(pictures.pictures.appearance.tileColours.size(), 2u);
  EXPECT_TRUE(pictures.pictures.sameScale);
  EXPECT_EQ(pictures.title, "Caps");
  EXPECT_EQ(pictures.share, 2);
  EXPECT_EQ(pictures.height, 30);
  EXPECT_FALSE(pictures.curves);
  const record::FigurePanel& plot = page.rows[1][0];
  EXPECT_THAT(plot.curves->selected, ElementsAre("radius", "theta"));
  EXPECT_EQ(plot.curves->against, record::CurvesAgainst::Progress);
  EXPECT_EQ(plot.curves->columns[0].file, folder_ / "data.csv");
  EXPECT_EQ(page.rows[1][1].pictures.grid, (picture::GridShape{1, 3}));
  EXPECT_EQ(read(one("")).letters, picture::PanelLetters::Small);
  EXPECT_EQ(read("letters = false\n" + one("")).letters, picture::PanelLetters::None);
  EXPECT_EQ(read("letters = true\n" + one("")).letters, picture::PanelLetters::Plain);
  EXPECT_TRUE(read(one("curves = \"all\"\n")).rows[0][0].curves->selected.empty());
}

TEST_F(FigureFileTest, NamesWhatExists) {
  EXPECT_EQ(refusal("rows = [[\"b\"]]\n[panel.a]\nrun = \"cap\"\n[panel.c]\nrun = \"fan\"\n"),
            "@/page.toml:1:10: error: there is no panel b, did you mean a?; there are a, c");
  EXPECT_EQ(refusal("rows = [[\"a\"]]\n[panel.a]\nrun = \"cup\"\n"),
            "@/page.toml:3:7: error: there is no run @/cup, did you mean cap?; @ has cap, fan");
  EXPECT_EQ(refusal("rows = [[\"a\"]]\n[panel.a]\nrun = \"x/y\"\n"),
            "@/page.toml:3:7: error: there is no run @/x/y, and no run in @/x");
  EXPECT_EQ(refusal("rows = [[\"a\"]]\n[panel.a]\ngrid = \"1x2\"\n"),
            "@/page.toml:2:8: error: panel a has no run; give run = \"FOLDER\"");
  EXPECT_EQ(refusal("[panel.a]\nrun = \"cap\"\n"),
            "@/page.toml: error: rows is missing; give lists with the names of panels, as in "
            "[[\"a\"], [\"b\", \"c\"]]");
  EXPECT_EQ(refusal("rows = [[\"a\"]]\n"),
            "@/page.toml: error: there is no panel; add tables [panel.NAME]");
  EXPECT_EQ(refusal("rows = [[\"a\", \"a\"]]\n[panel.a]\nrun = \"cap\"\n"),
            "@/page.toml:1:15: error: panel a is in rows twice");
  EXPECT_THAT(refusal(one("[panel.b]\nrun = \"fan\"\n")),
              HasSubstr(": error: panel b is not in rows; add or remove it"));
  EXPECT_THAT(refusal("rows = [\"a\"]\n[panel.a]\nrun = \"cap\"\n"),
              HasSubstr("@/page.toml:1:9: error: \"a\" is not allowed; give lists with "));
}

/// The keys of a panel are the options of `render` for one picture, and those of `curves`.
TEST_F(FigureFileTest, ListsTheAllowedKeys) {
  const std::string pictures = refusal(one("colur = \"error\"\n"));
  EXPECT_THAT(pictures, StartsWith("@/page.toml:4:1: error: unknown key of a panel of pictures "
                                   "colur, did you mean colour?; there are run, title, share, "
                                   "height, size, grid, captions, scale_bar, snapshots, "));
  for (const char* group : {"Style", "Camera"}) {
    for (const cli::OptionDescription& option :
         cli::commandNamed(cli::describeProgram(), "render").options) {
      if (option.group != group || option.key == "transparent") continue;
      EXPECT_THAT(pictures, HasSubstr(", " + option.key)) << option.key;
    }
  }
  EXPECT_EQ(refusal(one("curves = \"radius\"\nview = \"top\"\n")),
            "@/page.toml:5:1: error: unknown key of a plot view; there are run, title, share, "
            "height, curves, column, against");
  EXPECT_THAT(refusal(one("transparent = true\n")), HasSubstr("unknown key of a panel of pict"));
  EXPECT_EQ(refusal("colour = 3\n" + one("")),
            "@/page.toml:1:1: error: unknown key of a page colour; there are rows, panel, width, "
            "font_size, font, letters, dpi");
}

TEST_F(FigureFileTest, ValuesAreThoseOfTheOptions) {
  EXPECT_THAT(refusal(one("view = \"up\"\n")), HasSubstr("page.toml:4:8: error: --view"));
  EXPECT_EQ(refusal(one("grid = [\"1x2\", \"1x3\"]\n")),
            "@/page.toml:4:8: error: grid has one value");
  EXPECT_EQ(refusal(one("same_view = true\n")),
            "@/page.toml:2:8: error: --same-view has no effect with one run. Give kirireel render "
            "several runs or remove --same-view");
  EXPECT_EQ(read(one("title = \"One\"\n")).rows[0][0].title, "One");
  EXPECT_EQ(refusal("rows = [[\"a\"]]\n[panel]\na = 3\n"),
            "@/page.toml:3:5: error: 3 is not allowed; give a table, [panel.a]");
}

TEST_F(FigureFileTest, FormatsAreThoseOfTheFiles) {
  std::ofstream(folder_ / "page.toml") << one("");
  const auto parse = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"figure", (folder_ / "page.toml").string()};
    words.insert(words.end(), more.begin(), more.end());
    return std::get<cli::FigureOrder>(cli::parseCommandLine(words));
  };
  EXPECT_THAT(parse({}).outputs, ElementsAre(folder_ / "page.pdf"));
  const cli::FigureOrder order = parse({"--out", "x/a.svg", "--out", "x/a.png"});
  EXPECT_EQ(order.page.folder, "x");
  EXPECT_THAT(order.page.files, ElementsAre("a.svg", "a.png"));
  EXPECT_EQ(parse({"--out", "a.svg"}).page.folder, ".");
  for (const auto& [more, message] :
       {std::pair<std::vector<std::string>, std::string>(
            {"--out", "a.jpg"},
            "error: a.jpg has no format of a page; give a name that ends in .pdf, .svg or .png"),
        std::pair<std::vector<std::string>, std::string>(
            {"--out", "x/a.pdf", "--out", "y/a.png"},
            "error: x/a.pdf and y/a.png are in different folders; give one folder")}) {
    try {
      parse(more);
      ADD_FAILURE() << message;
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(), message);
    }
  }
}

}  // namespace
}  // namespace kirireel
