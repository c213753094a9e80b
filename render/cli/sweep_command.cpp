// A sweep does many runs in worker processes. The fingerprint of each run names its folder. Steps:
//
// - 1. Check all keys and values one by one (sweep_command.h).
// - 2. Workers take runs in turn. They skip a run whose folder exists or which another process has
//   claimed. So the same command may run on several machines with one folder, and continues after
//   an interruption.
// - 3. A failed run stores its reason instead of its files. A worker that crashes, hangs or uses
//   too much memory loses only its own run (worker_pool.h).
// - 4. Collect all results: NAME.csv, NAME.h5, NAME_costs.csv and a contact sheet NAME.png, moved
//   into place together.
//
// Shard I/N does the runs I, I + N, I + 2N, ... (from 1). Neighbours in the plan take about equally
// long, so interleaving balances the work better than blocks.
#include "render/cli/sweep_command.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <set>
#include <thread>

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "render/cli/model_commands.h"
#include "render/cli/option_group.h"
#include "render/cli/report.h"
#include "render/cli/scene_options.h"
#include "render/output/output_folder.h"
#include "render/picture/png.h"
#include "render/sweep/collect.h"
#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/files.h"

namespace kirireel::cli {
namespace {

namespace fs = std::filesystem;

/// A larger number of runs is probably a mistake.
constexpr std::uint64_t kMaxUnconfirmed = 1'000'000;
// A megabyte is 10^6 bytes here, as in the page's limit.
constexpr double kBytesInMegabyte = 1e6;
// In each run's folder: its printed text, mainly warnings.
constexpr const char* kMessages = "messages.txt";

/// Compression level of the contact sheet: half the time of zlib's default for a third more bytes.
constexpr int kSheetCompression = 3;

/// hardware_concurrency() is 0 if it is unknown.
int coreCount() {
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

/// An equal share of the machine's memory, unless a limit was given.
sweep::WorkerLimits withMemoryLimit(sweep::WorkerLimits limits) {
  if (limits.memoryBytes > 0) return limits;
  limits.memoryBytes =
      static_cast<std::int64_t>(::sysconf(_SC_PHYS_PAGES)) * ::sysconf(_SC_PAGESIZE) / limits.count;
  return limits;
}

/// Reads "3/8", both numbers >= 1. The message for any other text shows the form.
SweepShard parseShard(const scene::TypedValue& value) {
  const std::string requested = "I/N, as in 3/8: part I of N, counted from 1";
  const std::size_t slash = value.text.find('/');
  if (slash == std::string::npos) throw scene::valueError(value, requested);
  const auto number = [&](const std::string& text) {
    try {
      return scene::parseInteger({value.name, text}, {1, 1e9});
    } catch (const InputError&) {
      throw scene::valueError(value, requested);
    }
  };
  const long part = number(value.text.substr(0, slash));
  const long count = number(value.text.substr(slash + 1));
  if (part > count)
    throw scene::valueError(value, fmt::format("a part from 1/{0} to {0}/{0}", count));
  return {static_cast<std::uint64_t>(part), static_cast<std::uint64_t>(count)};
}

void addWorkerOptions(CLI::App& command, sweep::WorkerLimits& limits) {
  OptionGroup group(command, "Workers");
  limits.count = coreCount();
  group.value("--jobs", "COUNT", "one for each core", "processes at the same time",
              [&limits](const scene::TypedValue& typed) {
                limits.count = static_cast<int>(scene::parseInteger(typed, {1, 4096}));
              });
  group.number("--run-limit", limits.seconds, {1e-3, 1e9}, "SECONDS",
               "time limit of a run; a longer run fails");
  group.value("--memory-limit", "MEGABYTES", "the machine's memory over --jobs",
              "memory limit of each process; a run that needs more fails",
              [&limits](const scene::TypedValue& typed) {
                limits.memoryBytes = static_cast<std::int64_t>(
                    kBytesInMegabyte * scene::parseNumber(typed, {16, 1e9}));
              });
}

/// 0.1 s per run, as for a small sheet.
void requireConfirmation(const SweepRuns& runs, bool confirmed) {
  const std::uint64_t count = runs.sweep().plan.size();
  if (count <= kMaxUnconfirmed || confirmed) return;
  throw InputError(
      fmt::format("{}: error: these are {:.3g} runs, about {:.4g} days of one core at 0.1 s each; "
                  "use fewer values, or add --yes",
                  runs.sweep().file.string(), static_cast<double>(count),
                  static_cast<double>(count) * 0.1 / 86400));
}

/// The number of runs of a shard; there may be more shards than runs.
std::uint64_t runsOf(const SweepShard& shard, std::uint64_t runs) {
  return runs < shard.number ? 0 : (runs - shard.number) / shard.count + 1;
}

/// Redirects the text that a run prints into its folder.
void redirectPrints(const fs::path& file) {
  std::fflush(nullptr);
  // After fork, the worker has its own standard output and error. They stay if the file cannot be
  // opened.
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (opened < 0) return;
  ::dup2(opened, STDOUT_FILENO);
  ::dup2(opened, STDERR_FILENO);
  ::close(opened);
}

/// Removes empty files: most runs print nothing.
void dropEmptyMessages(const fs::path& folder) {
  std::fflush(nullptr);
  std::error_code ignored;
  if (fs::file_size(folder / kMessages, ignored) == 0) fs::remove(folder / kMessages, ignored);
}

/// Removes the sweep's folder from a reason, which must not depend on its place.
std::string withoutFolder(std::string text, const fs::path& folder) {
  const std::string part = folder.string() + "/";
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part)) {
    text.erase(at, part.size());
  }
  return text;
}

/// The runs of a sweep in their folder. `runs` and `order` must outlive it.
class SweepFolder {
 public:
  SweepFolder(const SweepRuns& runs, const fs::path& folder, const SweepOrder& order)
      : runs_(runs), folder_(folder / "runs"), order_(order) {
    makeFolder(folder_);
    requireWritableFolder(folder_);
  }

  /// Does a run that is neither done nor claimed by another process. Called in a worker.
  sweep::Verdict make(std::uint64_t index) const {
    std::optional<sweep::RunClaim> claim = take(index);
    if (!claim) return sweep::Verdict::Skipped;
    redirectPrints(claim->folder() / kMessages);
    // An empty reason means success.
    sweep::RunRecord record{false, "", runs_.inputs(index)};
    try {
      runs_.make(index, claim->folder());
    } catch (const std::bad_alloc&) {
      record.reason = "ran out of memory";
    } catch (const std::exception& error) {
      record.reason = withoutFolder(error.what(), claim->folder());
    }
    dropEmptyMessages(claim->folder());
    return finish(*claim, record);
  }

  /// Stores the reason why a run did not end.
  sweep::Verdict lose(std::uint64_t index, const std::string& reason) const {
    std::optional<sweep::RunClaim> claim = take(index);
    if (!claim) return sweep::Verdict::Skipped;
    claim->finish({true, reason, runs_.inputs(index)});
    return sweep::Verdict::Failed;
  }

 private:
  /// Stores the reason; on a full disk instead of the run.
  static sweep::Verdict finish(sweep::RunClaim& claim, sweep::RunRecord& record) {
    record.failed = !record.reason.empty();
    try {
      claim.finish(record);
    } catch (const OutputError& error) {
      // The files of the run fill the disk. Without them a record of one line fits.
      claim.clear();
      record.failed = true;
      record.reason = withoutFolder(error.what(), claim.folder());
      claim.finish(record);
    }
    return record.failed ? sweep::Verdict::Failed : sweep::Verdict::Done;
  }

  std::optional<sweep::RunClaim> take(std::uint64_t index) const {
    return sweep::RunClaim::take(folder_, runs_.name(index), order_.retryFailed);
  }

  const SweepRuns& runs_;
  fs::path folder_;
  const SweepOrder& order_;
};

/// Seconds up to 2 minutes, minutes up to 2 hours.
std::string timeText(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

/// Counts results and reports the progress of the sweep. The estimate of the time left is (seconds
/// so far) x (runs to come) / (runs made).
class Tally {
 public:
  explicit Tally(std::uint64_t total) : total_(total), start_(Clock::now()) {}

  void add(sweep::Verdict verdict) {
    ++(verdict == sweep::Verdict::Done     ? done_
       : verdict == sweep::Verdict::Failed ? failed_
                                           : skipped_);
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    const std::uint64_t seen = done_ + failed_ + skipped_;
    // Skipped runs take no time. The rate counts only runs that were made.
    const double left = seconds * static_cast<double>(total_ - seen) /
                        static_cast<double>(std::max<std::uint64_t>(1, done_ + failed_));
    line_.show(
        fmt::format("run {} of {}, {} failed, {} left", seen, total_, failed_, timeText(left)));
  }

  std::uint64_t failed() const { return failed_; }
  std::string text() const {
    return fmt::format("{} runs done, {} of them failed; {} done before, or running elsewhere",
                       done_ + failed_, failed_, skipped_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::uint64_t total_;
  Clock::time_point start_;
  std::uint64_t done_ = 0;
  std::uint64_t failed_ = 0;
  std::uint64_t skipped_ = 0;
  ProgressLine line_;
};

/// Results of a sweep.
struct MadeRuns {
  bool isWhole = false;  ///< false if a signal ended it
  std::uint64_t failed = 0;
};

/// Does the missing runs of a shard.
MadeRuns makeRuns(const SweepRuns& runs, const fs::path& folder, const SweepOrder& order) {
  noteSignals();
  const SweepFolder runFolder(runs, folder, order);
  const std::uint64_t total = runs.sweep().plan.size();
  Tally tally(runsOf(order.shard, total));
  std::uint64_t next = order.shard.number - 1;
  // The parent selects the next run; its children do the work.
  const sweep::WorkerJobs jobs = {
      [&]() -> std::optional<std::uint64_t> {
        if (next >= total) return std::nullopt;
        return std::exchange(next, next + order.shard.count);
      },
      [&](std::uint64_t index) { return runFolder.make(index); },
      [&](std::uint64_t index, const std::string& why) { return runFolder.lose(index, why); },
      [&](std::optional<sweep::Verdict> verdict) {
        if (verdict) tally.add(*verdict);
        return !takeInterrupt();
      }};
  const bool isWhole = sweep::runInWorkers(jobs, withMemoryLimit(order.limits));
  fmt::print("{}{}\n", isWhole ? "" : "interrupted; the same command continues: ", tally.text());
  return {isWhole, tally.failed()};
}

/// Reads the end states of the displayed runs.
void writeContactSheet(const sweep::Gathered& gathered, const std::vector<std::string>& keys,
                       const fs::path& folder, const fs::path& file) {
  // Nothing to show.
  if (gathered.runs.size() == gathered.failed) return;
  std::vector<sweep::ContactPicture> pictures;
  for (const sweep::SweepRow& run : gathered.runs) {
    const fs::path vertices = folder / "runs" / run.name / output::kFinalVertices;
    pictures.push_back({run.failed ? fs::path() : vertices, run.thickness, run.values});
  }
  picture::writePng(sweep::composeContactSheet(keys, pictures), file,
                    {.compressionLevel = kSheetCompression});
}

/// Writes the table, the costs and the contact sheet into the folder of the runs.
sweep::Gathered collect(const SweepRuns& runs, const fs::path& folder) {
  const auto values = [&runs](std::uint64_t index) {
    std::vector<std::string> texts;
    for (const sweep::SweepValue& value : runs.sweep().plan.run(index)) texts.push_back(value.text);
    return texts;
  };
  makeFolder(folder);
  // Two sweeps that end at the same time collect one after the other.
  const auto lock = sweep::FileLock::take(folder / "collect.lock", sweep::FileLock::IfHeld::Wait);
  const sweep::Gathered gathered =
      sweep::gather({folder / "runs", runs.sweep().plan.size(), runs.sweep().plan.keys(),
                     [&runs](std::uint64_t index) { return runs.name(index); }, values});
  const std::string name = runs.sweep().file.stem().string();
  std::vector<std::string> names = {name + ".csv", name + ".h5", name + "_costs.csv"};
  if (gathered.runs.size() > gathered.failed) names.push_back(name + ".png");
  // All files appear together, or none.
  output::FileSet files(folder, output::kContents);
  files.requireFree(names);
  const std::string stem = (files.stage() / name).string();
  writeTextFile(stem + ".csv", sweep::csvText(gathered.results));
  sweep::writeTableArrays(gathered.results, stem + ".h5");
  writeTextFile(stem + "_costs.csv", sweep::csvText(gathered.costs));
  writeContactSheet(gathered, runs.sweep().plan.keys(), folder, stem + ".png");
  files.commit(names);
  fmt::print("{0}.csv, {0}.h5, {0}.png: {1} runs done, {2} failed, {3} missing\n",
             (folder / name).string(), gathered.runs.size() - gathered.failed, gathered.failed,
             gathered.missing);
  return gathered;
}

}  // namespace

CLI::App* addSweepCommand(CLI::App& program, SweepOrder& order) {
  CLI::App* command =
      program.add_subcommand("sweep", "do many runs over parameters and write one table");
  addPlace(*command, "SWEEP", order.sweep, "a file like sweep.toml, see docs/sweeps.md");
  OptionGroup group(*command, "Output");
  group.value("--out", "FOLDER", "out/NAME of the sweep file", "folder for the runs and the table",
              [&order](const scene::TypedValue& typed) { order.folder = typed.text; });
  group.flag("--collect", "do no runs, only collect the results so far",
             [&order] { order.collectOnly = true; });
  OptionGroup which(*command, "Runs");
  which.value("--shard", "I/N", "1/1", "only part I of N, without collecting",
              [&order](const scene::TypedValue& typed) { order.shard = parseShard(typed); });
  which.flag("--retry-failed", "repeat failed runs", [&order] { order.retryFailed = true; });
  which.flag("--yes", "allow more than a million runs", [&order] { order.confirmed = true; });
  addWorkerOptions(*command, order.limits);
  command->footer(
      "Examples:\n"
      "  kirireel sweep sweep.toml\n"
      "  kirireel sweep sweep.toml --shard 3/8 && kirireel sweep sweep.toml --collect\n"
      "\n"
      "Finished runs are not repeated. Ctrl-C loses only the runs in progress.");
  return command;
}

void completeOrder(const CLI::App& command, SweepOrder& order) {
  requireGiven(order.sweep, "SWEEP", command);
}

int carryOut(const SweepOrder& order) {
  const SweepRuns runs(sweep::readSweepFile(order.sweep));
  requireConfirmation(runs, order.confirmed);
  const fs::path folder =
      order.folder.empty() ? fs::path("out") / order.sweep.stem() : order.folder;
  if (order.collectOnly) {
    const sweep::Gathered gathered = collect(runs, folder);
    return gathered.failed + gathered.missing == 0 ? kExitDone : kExitFailed;
  }
  const MadeRuns made = makeRuns(runs, folder, order);
  if (!made.isWhole) return kExitInterrupted;
  // Other shards may still run. Without shards, another process works on the missing runs.
  const std::uint64_t failed = order.shard.count > 1 ? made.failed : collect(runs, folder).failed;
  return failed == 0 ? kExitDone : kExitFailed;
}

// ------------------------------------------------------------------------------------------------
// A run of a sweep equals `kirireel simulate` (or `record`) with the same words. Its settings are
// applied to the options of a command in memory. The fingerprint is that of the completed order. A
// run that is in two sweeps has the same name in both and is done once.
//
// Names are the first 20 hexadecimal digits, 80 bits. The probability that two of n runs collide is
// about n^2 / 2^81, which is 4e-13 for a million runs.
//
// Naming a run costs as much as building and completing a command. Files that runs share are read
// and hashed once (inputs_).

namespace {

constexpr std::size_t kNameDigits = 20;

/// Options that the sweep sets: the folder and the reports of a run.
const std::set<std::string> kNotForSweeps = {"out", "json", "page"};

/// The keys of a run's options. "model" and "scene" are keys of sweeps only.
std::vector<std::string> runKeys(CLI::App& command) {
  std::vector<std::string> keys = {"model", "scene"};
  for (CLI::Option* option : command.get_options()) {
    const std::string key = settingKey(*option);
    if (!settingTable(*option).empty() && !kNotForSweeps.contains(key)) keys.push_back(key);
  }
  return keys;
}

/// The parameters of a family, which are in their own group of the help.
std::vector<std::string> familyKeys(const CLI::App& command) {
  std::vector<std::string> keys;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group() == kShapeGroup) keys.push_back(settingKey(*option));
  }
  return keys;
}

/// The option of a key, which must exist.
CLI::Option& optionOf(CLI::App& command, const std::string& key) {
  for (CLI::Option* option : command.get_options()) {
    if (settingKey(*option) == key) return *option;
  }
  throw std::logic_error("a key without an option: " + key);
}

/// One run as orders of `generate` and `simulate`. Not copyable or movable, because options point
/// into these orders.
class RunOrders {
 public:
  explicit RunOrders(const sweep::Sweep& sweep) : family_(sweep.family) {
    const bool paints =
        sweep.keep == sweep::SweepKeep::Pictures || sweep.keep == sweep::SweepKeep::All;
    run_ = paints ? addRecordCommand(program_, record_) : addSimulateCommand(program_, record_);
    record_.settings.painterCount = 1;  // other cores have runs of their own
    record_.settings.trajectory = sweep.keep != sweep::SweepKeep::State;
    if (sweep.keep == sweep::SweepKeep::Pictures)
      record_.settings.video = record_.settings.meshes = false;
    if (family_.empty()) return;
    generate_.family = family_;
    shape_ = addFamily(program_, generate::familyNamed(family_), generate_);
  }
  RunOrders(const RunOrders&) = delete;
  RunOrders& operator=(const RunOrders&) = delete;

  void apply(const sweep::SweepSetting& setting) {
    const auto& [key, value] = setting;
    // A parameter of the family precedes an option of the same name: a family may have its own
    // `thickness`.
    if (shape_ && has(familyKeys(*shape_), key)) {
      applyTo(*shape_, setting);
    } else if (key == "model") {
      requireNoFamily(value);
      record_.model = value.text;
    } else if (key == "scene") {
      record_.request.file = value.text;
    } else if (has(runKeys(*run_), key)) {
      applyTo(*run_, setting);
    } else {
      throw inputErrorAt(value.where, fmt::format("there is no parameter {}{}; {}", shown(key),
                                                  suggestion(key, allKeys()), helpReference()));
    }
  }

  /// The fingerprint of this run, valid or not. `known` is the sweep's cache of input files.
  std::string fingerprint(std::map<std::string, OrderInputs>& known) {
    try {
      complete();
    } catch (const InputError& error) {
      // The message replaces the scene, so the run is repeated if its message changes.
      record_.text = {
          {}, fmt::format("{}\n{}", orderText(*run_, record_.scene, {}).terms, error.what())};
    }
    record_.text.terms += ownTerms();
    return fingerprintOf(record_, inputs(known));
  }

  /// Does the run in a folder.
  void carryOut(const fs::path& folder) {
    record_.settings.folder = folder;
    if (shape_) record_.madeModel = makeModel(generate_);
    complete();
    runOrder(record_, [](const record::Progress& progress) {
      if (!progress.remark.empty()) printWarnings({progress.remark});
      return record::Interruption();
    });
  }

 private:
  void complete() {
    // Before the run, only the presence of a model matters.
    if (shape_ && !record_.madeModel) record_.madeModel = model::Model{family_};
    // A generated model has no folder for a scene file.
    if (!shape_ || !record_.request.file.empty()) {
      completeOrder(*run_, record_);
    } else {
      record_.text = orderText(*run_, record_.scene, {});
    }
  }

  /// Terms that only a sweep sets: a family's parameters, and the files of each run.
  std::string ownTerms() const {
    return fmt::format("{}\ntrajectory = {}\n", shape_ ? parametersText(*shape_) : "",
                       record_.settings.trajectory);
  }

  /// The input files of the run, which many runs share.
  OrderInputs inputs(std::map<std::string, OrderInputs>& known) const {
    const std::vector<fs::path>& targets = record_.request.parts.targets;
    if (shape_ && targets.empty() && record_.request.file.empty()) return {family_, {}};
    // Whether a target fits depends on the family's parameters.
    std::string names = fmt::format("{}\n{}\n{}", record_.model.string(),
                                    record_.request.file.string(), shape_ ? ownTerms() : "");
    // The key of the cache: everything that selects the input files.
    for (const fs::path& target : targets) names += '\n' + target.string();
    const auto [found, isNew] = known.try_emplace(names);
    if (!isNew) return found->second;
    RecordOrder order = record_;
    try {
      if (shape_) order.madeModel = makeModel(generate_);
    } catch (const InputError&) {
      order.madeModel = model::Model{family_};  // the run reports the fault
    }
    return found->second = readInputs(order);
  }

  void requireNoFamily(const sweep::SweepValue& value) const {
    if (family_.empty()) return;
    throw inputErrorAt(value.where, "use only one of model and generate; remove the other");
  }

  /// For suggestions: the options of a run and the family's parameters.
  std::vector<std::string> allKeys() const {
    std::vector<std::string> keys = runKeys(*run_);
    if (!shape_) return keys;
    for (const std::string& key : familyKeys(*shape_)) keys.push_back(key);
    return keys;
  }

  std::string helpReference() const {
    const std::string run = fmt::format("see kirireel {} --help", run_->get_name());
    return family_.empty() ? run : fmt::format("{} and kirireel generate {} --help", run, family_);
  }

  static void applyTo(CLI::App& command, const sweep::SweepSetting& setting) {
    const auto& [key, value] = setting;
    applySetting(optionOf(command, key), {"", key, {value.text}, value.isSwitch, value.where});
  }

  std::string family_;
  RecordOrder record_;
  GenerateOrder generate_;
  CLI::App program_;
  CLI::App* run_ = nullptr;
  CLI::App* shape_ = nullptr;
};

/// Throws for an unknown family, suggesting the nearest name.
void requireFamily(const sweep::Sweep& sweep) {
  std::vector<std::string> names;
  for (const generate::Family& family : generate::families()) names.push_back(family.name);
  if (sweep.family.empty() || has(names, sweep.family)) return;
  throw inputErrorAt(sweep.familyWhere,
                     fmt::format("there is no family {}{}; see kirireel generate --help",
                                 sweep.family, suggestion(sweep.family, names)));
}

/// Checks one value.
void requireValid(const sweep::Sweep& sweep, const sweep::SweepSetting& setting) {
  // Each value has its own order, so it cannot hide an error of another value.
  RunOrders(sweep).apply(setting);
  if (!sweep::isFileKey(setting.key) || isPresent(findModel(setting.value.text))) return;
  throw inputErrorAt(
      setting.value.where,
      fmt::format(
          "there is no file or folder {}; correct the name. It is relative to the sweep file",
          setting.value.text));
}

/// Checks each value separately. Errors of a combination are reported by its run.
void requireValid(const sweep::Sweep& sweep) {
  requireFamily(sweep);
  for (const sweep::SweepSetting& setting : sweep.settings) requireValid(sweep, setting);
  // A sweep may name its model in [base], at its top, or as a varied parameter.
  bool namesModel = !sweep.family.empty();
  for (const sweep::SweepAxis& axis : sweep.axes) {
    for (const sweep::SweepValue& value : axis.values) requireValid(sweep, {axis.key, value});
    namesModel = namesModel || axis.key == "model";
  }
  for (const sweep::SweepSetting& setting : sweep.settings) {
    namesModel = namesModel || setting.key == "model";
  }
  if (namesModel) return;
  throw inputErrorAt({sweep.file},
                     "there is nothing to run; add model = \"FOLDER\" or generate = \"FAMILY\"");
}

}  // namespace

SweepRuns::SweepRuns(sweep::Sweep sweep) : sweep_(std::move(sweep)) {
  requireValid(sweep_);
}

std::vector<sweep::SweepSetting> SweepRuns::settings(std::uint64_t index) const {
  std::vector<sweep::SweepSetting> settings = sweep_.settings;
  const std::vector<sweep::SweepValue> values = sweep_.plan.run(index);
  for (std::size_t k = 0; k < values.size(); ++k) {
    settings.push_back({sweep_.plan.keys()[k], values[k]});
  }
  std::sort(
      settings.begin(), settings.end(),
      [](const sweep::SweepSetting& a, const sweep::SweepSetting& b) { return a.key < b.key; });
  return settings;
}

RunInputs SweepRuns::inputs(std::uint64_t index) const {
  RunInputs inputs;
  if (!sweep_.family.empty()) inputs.emplace_back("generate", sweep_.family);
  for (const sweep::SweepSetting& setting : settings(index)) {
    inputs.emplace_back(setting.key, setting.value.text);
  }
  return inputs;
}

std::string SweepRuns::name(std::uint64_t index) const {
  RunOrders orders(sweep_);
  for (const sweep::SweepSetting& setting : settings(index)) orders.apply(setting);
  return orders.fingerprint(inputs_).substr(0, kNameDigits);
}

void SweepRuns::make(std::uint64_t index, const fs::path& folder) const {
  RunOrders orders(sweep_);
  for (const sweep::SweepSetting& setting : settings(index)) orders.apply(setting);
  orders.carryOut(folder);
}

}  // namespace kirireel::cli
