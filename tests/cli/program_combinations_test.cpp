// Short runs of every combination of a few choices: none crashes or hangs, and contradictions are
// refused in one line.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <sstream>

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/covering_array.h"
#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// ------------------------------------------------------------------------------------------------
// The models.

using Point = std::array<double, 3>;
using Outline = std::vector<Point>;

struct TestModel {
  std::vector<Outline> tiles;
  std::vector<std::array<int, 5>> joints;
  std::vector<Outline> target;  // empty: none
};

void write(const TestModel& model, const fs::path& folder) {
  fs::create_directories(folder);
  const auto text = [](const std::vector<Outline>& tiles) {
    std::string lines;
    for (const Outline& tile : tiles) {
      for (const Point& point : tile) lines += fmt::format("{} ", fmt::join(point, " "));
      lines += '\n';
    }
    return lines;
  };
  writeText(folder / "vertices.txt", text(model.tiles));
  if (!model.target.empty()) writeText(folder / "target.txt", text(model.target));
  std::string joints = "# joints\n";
  for (const auto& joint : model.joints) joints += fmt::format("{}\n", fmt::join(joint, " "));
  writeText(folder / "constraints.txt", joints);
}

/// Two by two rotating squares of edge 1, each turned by an angle.
std::vector<Outline> squares(double angle) {
  std::vector<Outline> tiles;
  const double pitch = std::cos(angle) + std::sin(angle);
  for (int tile = 0; tile < 4; ++tile) {
    const double turn = (tile == 0 || tile == 3) ? angle : -angle;
    Outline& outline = tiles.emplace_back();
    for (int k = 0; k < 4; ++k) {
      const double direction = turn + (2 * k - 3) * std::numbers::pi / 4;
      outline.push_back({tile % 2 * pitch + std::sqrt(0.5) * std::cos(direction),
                         tile / 2 * pitch + std::sqrt(0.5) * std::sin(direction), 0});
    }
  }
  return tiles;
}

TestModel flat() {
  // Corners count from the lower left one of a tile that is not rotated.
  return {squares(0.15),
          {{0, 1, 1, 0, 3}, {2, 2, 3, 3, 3}, {0, 2, 2, 1, 3}, {1, 3, 3, 0, 3}},
          squares(0.6)};
}

/// Every point changed.
TestModel moved(TestModel model, const std::function<Point(const Point&)>& change) {
  for (std::vector<Outline>* state : {&model.tiles, &model.target}) {
    for (Outline& tile : *state) std::ranges::transform(tile, tile.begin(), change);
  }
  return model;
}

TestModel upright() {
  return moved(flat(), [](const Point& p) { return Point{p[0], -p[2], p[1] + 2}; });
}

/// Three squares in a row, hinged at edges, that fold.
TestModel spatial() {
  const auto strip = [](double fold) {
    std::vector<Outline> tiles;
    double x = 0, z = 0;
    for (int k = 0; k < 3; ++k) {
      const double nextX = x + std::cos(k * fold), nextZ = z + std::sin(k * fold);
      tiles.push_back({{x, 0, z}, {nextX, 0, nextZ}, {nextX, 1, nextZ}, {x, 1, z}});
      x = nextX;
      z = nextZ;
    }
    return tiles;
  };
  return {
      strip(0.1), {{0, 1, 1, 0, 1}, {0, 2, 1, 3, 1}, {1, 1, 2, 0, 1}, {1, 2, 2, 3, 1}}, strip(0.6)};
}

/// Two angles that share a corner.
TestModel concave() {
  const auto angles = [](double turn) {
    const Outline angle = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
    Outline other;
    for (const Point& p : angle) {
      const double x = p[0], y = -p[1];
      other.insert(other.begin(), {2 + x * std::cos(turn) - y * std::sin(turn),
                                   x * std::sin(turn) + y * std::cos(turn), 0});
    }
    return std::vector<Outline>{angle, other};
  };
  return {angles(-0.1), {{0, 1, 1, 5, 3}}, angles(-0.8)};
}

TestModel jointless() {
  const auto square = [](double x, double y) {
    return Outline{{x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}};
  };
  return {{square(0, 0), square(1.2, 0)}, {}, {square(0, 0), square(1.5, 0.3)}};
}

TestModel targetless() {
  TestModel model = flat();
  model.target.clear();
  return model;
}

// ------------------------------------------------------------------------------------------------
// The choices. The first of each factor conflicts with nothing. A scene file has those that have no
// effect in some of the rows: on the command line these would be refused.

struct Choice {
  std::string name;
  Words words = {};           // of the command line
  std::string lists = "";     // of scene.toml, [[...]]
  std::string settings = "";  // of scene.toml, TABLE.KEY = VALUE
};

struct Factor {
  std::string name;
  std::vector<Choice> choices;
};

enum FactorNumber {
  kModel,
  kContacts,
  kGround,
  kGravity,
  kObstacle,
  kFriction,
  kActuation,
  kPins,
  kGrips,
  kHinges,
  kTimeline,
  kPlanar,
  kPath,
  kSolver,
  kTolerance,
  kResume,
  kSpelling
};

const std::vector<Factor>& factors() {
  static const std::vector<Factor> all = {
      {"model", {{"flat"}, {"upright"}, {"spatial"}, {"concave"}, {"jointless"}, {"targetless"}}},
      {"contacts",
       {{"auto"},
        {"none", {"--contacts", "none"}},
        {"unjoined", {"--contacts", "unjoined"}},
        {"all", {"--contacts", "all"}}}},
      {"ground", {{"no"}, {"yes", {"--ground"}}}},
      {"gravity", {{"no"}, {"down", {"--gravity", "-10"}}, {"oblique", {"--gravity", "1,0,-2"}}}},
      {"obstacle",
       {{"no"},
        {"box", {}, "[[obstacle]]\nshape = \"box\"\nsize = [1, 1, 0.5]\nposition = [0, 0, -1]\n"},
        {"sphere",
         {},
         "[[obstacle]]\nshape = \"sphere\"\nradius = 0.5\nposition = [0, 0, -1.2]\n"}}},
      {"friction",
       {{"no"},
        {"bricks", {}, "", "environment.brick_friction = 0.5\n"},
        {"ground", {"--ground-friction", "0.3"}}}},
      {"actuation",
       {{"auto"},
        {"target", {}, "", "actuation.actuation = \"target\"\n"},
        {"expansion", {}, "", "actuation.actuation = \"expansion\"\n"},
        {"boundary", {}, "", "actuation.actuation = \"boundary\"\n"},
        {"none", {}, "", "actuation.actuation = \"none\"\n"}}},
      {"pins", {{"no"}, {"first", {"--pin", "0"}}, {"two", {"--pin", "0,1"}}}},
      {"grips",
       {{"no"},
        {"pull",
         {},
         "[[grip]]\ntile = 0\nmove = {x = 0, y = 0}\n[[grip]]\ntile = 1\nmove = {x = 0.1, y = 0}\n",
         "model.hinge_stiffness = 0.02\n"}}},
      {"hinges",
       {{"no"},
        {"stiffness", {"--hinge-stiffness", "0.02"}},
        {"ligaments", {"--hinge-neck", "0.05,0.1,1e6", "--ligaments", "--planar", "on"}}}},
      {"timeline",
       {{"no"},
        {"pins",
         {},
         "[[timeline]]\nat = 0.02\npin = [0]\n[[timeline]]\nat = 0.05\nunpin = \"all\"\n"},
        {"pause",
         {},
         "[[timeline]]\nat = 0.02\npause = 0.02\n[[timeline]]\nat = 0.06\nreset = true\n"}}},
      {"planar", {{"auto"}, {"on", {"--planar", "on"}}, {"off", {"--planar", "off"}}}},
      {"path",
       {{"auto"},
        {"continuation", {}, "", "actuation.path = \"continuation\"\n"},
        {"dynamic", {}, "", "actuation.path = \"dynamic\"\n"},
        {"straight", {}, "", "actuation.path = \"straight\"\n"},
        {"guided", {}, "", "actuation.path = \"guided\"\n"}}},
      {"solver", {{"direct"}, {"bullet", {"--solver", "bullet"}}}},
      {"tolerance",
       {{"default"},
        {"fixed", {}, "", "solver.tolerance = 0\n"},
        {"fine", {}, "", "solver.tolerance = 1e-5\n"}}},
      {"resume", {{"no"}, {"interrupted"}}},
      {"spelling", {{"own"}, {"PyKirigami", {"--brick_thickness", "0.02"}}}}};
  return all;
}

int choiceNamed(FactorNumber factor, const std::string& name) {
  const std::vector<Choice>& choices = factors()[factor].choices;
  return static_cast<int>(std::ranges::find(choices, name, &Choice::name) - choices.begin());
}

using test::Conflict;

/// Pairs of choices that are refused. They are run separately. In the rows they would hide all
/// other choices.
std::vector<Conflict> conflicts() {
  std::vector<Conflict> all;
  const auto add = [&all](FactorNumber a, const Words& as, FactorNumber b, const Words& bs) {
    for (const std::string& nameA : as) {
      for (const std::string& nameB : bs) {
        all.push_back({{{a, choiceNamed(a, nameA)}, {b, choiceNamed(b, nameB)}}});
      }
    }
  };
  add(kSolver, {"bullet"}, kPins, {"first", "two"});
  add(kSolver, {"bullet"}, kObstacle, {"box", "sphere"});
  add(kSolver, {"bullet"}, kGrips, {"pull"});
  add(kSolver, {"bullet"}, kHinges, {"stiffness", "ligaments"});
  add(kSolver, {"bullet"}, kPath, {"continuation", "guided"});
  add(kSolver, {"bullet"}, kTolerance, {"fine"});
  add(kSolver, {"bullet"}, kTimeline, {"pins"});
  add(kPath, {"guided"}, kActuation, {"expansion", "boundary", "none"});
  add(kPath, {"guided"}, kTolerance, {"fine"});
  add(kPath, {"continuation"}, kGravity, {"down", "oblique"});
  add(kPath, {"continuation"}, kGround, {"yes"});
  add(kPath, {"continuation"}, kFriction, {"bricks", "ground"});
  add(kPath, {"continuation"}, kObstacle, {"box", "sphere"});
  add(kPath, {"continuation"}, kTimeline, {"pins", "pause"});
  add(kPath, {"continuation"}, kActuation, {"expansion", "boundary", "none"});
  add(kPath, {"continuation"}, kTolerance, {"fine"});
  add(kPath, {"continuation"}, kHinges, {"stiffness", "ligaments"});
  add(kGrips, {"pull"}, kContacts, {"unjoined", "all"});
  add(kGrips, {"pull"}, kGravity, {"down", "oblique"});
  add(kGrips, {"pull"}, kGround, {"yes"});
  add(kGrips, {"pull"}, kFriction, {"bricks", "ground"});
  add(kGrips, {"pull"}, kObstacle, {"box", "sphere"});
  add(kGrips, {"pull"}, kPath, {"dynamic", "straight", "guided"});
  add(kGrips, {"pull"}, kTimeline, {"pins", "pause"});
  add(kGrips, {"pull"}, kTolerance, {"fine"});
  add(kGrips, {"pull"}, kSpelling, {"PyKirigami"});
  add(kGrips, {"pull"}, kPlanar, {"off"});
  add(kGrips, {"pull"}, kModel, {"upright", "spatial", "jointless"});
  add(kHinges, {"ligaments"}, kPlanar, {"off"});
  add(kHinges, {"ligaments"}, kObstacle, {"box", "sphere"});
  add(kHinges, {"ligaments"}, kModel, {"spatial"});
  add(kHinges, {"stiffness", "ligaments"}, kModel, {"jointless"});
  add(kObstacle, {"box", "sphere"}, kPlanar, {"on"});
  add(kGrips, {"pull"}, kPins, {"two"});  // the gripped tile is pinned
  add(kPath, {"continuation"}, kPins, {"first", "two"});
  add(kPath, {"continuation"}, kSpelling, {"PyKirigami"});
  // Planar runs, such as those of ligaments, need a horizontal sheet on the ground, which friction
  // adds. In the plane, edges of the strip are no hinges.
  const test::FactorValue upright = {kModel, choiceNamed(kModel, "upright")};
  const test::FactorValue inPlane = {kPlanar, choiceNamed(kPlanar, "on")};
  for (const test::FactorValue& ground : {test::FactorValue{kGround, choiceNamed(kGround, "yes")},
                                          {kFriction, choiceNamed(kFriction, "ground")}}) {
    all.push_back({upright, ground, inPlane});
    all.push_back({upright, ground, {kHinges, choiceNamed(kHinges, "ligaments")}});
  }
  all.push_back({{kModel, choiceNamed(kModel, "spatial")},
                 inPlane,
                 {kHinges, choiceNamed(kHinges, "stiffness")}});
  return all;
}

// ------------------------------------------------------------------------------------------------
// The runs.

class Combinations : public testing::Test {
 protected:
  Combinations() {
    const std::vector<std::function<TestModel()>> models = {flat,    upright,   spatial,
                                                            concave, jointless, targetless};
    for (std::size_t k = 0; k < models.size(); ++k) {
      write(models[k](), scratch_ / factors()[kModel].choices[k].name);
    }
  }

  /// The words of a run. Writes its scene file.
  Words wordsOf(const std::vector<int>& row) {
    Words words = {"simulate"};
    std::string scene;
    const std::string model = (scratch_ / factors()[kModel].choices[row[kModel]].name).string();
    for (std::size_t k = 1; k < row.size(); ++k) {
      const Choice& choice = factors()[k].choices[row[k]];
      words.insert(words.end(), choice.words.begin(), choice.words.end());
      // Lists of tables end the keys before them.
      scene = choice.settings + scene + choice.lists;
    }
    if (row[kSpelling] == 1) words.push_back("--model");
    words.push_back(model);
    writeText(scratch_ / "scene.toml", "actuation.search_effort = 0\n" + scene);
    const Words rest = {"--scene",    (scratch_ / "scene.toml").string(),
                        "--out",      (scratch_ / "out").string(),
                        "--duration", "5"};
    words.insert(words.end(), rest.begin(), rest.end());
    return words;
  }

  /// A run that takes too long has the exit code 124 of timeout(1).
  static ProgramEnd runWithin(const Words& limit, const Words& words) {
    Words all = limit;
    all.push_back(KIRIREEL_PROGRAM);
    all.insert(all.end(), words.begin(), words.end());
    return runTool("timeout", all);
  }

  /// Runs a row. Returns the last exit code.
  int expectFine(const std::vector<int>& row) {
    const Words words = wordsOf(row);
    SCOPED_TRACE(
        fmt::format("kirireel {}\n{}", fmt::join(words, " "), readText(scratch_ / "scene.toml")));
    fs::remove_all(scratch_ / "out");
    if (row[kResume] == 0) return expectFine(runWithin({"120"}, words), false);
    // The first run is interrupted as soon as it handles signals, at a point that depends on the
    // machine. The second completes it.
    double seconds = 0.05;
    while (
        expectFine(runWithin({"--preserve-status", "-s", "INT", fmt::format("{}", seconds)}, words),
                   true) == kEndedBySignal) {
      seconds *= 1.5;
    }
    Words again = words;
    again.push_back("--resume");
    return expectFine(runWithin({"120"}, again), false);
  }

  static constexpr int kEndedBySignal = 128 + 2;

  int expectFine(const ProgramEnd& end, bool mayBeInterrupted) {
    ++runs_;
    message_ = end.err;
    // A signal before the program handles signals ends it.
    const bool isEarly = mayBeInterrupted && end.exitCode == kEndedBySignal;
    const bool isFine = isEarly || (end.exitCode >= 0 && end.exitCode <= 4);
    EXPECT_TRUE(isFine) << "exit code " << end.exitCode << "\n" << end.err;
    EXPECT_THAT(end.err, testing::Not(testing::HasSubstr("Sanitizer")));
    EXPECT_THAT(end.err, testing::Not(testing::HasSubstr("runtime error")));
    if (!isFine) ++faults_;
    // A run whose bricks are lost fails (exit code 1), and its output reports the reason.
    const Words printed = lines(end.err);
    const auto errors = std::ranges::count_if(printed, isError);
    if (end.exitCode == 2) {
      EXPECT_EQ(errors, 1) << end.err;
    } else {
      EXPECT_LE(errors, 1) << end.err;
    }
    return end.exitCode;
  }

  static bool isError(const std::string& line) { return line.find(": error: ") != line.npos; }

  static Words lines(const std::string& text) {
    Words lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }

  void runPart(int strength, int part, int parts) {
    std::vector<int> counts;
    for (const Factor& factor : factors())
      counts.push_back(static_cast<int>(factor.choices.size()));
    const std::vector<std::vector<int>> rows = test::coveringArray(counts, strength, conflicts());
    for (std::size_t k = static_cast<std::size_t>(part); k < rows.size();
         k += static_cast<std::size_t>(parts)) {
      if (expectFine(rows[k]) == 2) {
        ++refused_;
        fmt::print("refused: kirireel {}\n{}", fmt::join(wordsOf(rows[k]), " "), message_);
      }
    }
    // A refused row tests none of its other choices. Measured: 0.02 of the rows of pairs, 0.01 to
    // 0.04 of each part of fours.
    EXPECT_LE(refused_ * parts, 0.05 * static_cast<double>(rows.size()));
    fmt::print("{} rows, {} runs, {} refused, {} faults\n", rows.size(), runs_, refused_, faults_);
  }

  std::string message_;  // of the last run
  TemporaryFolder scratch_;
  int runs_ = 0;
  int refused_ = 0;  // rows
  int faults_ = 0;
};

TEST_F(Combinations, OfTwoChoicesEndNormally) {
  runPart(2, 0, 1);
}

TEST_F(Combinations, ThatConflictAreRefused) {
  for (const Conflict& conflict : conflicts()) {
    std::vector<int> row(factors().size(), 0);
    for (const test::FactorValue& choice : conflict) row[choice.factor] = choice.value;
    std::string names;
    for (const auto& [factor, value] : conflict) {
      names += factors()[factor].name + " " + factors()[factor].choices[value].name + ", ";
    }
    EXPECT_EQ(expectFine(row), 2) << names;
  }
}

// Bricks that overlap and fall on the ground.
TEST_F(Combinations, OfGroundGravityAndNoContactsRun) {
  std::vector<int> row(factors().size(), 0);
  row[kContacts] = choiceNamed(kContacts, "none");
  row[kGround] = row[kGravity] = 1;
  row[kPlanar] = choiceNamed(kPlanar, "off");
  for (const int resume : {0, 1}) {
    for (const int spelling : {0, 1}) {
      row[kResume] = resume;
      row[kSpelling] = spelling;
      expectFine(row);
    }
  }
}

class EveryFour : public Combinations, public testing::WithParamInterface<int> {};

constexpr int kParts = 8;

TEST_P(EveryFour, EndNormally) {
  runPart(4, GetParam(), kParts);
}

INSTANTIATE_TEST_SUITE_P(Combinations, EveryFour, testing::Range(0, kParts));

}  // namespace
}  // namespace kirireel
