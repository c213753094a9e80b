#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/files.h"

namespace kirireel {
namespace {

TEST(JsonText, KeepsTheOrderOfKeysAndTheDigitsOfNumbers) {
  const std::string text = R"({"b":[1,0.1,-2.5e-300],"a":{"z":null,"y":true}})";
  EXPECT_EQ(jsonText(parseJson(text)), text);
  EXPECT_EQ(jsonText(parseJsonOrDiscard(text)), text);
}

TEST(JsonText, HasALineForEachEntryWhereItIsIndented) {
  EXPECT_EQ(jsonText(Json{{"a", 1}}, 2), "{\n  \"a\": 1\n}");
}

// Names of files may have bytes that are not UTF-8. Our texts must not.
TEST(JsonText, ReplacesBytesThatAreNoUtf8) {
  EXPECT_EQ(jsonText(Json("caf\xe9")), "\"caf\xef\xbf\xbd\"");
}

TEST(ParseJson, ReportsWhereTheSyntaxIsWrong) {
  try {
    parseJson("{\n  \"a\": 1,,\n}");
    FAIL() << "was read";
  } catch (const Json::parse_error& error) {
    EXPECT_NE(std::string(error.what()).find("line 2"), std::string::npos) << error.what();
  }
  EXPECT_TRUE(parseJsonOrDiscard("{,}").is_discarded());
  EXPECT_TRUE(parseJsonOrDiscard("").is_discarded());
}

}  // namespace
}  // namespace kirireel
