#include "sim/generate/families.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "tests/sim/generate/sheet_checks.h"
#include "tests/support/files.h"
#include "tests/support/polygons.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using Given = std::map<std::string, double>;

/// A family and its parameters.
struct Request {
  std::string family;
  Given given;
};

void PrintTo(const Request& request, std::ostream* stream) {
  *stream << request.family;
  for (const auto& [name, value] : request.given) *stream << ' ' << name << ' ' << value;
}

model::Model made(const Request& request) {
  return generate::generateModel(generate::familyNamed(request.family), request.given);
}

bool isFlat(const std::vector<model::Tile>& tiles) {
  return model::liesFlat(tiles, 1e-12);
}

class GeneratedSheet : public testing::TestWithParam<Request> {};

TEST_P(GeneratedSheet, IsCongruentClosedConvexAndFreeOfOverlap) {
  const model::Model model = made(GetParam());
  ASSERT_FALSE(model.tiles.empty());
  std::vector<const std::vector<model::Tile>*> states = {&model.tiles};
  if (model.target) states.push_back(&*model.target);
  for (const std::vector<model::Tile>* tiles : states) {
    EXPECT_LT(test::opening(model, *tiles), 1e-9);  // measured 1.1e-14 at most
    EXPECT_LT(test::warp(*tiles), 1e-9);            // measured 2e-15 at most
    const bool flat = isFlat(*tiles);
    for (const model::Tile& tile : *tiles) {
      const Vector3 up = flat ? Vector3(0, 0, 1) : test::cornerNormal(tile);
      EXPECT_GT(test::convexity(tile, up), 1e-3);
    }
    EXPECT_EQ(test::overlaps(*tiles, flat), 0);
  }
  if (!model.target) return;
  EXPECT_LT(test::incongruence(model), 1e-9);  // measured 9e-15 at most
}

INSTANTIATE_TEST_SUITE_P(
    Family, GeneratedSheet,
    testing::Values(
        Request{"tessellation", {}}, Request{"tessellation", {{"columns", 7}, {"rows", 3}}},
        Request{"tessellation", {{"columns", 9}, {"rows", 10}, {"length", 2}, {"skew", 30}}},
        Request{"tessellation", {{"skew", -50}, {"target-angle", 140}}}, Request{"quads", {}},
        Request{"quads", {{"columns", 4}, {"rows", 8}, {"seed", 2}}},
        Request{"quads", {{"columns", 12}, {"rows", 12}, {"irregularity", 0.1}}},
        Request{"fan", {}}, Request{"fan", {{"columns", 4}, {"rows", 4}}},
        Request{"fan", {{"columns", 8}, {"rows", 8}, {"angle", 90}}}, Request{"heart", {}},
        Request{"heart", {{"columns", 6}, {"rows", 6}}},
        Request{"heart", {{"columns", 10}, {"rows", 10}}}, Request{"square-to-disk", {}},
        Request{"square-to-disk", {{"half-size", 1}}},
        Request{"square-to-disk", {{"half-size", 4}}}, Request{"square-to-circle", {}},
        Request{"square-to-circle", {{"half-size", 2}}},
        Request{"square-to-circle", {{"half-size", 5}}}, Request{"triangles", {}},
        Request{"triangles", {{"columns", 2}, {"rows", 7}, {"target-angle", 120}}},
        Request{"triangles", {{"columns", 8}, {"rows", 8}, {"target-angle", 240}}},
        Request{"hexagons", {}}, Request{"hexagons", {{"columns", 2}, {"rows", 2}}},
        Request{"hexagons", {{"columns", 6}, {"rows", 5}, {"target-angle", 180}}},
        Request{"nonrigid", {}}, Request{"nonrigid", {{"left", 0.5}, {"right", 2}}},
        Request{"nonrigid", {{"depth", 0.8}}}, Request{"cylinder", {}},
        Request{"cylinder", {{"half-columns", 2}, {"rows", 3}}},
        Request{"cylinder", {{"half-columns", 8}, {"rows", 9}, {"length", 1.5}}}));

INSTANTIATE_TEST_SUITE_P(
    Shell, GeneratedSheet,
    testing::Values(Request{"cap", {}}, Request{"cap", {{"half-size", 2}}},
                    Request{"cap", {{"half-size", 3}, {"angle", 30}}},
                    Request{"cap", {{"half-size", 5}}}, Request{"cube-to-sphere", {}},
                    Request{"cube-to-sphere", {{"half-size", 2}}},
                    Request{"cube-to-sphere", {{"half-size", 4}}}, Request{"moebius", {}},
                    Request{"moebius", {{"half-columns", 8}}},
                    Request{"moebius", {{"half-columns", 10}, {"half-twists", 3}}},
                    Request{"moebius", {{"half-twists", 0}}}, Request{"sphere-to-saddle", {}},
                    Request{"sphere-to-saddle", {{"half-columns", 3}, {"half-rows", 3}}},
                    Request{"sphere-to-saddle", {{"half-columns", 5}, {"half-rows", 3}}}));

INSTANTIATE_TEST_SUITE_P(
    Tiling, GeneratedSheet,
    testing::Values(
        Request{"stampfli-chain", {}}, Request{"stampfli-chain", {{"tiles", 216}}},
        Request{"stampfli-chain", {{"tiles", 84}}}, Request{"stampfli-removal", {}},
        Request{"stampfli-removal", {{"tiles", 84}}}, Request{"stampfli-removal", {{"tiles", 300}}},
        Request{"stampfli-expansion", {}}, Request{"stampfli-expansion", {{"tiles", 84}}},
        Request{"stampfli-expansion", {{"tiles", 200}, {"target-angle", 180}}},
        Request{"penrose-chain", {}}, Request{"penrose-chain", {{"tiles", 65}}},
        Request{"penrose-chain", {{"tiles", 100}}}, Request{"penrose-removal", {}},
        Request{"penrose-removal", {{"tiles", 50}}}, Request{"penrose-removal", {{"tiles", 300}}},
        Request{"penrose-expansion", {}}, Request{"penrose-expansion", {{"tiles", 100}}},
        Request{"penrose-expansion", {{"tiles", 200}, {"target-angle", 180}}},
        Request{"ammann-beenker-chain", {}}, Request{"ammann-beenker-chain", {{"tiles", 72}}},
        Request{"ammann-beenker-chain", {{"tiles", 100}}}, Request{"ammann-beenker-removal", {}},
        Request{"ammann-beenker-removal", {{"tiles", 50}}},
        Request{"ammann-beenker-removal", {{"tiles", 300}}},
        Request{"ammann-beenker-expansion", {}},
        Request{"ammann-beenker-expansion", {{"tiles", 100}}},
        Request{"ammann-beenker-expansion", {{"tiles", 200}, {"target-angle", 180}}}));

class ConcaveSheet : public testing::TestWithParam<Request> {};

/// Checked by brute force over all sides of all pairs.
int overlappingPairs(const std::vector<model::Tile>& tiles) {
  int count = 0;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      count += test::cornerDepth(tiles[i], tiles[j]) > 1e-9 ? 1 : 0;
    }
  }
  return count;
}

TEST_P(ConcaveSheet, IsCongruentClosedAndFreeOfOverlap) {
  const model::Model model = made(GetParam());
  EXPECT_LT(test::incongruence(model), 1e-9);  // measured 3e-15 at most
  double least = 1;
  for (const std::vector<model::Tile>* tiles : {&model.tiles, &*model.target}) {
    EXPECT_LT(test::opening(model, *tiles), 1e-9);
    EXPECT_EQ(overlappingPairs(*tiles), 0);
    for (const model::Tile& tile : *tiles) {
      least = std::min(least, test::convexity(tile, Vector3::UnitZ()));
    }
  }
  EXPECT_LT(least, -1e-2);  // concave
}

INSTANTIATE_TEST_SUITE_P(
    Family, ConcaveSheet,
    testing::Values(Request{"stars", {}}, Request{"stars", {{"depth", 0.35}, {"columns", 3}}},
                    Request{"crosses", {}}, Request{"crosses", {{"width", 0.6}, {"rows", 2}}},
                    Request{"islamic", {}}, Request{"islamic", {{"depth", 0.15}}},
                    Request{"trefoils", {}}, Request{"trefoils", {{"target-angle", 150}}}));

/// Families whose published models have so many tiles and joints.
TEST(Families, HaveThePublishedCounts) {
  const struct {
    Request request;
    std::size_t tiles, joints;
  } published[] = {{{"cylinder", {}}, 36, 66},
                   {{"cube-to-sphere", {}}, 216, 408},
                   {{"cube-to-sphere", {{"half-size", 4}}}, 384, 736},
                   {{"sphere-to-saddle", {}}, 100, 180},
                   {{"moebius", {}}, 24, 34},
                   {{"fan", {}}, 36, 60},
                   {{"heart", {}}, 16, 24},
                   {{"square-to-disk", {}}, 25, 40},
                   {{"square-to-circle", {}}, 36, 60},
                   {{"nonrigid", {}}, 4, 4},
                   {{"stampfli-chain", {}}, 24, 24},
                   {{"stampfli-removal", {}}, 108, 132}};
  for (const auto& [request, tiles, joints] : published) {
    const model::Model model = made(request);
    EXPECT_EQ(model.tiles.size(), tiles) << request.family;
    EXPECT_EQ(model.joints.size(), joints) << request.family;
  }
}

std::string messageFor(const Request& request) {
  return test::refusalOf([&] { made(request); });
}

TEST(Families, ReportWrongParameters) {
  EXPECT_EQ(messageFor({"cap", {{"half-size", 9}}}),
            "cap: error: half-size is 9, but must be a whole number in [1, 6]");
  EXPECT_EQ(messageFor({"cap", {{"half-size", 2.5}}}),
            "cap: error: half-size is 2.5, but must be a whole number in [1, 6]");
  EXPECT_EQ(messageFor({"nonrigid", {{"depth", -1}}}),
            "nonrigid: error: depth is -1, but must be a number in [1e-06, 1e+06]");
  EXPECT_EQ(messageFor({"heart", {{"size", 3}}}),
            "heart: error: there is no parameter size. Available: columns, rows, start-angle, "
            "target-angle");
  EXPECT_TRUE(
      messageFor({"hart", {}})
          .starts_with(
              "error: there is no family hart, did you mean heart?; give one of tessellation,"));
}

/// Two corners of a convex tile are 1e-12 of its diameter apart.
const Request kShortSide{"nonrigid", {{"left", 2e-6}, {"depth", 1e-6}, {"right", 1e6}}};

TEST(Families, RefuseImpossibleSheets) {
  // Tiles of the narrow strip fold over.
  EXPECT_EQ(messageFor({"heart", {{"columns", 8}, {"rows", 8}}}),
            "heart: error: no sheet with these parameters was found (tiles are not convex at the "
            "start). Use values nearer to the defaults");
  // Bays begin at 0.35 of a side and are 0.4 deep, so those of two sides meet.
  const auto crosses = [](double width, double depth) {
    return messageFor({"crosses",
                       {{"columns", 3},
                        {"rows", 6},
                        {"width", width},
                        {"depth", depth},
                        {"start-angle", 18.41}}});
  };
  EXPECT_EQ(crosses(0.3, 0.4),
            "crosses: error: no sheet with these parameters was found (tile 0 crosses or touches "
            "itself at the start). Use values nearer to the defaults");
  // Sides in one line do not cross, in any rotation.
  EXPECT_EQ(crosses(0.318, 0.147), "accepted");
  EXPECT_EQ(
      messageFor({"tessellation", {{"width", 1e-6}}}),
      "tessellation: error: no sheet with these parameters was found (tile 0 is too narrow at "
      "the start). Use values nearer to the defaults");
  EXPECT_EQ(messageFor(kShortSide),
            "nonrigid: error: no sheet with these parameters was found (tile 0 has two corners at "
            "one position at the start). Use values nearer to the defaults");
  // The first ring of Stampfli's tiling has only narrow rhombi.
  EXPECT_EQ(messageFor({"stampfli-removal", {{"tiles", 10}}}),
            "removal: error: all 12 tiles are narrow. Use a larger number of tiles");
  EXPECT_EQ(
      messageFor({"ammann-beenker-chain", {{"tiles", 20}}}),
      "chain: error: no closed chain through all 24 tiles was found. Use another number of tiles");
}

/// Each parameter at both ends of its range, the others at their defaults. Counts of tiles only at
/// their least: large sheets take long.
std::vector<Request> requestsAtEnds() {
  std::vector<Request> requests;
  for (const generate::Family& family : generate::families()) {
    for (const generate::FamilyParameter& parameter : family.parameters) {
      requests.push_back({family.name, {{parameter.name, parameter.least}}});
      if (parameter.whole) continue;
      requests.push_back({family.name, {{parameter.name, parameter.most}}});
    }
  }
  requests.push_back(kShortSide);
  return requests;
}

TEST(Families, AreReadableAtTheEndsOfTheirRanges) {
  int readable = 0;
  for (const Request& request : requestsAtEnds()) {
    model::Model model;
    if (test::refusalOf([&] { model = made(request); }) != "accepted") continue;
    const test::TemporaryFolder folder;
    formats::writeModelFolder(model, folder.path());
    std::vector<std::string> warnings;
    EXPECT_EQ(test::refusalOf([&] { formats::readModelFolder(folder.path(), warnings); }),
              "accepted")
        << testing::PrintToString(request);
    EXPECT_THAT(warnings, testing::IsEmpty()) << testing::PrintToString(request);
    ++readable;
  }
  EXPECT_GT(readable, 100);
}

/// Values of a family's lengths, the defaults times a factor.
Given lengthsTimes(const generate::Family& family, double factor) {
  Given given;
  for (const generate::FamilyParameter& parameter : family.parameters) {
    if (parameter.unit == "METRES") given[parameter.name] = factor * parameter.defaultValue;
    if (parameter.unit == "1/METRES") given[parameter.name] = parameter.defaultValue / factor;
  }
  return given;
}

/// The largest distance between a model's vertices and those of another times a factor.
double largestDistance(const model::Model& model, model::Model other, double factor) {
  model::scaleLengths(other, factor);
  const auto distance = [](const auto& tiles, const auto& others) {
    double largest = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      for (std::size_t k = 0; k < tiles[i].vertices.size(); ++k) {
        largest = std::max(largest, (tiles[i].vertices[k] - others[i].vertices[k]).norm());
      }
    }
    return largest;
  };
  return std::max(distance(model.tiles, other.tiles), distance(*model.target, *other.target));
}

TEST(Families, ScaleWithTheirLengths) {
  for (const generate::Family& family : generate::families()) {
    if (lengthsTimes(family, 1).empty()) continue;
    const model::Model model = generate::generateModel(family, {});
    for (const double factor : {1e-5, 0.75, 1.3, 1e4}) {
      // The range of the curvature is narrower than that of lengths.
      const bool hasCurvature = lengthsTimes(family, 1).contains("curvature");
      if (hasCurvature && (factor < 0.4 || factor > 40)) continue;
      const model::Model scaled = generate::generateModel(family, lengthsTimes(family, factor));
      // Measured 3.5e-8 m at most: a fit's start is equal only to rounding.
      EXPECT_LT(largestDistance(scaled, model, factor) / factor, 1e-6)
          << family.name << ' ' << factor;
    }
  }
}

TEST(Families, GiveTheSameModelEveryTime) {
  for (const char* family : {"moebius", "penrose-chain", "quads"}) {
    const model::Model first = made({family, {}}), second = made({family, {}});
    for (std::size_t i = 0; i < first.tiles.size(); ++i) {
      EXPECT_EQ(first.tiles[i].vertices, second.tiles[i].vertices) << family;
    }
  }
}

}  // namespace
}  // namespace kirireel
