#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/cli/command_line.h"
#include "render/cli/option_group.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

TEST(OptionNames, AreMadeOfTheKeysInMessages) {
  EXPECT_EQ(cli::spellOptions(
                "raise `search_effort`, or use `path = dynamic` (`align = false` keeps it)"),
            "raise --search-effort, or use --path dynamic (--no-align keeps it)");
  EXPECT_EQ(cli::spellOptions("`hinge_stiffness`: error: none"), "--hinge-stiffness: error: none");
  EXPECT_EQ(cli::spellOptions("no keys, `kirireel export` and a single `"),
            "no keys, `kirireel export` and a single `");
}

TEST(OptionNames, ExistForAllKeysInMessages) {
  std::set<std::string> options;
  for (const cli::CommandDescription& command : cli::describeProgram().commands) {
    for (const cli::OptionDescription& option : command.options) {
      options.insert(option.names.begin(), option.names.end());
    }
  }
  const std::regex key("`[a-z_]+( = [^`\"]*)?`");
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(
           std::filesystem::path(KIRIREEL_SOURCE_DIR) / "sim")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);) {
      // Comments name code in the same quotes.
      if (line.find("//") != std::string::npos) continue;
      for (std::sregex_iterator match(line.begin(), line.end(), key), end; match != end; ++match) {
        const std::string spelled = cli::spellOptions(match->str());
        EXPECT_TRUE(options.contains(spelled.substr(0, spelled.find(' ')))) << line;
        ++count;
      }
    }
  }
  EXPECT_GT(count, 50);
}

TEST(OptionNumber, ReadsWhatPeopleType) {
  const scene::Range all;
  EXPECT_EQ(scene::parseNumber({"--x", "0.02"}, all), 0.02);
  EXPECT_EQ(scene::parseNumber({"--x", "-1e-3"}, all), -1e-3);
  EXPECT_EQ(scene::parseNumber({"--x", "+5"}, all), 5);
  EXPECT_EQ(scene::parseNumber({"--x", "1"}, {0, 1}), 1);
}

TEST(OptionNumber, RefusesEverythingElse) {
  for (const char* text : {"", "abc", "1,5", "1 ", " 1", "nan", "inf", "1e999", "0x10"}) {
    EXPECT_EQ(
        test::refusalOf([&] {
          scene::parseNumber({"--thickness", text}, {0, 10});
        }),
        fmt::format("error: --thickness: '{}' is not allowed; give a number from 0 to 10", text));
  }
}

TEST(OptionTiles, AreNumbersOrAll) {
  EXPECT_TRUE(cli::parseTiles({"--split-tiles", "all"}).empty());
  EXPECT_EQ(cli::parseTiles({"--split-tiles", "3,7,8"}), (std::vector<int>{3, 7, 8}));
  EXPECT_EQ(
      test::refusalOf([] {
        cli::parseTiles({"--split-tiles", "3,x"});
      }),
      "error: --split-tiles: '3,x' is not allowed; give all, or numbers of tiles, as in 3,7,8");
}

TEST(OptionNumber, ReportsWhatIsAllowed) {
  const double most = scene::Range().most;
  EXPECT_EQ(test::refusalOf([&] {
              scene::parseNumber({"--mu", "-1"}, {0, most});
            }),
            "error: --mu: '-1' is not allowed; give a number of at least 0");
  EXPECT_EQ(test::refusalOf([&] {
              scene::parseInteger({"--fps", "2.5"}, {1, 240});
            }),
            "error: --fps: '2.5' is not allowed; give a whole number from 1 to 240");
  EXPECT_EQ(test::refusalOf([&] {
              scene::parseInteger({"--fps", "0"}, {1, 240});
            }),
            "error: --fps: '0' is not allowed; give a whole number from 1 to 240");
}

TEST(OptionSize, ReadsWidthAndHeight) {
  EXPECT_EQ(cli::parseSize({"--size", "640x480"}), (picture::FrameSize{640, 480}));
  for (const char* text : {"640", "640x", "x480", "0x480", "640x100000", "640x480x2", "640X480"}) {
    EXPECT_EQ(test::refusalOf([&] {
                cli::parseSize({"--size", text});
              }),
              fmt::format("error: --size: '{}' is not allowed; give WIDTHxHEIGHT in pixels, each "
                          "from 1 to 16384, as in 1280x720",
                          text));
  }
}

TEST(OptionLength, HasAnyUnit) {
  const auto width = [](const char* text) {
    return cli::parseLength({"--width", text}, "mm", {1, 10000});
  };
  for (const char* text : {"180", "180mm", "18cm", "0.18m"}) EXPECT_EQ(width(text), 180);
  EXPECT_EQ(width("31.4"), 31.4);
  EXPECT_DOUBLE_EQ(width("7in"), 177.8);
  EXPECT_EQ(cli::parseLength({"--font-size", "30"}, "pt", {1, 200}), 30);
  EXPECT_DOUBLE_EQ(cli::parseLength({"--font-size", "2.54mm"}, "pt", {1, 200}), 7.2);
  EXPECT_EQ(test::refusalOf([&] { width("18furlong"); }),
            "error: --width: '18furlong' is not allowed; give a number in mm, or with one of nm, "
            "um, mm, cm, m, km, in, pt, ft");
  EXPECT_EQ(test::refusalOf([&] { width("0.01cm"); }),
            "error: --width: '0.01cm' is not allowed; give a length from 1 to 10000 mm");
}

TEST(OptionGrid, ReadsRowsAndColumns) {
  EXPECT_EQ(cli::parseGrid({"--grid", "2x5"}), (picture::GridShape{2, 5}));
  EXPECT_EQ(
      test::refusalOf([] {
        cli::parseGrid({"--grid", "0x3"});
      }),
      "error: --grid: '0x3' is not allowed; give ROWSxCOLUMNS, each from 1 to 100, as in 3x3");
}

TEST(OptionGravity, IsAlongZOrAVector) {
  EXPECT_EQ(scene::parseGravity({"--gravity", "-9.81"}), Vector3(0, 0, -9.81));
  EXPECT_EQ(scene::parseGravity({"--gravity", "1,-2,3"}), Vector3(1, -2, 3));
  for (const char* text : {"", "down", "1,2", "1,2,3,4", "1,,3", "nan"}) {
    EXPECT_THAT(test::refusalOf([&] {
                  scene::parseGravity({"--gravity", text});
                }),
                HasSubstr("is not allowed; give one number (along z) or three as X,Y,Z"));
  }
}

TEST(OptionChoice, NamesTheChoices) {
  const scene::Choices<int> choices = {{"all", 1}, {"unjoined", 2}, {"none", 3}};
  EXPECT_EQ(scene::parseChoice<int>({"--contacts", "unjoined"}, choices), 2);
  EXPECT_EQ(test::refusalOf([&] {
              scene::parseChoice<int>({"--contacts", "some"}, choices);
            }),
            "error: --contacts: 'some' is not allowed; give all, unjoined or none");
}

TEST(OptionTileColour, IsTilesAndAColour) {
  const picture::TileColour made = cli::parseTileColour({"--tile-colour", "3,7,10-12=teal"});
  EXPECT_EQ(made.tiles, (std::vector<int>{3, 7, 10, 11, 12}));
  EXPECT_EQ(made.colour, (picture::Colour{0, 128, 128}));
  EXPECT_EQ(made.name, "");
  EXPECT_EQ(cli::tileColoursText({made}), "\"3,7,10,11,12=008080\"");
  const picture::TileColour named = cli::parseTileColour({"--tile-colour", "a = b: c:3,7=teal"});
  EXPECT_EQ(named.name, "a = b: c");
  EXPECT_EQ(named.tiles, (std::vector<int>{3, 7}));
  EXPECT_EQ(cli::tileColoursText({named}), "\"a = b: c:3,7=008080\"");
  for (const char* text : {"3", "=teal", "a=teal", "3,=teal", "5-3=teal", "-1=teal", "1-=teal"}) {
    EXPECT_EQ(test::refusalOf([&] {
                cli::parseTileColour({"--tile-colour", text});
              }),
              fmt::format("error: --tile-colour: '{}' is not allowed; give numbers of tiles and a "
                          "colour, as in 3,7,10-15=teal",
                          text));
  }
}

TEST(OptionTileOpacity, IsTilesAndAShare) {
  const picture::TileOpacity made = cli::parseTileOpacity({"--tile-opacity", "3,10-12=0.25"});
  EXPECT_EQ(made.tiles, (std::vector<int>{3, 10, 11, 12}));
  EXPECT_EQ(made.opacity, 0.25);
  EXPECT_EQ(cli::tileOpacitiesText({made}), "\"3,10,11,12=0.25\"");
  for (const char* text : {"3", "=0.5", "a=0.5", "3,=1", "5-3=1"}) {
    EXPECT_EQ(test::refusalOf([&] {
                cli::parseTileOpacity({"--tile-opacity", text});
              }),
              fmt::format("error: --tile-opacity: '{}' is not allowed; give numbers of tiles and a "
                          "share, as in 3,7,10-15=0.3",
                          text));
  }
  EXPECT_EQ(test::refusalOf([] {
              cli::parseTileOpacity({"--tile-opacity", "3=1.5"});
            }),
            "error: --tile-opacity: '1.5' is not allowed; give a number from 0 to 1");
}

TEST(OptionColour, IsHexadecimalOrAName) {
  EXPECT_EQ(cli::parseColour({"--brick-colour", "80aeDC"}), (picture::Colour{128, 174, 220}));
  EXPECT_EQ(cli::parseColour({"--brick-colour", "teal"}), (picture::Colour{0, 128, 128}));
  for (const char* text : {"", "80AED", "80AEDCFF", "sky", "80AEDG", "0x80AE", "-80AED"}) {
    EXPECT_EQ(test::refusalOf([&] {
                cli::parseColour({"--brick-colour", text});
              }),
              fmt::format("error: --brick-colour: '{}' is not allowed; give red, green and blue in "
                          "hexadecimal, for example 80AEDC, or a name of CSS such as teal, navy or "
                          "grey",
                          text));
  }
}

TEST(OptionCameraKeys, ReportWhichKeyIsWrong) {
  EXPECT_EQ(test::refusalOf([] {
              cli::parseCameraKeys({"--camera-keys", "0:0:0:1,2:30:4"});
            }),
            "error: --camera-keys: '2:30:4' is not allowed; give TIME:YAW:PITCH:ZOOM, for example "
            "2.5:90:-20:1.5");
  EXPECT_EQ(test::refusalOf([] {
              cli::parseCameraKeys({"--camera-keys", "0:0:-91:1"});
            }),
            "error: --camera-keys: '-91' is not allowed; give a number from -90 to 90");
}

TEST(OptionCaption, NamesParts) {
  const picture::CaptionParts none = cli::parseCaption({"--captions", "none"});
  EXPECT_FALSE(none.time || none.angle || none.error || none.gap);
  EXPECT_TRUE(cli::parseCaption({"--captions", "error,time"}).error);
  EXPECT_EQ(test::refusalOf([] {
              cli::parseCaption({"--captions", "time,colour"});
            }),
            "error: --captions: 'colour' is not allowed; give progress, time, angle, error, gap or "
            "none");
  EXPECT_EQ(test::refusalOf([] {
              cli::parseCaption({"--captions", "time,none"});
            }),
            "error: --captions: 'time,none' is not allowed; give none, or parts such as "
            "time,error");
}

TEST(OptionValues, FrameChoicesAreSecondsOrShares) {
  using Unit = record::FrameChoice::Unit;
  EXPECT_EQ(cli::parseFrameChoices({"--frames-at", "0,1.5,50%"}),
            (std::vector<record::FrameChoice>{
                {0, Unit::Seconds}, {1.5, Unit::Seconds}, {0.5, Unit::Share}}));
  EXPECT_THROW(cli::parseFrameChoices({"--frames-at", "120%"}), InputError);
  EXPECT_THROW(cli::parseFrameChoices({"--frames-at", "soon"}), InputError);
}

}  // namespace
}  // namespace kirireel
