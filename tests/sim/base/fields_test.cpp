/// Texts and checks made from the description of a struct.
#include "sim/base/fields.h"

#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/files.h"
#include "sim/base/state_tape.h"

namespace kirireel {
namespace {

using ::testing::ElementsAre;

struct Place {
  Vector3 point = Vector3::Zero();
  bool isKnown = false;

  bool operator==(const Place&) const = default;
  static constexpr auto fields() {
    return describeFields<Place>(field("point", &Place::point, "m"),
                                 field("is_known", &Place::isKnown));
  }
};

struct Journey {
  static constexpr int kNoField = 3;

  double length = 0;
  double seconds = 0;
  std::string name;
  std::vector<Place> places;
  std::optional<Place> rest;

  bool operator==(const Journey&) const = default;
  static constexpr auto fields() {
    return describeFields<Journey>(field("length", &Journey::length, "m"),
                                   field("seconds", &Journey::seconds, "s", "it took"),
                                   field("name", &Journey::name), field("places", &Journey::places),
                                   field("rest", &Journey::rest));
  }
};

Journey journey() {
  return {2.5, 1e-300, "there", {{{1, 2, 3}, true}, {{4, 5, 6}, false}}, Place{{7, 8, 9}, true}};
}

// describeFields() refuses a struct with another number of fields than are described.
TEST(Fields, AreCounted) {
  struct Empty {};
  struct Nested {
    Journey journey;
    Matrix6 matrix;
    double numbers[2];
    int last = 1;
  };
  EXPECT_EQ(fieldCount<Empty>(), 0U);
  EXPECT_EQ(fieldCount<Place>(), 2U);
  EXPECT_EQ(fieldCount<Journey>(), 5U);
  EXPECT_EQ(fieldCount<Pose>(), 2U);
  EXPECT_GE(fieldCount<Nested>(), 4U);
}

TEST(Fields, AreVisitedInOrder) {
  std::vector<std::string> names;
  const Journey there = journey();
  forEachField(there,
               [&](const auto& field, const auto& /*value*/) { names.push_back(field.name); });
  EXPECT_THAT(names, ElementsAre("length", "seconds", "name", "places", "rest"));
}

TEST(Fields, OfOneTypeAreFound) {
  constexpr auto numbers = fieldsOfType<double>(Journey::fields());
  ASSERT_EQ(numbers.size(), 2U);
  EXPECT_EQ(journey().*numbers[0].member, 2.5);
  EXPECT_STREQ(numbers[1].unit, "s");
  EXPECT_STREQ(numbers[1].meaning, "it took");
  EXPECT_STREQ(nameOfField(&Journey::seconds), "seconds");
}

TEST(Fields, AreRecordedAndPlayedBack) {
  for (const bool isThere : {false, true}) {
    Journey written = journey();
    if (!isThere) written.rest.reset();
    StateTape tape;
    tape.transfer(written);
    StateTape playing(tape.numbers());
    Journey read;
    read.rest = Place{};
    playing.transfer(read);
    EXPECT_EQ(read, written);
    EXPECT_TRUE(playing.isOver());
  }
}

TEST(Fields, MakeObjects) {
  struct Need {
    bool on = true;
    std::string why = "so";
    static constexpr auto fields() {
      return describeFields<Need>(field("on", &Need::on), field("why", &Need::why));
    }
  };
  struct Needs {
    Need first;
    double size = 0.5;
    static constexpr auto fields() {
      return describeFields<Needs>(field("first", &Needs::first), field("size", &Needs::size));
    }
  };
  EXPECT_EQ(fieldsJson<Json>(Needs{}).dump(), R"({"first":{"on":true,"why":"so"},"size":0.5})");
}

}  // namespace
}  // namespace kirireel
