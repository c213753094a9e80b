// Checks a finished run in two steps.
//
// Files: every file in "contents" of summary.json and of contents.json must have the recorded size
// and SHA-256, and both records must be sealed (output_folder.h).
//
// Figures: trajectory.h5 has the poses of all samples, one record per step, and the states in which
// the extreme figures of the run were found ("figure states"). From these the functions of
// sim/trajectory recompute the figures, which are compared with the summary:
//
//     per sample   joint_gap, penetration, target_error
//     all steps    joint_gap_mean = sum of means / steps, counts; with the samples joint_gap_max,
//                  target_error_min
//     one state    penetration_max and others, each at its own state; rigid_bound; elasticity
//
// Two figures a and b agree if |a - b| <= 1e-12 max(|a|, |b|). Two lengths also agree if they
// differ by at most 1e-12 of a tile.
//
// This finds an edited summary and figures that the run computed wrongly. It does not find a wrong
// simulation.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "render/output/output_folder.h"
#include "render/picture/video.h"
#include "render/record/run_pictures.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/files.h"
#include "sim/scene/scene_parts.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {
namespace {

namespace fs = std::filesystem;
// Figures are recomputed from the same numbers by the same arithmetic and agree to the last bit.
// The tolerance allows for compilers that add in another order.
constexpr double kFigureRounding = 1e-12;

/// Throws InputError if there is none.
std::string summaryText(const fs::path& folder) {
  if (isPresent(folder / output::kSummary)) {
    return readTextFile(folder / output::kSummary, "give the folder of a run");
  }
  throw InputError(fmt::format(
      "{}: error: there is no {} here; give the folder of a run of kirireel record or simulate",
      folder.string(), output::kSummary));
}

/// A text as in summary.json, which replaces bytes that are not UTF-8 by U+FFFD. Names of models
/// may have any bytes.
std::string asInJson(const std::string& text) {
  return parseJson(jsonText(Json(text)));
}

output::FileDigest digestIn(const std::string& name, const Json& noted) {
  return {name, noted.at("bytes").get<std::uintmax_t>(), noted.at("sha256").get<std::string>()};
}

/// A figure of the summary that follows from a single state, recomputed from that state.
struct StateFigure {
  const char* name;
  std::function<double(const Poses&)> compute;
};

/// Continues after a complaint if the rest can still be read.
class Verifier {
 public:
  explicit Verifier(fs::path folder) : folder_(std::move(folder)) {}

  VerifyReport run() {
    const std::string text = summaryText(folder_);
    if (!output::isSealed(text))
      complain(output::kSummary, "this is not the text that the run wrote");
    const Json summary = parseJsonOrDiscard(text);
    if (!summary.is_object() || !summary.contains("contents")) {
      complain(output::kSummary, "it lists no files to compare; record the run again");
      return report_;
    }
    try {
      compareFiles(summary.at("contents"));
      // A damaged trajectory would only repeat the complaint.
      if (report_.complaints.empty()) compareFigures(summary);
    } catch (const Json::exception&) {
      complain(output::kSummary, "its entries are not those of a run");
    }
    return report_;
  }

 private:
  void complain(const std::string& place, const std::string& what) {
    report_.complaints.push_back(fmt::format("{}: {}", (folder_ / place).string(), what));
  }

  /// Files exported or painted later are compared as listed in contents.json.
  void compareFiles(const Json& contents) {
    output::FileList files = output::listedFiles(folder_ / output::kContents);
    if (files.empty() && isPresent(folder_ / output::kContents)) {
      complain(output::kContents, "this is not the text that export or render wrote");
    }
    for (const auto& [name, noted] : contents.items())
      files.try_emplace(name, digestIn(name, noted));
    for (const auto& [name, noted] : files) {
      ++report_.files;
      const std::string found = output::difference(folder_, noted);
      if (!found.empty()) complain(name, found);
    }
  }

  /// `place`: the file with the figure; `least`: the difference that is tolerated.
  void compare(const std::string& place, const std::string& figure, double stated, double computed,
               double least = 0) {
    const double larger = std::max(std::abs(stated), std::abs(computed));
    if (std::abs(stated - computed) <= std::max(least, kFigureRounding * larger)) return;
    complain(place,
             fmt::format("{} is {:.17g}, but the poses give {:.17g}", figure, stated, computed));
  }

  /// A figure among the summary's "accuracy".
  void compareAccuracy(const Json& stated, double run::Accuracy::*figure, double computed) {
    const char* name = nameOfField(figure);
    compare(output::kSummary, name, stated.at(name), computed, lengthRounding_);
  }

  /// An entry of the summary with a copy in trajectory.h5.
  void compareCopy(const std::string& entry, const Json& stated, const Json& copy) {
    if (stated != copy)
      complain(output::kSummary, fmt::format("{} differs from trajectory.h5", entry));
  }

  /// One sample.
  void recompute(const trajectory::TrajectoryReader& run, const std::vector<brick::Pivot>& pivots,
                 std::size_t index) {
    const trajectory::Subject& subject = run.subject();
    const trajectory::Sample stored = run.sample(index);
    const std::string at = fmt::format(" at {:.4g} s", stored.time);
    compare(output::kTrajectory, "joint_gap" + at, stored.jointGap,
            trajectory::jointGap(pivots, stored.poses).max, lengthRounding_);
    compare(output::kTrajectory, "penetration" + at, stored.penetration,
            trajectory::deepestPenetration(subject.bricks, stored.poses).depth, lengthRounding_);
    if (subject.model.target) {
      compare(output::kTrajectory, "target_error" + at, stored.targetError,
              trajectory::targetError(*subject.model.target, subject.bricks, stored.poses),
              lengthRounding_);
    }
    ++report_.samples;
  }

  /// The files are unchanged, so any difference found here was wrong when written.
  void compareFigures(const Json& summary) {
    const trajectory::TrajectoryReader run(folder_ / output::kTrajectory);
    const std::vector<brick::Pivot> pivots =
        brick::makePivots(run.subject().model.joints, run.subject().bricks);
    lengthRounding_ = kFigureRounding * model::tileSize(run.subject().model);
    for (std::size_t i = 0; i < run.times().size(); ++i) recompute(run, pivots, i);
    if (run.steps().empty()) {
      complain(output::kTrajectory,
               "an earlier version of the program wrote it, without the states of the summary's "
               "figures; record the run again");
      return;
    }
    compareEnd(summary, run);
    compareModel(summary.at("model"), run.subject().model);
    compareCopy("events", summary.at("events"), eventsJson(run.end().events));
    compareCopy("settings", summary.at("settings"), parseJson(run.subject().settings));
    const Json findings = parseJson(run.end().findings);
    for (const auto& [entry, found] : findings.items())
      compareCopy(entry, summary.at(entry), found);
    compareSteps(summary, run);
    compareStates(summary, run, pivots);
    compareView(summary, run);
    compareVideo(summary);
  }

  /// The last event of a run repeats its outcome and reason.
  void compareEnd(const Json& summary, const trajectory::TrajectoryReader& run) {
    compare(output::kSummary, "end_time", summary.at("end_time"), run.times().back());
    const std::string outcome = summary.at("outcome");
    const std::string reason = summary.at("reason");
    const std::string stated = fmt::format("{}: {}", outcome, reason);
    // Painting may have been interrupted after the run.
    if (outcome == "interrupted" || run.end().events.empty()) return;
    if (run.end().events.back().text != stated) {
      complain(output::kSummary, "outcome or reason differ from the last event of trajectory.h5");
    }
  }

  /// Counts and sizes follow from the model in trajectory.h5.
  void compareModel(const Json& stated, const model::Model& model) {
    compareCopy("model.name", stated.at("name"), asInJson(model.name));
    compareCopy("model.has_target", stated.at("has_target"), model.target.has_value());
    compare(output::kSummary, "model.tiles", stated.at("tiles"),
            static_cast<double>(model.tiles.size()));
    compare(output::kSummary, "model.joints", stated.at("joints"),
            static_cast<double>(model.joints.size()));
    compare(output::kSummary, "model.size", stated.at("size"), model::modelSize(model));
    compare(output::kSummary, "model.tile_size", stated.at("tile_size"), model::tileSize(model));
  }

  /// Figures that depend on all steps.
  void compareSteps(const Json& summary, const trajectory::TrajectoryReader& run) {
    StepReport took;
    double gapSum = 0;
    double largestGap = 0;
    double smallestError = std::numeric_limits<double>::infinity();
    for (const trajectory::StepRecord& step : run.steps()) {
      took += step.took;
      gapSum += step.jointGapMean;
      largestGap = std::max(largestGap, step.jointGap);
      smallestError = std::min(smallestError, step.targetError);
    }
    for (std::size_t i = 0; i < run.times().size(); ++i) {
      const trajectory::Sample sample = run.sample(i);
      largestGap = std::max(largestGap, sample.jointGap);
      smallestError = std::min(smallestError, sample.targetError);
    }
    const Json& accuracy = summary.at("accuracy");
    compareAccuracy(accuracy, &run::Accuracy::jointGapMean,
                    gapSum / static_cast<double>(run.steps().size()));
    compareAccuracy(accuracy, &run::Accuracy::jointGapMax, largestGap);
    if (run.subject().model.target)
      compareAccuracy(accuracy, &run::Accuracy::targetErrorMin, smallestError);
    // Figures of steps without a part are not in the summary.
    for (const StepFigure& figure : kStepFigures) {
      if (!figure.part) continue;
      compare(output::kSummary, figure.partName,
              summary.at(figure.part).value(figure.partName, 0.0), figure.get(took));
    }
  }

  /// Figures that depend on one state: the start, the end, or a stored one.
  void compareStates(const Json& summary, const trajectory::TrajectoryReader& run,
                     const std::vector<brick::Pivot>& pivots) {
    const trajectory::Subject& subject = run.subject();
    const Json& stated = summary.at("accuracy");
    const trajectory::Sample first = run.sample(0);
    const trajectory::Sample last = run.sample(run.times().size() - 1);
    const Poses asRead = brick::startPoses(subject.model.tiles, subject.bricks);
    compareAccuracy(stated, &run::Accuracy::assemblyMove,
                    trajectory::targetError(brick::bottomTiles(subject.bricks, asRead),
                                            subject.bricks, first.poses));
    compareAccuracy(stated, &run::Accuracy::jointGapEnd, last.jointGap);
    if (subject.model.target) {
      compareAccuracy(stated, &run::Accuracy::targetErrorStart, first.targetError);
      compareAccuracy(stated, &run::Accuracy::targetErrorEnd, last.targetError);
      compareAccuracy(stated, &run::Accuracy::rigidBound,
                      trajectory::rigidBound(subject.model.tiles, *subject.model.target));
    }
    compareElasticity(summary, run, first.poses, last.poses);
    // A run that ended among the samples of an earlier process does not have these states.
    if (summary.at("outcome") == "interrupted" && run.end().figureStates.empty()) return;
    for (const StateFigure& figure : stateFigures(summary, subject, pivots, asRead)) {
      const auto state =
          std::ranges::find(run.end().figureStates, figure.name, &trajectory::FigureState::figure);
      if (state != run.end().figureStates.end()) {
        compare(output::kSummary, figure.name, stated.at(figure.name), figure.compute(state->poses),
                lengthRounding_);
      } else if (stated.at(figure.name) != 0 && !stated.at(figure.name).is_null()) {
        complain(output::kSummary, fmt::format("{} has no state in trajectory.h5", figure.name));
      }
    }
  }

  void compareElasticity(const Json& summary, const trajectory::TrajectoryReader& run,
                         const Poses& start, const Poses& end) {
    const Json stated = summary.value("elasticity", Json());
    const brick::PairForces& forces = run.subject().pairForces;
    const auto& panels = run.end().panels;
    const bool isElastic = !forces.empty() || panels;
    if (isElastic == stated.is_null()) {
      complain(output::kSummary, "elasticity and the springs in trajectory.h5 do not agree");
    }
    if (!isElastic || stated.is_null()) return;
    brick::Elasticity found = brick::elasticityOf(forces, start, end);
    if (panels) trajectory::setElasticity(*panels, found);
    for (const scene::PairForceKind& kind : scene::pairForceKinds()) {
      const std::string name = kind.name.counted;
      compare(output::kSummary, "elasticity." + name, stated.at(name), found.count(name));
    }
    for (const auto& figure : fieldsOfType<double>(brick::Elasticity::fields())) {
      compare(output::kSummary, std::string("elasticity.") + figure.name, stated.at(figure.name),
              found.*figure.member);
    }
  }

  /// The function that computes each figure from its state. All arguments must outlive the list.
  static std::vector<StateFigure> stateFigures(const Json& summary,
                                               const trajectory::Subject& subject,
                                               const std::vector<brick::Pivot>& pivots,
                                               const Poses& asRead) {
    // As in the run: overlaps in the corners that joined bricks share do not count as "outside".
    const double zone = summary.at("settings").at("environment").at("pivot_zone");
    const double least = trajectory::kRoundingOverlap * model::tileSize(subject.model);
    const auto overlaps =
        std::make_shared<trajectory::PenetrationMeter>(subject.bricks, pivots, zone, asRead, least);
    const auto gap = [&](const Poses& poses) { return trajectory::jointGap(pivots, poses).max; };
    const auto error = [&](const Poses& poses) {
      return trajectory::targetError(*subject.model.target, subject.bricks, poses);
    };
    using run::Accuracy;
    std::vector<StateFigure> figures = {
        {nameOfField(&Accuracy::jointGapMax), gap},
        {nameOfField(&Accuracy::jointOpeningMax), gap},
        {nameOfField(&Accuracy::penetrationMax),
         [overlaps](const Poses& poses) { return overlaps->at(poses).whole; }},
        {nameOfField(&Accuracy::penetrationOutsidePivotsMax),
         [overlaps](const Poses& poses) { return overlaps->at(poses).outsidePivots; }},
        {nameOfField(&Accuracy::penetrationGrownMax),
         [overlaps](const Poses& poses) { return overlaps->at(poses).grown; }}};
    if (!subject.model.target) return figures;
    figures.push_back({nameOfField(&Accuracy::targetErrorMin), error});
    figures.push_back({run::kAssembledError, error});
    figures.push_back({nameOfField(&Accuracy::springsRestError), error});
    return figures;
  }

  /// The view of the pictures, from the settings and the motion.
  void compareView(const Json& summary, const trajectory::TrajectoryReader& run) {
    const Json& stated = summary.at("view");
    if (stated.is_null()) return;
    const Json& pictures = summary.at("settings").at("pictures");
    const Json& given = pictures.at("view");
    picture::Appearance appearance;
    appearance.camera.orbit = pictures.at("look").at("orbit");
    const std::string ground = pictures.at("look").at("ground");
    for (const auto& [word, choice] : picture::kGroundLooks) {
      if (ground == word) appearance.ground = choice;
    }
    if (!given.is_null()) {
      appearance.camera.view = {given.at("azimuth"), given.at("elevation"), given.at("roll")};
    }
    const picture::ViewAngles view = viewOf(run, appearance)->angles;
    for (const auto& [name, angle] : {std::pair{"azimuth_deg", view.azimuth},
                                      {"elevation_deg", view.elevation},
                                      {"roll_deg", view.roll}}) {
      compare(output::kSummary, fmt::format("view.{}", name), stated.at(name), angle / kDegree);
    }
  }

  /// Counts the packets of the first video in the list.
  void compareVideo(const Json& summary) {
    for (const std::string name : summary.at("files")) {
      // A GIF omits frames that players cannot show.
      if (!picture::isVideo(name) || endingOf(name) == ".gif") continue;
      // A video that was painted again is not the run's.
      if (output::listedFiles(folder_ / output::kContents).contains(name)) return;
      compare(output::kSummary, "video_frames", summary.at("video_frames"),
              picture::countVideoFrames(folder_ / name));
      return;
    }
    compare(output::kSummary, "video_frames", summary.at("video_frames"), 0);
  }

  fs::path folder_;
  VerifyReport report_;
  double lengthRounding_ = 0;  // metres
};

}  // namespace

std::optional<FinishedRun> findFinishedRun(const fs::path& folder, const std::string& order) {
  if (!isFile(folder / output::kSummary)) return std::nullopt;
  const std::string text = summaryText(folder);
  const Json summary = parseJsonOrDiscard(text);
  if (!output::isSealed(text) || !summary.is_object()) return std::nullopt;
  try {
    if (summary.at("order") != order || summary.at("outcome") == "interrupted") return std::nullopt;
    for (const auto& [name, noted] : summary.at("contents").items()) {
      if (!output::difference(folder, digestIn(name, noted)).empty()) return std::nullopt;
    }
    return FinishedRun{summary.at("outcome"), !summary.at("shortfall").is_null(), text};
  } catch (const Json::exception&) {
    return std::nullopt;  // sealed, but not a run
  }
}

VerifyReport verifyRun(const fs::path& folder) {
  return Verifier(folder).run();
}

}  // namespace kirireel::record
