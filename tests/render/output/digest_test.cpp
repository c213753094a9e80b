#include <fstream>

#include <gtest/gtest.h>

#include "render/output/output_folder.h"
#include "sim/base/error.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

// Oracle: the examples of FIPS 180-4.
TEST(Sha256, IsThatOfTheStandardsExamples) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(DigestOf, ReadsTheWholeFile) {
  const test::TemporaryFolder folder;
  const std::string million(1000000, 'a');
  std::ofstream(folder / "file") << million;
  const output::FileDigest digest = output::digestOf(folder.path(), "file");
  EXPECT_EQ(digest.name, "file");
  EXPECT_EQ(digest.bytes, 1000000U);
  EXPECT_EQ(digest.sha256, "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(DigestOf, ReportsWhichFileCannotBeRead) {
  const test::TemporaryFolder folder;
  try {
    output::digestOf(folder.path(), "file");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(
        error.what(),
        (folder / "file").string() +
            ": error: the file cannot be read; check that it exists and that you may read it");
  }
}

TEST(Seal, HoldsUntilAnyByteChanges) {
  const std::string text = output::sealed("{\n  \"a\": 1\n}\n");
  EXPECT_TRUE(output::isSealed(text));
  for (std::size_t k = 0; k < text.size(); ++k) {
    std::string changed = text;
    changed[k] ^= 1;
    EXPECT_FALSE(output::isSealed(changed)) << k;
  }
  EXPECT_FALSE(output::isSealed("{}\n"));
  EXPECT_FALSE(output::isSealed(""));
}

}  // namespace
}  // namespace kirireel
