#include <gtest/gtest.h>

#include "render/cli/command_line.h"

namespace kirireel {
namespace {

using Words = std::vector<std::string>;

TEST(PeerSpellings, TranslateLongOptions) {
  EXPECT_EQ(cli::translatePeerSpellings({"--brick_thickness", "0.1", "--spring_stiffness=25"}),
            (Words{"--thickness", "0.1", "--spring-stiffness=25"}));
  EXPECT_EQ(cli::translatePeerSpellings({"--ground_plane", "--num_substeps", "20"}),
            (Words{"--ground", "--substeps", "20"}));
}

TEST(PeerSpellings, TranslateShortOptions) {
  EXPECT_EQ(
      cli::translatePeerSpellings({"-ss", "25", "-fd", "20", "-bt", "0.1", "-gp", "-gf", "0.3"}),
      (Words{"--spring-stiffness", "25", "--force-damping", "20", "--thickness", "0.1", "--ground",
             "--ground-friction", "0.3"}));
}

TEST(PeerSpellings, ReadItsTwoCollisionSwitches) {
  EXPECT_EQ(cli::translatePeerSpellings({"--no_collision"}), (Words{"--contacts=unjoined"}));
  EXPECT_EQ(cli::translatePeerSpellings({"--filter_collision"}), (Words{"--contacts=none"}));
}

TEST(PeerSpellings, ReadExpansionAndTargets) {
  EXPECT_EQ(cli::translatePeerSpellings({"--cm_expansion", "--target_vertices_file", "half.txt"}),
            (Words{"--actuation=expansion", "--target", "half.txt"}));
}

TEST(PeerSpellings, DropWhatHasNoEffectWithItsValue) {
  EXPECT_EQ(
      cli::translatePeerSpellings({"--camera_distance", "12", "-cd", "9", "--max_steps=500", "fan",
                                   "--auto_export_interval", "10", "--export_prefix", "a"}),
      (Words{"fan"}));
}

TEST(PeerSpellings, PutTheModelInItsPlaceAndDropHeadless) {
  EXPECT_EQ(cli::translatePeerSpellings({"record", "--model", "fan", "--headless"}),
            (Words{"record", "fan"}));
  EXPECT_EQ(cli::translatePeerSpellings({"record", "--model=fan"}), (Words{"record", "fan"}));
}

TEST(PeerSpellings, AreKnownFromOurs) {
  const std::vector<std::pair<Words, std::string>> cases = {
      {{"record", "fan", "--brick_thickness", "0.1"}, "--brick_thickness"},
      {{"record", "fan", "--brick-thickness", "0.1"}, "--brick-thickness"},
      {{"record", "--model=fan"}, "--model"},
      {{"record", "fan", "-ss", "25"}, "-ss"},
      {{"record", "fan", "-cd", "9"}, "-cd"},
      {{"record", "fan", "--no-collision"}, "--no-collision"},
      {{"record", "fan", "--spring_stiffness=25"}, "--spring_stiffness"},
      {{"record", "fan", "--ground_friction", "1"}, "--ground_friction"},
      {{"record", "fan", "--like", "pykirigami"}, "--like pykirigami"},
      {{"record", "my_fan", "--thickness", "0.1", "--gravity", "-9"}, ""},
      {{"record", "fan", "--spring-stiffness", "25"}, ""},
      {{"record", "fan", "--auto-detect-connections"}, "--auto-detect-connections"}};
  for (const auto& [words, expected] : cases) EXPECT_EQ(cli::peerSpelling(words), expected);
}

// An underscore in an option that only Kirireel has is a hyphen, and selects no constants.
TEST(PeerSpellings, AreNoOtherUnderscores) {
  const Words words = {"record", "fan",           "--walk_time",
                       "3",      "--no_outlines", "--colour_map=viridis"};
  EXPECT_EQ(cli::peerSpelling(words), "");
  EXPECT_EQ(cli::translatePeerSpellings(words),
            (Words{"record", "fan", "--walk-time", "3", "--no-outlines", "--colour-map=viridis"}));
}

TEST(PeerSpellings, KeepValuesAndOwnSpellings) {
  const Words own = {"record", "my_model", "--out=a_b/c", "--gravity", "-9.81", "--thickness", "1"};
  EXPECT_EQ(cli::translatePeerSpellings(own), own);
}

}  // namespace
}  // namespace kirireel
