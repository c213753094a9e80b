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

TEST(PeerSpellings, ReadNoCollisionAsUnjoinedContacts) {
  EXPECT_EQ(cli::translatePeerSpellings({"--no_collision"}), (Words{"--contacts=unjoined"}));
  EXPECT_EQ(cli::translatePeerSpellings({"--filter_collision"}), (Words{"--contacts=unjoined"}));
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
  EXPECT_TRUE(cli::usesPeerSpellings({"record", "fan", "--brick_thickness", "0.1"}));
  EXPECT_TRUE(cli::usesPeerSpellings({"record", "--model=fan"}));
  EXPECT_TRUE(cli::usesPeerSpellings({"record", "fan", "-ss", "25"}));
  EXPECT_TRUE(cli::usesPeerSpellings({"record", "fan", "-cd", "9"}));
  EXPECT_FALSE(
      cli::usesPeerSpellings({"record", "my_fan", "--thickness", "0.1", "--gravity", "-9"}));
}

TEST(PeerSpellings, LeaveValuesAndOwnSpellingsAlone) {
  const Words own = {"record", "my_model", "--out=a_b/c", "--gravity", "-9.81", "--thickness", "1"};
  EXPECT_EQ(cli::translatePeerSpellings(own), own);
}

}  // namespace
}  // namespace kirireel
