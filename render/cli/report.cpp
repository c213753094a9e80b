#include "render/cli/report.h"

#include <cstdio>

#include <fmt/format.h>
#include <unistd.h>

namespace kirireel {
namespace {

std::string describeTarget(const Accuracy& accuracy) {
  return fmt::format(
      "target error {:.3g} m at the end ({:.3g} at the start; rigid tiles can reach {:.3g})\n",
      accuracy.targetErrorEnd, accuracy.targetErrorStart, accuracy.rigidBound);
}

std::string describePath(const RunSummary& summary, bool hasTarget) {
  const double opening = summary.accuracy.jointOpeningMax;
  std::string text;
  if (hasTarget || opening > 0) text += fmt::format("path: {}\n", summary.pathReason);
  if (opening > 0) text += fmt::format("joints gave by {:.3g} m at most on the way\n", opening);
  return text;
}

std::string describeNeed(const char* name, const Need& need) {
  return fmt::format("{} {} ({})", name, need.on ? "on" : "off", need.reason);
}

/// Of the bricks that are in each other's way at the target, so many pairs are named.
constexpr std::size_t kPairsNamed = 3;

std::string describeBlocking(const std::vector<BlockingPair>& blocking) {
  if (blocking.empty()) return "";
  std::vector<std::string> pairs;
  for (const BlockingPair& pair : blocking) {
    if (pairs.size() < kPairsNamed) pairs.push_back(describe(pair));
  }
  return fmt::format("{} pairs of bricks would overlap at the target: {}{}\n", blocking.size(),
                     fmt::join(pairs, "; "), blocking.size() > pairs.size() ? "; ..." : "");
}

std::string describeCost(const RunSummary& summary) {
  const DeployCost& deploy = summary.deployCost;
  const RecordCost& record = summary.recordCost;
  std::string text = fmt::format(
      "{} steps in {:.2f} s, pictures {:.2f} s, video {:.2f} s; {:.1f} s in all\n", deploy.steps,
      deploy.cpuSeconds, record.cpuSecondsRender, record.cpuSecondsEncode, record.wallSeconds);
  if (deploy.unconvergedSteps > 0) {
    text += fmt::format("{} steps missed the tolerance of joints or contacts\n",
                        deploy.unconvergedSteps);
  }
  return text;
}

/// The files by name, those in a folder of their own as that folder alone.
std::vector<std::string> shortList(const std::vector<std::string>& files) {
  std::vector<std::string> list;
  for (const std::string& file : files) {
    const std::string name = file.substr(0, file.find('/') + 1);
    if (name.empty()) {
      list.push_back(file);
    } else if (list.empty() || list.back() != name) {
      list.push_back(name);
    }
  }
  return list;
}

}  // namespace

std::string describePictures(const PictureSettings& settings, const PictureReport& report) {
  const RecordCost& cost = report.recordCost;
  std::string text = fmt::format("{} frames: pictures {:.2f} s, video {:.2f} s; {:.1f} s in all\n",
                                 report.videoFrames, cost.cpuSecondsRender, cost.cpuSecondsEncode,
                                 cost.wallSeconds);
  if (report.stoppedAt)
    text += fmt::format("interrupted by {}: the video ends at {:.4g} s\n", report.stoppedBy,
                        *report.stoppedAt);
  text +=
      fmt::format("in {}: {}\n", settings.folder.string(), fmt::join(shortList(report.files), " "));
  return text;
}

ProgressLine::ProgressLine() : isTerminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (!shown_.empty()) fmt::print(stderr, "\n");
}

void ProgressLine::show(const Progress& progress) {
  show(fmt::format("{} {:3.0f}%", progress.stage, 100 * progress.share));
}

void ProgressLine::show(const std::string& line) {
  if (!isTerminal_ || line == shown_) return;
  // Back to the start of the line and clear it.
  fmt::print(stderr, "\r\033[K{}", line);
  std::fflush(stderr);
  shown_ = line;
}

std::string describeRun(const Scene& scene, const RecordSettings& settings,
                        const RunSummary& summary) {
  const Accuracy& accuracy = summary.accuracy;
  std::string text = fmt::format("{}: {} after {:.4g} s: {}\n", scene.model.name,
                                 toString(summary.outcome), summary.endTime, summary.reason);
  text += fmt::format("{} tiles, {} joints; {}; {}\n", scene.model.tiles.size(),
                      scene.model.joints.size(), describeNeed("planar", summary.needs.planar),
                      describeNeed("contacts", summary.needs.contacts));
  if (scene.model.target) {
    text += describeTarget(accuracy);
    text += describeBlocking(summary.blocking);
  }
  text += describePath(summary, scene.model.target.has_value());
  text += fmt::format("joint gap {:.3g} m at most, penetration {:.3g} m at most\n",
                      accuracy.jointGapMax, accuracy.penetrationMax);
  text += describeCost(summary);
  text += fmt::format("in {}: {}\n", settings.folder.string(),
                      fmt::join(shortList(summary.files), " "));
  return text;
}

}  // namespace kirireel
