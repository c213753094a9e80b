// A run of a sweep is what `kirireel simulate` (or `record`) would make of the same words: its
// settings are applied to a command's options in memory, and the fingerprint is taken of the
// completed order. So a run that stands in two sweeps has the same name in both and is made once.
//
// Names are the first 20 hexadecimal digits, 80 bits. The chance that two of n runs collide is
// about n^2 / 2^81: 4e-13 for a million runs.
//
// To name a run costs as much as to build and complete a command, and no file is read twice: what
// runs have in common is hashed once (inputs_).
#include "render/cli/sweep_runs.h"

#include <algorithm>
#include <set>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/generate_command.h"
#include "render/cli/record_command.h"
#include "render/cli/scene_settings.h"
#include "sim/base/spelling.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNameDigits = 20;

/// Options that say where a run goes and how it reports, which is the sweep's to say.
const std::set<std::string> kNotForSweeps = {"out", "json", "page"};

/// The keys of a run's options. "model" and "scene" are the sweep's own words.
std::vector<std::string> runKeys(CLI::App& command) {
  std::vector<std::string> keys = {"model", "scene"};
  for (CLI::Option* option : command.get_options()) {
    const std::string key = settingKey(*option);
    if (!settingTable(*option).empty() && !kNotForSweeps.contains(key)) keys.push_back(key);
  }
  return keys;
}

/// Parameters of a family stand in its own group of the help.
std::vector<std::string> familyKeys(const CLI::App& command) {
  std::vector<std::string> keys;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group() == kShapeGroup) keys.push_back(settingKey(*option));
  }
  return keys;
}

/// Only for keys that were found among the options before.
CLI::Option& optionOf(CLI::App& command, const std::string& key) {
  for (CLI::Option* option : command.get_options()) {
    if (settingKey(*option) == key) return *option;
  }
  throw std::logic_error("a key without an option: " + key);
}

bool has(const std::vector<std::string>& keys, const std::string& key) {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

/// One run as the commands `generate` and `simulate` would be told it. Options point into the
/// orders beside them, so it can be neither copied nor moved.
class RunOrders {
 public:
  explicit RunOrders(const Sweep& sweep) : family_(sweep.family) {
    const bool paints = sweep.keep == SweepKeep::Pictures || sweep.keep == SweepKeep::All;
    run_ = paints ? addRecordCommand(program_, record_) : addSimulateCommand(program_, record_);
    record_.settings.painterCount = 1;  // other cores have runs of their own
    record_.settings.trajectory = sweep.keep != SweepKeep::State;
    if (sweep.keep == SweepKeep::Pictures) record_.settings.video = record_.settings.meshes = false;
    if (family_.empty()) return;
    generate_.family = family_;
    shape_ = addFamily(program_, familyNamed(family_), generate_);
  }
  RunOrders(const RunOrders&) = delete;
  RunOrders& operator=(const RunOrders&) = delete;

  void apply(const SweepSetting& setting) {
    const auto& [key, value] = setting;
    // A family's parameter comes before an option of the same name: of `thickness` a family may
    // mean its own.
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
                                                  suggestion(key, allKeys()), whereToLook()));
    }
  }

  /// What tells this run from others. A run that cannot be made has a fingerprint too. `known` is
  /// the sweep's cache of input files.
  std::string fingerprint(std::map<std::string, OrderInputs>& known) {
    try {
      complete();
    } catch (const InputError& error) {
      // The message takes the place of the scene: the run fails with it, and fails anew when it
      // changes.
      record_.text = {
          {}, fmt::format("{}\n{}", orderText(*run_, record_.scene, {}).terms, error.what())};
    }
    record_.text.terms += ownTerms();
    return fingerprintOf(record_, inputs(known));
  }

  /// Makes the run in a folder.
  void carryOut(const fs::path& folder) {
    record_.settings.folder = folder;
    if (shape_) record_.madeModel = makeModel(generate_);
    complete();
    runOrder(record_, [](const Progress& progress) {
      if (!progress.remark.empty()) fmt::print(stderr, "kirireel: {}\n", progress.remark);
      return Interruption();
    });
  }

 private:
  void complete() {
    // Only that there is one counts until the run is made.
    if (shape_ && !record_.madeModel) record_.madeModel = Model{family_};
    // A generated model has no folder where a scene file may stand.
    if (!shape_ || !record_.request.file.empty()) {
      completeOrder(*run_, record_);
    } else {
      record_.text = orderText(*run_, record_.scene, {});
    }
  }

  /// What the sweep alone says: a family's parameters, and what each run leaves.
  std::string ownTerms() const {
    return fmt::format("{}\ntrajectory = {}\n", shape_ ? parametersText(*shape_) : "",
                       record_.settings.trajectory);
  }

  /// The files that the run is made from, which many runs have in common.
  OrderInputs inputs(std::map<std::string, OrderInputs>& known) const {
    const std::vector<fs::path>& targets = record_.request.parts.targets;
    if (shape_ && targets.empty() && record_.request.file.empty()) return {family_, {}};
    // A family's parameters decide whether a target fits.
    std::string names = fmt::format("{}\n{}\n{}", record_.model.string(),
                                    record_.request.file.string(), shape_ ? ownTerms() : "");
    // The key of the cache: everything that decides which files are read.
    for (const fs::path& target : targets) names += '\n' + target.string();
    const auto [found, isNew] = known.try_emplace(names);
    if (!isNew) return found->second;
    RecordOrder order = record_;
    try {
      if (shape_) order.madeModel = makeModel(generate_);
    } catch (const InputError&) {
      order.madeModel = Model{family_};  // the run itself says what is wrong
    }
    return found->second = readInputs(order);
  }

  void requireNoFamily(const SweepValue& value) const {
    if (family_.empty()) return;
    throw inputErrorAt(value.where, "either model or generate will do; remove the other");
  }

  /// For suggestions: the options of a run and the family's parameters.
  std::vector<std::string> allKeys() const {
    std::vector<std::string> keys = runKeys(*run_);
    if (!shape_) return keys;
    for (const std::string& key : familyKeys(*shape_)) keys.push_back(key);
    return keys;
  }

  std::string whereToLook() const {
    const std::string run = fmt::format("see kirireel {} --help", run_->get_name());
    return family_.empty() ? run : fmt::format("{} and kirireel generate {} --help", run, family_);
  }

  static void applyTo(CLI::App& command, const SweepSetting& setting) {
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

/// A family that does not exist, with the nearest name that does.
void requireFamily(const Sweep& sweep) {
  std::vector<std::string> names;
  for (const Family& family : families()) names.push_back(family.name);
  if (sweep.family.empty() || has(names, sweep.family)) return;
  throw inputErrorAt(sweep.familyWhere,
                     fmt::format("there is no family {}{}; see kirireel generate --help",
                                 sweep.family, suggestion(sweep.family, names)));
}

/// Such values were made paths relative to the sweep file when it was read.
bool namesFile(const std::string& key) {
  return key == "model" || key == "target" || key == "scene";
}

/// Tries a value alone.
void requireValid(const Sweep& sweep, const SweepSetting& setting) {
  // An order of its own for each value, so that one value cannot hide a mistake of another.
  RunOrders(sweep).apply(setting);
  if (!namesFile(setting.key) || fs::exists(setting.value.text)) return;
  throw inputErrorAt(setting.value.where,
                     fmt::format("there is no file or folder {}; correct the name, which is "
                                 "relative to the sweep file",
                                 setting.value.text));
}

/// Each value is tried alone: what a run of them all would refuse is for that run to say.
void requireValid(const Sweep& sweep) {
  requireFamily(sweep);
  for (const SweepSetting& setting : sweep.settings) requireValid(sweep, setting);
  // A sweep may name its model in [base], at its top, or as a parameter that varies.
  bool namesModel = !sweep.family.empty();
  for (const SweepAxis& axis : sweep.axes) {
    for (const SweepValue& value : axis.values) requireValid(sweep, {axis.key, value});
    namesModel = namesModel || axis.key == "model";
  }
  for (const SweepSetting& setting : sweep.settings) {
    namesModel = namesModel || setting.key == "model";
  }
  if (namesModel) return;
  throw inputErrorAt({sweep.file},
                     "there is nothing to run; add model = \"FOLDER\" or generate = \"FAMILY\"");
}

}  // namespace

SweepRuns::SweepRuns(Sweep sweep) : sweep_(std::move(sweep)) {
  requireValid(sweep_);
}

std::vector<SweepSetting> SweepRuns::settings(std::uint64_t index) const {
  std::vector<SweepSetting> settings = sweep_.settings;
  const std::vector<SweepValue> values = sweep_.plan.run(index);
  for (std::size_t k = 0; k < values.size(); ++k) {
    settings.push_back({sweep_.plan.keys()[k], values[k]});
  }
  std::sort(settings.begin(), settings.end(),
            [](const SweepSetting& a, const SweepSetting& b) { return a.key < b.key; });
  return settings;
}

RunInputs SweepRuns::inputs(std::uint64_t index) const {
  RunInputs inputs;
  if (!sweep_.family.empty()) inputs.emplace_back("generate", sweep_.family);
  for (const SweepSetting& setting : settings(index)) {
    inputs.emplace_back(setting.key, setting.value.text);
  }
  return inputs;
}

std::string SweepRuns::name(std::uint64_t index) const {
  RunOrders orders(sweep_);
  for (const SweepSetting& setting : settings(index)) orders.apply(setting);
  return orders.fingerprint(inputs_).substr(0, kNameDigits);
}

void SweepRuns::make(std::uint64_t index, const fs::path& folder) const {
  RunOrders orders(sweep_);
  for (const SweepSetting& setting : settings(index)) orders.apply(setting);
  orders.carryOut(folder);
}

}  // namespace kirireel
