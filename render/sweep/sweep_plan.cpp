// Grid of axes with n_0, n_1, ... values: the digits of i in the mixed base (n_0, n_1, ...) are the
// indices of run i on the axes; the last axis is the lowest digit. So no list of runs is kept.
//
// Latin hypercube (M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21, 1979): n runs cut
// each range into n equal parts. Each axis has a random permutation p of 0 to n - 1. Run i has the
// value at the fraction
//
//     (p(i) + r) / n,    r uniform in [0, 1).
//
// Each part of each range has one run, so n runs have n values of every parameter. A grid of n runs
// in d parameters has only the d-th root of n.
//
// The C++ standard fixes the sequence of std::mt19937_64, but not the library's distributions and
// shuffles. These are written out here.
#include "render/sweep/sweep_plan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <random>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/file_kinds.h"
#include "sim/scene/toml_file.h"

namespace kirireel::sweep {
namespace {

void sortAndDropRepeats(std::vector<SweepValue>& values) {
  std::stable_sort(values.begin(), values.end(), comesBefore);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

using Row = std::vector<SweepValue>;

void sortAndDropRepeats(std::vector<Row>& rows) {
  const auto rowComesBefore = [](const Row& a, const Row& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), comesBefore);
  };
  std::stable_sort(rows.begin(), rows.end(), rowComesBefore);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
}

/// In [0, 1). Not std::uniform_real_distribution, which may differ between libraries.
double randomShare(std::mt19937_64& generator) {
  // The upper 53 of 64 bits: a double has 53.
  return static_cast<double>(generator() >> 11) * 0x1p-53;
}

/// The numbers 0 to count - 1, shuffled (Fisher, Yates); not std::shuffle, for the same reason.
std::vector<std::size_t> shuffledNumbers(std::size_t count, std::mt19937_64& generator) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  for (std::size_t left = count; left > 1; --left) {
    // The bias of the remainder is below left / 2^64, which is negligible.
    std::swap(numbers[left - 1], numbers[generator() % left]);
  }
  return numbers;
}

}  // namespace

std::optional<double> numberIn(const std::string& text) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && next == end ? std::optional(number) : std::nullopt;
}

bool comesBefore(const SweepValue& a, const SweepValue& b) {
  const auto first = numberIn(a.text);
  const auto second = numberIn(b.text);
  if (first && second) return *first < *second;
  // A number comes before a text.
  if (first || second) return first.has_value();
  return a.text < b.text;
}

std::string SweepRange::at(double share) const {
  const double number =
      logarithmic ? from * std::pow(to / from, share) : from + (to - from) * share;
  // Nine digits are fewer than a double has, so 0.1 + 0.2 gives 0.3.
  return fmt::format("{:.9g}", whole ? std::round(number) : number);
}

SweepPlan SweepPlan::grid(std::vector<SweepAxis> axes) {
  SweepPlan plan;
  for (SweepAxis& axis : axes) {
    plan.keys_.push_back(axis.key);
    plan.axes_.push_back(std::move(axis.values));
    sortAndDropRepeats(plan.axes_.back());
  }
  return plan;
}

SweepPlan SweepPlan::list(const std::vector<SweepAxis>& axes) {
  SweepPlan plan;
  for (const SweepAxis& axis : axes) {
    plan.keys_.push_back(axis.key);
    plan.rows_.resize(axis.values.size());
    for (std::size_t i = 0; i < axis.values.size(); ++i) plan.rows_[i].push_back(axis.values[i]);
  }
  sortAndDropRepeats(plan.rows_);
  return plan;
}

SweepPlan SweepPlan::latinHypercube(const std::vector<SweepRangeAxis>& axes, std::size_t count,
                                    std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<SweepAxis> columns;
  for (const SweepRangeAxis& axis : axes) {
    columns.push_back({axis.key, axis.where, {}});
    for (const std::size_t part : shuffledNumbers(count, generator)) {
      const double share =
          (static_cast<double>(part) + randomShare(generator)) / static_cast<double>(count);
      columns.back().values.push_back({axis.range.at(share), false, axis.where});
    }
  }
  return list(columns);
}

std::uint64_t SweepPlan::size() const {
  if (axes_.empty()) return rows_.size();
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint64_t>::max();
  // The product is capped if it would overflow.
  std::uint64_t size = 1;
  for (const auto& values : axes_) {
    if (values.empty()) return 0;
    size = size > kMax / values.size() ? kMax : size * values.size();
  }
  return size;
}

std::vector<SweepValue> SweepPlan::run(std::uint64_t index) const {
  if (axes_.empty()) return rows_.at(index);
  std::vector<SweepValue> values(axes_.size());
  // The last axis changes fastest.
  for (std::size_t k = axes_.size(); k-- > 0;) {
    values[k] = axes_[k][index % axes_[k].size()];
    index /= axes_[k].size();
  }
  return values;
}

// ------------------------------------------------------------------------------------------------
// Reads sweep.toml key by key. TOML (toml.io, version 1.0) gives each value with its position in
// the file, so every error has file, line and column. cli/sweep_command.cpp checks the keys against
// the options of a run.
//
// A value is stored as the text of a command line ("25", "0,0,-9.81", "true"), because options read
// such text. SweepRange::at() computes the numbers of a range.

namespace {

constexpr std::size_t kMaxValues = 100000;  // of all parameters together; they are in memory
constexpr double kLargest = 1e300;

const std::map<std::string, SweepKeep>& keepWords() {
  static const std::map<std::string, SweepKeep> words = {{"state", SweepKeep::State},
                                                         {"trajectory", SweepKeep::Trajectory},
                                                         {"pictures", SweepKeep::Pictures},
                                                         {"all", SweepKeep::All}};
  return words;
}

std::string requireText(const scene::TomlValue& value, const std::string& requested) {
  if (!value.text() || value.text()->empty()) scene::refuseValue(value, requested);
  return *value.text();
}

const scene::TomlTable& requireTable(const scene::TomlEntry& entry) {
  if (!entry.value.table())
    scene::refuseValue(entry.value, fmt::format("a table, [{}]", entry.key));
  return *entry.value.table();
}

std::size_t readCount(const scene::TomlValue& value, double least, double most) {
  const std::string requested = fmt::format("a whole number from {:g} to {:g}", least, most);
  if (!value.whole()) scene::refuseValue(value, requested);
  return static_cast<std::size_t>(scene::requireNumber(value, least, most, requested));
}

/// Names of files are relative to the sweep file. Other names without a folder are kept: they may
/// be those of models that the program knows.
SweepValue readValue(const std::string& key, const scene::TomlValue& value) {
  std::string text = scene::typedText(value);
  if (isFileKey(key)) {
    const std::filesystem::path near = (value.where.file.parent_path() / text).lexically_normal();
    const bool isName = key != "scene" && !std::filesystem::path(text).has_parent_path();
    if (!isName || isPresent(near)) text = near.string();
  }
  return {text, value.truth() != nullptr, value.where};
}

/// "log" is true, "linear" false.
bool readScale(const scene::TomlValue& value) {
  const std::string* word = value.text();
  if (!word || (*word != "log" && *word != "linear"))
    scene::refuseValue(value, "\"linear\" or \"log\"");
  return *word == "log";
}

/// A range and the rest of its table.
struct RangeTable {
  SweepRange range;
  std::optional<std::size_t> count;
};

constexpr const char* kRangeAllowed =
    "a range, as in {from = 0.01, to = 0.1, count = 5, scale = \"log\"}";

void readRangeKey(const scene::TomlEntry& entry, RangeTable& table) {
  if (entry.key == "from" || entry.key == "to") {
    const double number = scene::requireNumber(entry.value, -kLargest, kLargest, "a number");
    (entry.key == "from" ? table.range.from : table.range.to) = number;
  } else if (entry.key == "scale") {
    table.range.logarithmic = readScale(entry.value);
  } else if (entry.key == "whole") {
    if (!entry.value.truth()) scene::refuseValue(entry.value, "true or false");
    table.range.whole = *entry.value.truth();
  } else if (entry.key == "count") {
    // At least two: both ends.
    table.count = readCount(entry.value, 2, kMaxValues);
  } else {
    scene::refuseKey(entry, "key of a range", {"from", "to", "count", "scale", "whole"});
  }
}

/// `from` may be larger than `to`.
RangeTable readRange(const scene::TomlValue& value) {
  const scene::TomlTable* table = value.table();
  if (!table || !scene::find(*table, "from") || !scene::find(*table, "to"))
    scene::refuseValue(value, kRangeAllowed);
  RangeTable read;
  for (const scene::TomlEntry& entry : *table) readRangeKey(entry, read);
  const SweepRange& range = read.range;
  if (range.logarithmic && !(range.from > 0 && range.to > 0)) {
    scene::refuseValue(value, "ends above 0 for scale = \"log\"");
  }
  return read;
}

/// Counts the values of all parameters; a grid has many more runs.
void requireFewValues(std::size_t count, const FileLocation& where) {
  if (count <= kMaxValues) return;
  throw inputErrorAt(
      where,
      fmt::format(
          "the parameters have more than {} values together; vary fewer, or make several sweeps",
          kMaxValues));
}

/// The values of a key in [grid] or [list]: a list of values, or a range with a count.
SweepAxis readAxis(const scene::TomlEntry& entry) {
  SweepAxis axis{entry.key, entry.where, {}};
  if (const std::vector<scene::TomlValue>* array = entry.value.array()) {
    for (const scene::TomlValue& element : *array)
      axis.values.push_back(readValue(entry.key, element));
    if (array->empty()) {
      throw inputErrorAt(
          entry.value.where,
          fmt::format("{0} has no values; give some, as in {0} = [1, 2]", shown(axis.key)));
    }
    return axis;
  }
  if (!entry.value.table())
    scene::refuseValue(entry.value, "a list [1, 2], or " + std::string(kRangeAllowed));
  const RangeTable table = readRange(entry.value);
  if (!table.count) scene::refuseValue(entry.value, kRangeAllowed);
  for (std::size_t i = 0; i < *table.count; ++i) {
    // Both ends belong to the range.
    const double share = static_cast<double>(i) / static_cast<double>(*table.count - 1);
    axis.values.push_back({table.range.at(share), false, entry.value.where});
  }
  return axis;
}

std::vector<SweepAxis> readAxes(const scene::TomlEntry& entry) {
  std::vector<SweepAxis> axes;
  std::size_t values = 0;
  for (const scene::TomlEntry& key : requireTable(entry)) {
    axes.push_back(readAxis(key));
    values += axes.back().values.size();
    requireFewValues(values, key.where);
  }
  if (axes.empty()) {
    throw inputErrorAt(entry.where,
                       fmt::format("[{}] is empty; name parameters and their values, as in "
                                   "spring_stiffness = [25, 50, 100]",
                                   entry.key));
  }
  return axes;
}

void requireEquallyMany(const std::vector<SweepAxis>& axes) {
  for (const SweepAxis& axis : axes) {
    if (axis.values.size() == axes.front().values.size()) continue;
    throw inputErrorAt(
        axis.where,
        fmt::format("{} has {} values but {} has {}; all keys of [list] need equally many",
                    shown(axis.key), axis.values.size(), shown(axes.front().key),
                    axes.front().values.size()));
  }
}

void readLatinHypercube(const scene::TomlEntry& entry, Sweep& sweep) {
  std::vector<SweepRangeAxis> axes;
  std::size_t runs = 0;
  std::uint64_t seed = 0;
  for (const scene::TomlEntry& key : requireTable(entry)) {
    if (key.key == "runs") {
      runs = readCount(key.value, 1, kMaxValues);
    } else if (key.key == "random_seed") {
      // Whole numbers of TOML are doubles here; below 1e15 they are exact.
      seed = readCount(key.value, 0, 1e15);
    } else {
      const RangeTable table = readRange(key.value);
      axes.push_back({key.key, key.where, table.range});
      const auto end = [&](double share) {
        return SweepValue{table.range.at(share), false, key.value.where};
      };
      // requireValid() checks both ends before the first run. Values between them are assumed to be
      // valid too.
      sweep.axes.push_back({key.key, key.where, {end(0), end(1)}});
    }
  }
  if (runs == 0 || axes.empty()) {
    throw inputErrorAt(entry.where,
                       fmt::format("[latin_hypercube] has no {}; give runs = 100 and ranges, as in "
                                   "thickness = {{from = 0.01, to = 0.1}}",
                                   axes.empty() ? "ranges" : "runs"));
  }
  requireFewValues(axes.size() * runs, entry.where);
  sweep.plan = SweepPlan::latinHypercube(axes, runs, seed);
}

/// Reads [grid], [list] or [latin_hypercube].
void readPlan(const scene::TomlEntry& entry, Sweep& sweep) {
  // A second plan if there are axes already.
  if (!sweep.axes.empty()) {
    throw inputErrorAt(entry.where,
                       "use only one of [grid], [list] and [latin_hypercube]; remove the others");
  }
  if (entry.key == "latin_hypercube") {
    readLatinHypercube(entry, sweep);
    return;
  }
  sweep.axes = readAxes(entry);
  if (entry.key == "list") requireEquallyMany(sweep.axes);
  sweep.plan = entry.key == "list" ? SweepPlan::list(sweep.axes) : SweepPlan::grid(sweep.axes);
}

/// Keys may be in any order.
void readEntry(const scene::TomlEntry& entry, Sweep& sweep) {
  static const std::vector<std::string> kKeys = {"model", "generate", "scene", "keep",
                                                 "base",  "grid",     "list",  "latin_hypercube"};
  if (entry.key == "grid" || entry.key == "list" || entry.key == "latin_hypercube") {
    readPlan(entry, sweep);
  } else if (entry.key == "base") {
    for (const scene::TomlEntry& setting : requireTable(entry)) {
      sweep.settings.push_back({setting.key, readValue(setting.key, setting.value)});
    }
  } else if (entry.key == "generate") {
    sweep.family = requireText(entry.value, "the name of a family");
    sweep.familyWhere = entry.value.where;
  } else if (entry.key == "model" || entry.key == "scene") {
    requireText(entry.value, "the name of a file or folder");
    sweep.settings.push_back({entry.key, readValue(entry.key, entry.value)});
  } else if (entry.key == "keep") {
    const auto found = keepWords().find(requireText(entry.value, "a word"));
    if (found == keepWords().end()) {
      scene::refuseValue(entry.value, "\"state\", \"trajectory\", \"pictures\" or \"all\"");
    }
    sweep.keep = found->second;
  } else {
    scene::refuseKey(entry, "key", kKeys);
  }
}

/// Checks that each key is either set for all runs or varied, and only once.
void requireKeysOnce(const Sweep& sweep) {
  std::map<std::string, int> lines;
  const auto require = [&lines](const std::string& key, const FileLocation& where) {
    const auto [found, isNew] = lines.try_emplace(key, where.line);
    if (isNew) return;
    throw inputErrorAt(where, fmt::format("{} is set twice (also in line {}); remove one",
                                          shown(key), found->second));
  };
  for (const SweepSetting& setting : sweep.settings) require(setting.key, setting.value.where);
  for (const SweepAxis& axis : sweep.axes) require(axis.key, axis.where);
}

}  // namespace

Sweep readSweepFile(const std::filesystem::path& path) {
  Sweep sweep;
  sweep.file = path;
  for (const scene::TomlEntry& entry : scene::readTomlFile(path, "a sweep file, like sweep.toml")) {
    readEntry(entry, sweep);
  }
  if (sweep.axes.empty()) {
    throw inputErrorAt({path}, "there is nothing to vary; add [grid], [list] or [latin_hypercube]");
  }
  requireKeysOnce(sweep);
  // Names and tables must not depend on the order in the file.
  std::sort(sweep.settings.begin(), sweep.settings.end(),
            [](const SweepSetting& a, const SweepSetting& b) { return a.key < b.key; });
  return sweep;
}

}  // namespace kirireel::sweep
