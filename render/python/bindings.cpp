// Python's SIGINT handler only sets a flag, which the interpreter checks between its own
// instructions. It would not stop a long run in C++. During the lifetime of a watch, our handler
// replaces Python's. It counts, then calls Python's handler, which sets its flag. check() compares
// the count with that at the watch's start, on any thread.
//
// Several watches may exist at the same time on several threads. The first installs the handler and
// the last removes it.
#include "render/python/bindings.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <memory>
#include <mutex>

#include <fmt/format.h>
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "render/cli/command_line.h"
#include "render/cli/manual.h"
#include "render/output/output_folder.h"
#include "render/picture/state_painter.h"
#include "render/record/pace.h"
#include "render/record/run_pictures.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "sim/trajectory/run_curves.h"
#include "sim/trajectory/trajectory_file.h"

namespace py = pybind11;

using namespace py::literals;

namespace kirireel::python {
namespace {

std::atomic<int> interruptions = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may not wait for a lock");

std::mutex handlerMutex;
int watches = 0;                     // number of living watches
struct sigaction pythonAction = {};  // before the first watch

extern "C" void noteAndPassOn(int signal) {
  ++interruptions;
  pythonAction.sa_handler(signal);
}

/// Whether a handler is neither ignored nor default and takes only a signal number.
bool isHandled(const struct sigaction& action) {
  return action.sa_handler != SIG_DFL && action.sa_handler != SIG_IGN &&
         (action.sa_flags & SA_SIGINFO) == 0;
}

}  // namespace

InterruptionWatch::InterruptionWatch() : before_(interruptions) {
  const std::lock_guard lock(handlerMutex);
  if (watches++ > 0) return;
  ::sigaction(SIGINT, nullptr, &pythonAction);
  if (!isHandled(pythonAction)) return;
  // Keeps Python's flags and mask.
  struct sigaction ours = pythonAction;
  ours.sa_handler = noteAndPassOn;
  ::sigaction(SIGINT, &ours, nullptr);
}

InterruptionWatch::~InterruptionWatch() {
  const std::lock_guard lock(handlerMutex);
  if (--watches == 0 && isHandled(pythonAction)) ::sigaction(SIGINT, &pythonAction, nullptr);
}

void InterruptionWatch::check() const {
  if (interruptions != before_) throw CtrlC();
}

void InterruptionWatch::raise() {
  // On the main thread this runs Python's handler, which raises. Other threads end in the same
  // manner.
  if (PyErr_CheckSignals() == 0) PyErr_SetNone(PyExc_KeyboardInterrupt);
  throw pybind11::error_already_set();
}

// ------------------------------------------------------------------------------------------------
// Keyword arguments become command line words for the program's own parser. Every option therefore
// works in Python with the same checks and messages. Numbers are converted to text, which is exact,
// because str() of a float reads back as the same double.

namespace {

/// NumPy arrays are not lists here; the option refuses their text.
bool isList(const py::handle& value) {
  return py::isinstance<py::list>(value) || py::isinstance<py::tuple>(value);
}

/// Python's own text, for a float the shortest text that reads back as the same number.
std::string textOf(const py::handle& value) {
  return py::str(value);
}

bool holdsNumbers(const py::handle& list) {
  const auto entries = py::reinterpret_borrow<py::sequence>(list);
  return std::all_of(entries.begin(), entries.end(), [](const auto& entry) {
    return !isList(entry) && !py::isinstance<py::str>(entry);
  });
}

/// "3,0,7". Without spaces, as on the command line.
std::string joinedText(const py::handle& list) {
  std::string text;
  for (const auto& entry : py::reinterpret_borrow<py::sequence>(list)) {
    if (!text.empty()) text += ',';
    text += textOf(entry);
  }
  return text;
}

/// Name and value are one word, joined by "=", because a value may begin with a hyphen.
void appendWords(const std::string& name, const py::handle& value,
                 std::vector<std::string>& words) {
  if (value.is_none()) return;
  // True and False before numbers, since bool is a subclass of int in Python.
  if (py::isinstance<py::bool_>(value)) {
    if (value.cast<bool>()) words.push_back(name);
  } else if (!isList(value)) {
    words.push_back(fmt::format("{}={}", name, textOf(value)));
  } else if (holdsNumbers(value)) {
    words.push_back(fmt::format("{}={}", name, joinedText(value)));
  } else {
    for (const auto& entry : py::reinterpret_borrow<py::sequence>(value)) {
      appendWords(name, entry, words);
    }
  }
}

}  // namespace

std::vector<std::string> optionWords(const py::kwargs& options,
                                     const std::vector<std::string>& notHere) {
  std::vector<std::string> words;
  for (const auto& [key, value] : options) {
    std::string name = textOf(key);
    if (std::ranges::find(notHere, name) != notHere.end()) {
      throw InputError(fmt::format("error: {} is not an option of this call; remove it", name));
    }
    std::replace(name.begin(), name.end(), '_', '-');
    appendWords("--" + name, value, words);
  }
  return words;
}

void warn(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) {
    if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
  }
}

// ------------------------------------------------------------------------------------------------
// A Python Model is a LoadedModel with its reading options, so deploy() has the same data as
// `kirireel record`. Tiles, targets and joints are copied to arrays on access. A model does not
// change.

namespace {

/// points x 3, C order.
py::array_t<double> pointArray(const std::vector<Vector3>& points) {
  py::array_t<double> array({points.size(), std::size_t{3}});
  auto entries = array.mutable_unchecked<2>();
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int k = 0; k < 3; ++k) entries(static_cast<py::ssize_t>(i), k) = points[i][k];
  }
  return array;
}

/// One array per tile, since tiles have different numbers of corners.
py::list tileList(const std::vector<model::Tile>& tiles) {
  py::list list;
  for (const model::Tile& tile : tiles) list.append(pointArray(tile.vertices));
  return list;
}

/// The columns of constraints.txt, zero-based.
py::array_t<int> jointArray(const model::Model& model) {
  py::array_t<int> array({model.joints.size(), std::size_t{5}});
  auto entries = array.mutable_unchecked<2>();
  py::ssize_t row = 0;
  for (const model::Joint& joint : model.joints) {
    const int columns[] = {joint.a.tile, joint.a.vertex, joint.b.tile, joint.b.vertex,
                           static_cast<int>(joint.face)};
    for (int k = 0; k < 5; ++k) entries(row, k) = columns[k];
    ++row;
  }
  return array;
}

/// Options are those of `record` for reading files. Warnings are issued when the interpreter lock
/// is held again.
cli::LoadedModel read(const std::filesystem::path& path, const py::kwargs& options) {
  const std::vector<std::string> words = optionWords(options, {});
  cli::LoadedModel loaded = withoutInterpreter([&] { return cli::loadModel(path, words); });
  warn(loaded.warnings);
  return loaded;
}

/// The words of `kirireel generate FAMILY FOLDER`. The folder is unused, but the command line
/// requires one.
cli::LoadedModel generate(std::string family, const py::kwargs& parameters) {
  std::replace(family.begin(), family.end(), '_', '-');
  std::vector<std::string> words = {"generate", family, "nowhere"};
  for (const std::string& word : optionWords(parameters, {"help"})) words.push_back(word);
  cli::LoadedModel loaded;
  const auto order = std::get<cli::GenerateOrder>(cli::parseCommandLine(words));
  loaded.model = withoutInterpreter([&] { return cli::makeModel(order); });
  return loaded;
}

/// Text of a model in the interpreter.
std::string describeModel(const cli::LoadedModel& loaded) {
  return fmt::format("<kirireel.Model {}: {} tiles, {} joints{}>", loaded.model.name,
                     loaded.model.tiles.size(), loaded.model.joints.size(),
                     loaded.model.target ? ", a target" : "");
}

}  // namespace

void addModels(py::module_& module) {
  py::class_<cli::LoadedModel>(module, "Model", "A sheet of rigid tiles joined at their corners.")
      .def_property_readonly("name",
                             [](const cli::LoadedModel& loaded) { return loaded.model.name; })
      .def_property_readonly(
          "tiles", [](const cli::LoadedModel& loaded) { return tileList(loaded.model.tiles); },
          "The start: of each tile an array corners x 3, metres, anticlockwise.")
      .def_property_readonly(
          "target",
          [](const cli::LoadedModel& loaded) -> py::object {
            if (!loaded.model.target) return py::none();
            return tileList(*loaded.model.target);
          },
          "Requested positions of the corners, as tiles; None without a target.")
      .def_property_readonly(
          "joints", [](const cli::LoadedModel& loaded) { return jointArray(loaded.model); },
          "joints x 5: tile, vertex, tile, vertex, from 0; face 1 bottom, 2 top, 3 both.")
      .def(
          "write",
          [](const cli::LoadedModel& loaded, const std::filesystem::path& path) {
            withoutInterpreter([&] { formats::writeModel(loaded.model, path); });
          },
          "path"_a, "Writes the model, in the format of the path's ending: none for a folder.")
      .def("__repr__", &describeModel);
  module.def(
      "read", &read, "path"_a,
      "Reads a model: a folder, a .fold file, or any model that `kirireel record` takes.\n\n"
      "joints_file, frame, fold, join_coplanar, strict, cut, ignore, widest_neck and joint_at "
      "are its options. Repairs are reported as a UserWarning.");
  module.def("generate", &generate, "family"_a, cli::generateDoc(cli::describeProgram()).c_str());
}

// ------------------------------------------------------------------------------------------------
// A run keeps its samples in arrays that NumPy uses without a copy. The arrays keep the run alive
// and are read-only. Deploying, painting and saving release the interpreter lock.

namespace {

using Column = const std::vector<double>& (trajectory::SampleTable::*)() const;

/// A run in memory, deployed here or read from a file. `reader` reads its samples like those of a
/// file, so painting and saving need no other code.
struct MemoryRun {
  MemoryRun(const trajectory::Subject& subject, const trajectory::TrajectoryEnd& end,
            std::shared_ptr<const trajectory::SampleTable> table)
      : samples(std::move(table)), reader(subject, end, samples) {}
  virtual ~MemoryRun() = default;

  std::shared_ptr<const trajectory::SampleTable> samples;
  trajectory::TrajectoryReader reader;
  std::vector<double> velocities;  ///< see SampleTable; empty until requested
};

/// A run that was deployed here. It also keeps the order, which save() needs.
struct DeployedRun : MemoryRun {
  DeployedRun(cli::RecordResult prepared, run::DeploymentResult ended,
              std::shared_ptr<const trajectory::SampleTable> table)
      : MemoryRun(trajectory::subjectOf(prepared.scene), ended.trajectory, std::move(table)),
        order(std::move(prepared)),
        result(std::move(ended)) {
    order.summary = record::summaryOf(result, samples->times().back());
  }

  cli::RecordResult order;
  run::DeploymentResult result;
};

// ---- arrays

/// A view of numbers in memory that `owner`, NumPy's `base`, keeps alive.
template <typename T>
py::array view(const T* data, const std::vector<py::ssize_t>& shape,
               const std::vector<py::ssize_t>& strides, const py::object& owner) {
  py::array array(py::dtype::of<T>(), shape, strides, data, owner);
  array.attr("setflags")("write"_a = false);
  return array;
}

/// Array of samples x bricks x `shown` numbers, from the `stored` numbers of each brick, beginning
/// at `first`. Strides are in bytes.
py::array brickView(const std::vector<double>& data, const trajectory::SampleTable& samples,
                    int stored, int shown, int first, const py::object& owner) {
  const auto count = static_cast<py::ssize_t>(samples.size());
  const auto bricks = static_cast<py::ssize_t>(samples.brickCount());
  constexpr py::ssize_t kBytes = sizeof(double);
  return view(data.data() + first, {count, bricks, shown},
              {bricks * stored * kBytes, stored * kBytes, kBytes}, owner);
}

/// One number per sample.
py::array column(const py::object& self, Column entries) {
  const std::vector<double>& data = (*self.cast<const MemoryRun&>().samples.*entries)();
  return view(data.data(), {static_cast<py::ssize_t>(data.size())}, {sizeof(double)}, self);
}

/// A view of the run's memory; nothing is copied.
py::array position(const py::object& self) {
  const trajectory::SampleTable& samples = *self.cast<const MemoryRun&>().samples;
  return brickView(samples.positions(), samples, 3, 3, 0, self);
}

/// w, x, y, z, as SampleTable stores them.
py::array rotation(const py::object& self) {
  const trajectory::SampleTable& samples = *self.cast<const MemoryRun&>().samples;
  return brickView(samples.rotations(), samples, 4, 4, 0, self);
}

/// `first` is 0 for velocities (m/s), 3 for angular velocities (rad/s), of six numbers per brick.
py::array velocity(const py::object& self, int first) {
  auto& run = self.cast<MemoryRun&>();
  if (run.velocities.empty()) run.velocities = run.samples->velocities();
  return brickView(run.velocities, *run.samples, 6, 3, first, self);
}

/// Array of bricks x `width` of one sample.
template <typename Write>
py::array_t<double> poseArray(const trajectory::Sample& sample, std::size_t width, Write write) {
  py::array_t<double> array({sample.poses.size(), width});
  double* at = array.mutable_data();
  for (const Pose& pose : sample.poses) at = write(pose, at);
  return array;
}

/// A copy, because the sample for on_sample exists only during the call.
py::array_t<double> samplePositions(const trajectory::Sample& sample) {
  return poseArray(sample, 3, [](const Pose& pose, double* at) {
    return std::copy_n(pose.position.data(), 3, at);
  });
}

py::array_t<double> sampleRotations(const trajectory::Sample& sample) {
  return poseArray(sample, 4, [](const Pose& pose, double* at) {
    const Quaternion& turn = pose.rotation;
    return std::ranges::copy(std::array{turn.w(), turn.x(), turn.y(), turn.z()}, at).out;
  });
}

// ---- deploying

/// Passes each sample to Python, and stores its exception. The first exception of on_sample ends
/// the run and is thrown again afterwards.
class SampleReporter {
 public:
  explicit SampleReporter(py::object report) : callback_(std::move(report)) {}

  /// False ends the run. Call it without the interpreter lock.
  bool operator()(const trajectory::Sample& sample) {
    if (callback_.is_none()) return true;
    // The run does not hold the interpreter lock, so other Python threads continue. It holds the
    // lock only for the call.
    const py::gil_scoped_acquire acquire;
    if (thrown_) return false;
    try {
      // None, the result of a function without return, continues the run.
      return !callback_(sample).is(py::bool_(false));
    } catch (...) {
      thrown_ = std::current_exception();
      return false;
    }
  }

  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  py::object callback_;
  std::exception_ptr thrown_;
};

/// The whole run; nothing is written to disk.
std::shared_ptr<DeployedRun> deployModel(const cli::LoadedModel& loaded, const py::object& onSample,
                                         const py::kwargs& options) {
  const cli::RecordOrder order =
      cli::parseRunOptions(loaded, optionWords(options, cli::optionsNotForRuns()));
  std::vector<std::string> warnings;
  std::shared_ptr<DeployedRun> run;
  SampleReporter report(onSample);
  withoutInterpreter([&] {
    cli::RecordResult prepared = cli::prepareOrder(order, warnings);
    const auto samples = std::make_shared<trajectory::SampleTable>();
    const run::SampleObserver keep = [&](const trajectory::Sample& sample) {
      samples->append(sample);
      return report(sample);
    };
    // Collect warnings, because they may come from threads without the interpreter lock.
    const run::TrialObserver search = [&](const run::SearchNews& news) {
      if (!news.warning.empty()) {
        warnings.push_back(fmt::format("{}: warning: {}", loaded.model.name, news.warning));
      }
      return true;
    };
    run::DeploymentResult result =
        deploy::deployUnkept(prepared.scene, prepared.settings.sampleInterval(), keep, search);
    run = std::make_shared<DeployedRun>(std::move(prepared), std::move(result), samples);
  });
  report.rethrow();
  warn(warnings);
  return run;
}

// ---- methods of runs

/// The index of the sample nearest to a time, by default the last. Of two equally near samples, the
/// earlier one.
std::size_t nearestSample(const std::vector<double>& times, std::optional<double> time) {
  if (!time) return times.size() - 1;
  return trajectory::nearestIndex(times, *time);
}

/// Completed fraction of the camera's orbit at a time, as in a video at an even pace, [0, 1]. Only
/// an orbit needs the whole run.
double orbitBehind(const MemoryRun& run, const record::PictureSettings& settings, double time) {
  if (settings.appearance.camera.orbit == 0) return 0;
  return record::momentAt(record::motionOf(run.reader), record::Pace::Even, time).turn;
}

py::array render(const MemoryRun& run, std::optional<double> time, const py::kwargs& options) {
  std::vector<std::string> words = {"render", output::kTrajectory};
  for (const std::string& word :
       optionWords(options, cli::optionsNotForPictures(cli::describeProgram()))) {
    words.push_back(word);
  }
  const record::PictureSettings settings =
      std::get<cli::RenderOrder>(cli::parseCommandLine(words)).settings;
  auto frame = std::make_unique<picture::Frame>();
  withoutInterpreter([&] {
    if (settings.graphics) picture::setGraphicsLibrary(*settings.graphics);
    const trajectory::Sample sample = run.reader.sample(nearestSample(run.reader.times(), time));
    // As in frames: if colours show values, a bar below the picture is their scale.
    picture::StatePainter painter(settings.size, settings.appearance,
                                  record::contentOf(run.reader, settings), {.colours = true});
    *frame = painter.paint(
        {sample.time, sample.poses, sample.pinned, orbitBehind(run, settings, sample.time)});
  });
  const py::ssize_t width = frame->size.width;
  const py::ssize_t height = frame->size.height;
  const std::uint8_t* pixels = frame->pixels.data();
  // The array takes ownership of the frame's pixels. The capsule deletes the frame with the array.
  const py::capsule owner(frame.release(),
                          [](void* kept) { delete static_cast<picture::Frame*>(kept); });
  return py::array(py::dtype::of<std::uint8_t>(), {height, width, py::ssize_t{4}},
                   {4 * width, py::ssize_t{4}, py::ssize_t{1}}, pixels, owner);
}

/// Writes the files of `kirireel record` from the existing samples. An interruption leaves the
/// folder unchanged.
std::vector<std::string> save(const DeployedRun& run, const std::filesystem::path& folder) {
  if (folder.empty()) throw InputError("error: the folder's name is empty; give one");
  return withoutInterpreter([&] {
    record::RecordSettings settings = run.order.settings;
    settings.folder = folder;
    // Replaces the deployment: passes the samples to record()'s observer and returns the known
    // result.
    const record::Deployer again = [&run](const scene::Scene&, double,
                                          const run::SampleObserver& observer,
                                          const run::TrialObserver&, run::Checkpoints*) {
      for (std::size_t i = 0; i < run.samples->size(); ++i) observer(run.samples->sample(i));
      return run.result;
    };
    const record::ProgressObserver progress = [](const record::Progress&) -> record::Interruption {
      return std::nullopt;
    };
    return record::record(run.order.scene, settings, progress, again).files;
  });
}

/// A dict as from json.loads.
py::object summary(const DeployedRun& run) {
  const cli::RecordResult& order = run.order;
  return py::module_::import("json").attr("loads")(
      record::summaryJson(order.scene, order.settings, order.summary));
}

/// Reads all samples into memory, so the file may be deleted afterwards.
std::shared_ptr<MemoryRun> openTrajectory(const std::filesystem::path& path) {
  return withoutInterpreter([&] {
    const trajectory::TrajectoryReader file(output::trajectoryOf(path));
    return std::make_shared<MemoryRun>(
        file.subject(), file.end(),
        std::make_shared<trajectory::SampleTable>(trajectory::readSamples(file)));
  });
}

std::vector<std::pair<double, std::string>> events(const MemoryRun& run) {
  std::vector<std::pair<double, std::string>> list;
  for (const trajectory::Event& event : run.reader.end().events)
    list.emplace_back(event.time, event.text);
  return list;
}

std::string describe(const MemoryRun& run) {
  return fmt::format("<kirireel trajectory of {}: {} samples, {} tiles, {:g} s>",
                     run.reader.subject().model.name, run.samples->size(),
                     run.samples->brickCount(), run.samples->times().back());
}

// ---- the module

/// Measures are attributes, poses are arrays made on access.
void addSample(py::module_& module) {
  py::class_<trajectory::Sample>(module, "Sample", "The state at one time, with its measures.")
      .def_readonly("time", &trajectory::Sample::time, "simulated seconds")
      .def_readonly("joint_gap", &trajectory::Sample::jointGap, "largest gap of any joint, metres")
      .def_readonly("target_error", &trajectory::Sample::targetError,
                    "largest distance of a corner from its target, metres; 0 without a target")
      .def_readonly("penetration", &trajectory::Sample::penetration, "deepest, metres")
      .def_property_readonly("position", &samplePositions,
                             "tiles x 3, metres, of the centres of mass (a copy)")
      .def_property_readonly("rotation", &sampleRotations,
                             "tiles x 4, unit quaternions w x y z, brick axes to world (a copy)");
}

void addCurves(py::class_<MemoryRun, std::shared_ptr<MemoryRun>>& trajectory) {
  const auto add = [&trajectory](const char* name, Column entries, const char* doc) {
    trajectory.def_property_readonly(
        name, [entries](const py::object& self) { return column(self, entries); }, doc);
  };
  add("time", &trajectory::SampleTable::times, "samples; simulated seconds");
  add("joint_gap", &trajectory::SampleTable::jointGaps,
      "samples; largest gap of any joint, metres");
  add("target_error", &trajectory::SampleTable::targetErrors,
      "samples; largest distance of a corner from its target, metres; 0 without a target");
  add("penetration", &trajectory::SampleTable::penetrations,
      "samples; deepest overlap of two bricks, metres");
}

/// Docstrings have shapes and units.
void addTrajectory(py::module_& module) {
  py::class_<MemoryRun, std::shared_ptr<MemoryRun>> trajectory(
      module, "Trajectory",
      "The states of a run by time. Arrays are views of its memory without a copy, and read-only.");
  addCurves(trajectory);
  trajectory
      .def_property_readonly("position", &position,
                             "samples x tiles x 3, metres, of the centres of mass")
      .def_property_readonly("rotation", &rotation,
                             "samples x tiles x 4, unit quaternions w x y z, brick axes to world")
      .def_property_readonly(
          "velocity", [](const py::object& self) { return velocity(self, 0); },
          "samples x tiles x 3, m/s, of the centres of mass: central differences of the samples")
      .def_property_readonly(
          "angular_velocity", [](const py::object& self) { return velocity(self, 3); },
          "samples x tiles x 3, rad/s, world axes: central differences of the samples")
      .def_property_readonly("events", &events, "What happened: simulated seconds and one line.")
      .def_property_readonly(
          "model",
          [](const MemoryRun& run) {
            return cli::LoadedModel{run.reader.subject().model, {}, {}, {}, {}};
          },
          "The model as it was deployed, with its target moved onto the start.")
      .def("render", &render, "time"_a = py::none(), cli::renderDoc(cli::describeProgram()).c_str())
      .def("__repr__", &describe);
}

/// Data of deployments only: the outcome, and saving.
void addRun(py::module_& module) {
  py::class_<DeployedRun, MemoryRun, std::shared_ptr<DeployedRun>>(module, "Run",
                                                                   "A deployment made by deploy().")
      .def_property_readonly(
          "outcome", [](const DeployedRun& run) { return run::toString(run.result.outcome); },
          "settled, locked, out_of_time, diverged or interrupted")
      .def_property_readonly(
          "reason", [](const DeployedRun& run) { return run.result.reason; }, "one line: why")
      .def_property_readonly(
          "shortfall", [](const DeployedRun& run) { return run.result.shortfall; },
          "why the run missed its goal; empty if it did not")
      .def_property_readonly(
          "at_target", [](const DeployedRun& run) { return run.result.atTarget; },
          "whether it ended at its target; None without a drive to a target")
      .def_property_readonly("summary", &summary,
                             "The summary as in summary.json, without written files.")
      .def("save", &save, "folder"_a,
           "Writes the files of `kirireel record`, with the same bytes (except cost and hash in "
           "summary.json). Returns their names.");
}

}  // namespace

void addRuns(py::module_& module) {
  addSample(module);
  addTrajectory(module);
  addRun(module);
  module.def("deploy", &deployModel, "model"_a, "on_sample"_a = py::none(),
             cli::deployDoc(cli::describeProgram()).c_str());
  module.def("open", &openTrajectory, "path"_a,
             "Reads a trajectory.h5, or the one in a folder. Returns a Trajectory.");
}

}  // namespace kirireel::python
