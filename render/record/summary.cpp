// summary.json is one object with these keys, in this order:
//
//     outcome, reason, end_time (s), video_frames
//     model       name, tiles, joints, has_target, size (m), tile_size (m)
//     accuracy    gaps, errors, bounds, penetrations (m) and what the steps report
//     elasticity  number of each of pairForceKinds(), such as springs; energy_start, energy_end
//     (J),
//                 moment_end (N m); null without pair forces. For tiles that bend
//                 under grips also the numbers of bars and folds, which have these energies
//     at_target, shortfall, bricks_left_out_from (s), warnings, alignment, path, blocking, needs
//     events      [{time (s), what}]
//     settings    with the tables and keys of scene.toml; pictures; scene: a whole scene file
//     view        of the pictures, automatic or given: azimuth_deg, elevation_deg, roll_deg
//     order, left_out, inputs [{name, sha256}], files
//     contents    {name: {bytes, sha256}}, see output_folder.cpp
//     cost        counts of steps, seconds, peak_memory_bytes
//     versions    name: version
//     sha256      the seal (output_folder.h)
//
// Lengths are in metres. A missing value is null: every key is present. Numbers have the shortest
// digits that read back to the same double.
//
// trajectory.h5 has the same texts of settings and findings, and `verify` compares them.
#include "render/record/summary.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "render/picture/png.h"
#include "render/picture/video.h"
#include "render/writers/mesh.h"
#include "sim/base/file_kinds.h"
#include "sim/engines/bullet_world.h"
#include "sim/run/forces.h"
#include "sim/run/run_drive.h"
#include "sim/scene/scene_parts.h"
#include "sim/scene/settings.h"
#include "sim/trajectory/array_file.h"

namespace kirireel::record {
namespace {

/// Null if the value does not exist.
Json onlyIf(bool exists, double figure) {
  return exists ? Json(figure) : Json(nullptr);
}

/// Size is the diagonal of the start, tile_size the mean edge.
Json modelJson(const model::Model& model) {
  return {{"name", model.name},
          {"tiles", model.tiles.size()},
          {"joints", model.joints.size()},
          {"has_target", model.target.has_value()},
          {"size", model::modelSize(model)},
          {"tile_size", model::tileSize(model)}};
}

/// Adds the figures of the steps in this part of the summary.
void addStepFigures(Json& json, const std::string& part, const StepReport& took) {
  for (const StepFigure& figure : kStepFigures) {
    if (!figure.part || figure.part != part) continue;
    const double value = figure.get(took);
    const bool isCount = figure.unit == std::string("1");
    json[figure.partName] = isCount ? Json(static_cast<long>(value)) : Json(value);
  }
}

/// The figures of accuracy that only runs with a target have.
constexpr std::array kOfTarget = {&run::Accuracy::targetErrorStart, &run::Accuracy::targetErrorEnd,
                                  &run::Accuracy::targetErrorMin, &run::Accuracy::rigidBound,
                                  &run::Accuracy::springsRestError};

/// Lengths; null without a target or a search.
Json accuracyJson(const RunSummary& summary, bool hasTarget) {
  Json json = fieldsJson<Json>(summary.accuracy);
  if (!hasTarget) {
    for (const auto figure : kOfTarget) json[nameOfField(figure)] = nullptr;
  }
  json[run::kAssembledError] = onlyIf(summary.assembledError >= 0, summary.assembledError);
  json["time_error"] = summary.timeError ? Json(*summary.timeError) : Json(nullptr);
  addStepFigures(json, "accuracy", summary.cost.took);
  return json;
}

Json elasticityJson(const std::optional<brick::Elasticity>& elasticity) {
  if (!elasticity) return nullptr;
  Json json;
  for (const scene::PairForceKind& kind : scene::pairForceKinds()) {
    json[kind.name.counted] = elasticity->count(kind.name.counted);
  }
  for (const auto& [name, count] : elasticity->counts) json[name] = count;
  for (const auto& figure : fieldsOfType<double>(brick::Elasticity::fields())) {
    json[figure.name] = (*elasticity).*figure.member;
  }
  return json;
}

/// Lengths in metres, work in multiplications.
Json candidatesJson(const std::vector<run::PathEvaluation>& candidates) {
  Json json = Json::array();
  for (const run::PathEvaluation& path : candidates) {
    json.push_back({{"candidate", path.candidate},
                    {"end", run::toString(path.end)},
                    {"error", path.error},
                    {"overlap_growth", path.overlapGrowth},
                    {"overlap_growth_at_end", path.overlapGrowthAtEnd},
                    {"opening", path.opening},
                    {"rough_frames", path.roughFrames},
                    {"step_change", path.stepChange},
                    {"largest_turn_deg", path.largestTurn / kDegree},
                    {"length", path.length},
                    {"work", path.work}});
  }
  return json;
}

/// Times in simulated seconds, work in multiplications; null if a kind of path has no such value.
Json pathJson(const RunSummary& summary) {
  const double searchLimit = summary.cost.searchLimit;
  const scene::PathSettings& path = summary.path;
  const bool isGuided = path.kind == scene::PathKind::Guided;
  const bool isKinematic = path.kind == scene::PathKind::Continuation;
  return {{"kind", isGuided      ? "guided"
                   : isKinematic ? "continuation"
                                 : "straight"},
          {"reason", summary.pathReason},
          {"candidates", candidatesJson(summary.candidates)},
          {"search_work", summary.cost.searchWork},
          {"search_limit", onlyIf(std::isfinite(searchLimit), searchLimit)},
          {"open_time", onlyIf(isGuided && path.openTime > 0, path.openTime)},
          {"guide_time", onlyIf(isGuided, path.guideTime)},
          {"joint_ratio", onlyIf(path.jointsAreCompliant(), path.jointRatio)}};
}

/// Pairs of bricks that would overlap at the target, and remedies.
Json blockingJson(const std::vector<run::BlockingPair>& blocking) {
  Json pairs = Json::array();
  for (const run::BlockingPair& pair : blocking) {
    Json face;
    if (pair.freeingFace) face = *pair.freeingFace == model::JointFace::Top ? "top" : "bottom";
    pairs.push_back(
        {{"tiles", {pair.tileA, pair.tileB}},
         {"overlap_at_target", pair.overlap},
         {"free_with_joints_on", face},
         {"free_with_thickness", onlyIf(pair.freeingThickness > 0, pair.freeingThickness)}});
  }
  return pairs;
}

Json alignmentJson(const scene::StartAlignment& alignment, bool hasTarget) {
  if (!alignment.requested || !hasTarget) return nullptr;
  return {{"moved", alignment.moved},
          {"turned", alignment.turned},
          {"by", alignment.byHeld ? "pinned tiles" : "all tiles"}};
}

/// CPU seconds by stage, wall seconds for all, bytes.
Json costJson(const RunSummary& summary) {
  Json json = Json::object();
  addStepFigures(json, "cost", summary.cost.took);
  json.update({{"cpu_seconds_search", summary.cost.cpuSecondsSearch},
               {"cpu_seconds_deploy", summary.cost.cpuSeconds},
               {"cpu_seconds_render", summary.recordCost.cpuSecondsRender},
               {"cpu_seconds_encode", summary.recordCost.cpuSecondsEncode},
               {"wall_seconds", summary.recordCost.wallSeconds},
               {"peak_memory_bytes", summary.recordCost.peakMemoryBytes}});
  return json;
}

Json obstaclesJson(const std::vector<scene::Obstacle>& obstacles) {
  Json json = Json::array();
  for (const scene::Obstacle& obstacle : obstacles) {
    const Quaternion& turn = obstacle.pose.rotation;
    Json& entry = json.emplace_back();
    switch (obstacle.shape) {
      case scene::Obstacle::Shape::Box:
        entry = {{"shape", "box"}, {"size", vectorJson(obstacle.size)}};
        break;
      case scene::Obstacle::Shape::Sphere:
        entry = {{"shape", "sphere"}, {"radius", obstacle.radius}};
        break;
      case scene::Obstacle::Shape::Mesh:
        entry = {{"shape", "mesh"}, {"faces", obstacle.mesh.size()}};
    }
    entry["position"] = vectorJson(obstacle.pose.position);
    entry["rotation"] = {turn.w(), turn.x(), turn.y(), turn.z()};
    entry["friction"] = obstacle.friction;
  }
  return json;
}

Json velocitiesJson(const std::vector<scene::InitialVelocity>& velocities, int countsFrom) {
  Json json = Json::array();
  for (const scene::InitialVelocity& velocity : velocities) {
    std::vector<int> tiles = velocity.tiles;
    for (int& tile : tiles) tile += countsFrom;
    json.push_back({{"tiles", tiles},
                    {"linear", vectorJson(velocity.linear)},
                    {"angular", vectorJson(velocity.angular)}});
  }
  return json;
}

Json viewJson(const std::optional<picture::ViewAngles>& view) {
  if (!view) return nullptr;
  return {{"azimuth", view->azimuth}, {"elevation", view->elevation}, {"roll", view->roll}};
}

/// The view of the painted pictures, in the form of `--view`.
Json paintedViewJson(const std::optional<picture::AutomaticView>& view) {
  if (!view) return nullptr;
  return {{"azimuth_deg", view->angles.azimuth / kDegree},
          {"elevation_deg", view->angles.elevation / kDegree},
          {"roll_deg", view->angles.roll / kDegree}};
}

/// The word of a choice in its table.
template <typename Choices, typename Choice>
const char* wordOf(const Choices& choices, Choice choice) {
  return std::ranges::find(choices, choice, &Choices::value_type::second)->first;
}

Json appearanceJson(const picture::Appearance& appearance) {
  return {{"theme", appearance.theme == picture::Theme::Dark ? "dark" : "light"},
          {"colour", wordOf(picture::kColourings, appearance.colouring)},
          {"ground", wordOf(picture::kGroundLooks, appearance.ground)},
          {"transparent", appearance.transparent},
          {"outlines", appearance.outlines},
          {"joint_marks", appearance.jointMarks},
          {"target_lines", appearance.targetLines},
          {"trails", appearance.trails.size()},
          {"ghost", wordOf(picture::kGhosts, appearance.ghost)},
          {"depth_cue", appearance.depthCue},
          {"zoom", appearance.camera.zoom},
          {"margin", appearance.camera.margin},
          {"orbit", appearance.camera.orbit},
          {"camera_keys", appearance.camera.keys.size()}};
}

/// Sizes in pixels.
Json pictureJson(const RecordSettings& settings) {
  return {{"width", settings.size.width},
          {"height", settings.size.height},
          {"frames_per_second", settings.framesPerSecond},
          {"view", viewJson(settings.appearance.camera.view)},
          {"look", appearanceJson(settings.appearance)},
          {"grid_rows", settings.grid.rows},
          {"grid_columns", settings.grid.columns},
          {"pace", settings.pace == Pace::Even ? "even" : "real"},
          {"snapshots", settings.spacing == SnapshotSpacing::Time ? "time" : "progress"}};
}

/// The value of a setting as in scene.toml; null if it has none.
Json settingJson(const scene::Setting& setting, const scene::Scene& scene) {
  const std::string text = setting.write(scene);
  if (text.empty()) return nullptr;
  const Json json = parseJsonOrDiscard(text);
  return json.is_discarded() ? Json(text) : json;
}

/// Mean stiffness of the springs per brick; rotation is about a brick's normal.
Json springsJson(const scene::Scene& scene) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const auto mean = [&](const auto& part) {
    double sum = 0;
    for (const brick::Brick& brick : bricks)
      sum += part(brick, run::springOf(brick, scene.springs));
    return sum / static_cast<double>(bricks.size());
  };
  return {{"spring_stiffness", mean([](const brick::Brick&, const run::BrickSpring& spring) {
             return spring.springStiffness;
           })},
          {"torque_stiffness", mean([](const brick::Brick&, const run::BrickSpring& spring) {
             return spring.torqueStiffness;
           })},
          {"force_damping", mean([](const brick::Brick&, const run::BrickSpring& spring) {
             return spring.forceDamping;
           })},
          {"torque_damping", mean([](const brick::Brick& brick, const run::BrickSpring& spring) {
             return brick.normal.dot(spring.torqueDamping * brick.normal);
           })}};
}

/// The settings by table and key, and values that are fixed or follow from the model. Values of
/// settings are JSON already; other text becomes a string.
Json settingsJson(const scene::Scene& scene, const RecordSettings& settings) {
  Json json = Json::object();
  for (const scene::SettingGroup& group : scene::sceneSettings()) {
    for (const scene::Setting& setting : group.settings) {
      json[group.table][setting.key] = settingJson(setting, scene);
    }
  }
  const scene::Environment& environment = scene.environment;
  const std::optional<scene::Ground>& ground = environment.ground;
  json["model"]["hinges_from_file"] = scene.hinges.own.size();
  json["actuation"]["springs_used"] = springsJson(scene);
  json["environment"]["ground_height"] = ground ? Json(ground->height) : Json(nullptr);
  json["environment"]["obstacles"] = obstaclesJson(environment.obstacles);
  json["environment"]["pivot_zone"] = environment.pivotZone;
  json["stop"]["settle_speed"] = scene.stop.settleSpeed;
  json["stop"]["settle_time"] = scene.stop.settleTime;
  json["velocities"] = velocitiesJson(scene.velocities, scene.model.fileOrder.countsFrom);
  json["pictures"] = pictureJson(settings);
  json["defaults"] = settings.peerSpelling.empty() ? "kirireel" : "pykirigami";
  json["scene"] = settings.sceneText.empty() ? Json(nullptr) : Json(settings.sceneText);
  return json;
}

/// Names without folders: the place of a model does not change a run.
Json inputsJson(const std::vector<InputFile>& inputs) {
  Json json = Json::array();
  for (const InputFile& input : inputs) {
    const Json entry = {{"name", input.path.filename().string()}, {"sha256", input.sha256}};
    // Some files are opened twice in succession.
    if (json.empty() || json.back() != entry) json.push_back(entry);
  }
  return json;
}

Json contentsJson(const std::vector<output::FileDigest>& digests) {
  Json contents = Json::object();
  for (const output::FileDigest& digest : digests) {
    contents[digest.name] = {{"bytes", digest.bytes}, {"sha256", digest.sha256}};
  }
  return contents;
}

Json versionsJson(const std::string& graphics) {
  Json versions = Json::object();
  for (const auto& [name, version] : allVersions()) versions[name] = version;
  versions["opengl"] = graphics.empty() ? Json(nullptr) : Json(graphics);
  return versions;
}

/// Findings of a run about its scene.
Json findingsJson(const scene::Scene& scene, const RunSummary& summary) {
  const std::optional<double>& leftOut = summary.leftOutFrom;
  return {{"at_target", summary.atTarget ? Json(*summary.atTarget) : Json(nullptr)},
          {"shortfall", summary.shortfall.empty() ? Json(nullptr) : Json(summary.shortfall)},
          {"bricks_left_out_from", leftOut ? Json(*leftOut) : Json(nullptr)},
          {"warnings", summary.warnings},
          {"alignment", alignmentJson(scene.alignment, scene.model.target.has_value())},
          {"path", pathJson(summary)},
          {"blocking", blockingJson(summary.blocking)},
          {"needs", fieldsJson<Json>(summary.needs)}};
}

}  // namespace

Json vectorJson(const Vector3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Json eventsJson(const std::vector<trajectory::Event>& events) {
  Json json = Json::array();
  for (const trajectory::Event& event : events) json.push_back(fieldsJson<Json>(event));
  return json;
}

std::string summaryJson(const scene::Scene& scene, const RecordSettings& settings,
                        const RunSummary& summary) {
  Json json = {
      {"outcome", run::toString(summary.outcome)},
      {"reason", summary.reason},
      {"end_time", summary.endTime},
      {"video_frames", summary.videoFrames},
      {"model", modelJson(scene.model)},
      {"accuracy", accuracyJson(summary, scene.model.target.has_value())},
      {"elasticity", elasticityJson(summary.elasticity)},
  };
  json.update(findingsJson(scene, summary));
  json.update(Json{
      {"events", eventsJson(summary.trajectory.events)},
      {"settings", settingsJson(scene, settings)},
      {"view", paintedViewJson(summary.view)},
      {"order", settings.order.empty() ? Json(nullptr) : Json(settings.order)},
      {"left_out", summary.leftOut.empty() ? Json(nullptr) : Json(summary.leftOut)},
      {"inputs", inputsJson(settings.inputs)},
      {"files", summary.files},
      {"contents", contentsJson(summary.digests)},
      {"cost", costJson(summary)},
      {"versions", versionsJson(summary.graphics)},
  });
  return output::sealed(jsonText(json, 2) + "\n");
}

std::string findingsText(const scene::Scene& scene, const RunSummary& summary) {
  return jsonText(findingsJson(scene, summary), 2) + "\n";
}

std::string settingsText(const scene::Scene& scene, const RecordSettings& settings) {
  return jsonText(settingsJson(scene, settings), 2) + "\n";
}

// ------------------------------------------------------------------------------------------------
// The versions of the program and of the libraries that affect its results.

std::string programVersion() {
  return KIRIREEL_VERSION;
}

std::string madeBy(const std::vector<std::string>& models, const std::string& order) {
  const std::string text =
      fmt::format("Kirireel {}, model {}", programVersion(), fmt::join(models, ", "));
  return order.empty() ? text : fmt::format("{}, order {}", text, order);
}

std::vector<std::pair<std::string, std::string>> allVersions() {
  return {
      {"kirireel", programVersion()},
      {"compiler", __VERSION__},
      {"eigen",
       fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
      {"bullet", engines::bulletVersion()},
      {"hdf5", trajectory::arrayLibraryVersion()},
      {"libavcodec", picture::encoderLibraryVersion()},
      {"libpng", picture::pngLibraryVersion()},
      {"assimp", writers::meshLibraryVersion()},
  };
}

std::string versionText() {
  std::string text;
  for (const auto& [name, version] : allVersions()) text += fmt::format("{} {}\n", name, version);
  return text;
}

std::map<std::string, std::string> sweepInputs(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "run.json";
  if (!isFile(file)) return {};
  const Json run = parseJsonOrDiscard(readTextFile(file, "remove it if it is not a sweep's"));
  std::map<std::string, std::string> inputs;
  if (!run.is_object() || !run.contains("inputs")) return inputs;
  for (const auto& [name, value] : run["inputs"].items()) {
    if (value.is_string()) inputs[name] = value.get<std::string>();
  }
  return inputs;
}

}  // namespace kirireel::record
