// Default deployments: every model of the given folders as `kirireel record` would deploy it, or
// members of all families drawn at random, one per row. Prints where it ended against the least
// error found (without a target, the factor by which the tiles' squared distances from their centre
// grew), how deep bricks overlapped beyond the start, the largest joint gap (where joints open,
// also the smallest that the string method finds), the path's length over the one of the tiles' own
// motions (and the mobility of the tiles if it is long), how far states are from the symmetries
// that the model has, and CPU seconds: of the search, and of the run. Lengths are in tiles. A row
// begins with "holds", or with what it misses:
//   far      it ends farther from the target than 1.05 x the smallest error found and 1e-6 tiles
//   long     its path is longer than 1.5 x the tiles' own motions, and 5% longer than the least
//            to which the string method shortens it: many mechanisms have no path of that length
//   back     it turns back: two moves between samples, one after the other, are opposed
//   overlap  bricks overlap by more than 1e-4 tiles beyond the start, and no warning reports it
//   open     joints open by more than 1e-10 tiles and 1.2 x the smallest that was found
// Rows whose bricks would overlap at the target are marked as blocked there. The last line counts.
//
//     build/release/tests/bench/deployments [FOLDER ...] [--search-effort FACTOR] [--contacts auto]
//     build/release/tests/bench/deployments --seed 1 --count 40 [--tiles 100]

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/deploy/deployment.h"
#include "sim/formats/read_model.h"
#include "sim/model/isometry.h"
#include "sim/run/mechanism_path.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/sheet.h"
#include "tests/bench/string_method.h"
#include "tests/support/drawn_models.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

constexpr double kClosed = 1e-10;  // gap in tiles, of joints that are exact
constexpr double kOpen = 1.2;      // of the smallest opening found
constexpr double kLong = 1.05;     // of the smallest length found
constexpr double kFar = 1.05;      // of the smallest error found
constexpr double kArrived = 1e-6;  // error in tiles
constexpr double kBack = 0.1;      // cosine of two opposed moves, up to rounding

const std::map<std::string, scene::ContactFilter> kFilters = {
    {"auto", scene::ContactFilter::Auto},
    {"none", scene::ContactFilter::None},
    {"unjoined", scene::ContactFilter::Unjoined},
    {"all", scene::ContactFilter::All}};

std::vector<fs::path> modelsIn(const fs::path& folder) {
  if (fs::exists(folder / "vertices.txt") || fs::is_regular_file(folder)) return {folder};
  std::vector<fs::path> models;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const bool isContracted = entry.path().filename().string().ends_with("_contracted.obj");
    if (isContracted || fs::exists(entry.path() / "vertices.txt")) models.push_back(entry.path());
  }
  std::ranges::sort(models);
  return models;
}

/// The length of the run's motion over that of the tiles' own motions to the same end.
double windingOf(const scene::Scene& scene, const trajectory::Trajectory& trajectory) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<trajectory::Sample>& samples = trajectory.samples;
  double length = 0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    length += run::pathDistance(bricks, samples[k - 1].poses, samples[k].poses);
  }
  if (length == 0) return 1;
  return length / run::pathDistance(bricks, samples.front().poses, samples.back().poses);
}

/// Mobility of the tiles at a fraction of the run, without rigid motions of the whole.
int freedomsAt(const scene::Scene& scene, const trajectory::Trajectory& trajectory, double part) {
  const auto last = static_cast<double>(trajectory.samples.size() - 1);
  const trajectory::Sample& middle =
      trajectory.samples[static_cast<std::size_t>(std::lround(part * last))];
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  std::vector<model::Tile> tiles = scene.model.tiles;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < tiles[i].vertices.size(); ++k) {
      tiles[i].vertices[k] = middle.poses[i].apply(bricks[i].bottom[k]);
    }
  }
  const trajectory::Freedom freedom =
      scene::sceneNeeds(scene).planar.on ? trajectory::Freedom::Plane : trajectory::Freedom::Space;
  return trajectory::mobility(scene.model, tiles, freedom, scene.brick.thickness).freedoms;
}

/// The largest of the values at a quarter, half and three quarters of the run.
int freedomsOf(const scene::Scene& scene, const trajectory::Trajectory& trajectory) {
  return std::max({freedomsAt(scene, trajectory, 0.25), freedomsAt(scene, trajectory, 0.5),
                   freedomsAt(scene, trajectory, 0.75)});
}

std::vector<Poses> statesOf(const trajectory::Trajectory& trajectory) {
  std::vector<Poses> states;
  for (const trajectory::Sample& sample : trajectory.samples) states.push_back(sample.poses);
  return states;
}

/// Largest allowed overlap of another path beyond the start, metres: that of the run, or the limit
/// of collision-free paths.
double maxGrownOf(const scene::Scene& scene, const run::DeploymentResult& result) {
  return std::max(run::kAllowedOverlap * model::tileSize(scene.model),
                  result.accuracy.penetrationGrownMax);
}

/// Figures of a row, and the requirements that it misses.
struct Row {
  std::string words;
  std::vector<std::string> missed;

  void add(const std::string& more) { words += " " + more; }
  void require(bool holds, const char* what) {
    if (!holds) missed.emplace_back(what);
  }
};

// Longer runs, over the tiles' own motions, are compared with the string method.
constexpr double kDetour = 1.5;

/// The length of a run over that of its tiles' own motions. For a long one, also the number of
/// freedoms of its tiles and the length to which the string method shortens it. A mechanism whose
/// tiles must move apart to turn has no path as short as the tiles' own motions.
void addWinding(const scene::Scene& scene, const run::DeploymentResult& result, Row& row) {
  const trajectory::Trajectory& trajectory = result.trajectory;
  const double winding = windingOf(scene, trajectory);
  row.add(fmt::format("winding {:5.2f}", winding));
  if (winding <= kDetour) return;
  const double least = minLength(scene, statesOf(trajectory), maxGrownOf(scene, result));
  row.add(fmt::format("freedom {} shortened {:.2f}", freedomsOf(scene, trajectory), least));
  row.require(least * kLong >= 1, "long");
}

/// Whether two consecutive moves between samples are opposed: the cosine of their angle is clearly
/// below 0.
bool turnsBack(const scene::Scene& scene, const trajectory::Trajectory& trajectory) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<trajectory::Sample>& samples = trajectory.samples;
  for (std::size_t k = 2; k < samples.size(); ++k) {
    const double first = run::pathDistance(bricks, samples[k - 2].poses, samples[k - 1].poses);
    const double second = run::pathDistance(bricks, samples[k - 1].poses, samples[k].poses);
    const double both = run::pathDistance(bricks, samples[k - 2].poses, samples[k].poses);
    if (both * both < first * first + second * second - 2 * kBack * first * second) return true;
  }
  return false;
}

/// The sum of squared distances of the tiles' centres from their common centre, square metres.
double extentOf(const Poses& poses) {
  Vector3 centre = Vector3::Zero();
  for (const Pose& pose : poses) centre += pose.position / static_cast<double>(poses.size());
  double sum = 0;
  for (const Pose& pose : poses) sum += (pose.position - centre).squaredNorm();
  return sum;
}

/// The end of a run: its target error, or the extension of a sheet without a target.
void addEnd(const scene::Scene& scene, const run::DeploymentResult& result, Row& row) {
  const std::vector<trajectory::Sample>& samples = result.trajectory.samples;
  if (!scene.model.target) {
    row.add(fmt::format("extended {:.9f}",
                        extentOf(samples.back().poses) / extentOf(samples.front().poses)));
    return;
  }
  const double tile = model::tileSize(scene.model);
  const double error = result.accuracy.targetErrorEnd, least = result.assembledError;
  row.add(fmt::format("error {:8.1e} least {:8.1e}", error / tile, least / tile));
  if (!result.blocking.empty())
    row.add(fmt::format("blocked {} by {:.1e}", result.blocking.size(),
                        result.blocking.front().overlap / tile));
  row.require(error <= std::max(kFar * least, kArrived * tile), "far");
}

/// The opening of joints. If they opened, also the smallest opening that the string method finds
/// from the run's own states and from the tiles' own motions, and the ratio of the two.
void addGap(const scene::Scene& scene, const run::DeploymentResult& result, Row& row) {
  const double tile = model::tileSize(scene.model);
  const double opening = std::max(result.accuracy.jointGapMax, result.accuracy.jointOpeningMax);
  row.add(fmt::format("gap {:8.1e}", opening / tile));
  if (opening <= kClosed * tile) return;
  const std::vector<Poses> states = statesOf(result.trajectory);
  const double maxGrown = result.needs.contacts.on ? maxGrownOf(scene, result)
                                                   : std::numeric_limits<double>::infinity();
  const double least = std::min(minOpening(scene, states, maxGrown),
                                minOpening(scene, {states.front(), states.back()}, maxGrown));
  row.add(fmt::format("least {:8.1e} ratio {:.2f}", least / tile, opening / least));
  row.require(opening <= kOpen * least, "open");
}

/// The largest distance of the run from the symmetries of its model, metres, and their number.
std::string asymmetryOf(const scene::Scene& scene, const trajectory::Trajectory& trajectory) {
  const std::vector<model::Symmetry> group = model::symmetriesOf(scene.model);
  const double tile = model::tileSize(scene.model);
  double farthest = 0;
  for (const trajectory::Sample& sample : trajectory.samples) {
    farthest = std::max(farthest, model::asymmetry(sample.poses, group, tile));
  }
  return fmt::format("{:8.1e} of {:>2}", farthest / tile, group.size());
}

/// Numbers of rows.
struct Tally {
  int rows = 0;
  int held = 0;
  int blocked = 0;      ///< whose bricks would overlap at the target
  int heldBlocked = 0;  ///< of them

  void count(bool holds, bool isBlocked) {
    ++rows;
    if (holds) ++held;
    if (isBlocked) ++blocked;
    if (holds && isBlocked) ++heldBlocked;
  }

  void print() const {
    const int free = rows - blocked, heldFree = held - heldBlocked;
    fmt::print("{} of {} rows hold; of {} whose bricks do not overlap at the target {} ({:.0f}%)\n",
               held, rows, free, heldFree, free > 0 ? 100.0 * heldFree / free : 100);
  }
};

void addOverlap(const scene::Scene& scene, const run::DeploymentResult& result, Row& row) {
  const double tile = model::tileSize(scene.model);
  const double grown = result.accuracy.penetrationGrownMax;
  row.add(fmt::format("overlap {:8.1e}", grown / tile));
  const bool isReported = std::ranges::any_of(result.warnings, [](const std::string& warning) {
    return warning.find("bricks pass") != std::string::npos ||
           warning.find("into each other") != std::string::npos;
  });
  row.require(grown <= run::kAllowedOverlap * tile || isReported, "overlap");
}

void printRow(const std::string& name, scene::Scene scene, Tally& tally) {
  if (scene.model.target) model::alignStartToTarget(scene.model);
  scene::fillFromModel(scene);
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 30, nullptr);
  const bool isContinuation = result.path.kind == scene::PathKind::Continuation;
  Row row;
  addEnd(scene, result, row);
  addOverlap(scene, result, row);
  addGap(scene, result, row);
  addWinding(scene, result, row);
  row.require(!turnsBack(scene, result.trajectory), "back");
  tally.count(row.missed.empty(), !result.blocking.empty());
  fmt::print(
      "{:<12} {:<30} {:>4} {:<11} {:<12}{} asymmetry {} contacts {} {:6.2f} + {:6.2f} s  {}\n",
      row.missed.empty() ? "holds" : fmt::format("{}", fmt::join(row.missed, ",")), name,
      scene.model.tiles.size(), run::toString(result.outcome),
      isContinuation ? "continuation" : "dynamic", row.words, asymmetryOf(scene, result.trajectory),
      result.needs.contacts.on ? "on " : "off", result.cost.cpuSecondsSearch,
      result.cost.cpuSeconds, isContinuation ? result.needs.contacts.reason : result.pathReason);
  std::fflush(stdout);
}

void deployAll(const std::vector<std::string>& folders, scene::Scene scene) {
  Tally tally;
  for (const std::string& folder : folders) {
    for (const fs::path& path : modelsIn(folder)) {
      const std::string name = path.filename().string();
      try {
        std::vector<std::string> warnings;
        scene.model = formats::readModel(path, std::nullopt, warnings);
        printRow(name, scene, tally);
      } catch (const std::exception& error) {
        fmt::print("{:<30} {}\n", name, error.what());
      }
    }
  }
  tally.print();
}

void deployDrawn(DrawnModels models, int first, int count, const scene::Scene& scene) {
  Tally tally;
  for (int i = 0; i < first + count; ++i) {
    DrawnModel drawn = models.next();
    if (i < first) continue;
    scene::Scene member = scene;
    member.model = std::move(drawn.model);
    if (member.brick.thickness == 0) {
      member.brick.thickness = drawn.thickness * model::tileSize(member.model);
    }
    printRow(fmt::format("{} {} thick={:.2g}", i, drawn.name, drawn.thickness), std::move(member),
             tally);
  }
  tally.print();
}

}  // namespace
}  // namespace kirireel

int main(int count, char** arguments) {
  CLI::App program{"Deploys models as a default run does"};
  std::vector<std::string> folders = {std::string(KIRIREEL_SOURCE_DIR) + "/data"};
  kirireel::scene::Scene scene = kirireel::scene::openScene();
  std::string contacts = "auto";
  unsigned seed = 0;
  int first = 0, members = 40;
  std::size_t tiles = 100;
  program.add_option("folders", folders, "models, or folders of models");
  program.add_option("--search-effort", scene.path.searchEffort, "work relative to the default");
  program.add_option("--thickness", scene.brick.thickness, "metres; else from the model");
  program.add_option("--contacts", contacts, "auto, none, unjoined or all");
  const CLI::Option* drawn = program.add_option("--seed", seed, "draw members of all families");
  program.add_option("--first", first, "member to begin with, counted from 0")->needs("--seed");
  program.add_option("--count", members, "members to deploy")->needs("--seed");
  program.add_option("--tiles", tiles, "of a member, at most")->needs("--seed");
  CLI11_PARSE(program, count, arguments);
  scene.environment.contacts = kirireel::kFilters.at(contacts);
  if (*drawn) {
    kirireel::deployDrawn({seed, tiles}, first, members, scene);
  } else {
    kirireel::deployAll(folders, scene);
  }
}
