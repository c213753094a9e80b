#include "render/sweep/input_digest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

TEST(InputDigest, IsSha256OfLengthAndText) {
  InputDigest digest;
  digest.add("abc");
  // printf 3:abc | sha256sum
  EXPECT_EQ(digest.take(), "aab5f9ae99b2e38fb462025c8f72f570c9c811705d2a4277dc855d7fa293fe97");
}

TEST(InputDigest, TellsWhereTextsAreSplit) {
  InputDigest digest;
  digest.add("ab");
  digest.add("c");
  const std::string first = digest.take();
  digest.add("a");
  digest.add("bc");
  EXPECT_NE(digest.take(), first);
}

TEST(DigestOfFiles, FollowsContentAndNotPlace) {
  const test::TemporaryFolder folder;
  for (const char* place : {"a", "b"}) {
    std::filesystem::create_directories(folder / place / "model");
    std::ofstream(folder / place / "model" / "vertices.txt") << "0 0 0";
  }
  const std::string digest = digestOfFiles(folder / "a" / "model");
  EXPECT_EQ(digestOfFiles(folder / "b" / "model"), digest);
  std::ofstream(folder / "b" / "model" / "target.txt") << "1 0 0";
  EXPECT_NE(digestOfFiles(folder / "b" / "model"), digest);
}

TEST(DigestOfFiles, SeesTheSiblingThatHoldsTheTarget) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "fan_contracted.obj") << "v 0 0 0";
  const std::string alone = digestOfFiles(folder / "fan_contracted.obj");
  std::ofstream(folder / "other.obj") << "v 1 0 0";
  EXPECT_EQ(digestOfFiles(folder / "fan_contracted.obj"), alone);
  std::ofstream(folder / "fan_deployed.obj") << "v 1 0 0";
  EXPECT_NE(digestOfFiles(folder / "fan_contracted.obj"), alone);
}

TEST(DigestOfFiles, SaysWhatIsMissing) {
  EXPECT_THAT([] { digestOfFiles("/no/such/model"); },
              testing::ThrowsMessage<InputError>(
                  "/no/such/model: error: there is no such file or folder; correct the name"));
}

}  // namespace
}  // namespace kirireel
