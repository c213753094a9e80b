// record() in its order:
//
// - 1. Reject invalid input: settings, styles, exports, files of others in the folder, font,
//   encoder, graphics library.
// - 2. Deploy the scene. A separate thread writes samples to trajectory.h5 (pipeline.h). A killed
//   run can continue from a checkpoint.
// - 3. Make end state, meshes, load curve, pictures, video and exports from trajectory.h5. So
//   render() and export can make them again.
// - 4. Hash the files, write summary.json, and move all of them into place together (FileSet).
//
// An interruption ends the current stage. The results so far are written, and the summary names its
// cause. Only errors (a full disk) leave the folder unchanged; the checkpoint then remains.
//
// Memory does not grow with the run: samples are streamed to the file and read back one by one.
#include "render/record/record.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "render/output/output_folder.h"
#include "render/picture/gl_context.h"
#include "render/picture/label.h"
#include "render/record/curves.h"
#include "render/record/inset.h"
#include "render/record/load_curve_file.h"
#include "render/record/pace.h"
#include "render/record/pipeline.h"
#include "render/record/run_pictures.h"
#include "render/record/summary.h"
#include "render/writers/mesh.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/base/interruption.h"
#include "sim/formats/read_model.h"

namespace kirireel::record {
namespace {

/// Steps that take less are not interrupted from within, so their checkpoint loses nothing.
constexpr std::chrono::milliseconds kPatience{100};
/// Least duration of the motion in a video at an even pace, without held frames, seconds.
constexpr double kMinMotion = 0.1;

/// `meaning`: for the message, as in "a factor".
void requireWithin(double value, double least, double most, const char* option,
                   const char* meaning) {
  if (value >= least && value <= most) return;
  throw InputError(fmt::format("error: {0} {1:g} is not possible; give {2} of {3:g} to {4:g}",
                               option, value, meaning, least, most));
}

/// Rejects impossible grids before the deployment.
void requireGrid(const PictureSettings& settings) {
  picture::GridStyle style;
  style.heads = settings.columnHeads;
  picture::layOutGrid(settings.size, settings.grid, style);
  for (const std::string& head : settings.columnHeads)
    picture::requireDrawable("--column-heads", head);
  if (settings.arrows) picture::requireDrawable("--arrows", picture::kArrow);
}

/// Also sets the font of all text from now on.
void requireValidSettings(const PictureSettings& settings) {
  picture::setFont(settings.font);
  picture::requireValidSize(settings.size);
  if (settings.snapshots) requireGrid(settings);
  if (settings.video) picture::requireValidSettings(settings.videoFile, videoSettings(settings));
  const int most = settings.paintsFrames() ? kMaxFrameRate : kMaxSampleRate;
  if (settings.framesPerSecond < 1 || settings.framesPerSecond > most) {
    throw InputError(
        fmt::format("error: --fps {} is not possible; give 1 to {}{}", settings.framesPerSecond,
                    most, settings.paintsFrames() ? ", or remove the video (--no-video)" : ""));
  }
  if (settings.video)
    picture::requireEncoder(settings.folder / settings.videoFile, videoSettings(settings));
  if (settings.video) requireTitle({settings.title, settings.subtitle});
  requireWithin(settings.speed, 1e-3, 1e3, "--speed", "a factor");
  if (settings.fontPoints && !settings.gridWidth) {
    throw InputError(
        "error: --font-size requires --width, as in --width 180mm. Add --width or remove "
        "--font-size");
  }
  const double dots = settings.gridWidth.value_or(0) / 25.4 * settings.gridDotsPerInch();
  if (dots > picture::kMaxFrameSide) {
    throw InputError(
        fmt::format("error: --width {:g}mm at {:g} dots per inch is {:.0f} pixels, at most {} are "
                    "allowed; give a smaller --dpi",
                    *settings.gridWidth, settings.gridDotsPerInch(), dots, picture::kMaxFrameSide));
  }
  requireWithin(settings.heldSeconds(), 0, 60, "--hold", "seconds");
  requireWithin(settings.length, 0.1, 36000, "--length", "seconds");
  if (settings.pace == Pace::Even && settings.length < 2 * settings.heldSeconds() + kMinMotion) {
    throw InputError(fmt::format(
        "error: --length {:g} leaves no time for motion between --hold {:g} at the start and the "
        "end; give --length of {:g} or more, or a shorter --hold",
        settings.length, settings.heldSeconds(), 2 * settings.heldSeconds() + kMinMotion));
  }
}

/// Painters beyond these wait for the encoder.
constexpr int kMaxPainters = 16;
/// The maximum in Mesa.
constexpr int kMaxRasterThreads = 16;

/// Whether the run needs trajectory.h5. Pictures, meshes and exports are made from it.
bool keepsTrajectory(const RecordSettings& settings) {
  return settings.trajectory || settings.meshes || settings.paints() ||
         !settings.exports.formats.empty();
}

/// The end of a run that the files show.
struct RunEnd {
  run::DeploymentResult result;
  SharedSample first;
  SharedSample last;
  std::optional<double> leftOutFrom;  ///< see RunSummary
};

/// A deployment knows that it was ended early, but not by whom.
void nameInterruption(const std::string& by, run::DeploymentResult& result) {
  if (result.outcome != run::Outcome::Interrupted) return;
  result.reason = "interrupted by " + by;
  result.trajectory.events.back().text = run::endText(result.outcome, result.reason);
}

void summarize(const RunEnd& end, RunSummary& summary) {
  static_cast<run::DeploymentResult&>(summary) = end.result;
  summary.endTime = end.last->time;
  summary.leftOutFrom = end.leftOutFrom;
}

/// Writes one run to trajectory.h5. All arguments must outlive it.
class LiveRun {
  using Clock = std::chrono::steady_clock;

 public:
  /// The folder must be locked.
  LiveRun(const scene::Scene& scene, const RecordSettings& settings,
          const ProgressObserver& observer, const Deployer& deployer)
      : scene_(scene),
        settings_(settings),
        observer_(observer),
        deployer_(deployer),
        subject_(trajectory::subjectOf(scene)),
        start_(contentOf(subject_)),
        checkpoints_(settings.folder / output::kCheckpoint, settings.order) {
    if (settings.resume) {
      remark_ = checkpoints_.find();
    } else {
      checkpoints_.remove();
    }
  }

  /// Calls observers on this thread; the writer has its own thread.
  void deploy() {
    std::optional<ThreadedTrajectoryWriter> writer;
    if (keepsTrajectory(settings_)) {
      subject_.settings = settingsText(scene_, settings_);
      writer.emplace(settings_.folder / output::kTrajectory, subject_);
    }
    const run::SampleObserver watch = [&](const trajectory::Sample& sample) {
      keep(sample);
      const bool taken = !writer || writer->take(end_.last);
      return taken &&
             reportProgress("deploying", std::min(1.0, sample.time / scene_.stop.duration));
    };
    const run::TrialObserver searching = [&](const run::SearchNews& news) {
      if (!news.warning.empty()) reportWarning(news.warning);
      return reportProgress("searching a path", news.share);
    };
    const InterruptionScope scope([this] { endLongStep(); });
    end_.result = deployer_(scene_, settings_.sampleInterval(), watch, searching,
                            settings_.order.empty() ? nullptr : &checkpoints_);
    if (interruption_) nameInterruption(*interruption_, end_.result);
    if (!writer) return;
    RunSummary summary;
    summarize(end_, summary);
    end_.result.trajectory.findings = findingsText(scene_, summary);
    writer->finish(end_.result.trajectory);
    if (end_.result.loadCurve) {
      addLoadCurve(settings_.folder / output::kTrajectory, *end_.result.loadCurve);
    }
  }

  const RunEnd& end() const { return end_; }
  /// Call it when all of the run's files are in place.
  void removeCheckpoint() { checkpoints_.remove(); }

 private:
  void reportWarning(const std::string& warning) {
    observer_(
        {"searching a path", 0, fmt::format("{}: warning: {}", scene_.model.name, warning), true});
  }

  /// Returns whether the deployment continues. After the first stop the observer is not called
  /// again.
  bool reportProgress(const char* stage, double share) {
    stage_ = stage;
    share_ = share;
    if (interruption_) return false;
    interruption_ = observer_({stage, share, std::exchange(remark_, {})});
    reportedAt_ = Clock::now();
    return !interruption_;
  }

  /// Samples and news of the search may be far apart.
  void endLongStep() {
    if (!InterruptionCatcher::exists() || Clock::now() - reportedAt_ < kPatience) return;
    if (!reportProgress(stage_, share_)) throw Interrupted();
  }

  void keep(const trajectory::Sample& sample) {
    end_.last = std::make_shared<const trajectory::Sample>(sample);
    if (!end_.first) end_.first = end_.last;
    if (!end_.leftOutFrom && !picture::showsAllBricks(start_, sample.poses))
      end_.leftOutFrom = sample.time;
  }

  const scene::Scene& scene_;
  const RecordSettings& settings_;
  const ProgressObserver& observer_;
  const Deployer& deployer_;
  trajectory::Subject subject_;
  picture::PictureContent start_;
  run::Checkpoints checkpoints_;
  std::string remark_;  // not reported yet
  const char* stage_ = "searching a path";
  double share_ = 0;
  Interruption interruption_;
  Clock::time_point reportedAt_;
  RunEnd end_;
};

void writeEndState(const scene::Scene& scene, const RunEnd& end, const RecordSettings& settings,
                   RunSummary& summary) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  formats::writeTiles(model::inUnit(model::inFileOrder(brick::bottomTiles(bricks, end.last->poses),
                                                       scene.model.fileOrder),
                                    scene.model.unit),
                      settings.folder / output::kFinalVertices, scene.model.unit);
  summary.files.emplace_back(output::kFinalVertices);
  if (!settings.meshes) return;
  const auto write = [&](const char* name, const trajectory::Sample& sample) {
    for (const char* ending : {".obj", ".ply"}) {
      summary.files.push_back(fmt::format("{}{}", name, ending));
      writers::writeMesh(settings.folder / summary.files.back(), bricks, sample.poses,
                         scene.model.unit);
    }
  };
  write(output::kInitialMesh, *end.first);
  write(output::kFinalMesh, *end.last);
}

/// Writes meshes of the moments that the timeline requested: two files for each "export", numbered
/// from 1.
void writeStates(const scene::Scene& scene, const RecordSettings& settings, RunSummary& summary) {
  const trajectory::TrajectoryReader run(settings.folder / output::kTrajectory);
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  int number = 0;
  for (const std::size_t sample : samplesOf("export", run)) {
    ++number;
    for (const char* ending : {".obj", ".ply"}) {
      summary.files.push_back(output::momentFile(output::kStateMoment, number, ending));
      writers::writeMesh(settings.folder / summary.files.back(), bricks, run.sample(sample).poses,
                         scene.model.unit);
    }
  }
}

/// The equilibria of a scene with grips.
void writeLoadCurve(const RecordSettings& settings, const LengthUnit& unit, RunSummary& summary) {
  if (!summary.loadCurve) return;
  writeTextFile(settings.folder / output::kLoadCurve,
                mechanics::loadTable(*summary.loadCurve, unit));
  summary.files.emplace_back(output::kLoadCurve);
}

/// Sets up the graphics library, which reports missing parts before a simulation. Making a context
/// takes a moment, but a run of hours without pictures costs more.
void prepareGraphics(const PictureSettings& settings) {
  if (settings.graphics) picture::setGraphicsLibrary(*settings.graphics);
  // Mesa draws the triangles of all contexts with one set of threads. Without these threads it
  // draws on the painters' own, but only one painter at a time under a lock
  // (lp_setup_rasterize_scene). This is two thirds of painting, so all others would wait in every
  // frame.
  if (settings.paintsFrames()) {
    const int painters = settings.painters();
    picture::setRasterThreads(painters > 1 ? std::min(painters, kMaxRasterThreads) : 0);
  }
  if (settings.paints()) const picture::Context probe;
}

/// Whether the run ended before it could move.
bool wasCutShort(const trajectory::TrajectoryReader& run) {
  if (run.end().events.empty()) return false;
  const std::string& text = run.end().events.back().text;
  return text.starts_with(run::toString(run::Outcome::Interrupted)) ||
         text.starts_with(run::toString(run::Outcome::Diverged));
}

/// Whether one picture shows the whole run. Motion shorter than this fraction of the model's size
/// is ignored.
bool isStill(const trajectory::TrajectoryReader& run, const MotionCurve& motion,
             const picture::CameraChoice& camera) {
  constexpr double kStill = 1e-9;
  if (wasCutShort(run)) return false;
  return motion.length() <= kStill * model::modelSize(run.subject().model) && camera.orbit == 0 &&
         camera.keys.empty();
}

/// Makes all pictures of a finished run, if the settings request any.
void makePictures(const trajectory::TrajectoryReader& run, const PictureSettings& asked,
                  const ProgressObserver& observer, PictureReport& report) {
  if (!asked.paints()) return;
  PictureSettings settings = asked;
  const MotionCurve motion = motionOf(run);
  if (asked.snapshots && isStill(run, motion, asked.appearance.camera)) {
    settings.video = settings.frames = false;
    settings.grid = {1, 1};
    settings.columnHeads.clear();
    if (!settings.captions) settings.captions = picture::CaptionParts();
    observer({"painting", 1,
              fmt::format("{}: nothing moves, so there is one picture{}", run.subject().model.name,
                          asked.video ? " and no video" : "")});
  }
  RunPictures pictures(run, settings, report);
  if (settings.paintsFrames()) pictures.makeFrames(run, motion, observer);
  pictures.writeSnapshots(run, motion);
}

/// A run that lacks a curve keeps its pictures, because it may have been long.
void checkInset(const trajectory::TrajectoryReader& run, const ProgressObserver& observer,
                RecordSettings& settings) {
  if (settings.inset.empty()) return;
  try {
    insetCurve(run, settings);
  } catch (const InputError& error) {
    settings.inset.clear();
    observer({"painting", 0, fmt::format("warning: the video has no inset: {}", error.what())});
  }
}

/// Files in place do not change, so each is read once. Files with a known digest are not read
/// again.
void noteDigests(const std::filesystem::path& folder, RunSummary& summary) {
  std::set<std::string> known = {output::kSummary};
  for (const output::FileDigest& digest : summary.digests) known.insert(digest.name);
  for (const std::string& file : summary.files) {
    if (known.insert(file).second) summary.digests.push_back(output::digestOf(folder, file));
  }
}

/// A missing state to export does not make the run fail.
void writeExports(const RecordSettings& settings, RunSummary& summary) {
  const trajectory::TrajectoryReader trajectory(settings.folder / output::kTrajectory);
  try {
    for (const std::string& file :
         exports::exportInto(trajectory, settings.exports, settings.folder)) {
      summary.files.push_back(file);
    }
  } catch (const InputError& error) {
    summary.leftOut = error.what();
  }
}

/// Whether pictures of some run may have this name. Names with any number count, because the number
/// of pictures is not known.
bool isPicture(const std::string& name, const PictureSettings& settings) {
  const bool hasFrames = settings.frames || !settings.chosenFrames.empty();
  const auto isPage = [&name](picture::PageFormat format) {
    return name == picture::pageFile(output::kSnapshotPages, format);
  };
  return (settings.video && name == settings.videoFile) ||
         (settings.snapshots && name == output::kSnapshots) ||
         (settings.snapshots && std::ranges::any_of(settings.pages, isPage)) ||
         (settings.svg &&
          output::isNumbered(name, [](int k) { return output::snapshotDrawing(k).string(); })) ||
         (hasFrames && name == output::kFrames + std::string("/")) ||
         (hasFrames &&
          output::isNumbered(name, [](int k) { return output::frameFile(k).string(); })) ||
         output::isNumbered(
             name, [](int k) { return output::momentFile(output::kSnapshotMoment, k, ".png"); });
}

/// The same of all files.
bool isOutput(const std::string& name, const RecordSettings& settings) {
  if (name == output::kFinalVertices || name == output::kLoadCurve) return true;
  if (keepsTrajectory(settings) && name == output::kTrajectory) return true;
  if (settings.paints() && isPicture(name, settings)) return true;
  if (exports::isExported(name, settings.exports)) return true;
  for (const char* ending : {".obj", ".ply"}) {
    if (!settings.meshes) break;
    if (name == output::kInitialMesh + std::string(ending)) return true;
    if (name == output::kFinalMesh + std::string(ending)) return true;
    const auto moment = [&](int k) { return output::momentFile(output::kStateMoment, k, ending); };
    if (output::isNumbered(name, moment)) return true;
  }
  return false;
}

/// Calls `paint` with settings of a temporary folder. Its files appear in the asked folder when all
/// of them are complete.
PictureReport paintFiles(PictureSettings settings, const std::vector<std::string>& models,
                         const std::function<void(const PictureSettings&, PictureReport&)>& paint) {
  const Stopwatch stopwatch;
  output::FileSet files(settings.folder, output::kContents);
  files.requireFree([&settings](const std::string& name) { return isPicture(name, settings); });
  settings.folder = files.stage();
  settings.madeBy = madeBy(models);
  PictureReport report;
  prepareGraphics(settings);
  paint(settings, report);
  if (!report.files.empty()) files.commit(report.files);
  report.recordCost.wallSeconds = stopwatch.seconds();
  report.recordCost.peakMemoryBytes = peakMemoryBytes();
  return report;
}

}  // namespace

int PictureSettings::painters() const {
  const int cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  return painterCount.value_or(std::min(cores, kMaxPainters));
}

RunSummary summaryOf(const run::DeploymentResult& result, double endTime) {
  RunSummary summary{{}, result};
  summary.endTime = endTime;
  return summary;
}

RunSummary record(const scene::Scene& scene, const RecordSettings& asked,
                  const ProgressObserver& observer, const Deployer& deployer) {
  const Stopwatch stopwatch;
  requireValidSettings(asked);
  requirePaintable(contentOf(trajectory::subjectOf(scene)), asked);
  exports::requireExportable(scene.model, scene.brick, asked.exports);
  output::FileSet files(asked.folder, output::kSummary);
  files.requireFree([&asked](const std::string& name) { return isOutput(name, asked); });
  RecordSettings settings = asked;
  settings.folder = files.stage();
  settings.madeBy = madeBy({scene.model.name}, settings.order);
  // One scale held for the start and the target; it must hold for a motion that leaves their plane.
  if (settings.scaleBar) settings.appearance.camera.orthographic = true;

  RunSummary summary;
  LiveRun run(scene, settings, observer, deployer);
  prepareGraphics(settings);
  run.deploy();
  summarize(run.end(), summary);
  if (keepsTrajectory(settings)) summary.files.emplace_back(output::kTrajectory);
  writeEndState(scene, run.end(), settings, summary);
  if (settings.meshes) writeStates(scene, settings, summary);
  writeLoadCurve(settings, scene.model.unit, summary);
  if (settings.paints()) {
    const trajectory::TrajectoryReader trajectory(settings.folder / output::kTrajectory);
    checkInset(trajectory, observer, settings);
    makePictures(trajectory, settings, observer, summary);
  }
  if (summary.stoppedAt) {
    summary.outcome = run::Outcome::Interrupted;
    summary.reason = fmt::format("interrupted by {} while painting; the video ends at {:.4g} s",
                                 summary.stoppedBy, *summary.stoppedAt);
  }

  summary.files.emplace_back(output::kSummary);
  // If an export fails, all other files are still written.
  std::exception_ptr exportFailure;
  try {
    if (!settings.exports.formats.empty()) writeExports(settings, summary);
  } catch (const OutputError&) {
    exportFailure = std::current_exception();
  }
  if (!summary.leftOut.empty()) {
    observer({"exporting", 1, fmt::format("warning: nothing was exported: {}", summary.leftOut)});
  }
  noteDigests(settings.folder, summary);
  summary.recordCost.wallSeconds = stopwatch.seconds();
  summary.recordCost.peakMemoryBytes = peakMemoryBytes();
  if (summary.outcome != run::Outcome::Interrupted) run.removeCheckpoint();
  files.commit(summaryJson(scene, settings, summary));
  if (exportFailure) std::rethrow_exception(exportFailure);
  return summary;
}

PictureReport render(const std::filesystem::path& trajectory, const PictureSettings& settings,
                     const ProgressObserver& observer) {
  requireValidSettings(settings);
  const trajectory::TrajectoryReader run(trajectory);
  return paintFiles(settings, {run.subject().model.name},
                    [&](const PictureSettings& aside, PictureReport& report) {
                      makePictures(run, aside, observer, report);
                    });
}

PictureReport renderSeveral(const std::vector<std::filesystem::path>& trajectories,
                            const PictureSettings& asked, const ProgressObserver& observer) {
  PictureSettings settings = asked;
  settings.grid.rows = static_cast<int>(trajectories.size());
  requireValidSettings(settings);
  std::vector<std::unique_ptr<trajectory::TrajectoryReader>> opened;
  std::vector<const trajectory::TrajectoryReader*> runs;
  std::vector<std::string> models;
  for (const std::filesystem::path& trajectory : trajectories) {
    opened.push_back(std::make_unique<trajectory::TrajectoryReader>(trajectory));
    runs.push_back(opened.back().get());
    models.push_back(runs.back()->subject().model.name);
  }
  return paintFiles(settings, models, [&](const PictureSettings& aside, PictureReport& report) {
    const std::vector<std::string> names = namesOf(runs, trajectories);
    if (aside.paintsFrames()) makeSideBySide(runs, names, aside, observer, report);
    if (!aside.snapshots) return;
    std::vector<PanelRow> rows = figureRows(runs, aside);
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].head = names[k];
    PanelSheet(rows, aside.grid, aside, report).write();
  });
}

}  // namespace kirireel::record
