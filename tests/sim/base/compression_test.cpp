#include <gtest/gtest.h>

#include "sim/base/files.h"

namespace kirireel {
namespace {

std::span<const std::byte> bytes(const std::string& text) {
  return std::as_bytes(std::span(text));
}

// The examples of RFC 4648, section 10.
TEST(Base64, IsThatOfTheStandard) {
  const std::pair<const char*, const char*> examples[] = {{"", ""},
                                                          {"f", "Zg=="},
                                                          {"fo", "Zm8="},
                                                          {"foo", "Zm9v"},
                                                          {"foob", "Zm9vYg=="},
                                                          {"fooba", "Zm9vYmE="},
                                                          {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, text] : examples) EXPECT_EQ(base64(bytes(plain)), text);
  EXPECT_EQ(base64(bytes("\xff\xfe\xfd")), "//79");
}

// The check value of CRC-32/ISO-HDLC, and an Adler-32 at the end (RFC 1950).
TEST(Compression, IsThatOfZlib) {
  EXPECT_EQ(checksumOf(bytes("123456789")), 0xcbf43926U);
  const std::string packed = compressed(bytes(std::string(10000, 'a')));
  EXPECT_LT(packed.size(), 60U);
  EXPECT_EQ(packed[0], '\x78');
  EXPECT_EQ(compressed(bytes("abc")), compressed(bytes("abc")));
}

}  // namespace
}  // namespace kirireel
