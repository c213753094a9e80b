// Default deployments: every model of the given folders as `kirireel record` would deploy it, or
// members of all families drawn at random, one a row. Prints where it ended against the least error
// found (without a target, the factor by which the tiles' squared distances from their centre
// grew), how deep bricks overlapped beyond the start, the largest joint gap (where joints open,
// also the least that the string method finds), the path's length over the one of the tiles' own
// motions (where that is long, in how many ways the tiles can move), how far states are from the
// symmetries that the model has, and CPU seconds: of the search, and of the run. Lengths are in
// tiles.
//
//     build/release/tests/bench/deployments [FOLDER ...] [--search SECONDS] [--contacts auto]
//     build/release/tests/bench/deployments --seed 1 --count 40 [--tiles 100]

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/deploy/continuation.h"
#include "sim/deploy/deployment.h"
#include "sim/measure/sheet.h"
#include "sim/model/isometry.h"
#include "sim/model/read_model.h"
#include "tests/bench/string_method.h"
#include "tests/support/drawn_models.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

constexpr double kClosed = 1e-9;  // gap in tiles, of joints that are exact

const std::map<std::string, ContactFilter> kFilters = {{"auto", ContactFilter::Auto},
                                                       {"none", ContactFilter::None},
                                                       {"unjoined", ContactFilter::Unjoined},
                                                       {"all", ContactFilter::All}};

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

/// The length of the run's motion over the one of the tiles' own motions to where it ends.
double windingOf(const Scene& scene, const Trajectory& trajectory) {
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  const std::vector<Sample>& samples = trajectory.samples;
  double length = 0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    length += pathDistance(bricks, samples[k - 1].poses, samples[k].poses);
  }
  if (length == 0) return 1;
  return length / pathDistance(bricks, samples.front().poses, samples.back().poses);
}

/// In how many ways the tiles can move half way along the run, beyond moves of the whole.
int freedomsOf(const Scene& scene, const Trajectory& trajectory) {
  const Sample& middle = trajectory.samples[trajectory.samples.size() / 2];
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  std::vector<Tile> tiles = scene.model.tiles;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < tiles[i].vertices.size(); ++k) {
      tiles[i].vertices[k] = middle.poses[i].apply(bricks[i].bottom[k]);
    }
  }
  const Freedom freedom = sceneNeeds(scene).planar.on ? Freedom::Plane : Freedom::Space;
  return mobility(scene.model, tiles, freedom, scene.brick.thickness).freedoms;
}

/// How much longer than its tiles' own motions a run is; of a long one also how many ways there
/// are in which its tiles can move, since a mechanism with one has no other path.
std::string windingWords(const Scene& scene, const Trajectory& trajectory) {
  const double winding = windingOf(scene, trajectory);
  if (winding <= kDetour) return fmt::format("{:5.2f}", winding);
  return fmt::format("{:5.2f} freedom {}", winding, freedomsOf(scene, trajectory));
}

/// The sum of squared distances of the tiles' centres from their common centre, square metres.
double extentOf(const Poses& poses) {
  Vector3 centre = Vector3::Zero();
  for (const Pose& pose : poses) centre += pose.position / static_cast<double>(poses.size());
  double sum = 0;
  for (const Pose& pose : poses) sum += (pose.position - centre).squaredNorm();
  return sum;
}

/// Where a run ended: its target error, or how much a sheet without a target has extended.
std::string endWords(const Scene& scene, const DeploymentResult& result) {
  const std::vector<Sample>& samples = result.trajectory.samples;
  if (!scene.model.target) {
    return fmt::format("extended {:.9f}",
                       extentOf(samples.back().poses) / extentOf(samples.front().poses));
  }
  const double tile = tileSize(scene.model);
  return fmt::format("error {:8.1e} least {:8.1e}", result.accuracy.targetErrorEnd / tile,
                     result.assembledError / tile);
}

/// How far joints opened; where they did, also the least opening that the string method finds from
/// the run's own states and from the tiles' own motions, and the ratio of the two.
std::string gapWords(const Scene& scene, const DeploymentResult& result) {
  const double tile = tileSize(scene.model);
  const double opening = std::max(result.accuracy.jointGapMax, result.accuracy.jointOpeningMax);
  if (opening <= kClosed * tile) return fmt::format("{:8.1e}", opening / tile);
  std::vector<Poses> states;
  for (const Sample& sample : result.trajectory.samples) states.push_back(sample.poses);
  const double most = std::max(kClearShare * tile, result.accuracy.penetrationGrownMax);
  const double mostGrown =
      result.needs.contacts.on ? most : std::numeric_limits<double>::infinity();
  const double least = std::min(leastOpening(scene, states, mostGrown),
                                leastOpening(scene, {states.front(), states.back()}, mostGrown));
  return fmt::format("{:8.1e} least {:8.1e} ratio {:.2f}", opening / tile, least / tile,
                     opening / least);
}

/// How far the run is from the symmetries of its model at most, metres, with how many there are.
std::string asymmetryOf(const Scene& scene, const Trajectory& trajectory) {
  const std::vector<Symmetry> group = symmetriesOf(scene.model);
  const double tile = tileSize(scene.model);
  double farthest = 0;
  for (const Sample& sample : trajectory.samples) {
    farthest = std::max(farthest, asymmetry(sample.poses, group, tile));
  }
  return fmt::format("{:8.1e} of {:>2}", farthest / tile, group.size());
}

void printRow(const std::string& name, Scene scene) {
  if (scene.model.target) alignStartToTarget(scene.model);
  fillFromModel(scene);
  const DeploymentResult result = deploy(scene, 1.0 / 30, nullptr);
  const double tile = tileSize(scene.model);
  const bool isWalked = result.path.kind == PathKind::Continuation;
  fmt::print(
      "{:<30} {:>4} {:<11} {:<12} {} overlap {:8.1e} gap {} "
      "winding {} asymmetry {} contacts {} {:6.2f} + {:6.2f} s  {}\n",
      name, scene.model.tiles.size(), toString(result.outcome),
      isWalked ? "continuation" : "dynamic", endWords(scene, result),
      result.accuracy.penetrationGrownMax / tile, gapWords(scene, result),
      windingWords(scene, result.trajectory), asymmetryOf(scene, result.trajectory),
      result.needs.contacts.on ? "on " : "off", result.cost.cpuSecondsSearch,
      result.cost.cpuSeconds, isWalked ? result.needs.contacts.reason : result.pathReason);
  std::fflush(stdout);
}

void deployAll(const std::vector<std::string>& folders, Scene scene) {
  for (const std::string& folder : folders) {
    for (const fs::path& path : modelsIn(folder)) {
      const std::string name = path.filename().string();
      try {
        std::vector<std::string> warnings;
        scene.model = readModel(path, std::nullopt, warnings);
        printRow(name, scene);
      } catch (const std::exception& error) {
        fmt::print("{:<30} {}\n", name, error.what());
      }
    }
  }
}

void deployDrawn(DrawnModels models, int first, int count, const Scene& scene) {
  for (int i = 0; i < first + count; ++i) {
    DrawnModel drawn = models.next();
    if (i < first) continue;
    Scene member = scene;
    member.model = std::move(drawn.model);
    if (member.brick.thickness == 0) {
      member.brick.thickness = drawn.thickness * tileSize(member.model);
    }
    printRow(fmt::format("{} {} thick={:.2g}", i, drawn.name, drawn.thickness), std::move(member));
  }
}

}  // namespace
}  // namespace kirireel

int main(int count, char** arguments) {
  CLI::App program{"Deploys models as a default run does"};
  std::vector<std::string> folders = {std::string(KIRIREEL_SOURCE_DIR) + "/data"};
  kirireel::Scene scene = kirireel::openScene();
  std::string contacts = "auto";
  unsigned seed = 0;
  int first = 0, members = 40;
  std::size_t tiles = 100;
  program.add_option("folders", folders, "models, or folders of models");
  program.add_option("--search", scene.path.searchTime, "seconds of a reference core");
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
