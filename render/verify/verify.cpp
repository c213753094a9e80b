#include "render/verify/verify.h"

#include <algorithm>
#include <cmath>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "render/digest/digest.h"
#include "sim/base/error.h"
#include "sim/base/text_file.h"
#include "sim/measure/measures.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kSummary = "summary.json";
constexpr const char* kTrajectory = "trajectory.h5";
// Other processors round differently in the last bits: this part of the model's size.
constexpr double kRounding = 1e-12;

std::string readSummary(const fs::path& folder) {
  if (fs::exists(folder / kSummary)) {
    return readTextFile(folder / kSummary, "give the folder that a run left");
  }
  throw InputError(fmt::format(
      "{}: error: there is no {} here; give the folder that a run of kirireel record or "
      "simulate left",
      folder.string(), kSummary));
}

/// Whether a name means a file in the folder or below it.
bool staysInside(const fs::path& name) {
  return !name.empty() && name.is_relative() &&
         std::none_of(name.begin(), name.end(), [](const fs::path& part) { return part == ".."; });
}

/// What is wrong with a file; empty when it is as noted.
std::string difference(const fs::path& folder, const std::string& name, const Json& noted) {
  if (!staysInside(name)) return "this is no name of a file in the folder";
  std::error_code ignored;
  if (!fs::is_regular_file(folder / name, ignored)) return "the file is missing";
  const FileDigest digest = digestOf(folder, name);
  const auto bytes = noted.at("bytes").get<std::uintmax_t>();
  if (digest.bytes != bytes) {
    return fmt::format("{} bytes where the run left {}", digest.bytes, bytes);
  }
  return digest.sha256 == noted.at("sha256").get<std::string>() ? ""
                                                                : "other bytes than the run left";
}

/// The figures of a run that its samples alone decide.
struct Figures {
  double jointGapMax = 0;
  double penetrationMax = 0;
  double errorMin = 0;
  Sample first;
  Sample last;
};

class Verifier {
 public:
  explicit Verifier(fs::path folder) : folder_(std::move(folder)) {}

  VerifyReport run() {
    const std::string text = readSummary(folder_);
    if (!isSealed(text)) complain(kSummary, "this is not the text that the run wrote");
    const Json summary = Json::parse(text, nullptr, false);
    if (!summary.is_object() || !summary.contains("contents")) {
      complain(kSummary, "it names no files to compare with; record the run again");
      return report_;
    }
    try {
      compareFiles(summary.at("contents"));
      if (report_.complaints.empty()) compareFigures(summary);
    } catch (const Json::exception& error) {
      complain(kSummary, "its entries are not those of a run");
    }
    return report_;
  }

 private:
  void complain(const std::string& place, const std::string& what) {
    report_.complaints.push_back(fmt::format("{}: {}", (folder_ / place).string(), what));
  }

  void compareFiles(const Json& contents) {
    for (const auto& [name, noted] : contents.items()) {
      ++report_.files;
      const std::string found = difference(folder_, name, noted);
      if (!found.empty()) complain(name, found);
    }
  }

  void compare(const std::string& place, const std::string& figure, double stated,
               double computed) {
    if (std::abs(stated - computed) <= kRounding * size_) return;
    complain(place,
             fmt::format("{} is {:.17g}, yet the poses give {:.17g}", figure, stated, computed));
  }

  Sample recompute(const TrajectoryReader& run, const std::vector<Pivot>& pivots,
                   std::size_t index) {
    const Subject& subject = run.subject();
    const Sample stored = run.sample(index);
    Sample sample = stored;
    sample.jointGap = jointGap(pivots, stored.poses).max;
    sample.penetration = deepestPenetration(subject.bricks, stored.poses).depth;
    if (subject.model.target) {
      sample.targetError = targetError(*subject.model.target, subject.bricks, stored.poses);
    }
    const std::string at = fmt::format(" at {:.4g} s", stored.time);
    compare(kTrajectory, "joint_gap" + at, stored.jointGap, sample.jointGap);
    compare(kTrajectory, "target_error" + at, stored.targetError, sample.targetError);
    compare(kTrajectory, "penetration" + at, stored.penetration, sample.penetration);
    ++report_.samples;
    return sample;
  }

  Figures recompute(const TrajectoryReader& run) {
    const std::vector<Pivot> pivots = makePivots(run.subject().model.joints, run.subject().bricks);
    Figures figures;
    for (std::size_t i = 0; i < run.times().size(); ++i) {
      Sample sample = recompute(run, pivots, i);
      figures.jointGapMax = std::max(figures.jointGapMax, sample.jointGap);
      figures.penetrationMax = std::max(figures.penetrationMax, sample.penetration);
      figures.errorMin =
          i == 0 ? sample.targetError : std::min(figures.errorMin, sample.targetError);
      if (i == 0) figures.first = sample;
      figures.last = std::move(sample);
    }
    return figures;
  }

  void compareFigures(const Json& summary) {
    const TrajectoryReader run(folder_ / kTrajectory);
    size_ = modelSize(run.subject().model);
    const Figures figures = recompute(run);
    compare(kSummary, "end_time", summary.at("end_time"), figures.last.time);
    // What a run that diverged measured last cannot be drawn and is not in its trajectory.
    if (summary.at("outcome") == "diverged") return;
    const Json& stated = summary.at("accuracy");
    compare(kSummary, "joint_gap_end", stated.at("joint_gap_end"), figures.last.jointGap);
    compare(kSummary, "penetration_max", stated.at("penetration_max"), figures.penetrationMax);
    // The summary counts every step, the trajectory has some of them.
    const double gap = std::max(stated.at("joint_gap_max").get<double>(),
                                stated.at("joint_opening_max").get<double>());
    if (figures.jointGapMax > gap) compare(kSummary, "joint_gap_max", gap, figures.jointGapMax);
    if (run.subject().model.target) compareWithTarget(stated, figures, run.subject().model);
  }

  void compareWithTarget(const Json& stated, const Figures& figures, const Model& model) {
    compare(kSummary, "target_error_start", stated.at("target_error_start"),
            figures.first.targetError);
    compare(kSummary, "target_error_end", stated.at("target_error_end"), figures.last.targetError);
    compare(kSummary, "rigid_bound", stated.at("rigid_bound"),
            rigidBound(model.tiles, *model.target));
    const double least = stated.at("target_error_min");
    if (figures.errorMin < least) compare(kSummary, "target_error_min", least, figures.errorMin);
  }

  fs::path folder_;
  double size_ = 0;  ///< of the model, metres
  VerifyReport report_;
};

}  // namespace

std::optional<FinishedRun> findFinishedRun(const fs::path& folder, const std::string& order) {
  if (!fs::is_regular_file(folder / kSummary)) return std::nullopt;
  const std::string text = readSummary(folder);
  const Json summary = Json::parse(text, nullptr, false);
  if (!isSealed(text) || !summary.is_object()) return std::nullopt;
  try {
    if (summary.at("order") != order || summary.at("outcome") == "interrupted") return std::nullopt;
    for (const auto& [name, noted] : summary.at("contents").items()) {
      if (!difference(folder, name, noted).empty()) return std::nullopt;
    }
    return FinishedRun{summary.at("outcome"), text};
  } catch (const Json::exception&) {
    return std::nullopt;  // sealed, but no run's
  }
}

VerifyReport verifyRun(const fs::path& folder) {
  return Verifier(folder).run();
}

}  // namespace kirireel
