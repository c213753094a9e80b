// Text about a run, made from its summary. Errors are in metres and in tiles (mean edges), which
// makes models of different size comparable.
//
// A run that arrives may keep an error. Its reason is the first of these facts that applies:
// rounding of the input; shapes of the target's tiles (a lower bound for all rigid tiles); open
// joints of the target itself; the search found no nearer state.
#include "render/cli/report.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "render/cli/option_group.h"
#include "render/picture/state_painter.h"
#include "render/report/inspection.h"
#include "sim/base/words.h"
#include "sim/run/assembled_state.h"
#include "sim/run/dynamics.h"
#include "sim/scene/scene_parts.h"

namespace kirireel::cli {
namespace {

// A target is reached if the error is below this fraction of a tile.
constexpr double kReached = 1e-6;
// Depths with a larger ratio count as equal.
constexpr double kEqualDepths = 0.999;
// A bound explains an error up to this factor above it.
constexpr double kExplains = 1.05;

/// "0.0121 m (0.012 tiles)".
std::string inTiles(double metres, const model::Model& model) {
  return model::lengthInTiles(metres, model, 3);
}

/// Why a run that arrived is not nearer to its target, in one line; empty if it is. The reason of a
/// missed target is in the first line.
std::string reasonOfError(const scene::Scene& scene, const record::RunSummary& summary) {
  const double tile = model::tileSize(scene.model);
  const double error = summary.accuracy.targetErrorEnd;
  if (summary.atTarget != true || error <= kReached * tile) return "";
  if (scene.model.rounding > 0 && error <= run::roundedReach(scene.model)) {
    return fmt::format(
        "reason: tiles fit each other only to {}, which explains errors of up to {}\n",
        lengthText(scene.model.rounding, scene.model.unit, 1),
        lengthText(run::roundedReach(scene.model), scene.model.unit, 2));
  }
  if (error <= kExplains * summary.accuracy.rigidBound) {
    return "reason: the target's tiles have other shapes, which rigid tiles cannot fit\n";
  }
  const double gap = model::largestJointGap(scene.model.joints, *scene.model.target);
  if (gap > kReached * tile) {
    return fmt::format("reason: the target opens its joints by {}; closed joints cannot reach it\n",
                       inTiles(gap, scene.model));
  }
  return "reason: no nearer state with closed joints was found\n";
}

/// Two or three lines: error, bounds, reason.
std::string describeTarget(const scene::Scene& scene, const record::RunSummary& summary) {
  const run::Accuracy& accuracy = summary.accuracy;
  const model::Model& model = scene.model;
  std::string text = fmt::format("target error {} at the end ({} at the start)\n",
                                 inTiles(accuracy.targetErrorEnd, model),
                                 lengthText(accuracy.targetErrorStart, model.unit));
  text += fmt::format("bounds: rigid tiles cannot come nearer than {}",
                      inTiles(accuracy.rigidBound, model));
  if (summary.assembledError >= 0) {
    text += fmt::format("; nearest state found with closed joints {}",
                        inTiles(summary.assembledError, model));
  }
  return text + "\n" + reasonOfError(scene, summary);
}

/// The largest gap of any step, and the gap at the end. Compliant joints, which open on purpose,
/// are listed separately.
std::string describeJoints(const scene::Scene& scene, const record::RunSummary& summary) {
  const run::Accuracy& accuracy = summary.accuracy;
  const model::Model& model = scene.model;
  std::string text =
      fmt::format("joint gap {} at most, {} at the end", inTiles(accuracy.jointGapMax, model),
                  lengthText(accuracy.jointGapEnd, model.unit));
  if (accuracy.jointOpeningMax > 0) {
    text += fmt::format("; compliant joints opened by {} at most",
                        inTiles(accuracy.jointOpeningMax, model));
  }
  return text + "\n";
}

/// The tolerance in time of the steps of a run, and the exceptions; empty for runs without such
/// steps. The total error is only known if it was measured.
std::string describeTime(const scene::Scene& scene, const record::RunSummary& summary) {
  const run::DeployCost& cost = summary.cost;
  scene::Scene run = scene;
  run.path = summary.path;
  const bool isContinuation = summary.path.kind == scene::PathKind::Continuation;
  if (isContinuation || !scene.grips.empty() || !run::keepsTolerance(run)) {
    return summary.path.kind == scene::PathKind::Guided
               ? "time: critically damped springs guide the tiles in fixed steps, without a "
                 "tolerance\n"
               : "";
  }
  std::string text = fmt::format("time: tolerance {:.2g} tiles per step", scene.solver.tolerance);
  if (cost.took.touchingTime > 0) {
    text += fmt::format(
        "; exceeded during {:.3g} s, when contacts changed too often or did not converge",
        cost.took.touchingTime);
  }
  if (cost.took.singularTime > 0) {
    text += fmt::format(
        "; exceeded during {:.3g} s, when joints were singular or springs too stiff for it",
        cost.took.singularTime);
  }
  if (cost.took.rounding > 0 || cost.took.energyRounding > 0) {
    text +=
        fmt::format("; rounding adds up to {:.2g} tiles and {:.2g} J in all",
                    cost.took.rounding / model::tileSize(scene.model), cost.took.energyRounding);
  }
  const bool isMissed = cost.took.touchingTime + cost.took.singularTime > 0;
  text += summary.timeError
              ? fmt::format("; a hundredth of it moves vertices by at most {:.2g} tiles{}",
                            *summary.timeError, isMissed ? " (with a tenth of the timestep)" : "")
              : "; the error of the run is not known (--measure-time-error)";
  return fmt::format("{}; {:.2g} s of CPU time, {} steps rejected\n", text, cost.cpuSeconds,
                     cost.took.rejected);
}

/// The total depth, and its part outside the corners that joined bricks share. Thick bricks cannot
/// avoid overlap in these corners; contacts prevent the rest.
std::string describePenetration(const scene::Scene& scene, const record::RunSummary& summary) {
  const run::Accuracy& accuracy = summary.accuracy;
  const LengthUnit& unit = scene.model.unit;
  std::string text =
      fmt::format("penetration {} at most", inTiles(accuracy.penetrationMax, scene.model));
  if (accuracy.penetrationOutsidePivotsMax >= kEqualDepths * accuracy.penetrationMax) {
    text += ", outside the corners that joined bricks share";
  } else {
    text += fmt::format(", in the corners that joined bricks share; {} outside them",
                        lengthText(accuracy.penetrationOutsidePivotsMax, unit));
  }
  const auto [less, more] =
      std::minmax(accuracy.penetrationGrownMax, accuracy.penetrationOutsidePivotsMax);
  if (less < kEqualDepths * more) {
    text +=
        fmt::format(", {} more than at the start", lengthText(accuracy.penetrationGrownMax, unit));
  }
  return text + "\n";
}

/// Energies of pair forces; empty without such forces.
std::string describeElasticity(const std::optional<brick::Elasticity>& found) {
  if (!found) return "";
  std::vector<std::string> forces;
  for (const scene::PairForceKind& kind : scene::pairForceKinds()) {
    const int count = found->count(kind.name.counted);
    if (count > 0) forces.push_back(fmt::format(fmt::runtime(kind.name.words), count));
  }
  // Springs at hinges are folds of panels.
  if (const int bars = found->count("bars"); bars > 0) {
    forces = {fmt::format("{} bars", bars), fmt::format("{} folds", found->count("folds"))};
  }
  return fmt::format(
      "{}: {:.4g} J at the start, {:.4g} J at the end, moments up to {:.4g} N m there\n",
      fmt::join(forces, " and "), found->energyStart, found->energyEnd, found->momentEnd);
}

/// Runs without a target report a path only if joints opened.
std::string describePath(const record::RunSummary& summary, bool hasTarget) {
  if (!hasTarget && summary.accuracy.jointOpeningMax == 0) return "";
  return fmt::format("path: {}\n", summary.pathReason);
}

/// Largest number of named pairs of bricks that block each other at the target.
constexpr std::size_t kPairsNamed = 3;

/// The deepest pairs come first.
std::string describeBlocking(const std::vector<run::BlockingPair>& blocking,
                             const model::Model& model) {
  if (blocking.empty()) return "";
  std::vector<std::string> pairs;
  for (const run::BlockingPair& pair : blocking) {
    if (pairs.size() == kPairsNamed) break;
    pairs.push_back(run::describe(pair, model.fileOrder.countsFrom, model.unit));
  }
  return fmt::format("{} of bricks would overlap at the target: {}{}\n",
                     counted(blocking.size(), "pair"), fmt::join(pairs, "; "),
                     blocking.size() > pairs.size() ? "; ..." : "");
}

/// CPU seconds of all threads together, and total wall time.
std::string describeCost(const record::RunSummary& summary) {
  const run::DeployCost& deploy = summary.cost;
  const record::RecordCost& record = summary.recordCost;
  std::string text =
      fmt::format("{} steps in {:.2f} s, pictures {:.2f} s, video {:.2f} s; {:.1f} s in all\n",
                  deploy.took.steps, deploy.cpuSeconds, record.cpuSecondsRender,
                  record.cpuSecondsEncode, record.wallSeconds);
  if (deploy.took.unconverged > 0) {
    text += fmt::format(
        "{} steps of the smallest length missed the tolerance of joints or contacts: {}\n",
        deploy.took.unconverged,
        summary.needs.contacts.on
            ? "in these, bricks that touch or are joined moved as rigid pieces and lag "
              "behind their springs"
            : "they were accepted; the joint gap and the end may have this error");
  }
  return text;
}

/// The files by name, but each subfolder only once: "frames/" has hundreds of files.
std::vector<std::string> shortList(const std::vector<std::string>& files) {
  std::vector<std::string> list;
  for (const std::string& file : files) {
    // Empty for a file at the top: find gives npos, and npos + 1 is 0.
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

std::string describePictures(const record::PictureSettings& settings,
                             const record::PictureReport& report) {
  const record::RecordCost& cost = report.recordCost;
  std::string text;
  if (report.videoFrames > 0) {
    text = fmt::format("{} frames: pictures {:.2f} s, video {:.2f} s; {:.1f} s in all\n",
                       report.videoFrames, cost.cpuSecondsRender, cost.cpuSecondsEncode,
                       cost.wallSeconds);
  }
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

void ProgressLine::show(const record::Progress& progress) {
  show(fmt::format("{} {:3.0f}%", progress.stage, 100 * progress.share));
}

void ProgressLine::show(const std::string& line) {
  // No line in a log file, because it cannot be erased there.
  if (!isTerminal_ || line == shown_) return;
  // Return to the start of the line and clear it.
  fmt::print(stderr, "\r\033[K{}", line);
  std::fflush(stderr);
  shown_ = line;
}

namespace {

/// "target reached, error 1e-13 m", "came to rest 0.2 m short of the target: ...", "settled after
/// 6 s: ...".
std::string describeEnd(const scene::Scene& scene, const record::RunSummary& summary) {
  using enum run::Outcome;
  const bool isDiverged = summary.outcome == Diverged;
  const bool isOpen = summary.outcome == OutOfTime && !summary.atTarget;
  const bool isWhole = summary.loadCurve || summary.atTarget == false || isOpen;
  if (summary.outcome == Interrupted || (isWhole && !isDiverged)) return summary.reason;
  if (summary.atTarget == true) {
    return fmt::format("target reached, error {}",
                       lengthText(summary.accuracy.targetErrorEnd, scene.model.unit, 2));
  }
  const std::string end =
      fmt::format("{} after {:.4g} s", run::toString(summary.outcome), summary.endTime);
  const bool isExplained = isDiverged || summary.outcome == Locked || summary.shortfall.empty();
  return isExplained ? end + ": " + summary.reason : end;
}

/// The end, and all faults of the run.
std::string headline(const scene::Scene& scene, const record::RunSummary& summary) {
  std::string text = describeEnd(scene, summary);
  if (summary.shortfall.empty() || summary.outcome == run::Outcome::Interrupted) return text;
  if (text.find(summary.shortfall) == std::string::npos) text += ", but " + summary.shortfall;
  return fmt::format("{}; exit code {}", text, kExitShort);
}

/// Collisions of a run. Overlaps of tiles are measured; ground and obstacles only act as contacts.
std::string describeContacts(const scene::Scene& scene, const record::RunSummary& summary) {
  const double most = run::kAllowedOverlap * model::tileSize(scene.model);
  const run::Accuracy& accuracy = summary.accuracy;
  if (summary.needs.contacts.on) return "contacts on";
  if (accuracy.penetrationGrownMax > most) return "contacts off";
  std::string text = "no overlaps";
  if (scene.environment.ground || !scene.environment.obstacles.empty()) text += " between tiles";
  if (accuracy.penetrationOutsidePivotsMax > most) text += " beyond those of the start";
  return text;
}

/// "kinematic path, no overlaps".
std::string describeMotion(const scene::Scene& scene, const record::RunSummary& summary) {
  const char* path = summary.loadCurve                                    ? "path of equilibria"
                     : summary.path.kind == scene::PathKind::Continuation ? "kinematic path"
                     : summary.path.kind == scene::PathKind::Guided       ? "guided by springs"
                                                                          : "dynamics";
  return fmt::format("{}, {}", path, describeContacts(scene, summary));
}

/// Up to two lines: overlaps that grew during the run, and overlaps that block the target.
std::string describeWorstOverlap(const scene::Scene& scene, const record::RunSummary& summary) {
  const double tile = model::tileSize(scene.model);
  const double grown = summary.accuracy.penetrationGrownMax;
  const bool isOverlapping = grown > run::kAllowedOverlap * tile;
  std::string text =
      isOverlapping ? fmt::format("worst overlap {}\n", inTiles(grown, scene.model)) : "";
  if (summary.blocking.empty() || (summary.atTarget == true && !isOverlapping)) return text;
  const run::BlockingPair& worst = summary.blocking.front();
  const int first = scene.model.fileOrder.countsFrom;
  return text + fmt::format("overlaps at the target: {}, worst tiles {} and {} ({})\n",
                            counted(summary.blocking.size(), "pair"), first + worst.tileA,
                            first + worst.tileB, lengthText(worst.overlap, scene.model.unit, 2));
}

}  // namespace

std::string describeRunBriefly(const scene::Scene& scene, const record::RecordSettings& settings,
                               const record::RunSummary& summary) {
  std::string text = fmt::format("{}: {}\n", scene.model.name, headline(scene, summary));
  text +=
      fmt::format("{}, {}, {}; {}", counted(scene.model.tiles.size(), "tile"),
                  counted(scene.model.joints.size(), "joint"),
                  summary.needs.planar.on ? "planar" : "in space", describeMotion(scene, summary));
  if (!settings.peerSpelling.empty())
    text += fmt::format("; PyKirigami's constants, by {}", settings.peerSpelling);
  text += '\n';
  if (!scene.model.joints.empty()) {
    const run::Accuracy& accuracy = summary.accuracy;
    text += accuracy.jointOpeningMax > 0
                ? fmt::format("joints open by up to {}, {} at the end\n",
                              inTiles(accuracy.jointOpeningMax, scene.model),
                              lengthText(accuracy.jointGapEnd, scene.model.unit, 2))
                : fmt::format("joints closed to {}\n",
                              lengthText(accuracy.jointGapMax, scene.model.unit, 2));
  }
  text += describeWorstOverlap(scene, summary);
  text += fmt::format("{} files in {} ({:.1f} s)", summary.files.size(), settings.folder.string(),
                      summary.recordCost.wallSeconds);
  if (const std::size_t count = summary.warnings.size(); count > 0) {
    text += fmt::format("; {}: --verbose", counted(count, "warning"));
  }
  return spellOptions(text + "\n");
}

std::string describeRun(const scene::Scene& scene, const record::RecordSettings& settings,
                        const record::RunSummary& summary) {
  std::string text = fmt::format("{}: {} after {:.4g} s: {}\n", scene.model.name,
                                 run::toString(summary.outcome), summary.endTime, summary.reason);
  text += fmt::format("{} tiles, {} joints; {}; {}\n", scene.model.tiles.size(),
                      scene.model.joints.size(), report::needText("planar", summary.needs.planar),
                      report::needText("contacts", summary.needs.contacts));
  if (!settings.peerSpelling.empty()) {
    text += fmt::format("PyKirigami's constants for options that are not given, because of {}\n",
                        settings.peerSpelling);
  }
  for (const std::string& warning : summary.warnings) text += fmt::format("warning: {}\n", warning);
  if (scene.model.target && !summary.loadCurve) {
    text += describeTarget(scene, summary);
    text += describeBlocking(summary.blocking, scene.model);
  }
  text += describePath(summary, scene.model.target.has_value());
  text += describeJoints(scene, summary) + describeTime(scene, summary);
  text += describeElasticity(summary.elasticity);
  text += describePenetration(scene, summary);
  if (summary.leftOutFrom) {
    text += fmt::format(
        "pictures do not show bricks that are farther away than {:g} model sizes, the first at "
        "{:.4g} s; "
        "trajectory.h5 has them\n",
        picture::kFarthestShown, *summary.leftOutFrom);
  }
  if (scene.alignment.moved > kReached * model::tileSize(scene.model)) {
    text += scene::describe(scene.alignment, scene.model.unit) + "\n";
  }
  text += describeCost(summary);
  text += fmt::format("in {}: {}\n", settings.folder.string(),
                      fmt::join(shortList(summary.files), " "));
  return spellOptions(text);
}

// ------------------------------------------------------------------------------------------------
// A handler only stores the number of its signal in a lock-free atomic; more is not allowed (C++
// standard, [support.signal]; signal-safety(7)). Long loops poll takeInterrupt() and stop when
// files are complete. A second signal is stored in the same way and ends the next stage, so no file
// is ever incomplete.
//
// SIGXFSZ is sent if a file would exceed the limit of its process (ulimit -f). It is ignored: the
// write then fails with EFBIG, which is reported like a full disk.

namespace {

std::atomic<int> noted = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait for a lock");

/// A later signal replaces an earlier one that was not taken yet.
extern "C" void noteInterrupt(int signal) {
  noted = signal;
}

}  // namespace

void noteSignals() {
  std::signal(SIGINT, noteInterrupt);
  std::signal(SIGTERM, noteInterrupt);
  // signal() returns the previous handler. nohup ignores SIGHUP, which is kept.
  if (std::signal(SIGHUP, noteInterrupt) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

std::optional<std::string> takeInterrupt() {
  switch (noted.exchange(0)) {
    case SIGINT:
      return "SIGINT";
    case SIGTERM:
      return "SIGTERM";
    case SIGHUP:
      return "SIGHUP";
    default:
      return std::nullopt;
  }
}

}  // namespace kirireel::cli
