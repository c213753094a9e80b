// Says in words what the run was, from trajectory.h5 alone: a page can be made where summary.json
// is missing. "Findings" is the JSON text that record() stores in the trajectory (path, warnings);
// files of older versions have none.
#include "render/page/page_words.h"

#include <algorithm>

#include <fmt/format.h>

#include "render/page/packed_array.h"
#include "sim/measure/run_curves.h"
#include "sim/model/model.h"

namespace kirireel {
namespace {

/// What the run found out; nothing in old files.
Json findingsOf(const TrajectoryReader& run) {
  const Json findings = Json::parse(run.end().findings, nullptr, false);
  return findings.is_object() ? findings : Json::object();
}

/// "1 tile", "12 tiles".
std::string counted(std::size_t count, const char* one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
}

/// In metres and in tiles, since models come in any size.
std::string lengthText(double metres, double tile) {
  return fmt::format("{:.3g} m ({:.2g} tiles)", metres, metres / tile);
}

/// The sides of the box along x, y and z.
std::string sizeText(const std::vector<Tile>& tiles) {
  Eigen::AlignedBox3d box;
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) box.extend(vertex);
  }
  const Vector3 sides = box.sizes();
  return fmt::format("{:.4g} × {:.4g} × {:.4g} m", sides.x(), sides.y(), sides.z());
}

/// Nothing for models without a target.
void addErrors(const TrajectoryReader& run, double tile, Facts& facts) {
  if (!run.subject().model.target) return;
  const Sample first = run.sample(0);
  const Sample last = run.sample(run.times().size() - 1);
  facts.emplace_back("Distance from the target, start", lengthText(first.targetError, tile));
  facts.emplace_back("Distance from the target, end", lengthText(last.targetError, tile));
}

/// Joint gaps are known of every step, overlaps of the samples alone.
void addAccuracy(const TrajectoryReader& run, double tile, Facts& facts) {
  double gap = 0, overlap = 0;
  for (const StepRecord& step : run.steps()) gap = std::max(gap, step.jointGap);
  for (std::size_t k = 0; k < run.times().size(); ++k) {
    const Sample sample = run.sample(k);
    gap = std::max(gap, sample.jointGap);
    overlap = std::max(overlap, sample.penetration);
  }
  facts.emplace_back("Widest joint gap", lengthText(gap, tile));
  facts.emplace_back("Deepest overlap", lengthText(overlap, tile));
}

}  // namespace

Facts factsOf(const TrajectoryReader& run) {
  const Subject& subject = run.subject();
  const Model& model = subject.model;
  const double tile = tileSize(model);
  Facts facts = {
      {"Sheet", counted(model.tiles.size(), "tile") + ", " + counted(model.joints.size(), "joint")},
      {"Thickness", lengthText(subject.brickRule.thickness, tile)},
      {"Size, start", sizeText(model.tiles)}};
  const Sample last = run.sample(run.times().size() - 1);
  facts.emplace_back("Size, end", sizeText(bottomTiles(subject.bricks, last.poses)));
  facts.emplace_back("Simulated time", fmt::format("{:.4g} s", run.times().back()));
  if (!run.end().events.empty()) facts.emplace_back("End", run.end().events.back().text);
  const Json findings = findingsOf(run);
  if (findings.contains("path")) {
    facts.emplace_back("Path", findings["path"].value("reason", ""));
  }
  addErrors(run, tile, facts);
  addAccuracy(run, tile, facts);
  if (!run.hasMechanics()) facts.emplace_back("Energies and forces", kNoMechanics);
  // A fact without a value is not told.
  std::erase_if(facts, [](const auto& fact) { return fact.second.empty(); });
  return facts;
}

std::vector<std::string> warningsOf(const TrajectoryReader& run) {
  const Json findings = findingsOf(run);
  return findings.value("warnings", std::vector<std::string>());
}

std::string htmlText(const std::string& text) {
  std::string shown;
  for (const char letter : text) {
    switch (letter) {
      case '&':
        shown += "&amp;";
        break;
      case '<':
        shown += "&lt;";
        break;
      case '>':
        shown += "&gt;";
        break;
      case '"':
        shown += "&quot;";
        break;
      default:
        shown += letter;
    }
  }
  return shown;
}

}  // namespace kirireel
