// A run is made in OUT/runs/HASH.part and renamed to OUT/runs/HASH when it is complete. rename(2)
// is atomic within a file system, so a finished folder has either all its files or does not exist.
//
// The process that makes a run holds an advisory lock (flock(2)) on HASH.part/lock. The kernel
// releases it when the process ends in any way, so stale locks do not occur. On NFS Linux converts
// flock to server locks, which work across machines.
//
// The order in take() matters. Another process may finish the run between the first check and the
// lock, and rename the folder with the lock in it. After locking, isOf() therefore checks that the
// path still refers to the locked file. The finished folder is then checked again.
#include "render/sweep/collect.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "render/output/output_folder.h"
#include "render/picture/state_painter.h"
#include "render/sweep/sweep_plan.h"
#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/files.h"
#include "sim/formats/read_model.h"
#include "sim/trajectory/array_file.h"

namespace kirireel::sweep {
namespace {

namespace fs = std::filesystem;
constexpr const char* kRecord = "run.json";
constexpr const char* kLock = "lock";

/// Empties a folder except its lock: files of a killed run.
void removeLeftovers(const fs::path& folder) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename() != kLock) fs::remove_all(entry.path());
  }
}

/// Whether a run is still to be made.
bool isOpen(const fs::path& finished, bool retryFailed) {
  const std::optional<RunRecord> record = readRunRecord(finished);
  return !record || (retryFailed && record->failed);
}

/// An object with the keys status ("done" or "failed"), reason and inputs.
std::string recordText(const RunRecord& record) {
  Json inputs = Json::object();
  for (const auto& [key, value] : record.inputs) inputs[key] = value;
  const Json json = {
      {"status", record.failed ? "failed" : "done"}, {"reason", record.reason}, {"inputs", inputs}};
  return jsonText(json, 2) + "\n";
}

}  // namespace

std::optional<FileLock> FileLock::take(const fs::path& file, IfHeld ifHeld) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  // The former lock holder may have just moved the folder into place.
  if (descriptor < 0 && errno == ENOENT && ifHeld == IfHeld::GiveUp) return std::nullopt;
  if (descriptor < 0) {
    throw OutputError(
        fmt::format("{}: error: cannot be made ({}); choose another folder with --out",
                    file.string(), std::strerror(errno)));
  }
  // From here on the descriptor is always closed.
  FileLock lock(descriptor);
  const int patience = ifHeld == IfHeld::GiveUp ? LOCK_NB : 0;
  int result = 0;
  do {
    result = ::flock(descriptor, LOCK_EX | patience);
  } while (result != 0 && errno == EINTR);
  if (result == 0) return lock.isOf(file) ? std::optional(std::move(lock)) : std::nullopt;
  if (errno == EWOULDBLOCK) return std::nullopt;
  throw OutputError(
      fmt::format("{}: error: cannot be locked ({}); choose a folder on another disk "
                  "with --out",
                  file.string(), std::strerror(errno)));
}

/// A renamed file keeps its inode. The old name then refers to another file or to none.
bool FileLock::isOf(const fs::path& file) const {
  struct stat held = {};
  struct stat named = {};
  // The same device and inode: the same file.
  return ::fstat(descriptor_, &held) == 0 && ::stat(file.c_str(), &named) == 0 &&
         held.st_dev == named.st_dev && held.st_ino == named.st_ino;
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::optional<RunRecord> readRunRecord(const fs::path& runFolder) {
  const fs::path file = runFolder / kRecord;
  std::ifstream stream = openInputFile(file);
  if (!stream) return std::nullopt;
  try {
    const Json json = parseJson(std::string(std::istreambuf_iterator<char>(stream), {}));
    RunRecord record{json.at("status") == "failed", json.at("reason"), {}};
    for (const auto& [key, value] : json.at("inputs").items()) {
      record.inputs.emplace_back(key, value);
    }
    return record;
  } catch (const Json::exception&) {
    throw inputErrorAt({file},
                       "this is not the record of a run; remove its folder to run it again");
  }
}

std::optional<RunClaim> RunClaim::take(const fs::path& runs, const std::string& name,
                                       bool retryFailed) {
  const fs::path finished = runs / name;
  if (!isOpen(finished, retryFailed)) return std::nullopt;
  const fs::path folder = runs / (name + ".part");
  makeFolder(folder);
  std::optional<FileLock> lock = FileLock::take(folder / kLock, FileLock::IfHeld::GiveUp);
  if (!lock) return std::nullopt;
  // Another process may have finished it since the first check. This folder then belongs only to
  // us.
  if (!isOpen(finished, retryFailed)) {
    fs::remove_all(folder);
    return std::nullopt;
  }
  removeLeftovers(folder);
  return RunClaim(std::move(*lock), folder, finished);
}

void RunClaim::clear() const {
  removeLeftovers(folder_);
}

void RunClaim::finish(const RunRecord& record) {
  writeTextFile(folder_ / kRecord, recordText(record));
  // A repeated failed run already has a folder. It is moved aside first and removed last, so one of
  // the two always exists.
  const fs::path former = finished_.string() + ".old.part";
  std::error_code ignored;
  fs::remove_all(former, ignored);
  if (isPresent(finished_)) moveFile(finished_, former);
  moveFile(folder_, finished_);
  fs::remove(finished_ / kLock, ignored);
  fs::remove_all(former, ignored);
}

// ------------------------------------------------------------------------------------------------
// Collects the summaries of all finished runs in the order of the plan. The table does not depend
// on the order in which runs were made. The result is two tables:
//     results   run, parameters..., status, reason, measures...
//     costs     run, seconds and bytes of each stage
//
// Costs are separate because they vary between executions. The results of two machines can be
// compared byte by byte.
//
// The measures are read from summary.json by JSON pointers (RFC 6901): all values of a version
// under /accuracy, and some more. Their names are those of the first finished run; failed runs have
// empty cells there.
//
// Only the cells are kept, not the summaries: memory grows with the table.
//
// HDF5: each column is a data set in the root group. A column of numbers is an array of doubles
// with NaN for empty cells. A column with any other text is an array of texts.

namespace {

/// Thickness for the pictures of a table, in metres.
const Json::json_pointer kThickness("/settings/model/thickness");

/// A column of the results and its location in summary.json.
struct Figure {
  std::string column;
  Json::json_pointer place;
};

/// Columns whose name is their key below `parent`.
std::vector<Figure> figuresOf(const std::string& parent, const std::vector<std::string>& names) {
  std::vector<Figure> figures;
  for (const std::string& name : names) {
    figures.push_back({name, Json::json_pointer(parent + "/" + name)});
  }
  return figures;
}

/// The measures of a run, including all accuracy values. Their names differ from those of
/// parameters such as "tiles" and "path".
std::vector<Figure> measures(const Json& summary) {
  std::vector<Figure> figures = {{"outcome", Json::json_pointer("/outcome")},
                                 {"end_time", Json::json_pointer("/end_time")},
                                 {"tile_count", Json::json_pointer("/model/tiles")},
                                 {"joint_count", Json::json_pointer("/model/joints")},
                                 {"path_kind", Json::json_pointer("/path/kind")}};
  for (const auto& accuracy : summary.at("accuracy").items()) {
    figures.push_back({accuracy.key(), Json::json_pointer("/accuracy/" + accuracy.key())});
  }
  const auto steps = figuresOf("/cost", {"steps", "halved_steps", "unconverged_steps"});
  figures.insert(figures.end(), steps.begin(), steps.end());
  return figures;
}

const std::vector<Figure>& costFigures() {
  static const std::vector<Figure> figures =
      figuresOf("/cost", {"cpu_seconds_search", "cpu_seconds_deploy", "cpu_seconds_render",
                          "cpu_seconds_encode", "wall_seconds", "peak_memory_bytes"});
  return figures;
}

/// Parsing does not throw: anything but an object is refused below.
Json readRunSummary(const fs::path& folder) {
  const fs::path file = folder / output::kSummary;
  std::ifstream stream = openInputFile(file);
  Json summary = parseJsonOrDiscard(std::string(std::istreambuf_iterator<char>(stream), {}));
  if (!summary.is_object() || !summary.contains("accuracy") || !summary.contains(kThickness)) {
    throw inputErrorAt({file},
                       "this is not the summary of a run; remove its folder to run it again");
  }
  return summary;
}

/// Numbers with the digits of the summary: no precision is lost.
std::string cellOf(const Json& summary, const Figure& figure) {
  if (!summary.contains(figure.place)) return "";
  const Json& value = summary.at(figure.place);
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : jsonText(value);
}

/// A table that grows by rows. All columns always have as many cells as there are rows.
class TableBuilder {
 public:
  void addColumns(const std::vector<std::string>& names) {
    // Earlier rows have empty cells there.
    for (const std::string& name : names) table_.push_back({name, {rows_, ""}});
  }

  /// Missing cells at the end of a row are empty.
  void addRow(std::vector<std::string> cells) {
    cells.resize(table_.size());
    for (std::size_t k = 0; k < cells.size(); ++k) table_[k].cells.push_back(std::move(cells[k]));
    ++rows_;
  }

  SweepTable take() { return std::move(table_); }

 private:
  SweepTable table_;
  std::size_t rows_ = 0;
};

std::vector<std::string> namesOf(const std::vector<Figure>& figures) {
  std::vector<std::string> names;
  for (const Figure& figure : figures) names.push_back(figure.column);
  return names;
}

void appendCells(const Json& summary, const std::vector<Figure>& figures,
                 std::vector<std::string>& cells) {
  for (const Figure& figure : figures) cells.push_back(cellOf(summary, figure));
}

/// Adds finished runs one by one and keeps only their numbers, not their summaries.
class Gatherer {
 public:
  explicit Gatherer(const std::vector<std::string>& keys) {
    results_.addColumns({"run"});
    results_.addColumns(keys);
    results_.addColumns({"status", "reason"});
    costs_.addColumns({"run"});
    costs_.addColumns(namesOf(costFigures()));
  }

  /// summary: null for a failed run.
  void add(const SweepRow& run, const std::string& reason, const Json& summary) {
    std::vector<std::string> cells = {run.name};
    cells.insert(cells.end(), run.values.begin(), run.values.end());
    cells.insert(cells.end(), {run.failed ? "failed" : "done", reason});
    if (!run.failed) {
      if (measures_.empty()) {
        measures_ = measures(summary);
        results_.addColumns(namesOf(measures_));
      }
      appendCells(summary, measures_, cells);
      std::vector<std::string> costs = {run.name};
      appendCells(summary, costFigures(), costs);
      costs_.addRow(std::move(costs));
    }
    results_.addRow(std::move(cells));
  }

  SweepTable takeResults() { return results_.take(); }
  SweepTable takeCosts() { return costs_.take(); }

 private:
  std::vector<Figure> measures_;  ///< set by the first finished run
  TableBuilder results_;
  TableBuilder costs_;
};

/// RFC 4180, section 2: cells with commas, quotation marks or line breaks are in quotation marks,
/// and inner marks are doubled. File names may contain any of these.
std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos) return cell;
  std::string text = "\"";
  for (const char letter : cell)
    text += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return text + "\"";
}

void writeColumn(const TableColumn& column, trajectory::ArrayWriter& writer) {
  std::vector<double> numbers;
  bool isText = true;
  for (const std::string& cell : column.cells) {
    const std::optional<double> number =
        cell.empty() ? std::numeric_limits<double>::quiet_NaN() : numberIn(cell);
    // A single text makes the whole column texts.
    if (!number) {
      writer.write(column.name, column.cells);
      return;
    }
    // Stays true if all cells are empty.
    isText = isText && std::isnan(*number);
    numbers.push_back(*number);
  }
  // A column of empty reasons is also text.
  if (isText) {
    writer.write(column.name, column.cells);
  } else {
    writer.write(column.name, numbers, {numbers.size()});
  }
}

}  // namespace

Gathered gather(const SweepListing& listing) {
  Gathered gathered;
  Gatherer gatherer(listing.keys);
  for (std::uint64_t index = 0; index < listing.count; ++index) {
    SweepRow run{listing.name(index), listing.values(index)};
    const std::optional<RunRecord> record = readRunRecord(listing.runs / run.name);
    // No record: the run was not made, is in progress, or its worker was killed.
    if (!record) {
      ++gathered.missing;
      continue;
    }
    run.failed = record->failed;
    gathered.failed += run.failed ? 1 : 0;
    Json summary;
    if (!run.failed) {
      summary = readRunSummary(listing.runs / run.name);
      run.thickness = summary.at(kThickness).get<double>();
    }
    gatherer.add(run, record->reason, summary);
    gathered.runs.push_back(std::move(run));
  }
  gathered.results = gatherer.takeResults();
  gathered.costs = gatherer.takeCosts();
  return gathered;
}

std::string csvText(const SweepTable& table) {
  std::vector<std::string> names;
  for (const TableColumn& column : table) names.push_back(quoted(column.name));
  std::string text = fmt::format("{}\n", fmt::join(names, ","));
  const std::size_t rows = table.empty() ? 0 : table.front().cells.size();
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < table.size(); ++k) {
      if (k > 0) text += ',';
      text += quoted(table[k].cells[row]);
    }
    text += '\n';
  }
  return text;
}

void writeTableArrays(const SweepTable& table, const fs::path& file) {
  PendingFile pending(file);
  trajectory::ArrayWriter writer(pending.path(), file);
  std::vector<std::string> names;
  for (const TableColumn& column : table) {
    names.push_back(column.name);
    writeColumn(column, writer);
  }
  writer.setAttribute("/", "format", "kirireel sweep");
  writer.setAttribute("/", "columns", fmt::format("{}", fmt::join(names, ",")));
  writer.close();
  pending.commit();
}

// ------------------------------------------------------------------------------------------------
// Selects the pictures of the page in two steps: the runs, then the number of columns.
//
// A series is a sequence of neighbours in the table that differ only in the last parameter. A grid
// of a x b values has series of b. If all n runs fit (n <= 100), all are shown. Otherwise every
// k-th series and every m-th run of each, including the first and the last. The page thus shows the
// ends of both parameters.
//
// With series of s pictures, a row of c columns keeps equal values in one column if c divides s or
// s divides c. Among these c the page with the most similar sides is used, if they differ by less
// than a factor of 4; otherwise c = ceil(sqrt n).
//
// Each picture has its own scale, because models of a sweep may differ in size by orders of
// magnitude.

namespace {

/// Pixels. A hundred of them make a page of 3200 x 2400 plus captions.
constexpr picture::FrameSize kPictureSize = {320, 240};

/// Pictures of a longer series, if not all fit. Ten by ten pictures is kMaxContacts.
constexpr std::size_t kMaxSeries = 10;

/// Rows may end with series if the ratio of the page's sides is at most this.
constexpr double kMaxStretch = 4;

/// Paints end states, all in one graphics context.
class EndStatePainter {
 public:
  /// Bricks made from the final tiles show the deployed bricks.
  picture::Frame paint(const ContactPicture& picture) {
    // A failed run has an empty picture in the colour of the page.
    if (picture.vertices.empty())
      return picture::makeFrame(kPictureSize, picture::Style().background);
    model::Model model;
    model.tiles = formats::readTileFile(picture.vertices);
    brick::BrickRule rule;
    rule.thickness = picture.thickness;
    const picture::PictureContent content = picture::makeContent(model, rule, std::nullopt);
    // Making a graphics context takes longer than painting a small picture.
    if (painter_) {
      painter_->show({}, content);
    } else {
      painter_.emplace(kPictureSize, picture::Appearance(), content);
    }
    return painter_->paint({0, content.start, {}});
  }

 private:
  std::optional<picture::StatePainter> painter_;
};

/// At most `most` indices >= 0, evenly spaced, including the first and the last.
std::vector<std::size_t> chooseEvenly(std::size_t count, std::size_t most) {
  const std::size_t chosen = std::min(count, most);
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < chosen; ++i) {
    // Rounded down, which keeps both ends: i = chosen - 1 gives count - 1.
    numbers.push_back(chosen == 1 ? 0 : i * (count - 1) / (chosen - 1));
  }
  return numbers;
}

/// Ratio of the longer to the shorter side of the page.
double stretch(std::size_t columns, std::size_t count) {
  const double rows = std::ceil(static_cast<double>(count) / static_cast<double>(columns));
  const double ratio = rows / static_cast<double>(columns);
  return std::max(ratio, 1 / ratio);
}

/// As many columns as rows, or as near as possible with rows that end with series.
picture::GridShape shapeFor(std::size_t count, std::size_t series) {
  auto best = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  double least = kMaxStretch;
  for (std::size_t columns = 1; series > 1 && series < count && columns <= count; ++columns) {
    if (series % columns != 0 && columns % series != 0) continue;
    if (stretch(columns, count) >= least) continue;
    least = stretch(columns, count);
    best = columns;
  }
  return {static_cast<int>((count + best - 1) / best), static_cast<int>(best)};
}

/// Number of pictures in a series; 1 if series have different lengths.
std::size_t seriesLength(const std::vector<ContactPicture>& pictures) {
  const auto isAlike = [](const ContactPicture& a, const ContactPicture& b) {
    return std::equal(a.values.begin(), a.values.end() - 1, b.values.begin());
  };
  std::vector<std::size_t> lengths;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (i == 0 || !isAlike(pictures[i - 1], pictures[i])) lengths.push_back(0);
    ++lengths.back();
  }
  // A list or a Latin hypercube has no such order.
  const bool isEven = std::all_of(lengths.begin(), lengths.end(),
                                  [&](std::size_t length) { return length == lengths.front(); });
  return isEven ? lengths.front() : 1;
}

}  // namespace

ContactLayout layOutContacts(std::size_t count, std::size_t series) {
  if (count <= kMaxContacts) return {chooseEvenly(count, count), shapeFor(count, series)};
  if (series == 1 || series == count) {
    return {chooseEvenly(count, kMaxContacts), shapeFor(kMaxContacts, 1)};
  }
  const auto across = chooseEvenly(series, kMaxSeries);
  const auto down = chooseEvenly(count / series, kMaxContacts / across.size());
  ContactLayout layout;
  for (const std::size_t one : down) {
    for (const std::size_t place : across) layout.chosen.push_back(one * series + place);
  }
  layout.shape = shapeFor(layout.chosen.size(), across.size());
  return layout;
}

picture::Frame composeContactSheet(const std::vector<std::string>& keys,
                                   const std::vector<ContactPicture>& pictures) {
  if (pictures.empty()) throw InputError("error: no run is finished, so there is nothing to show");
  const ContactLayout layout = layOutContacts(pictures.size(), seriesLength(pictures));
  std::vector<std::vector<std::string>> values;
  for (const std::size_t chosen : layout.chosen) values.push_back(pictures[chosen].values);
  const std::vector<std::string> captions = captionsOf(keys, values);
  EndStatePainter painter;
  std::vector<picture::GridPicture> cells;
  for (std::size_t i = 0; i < captions.size(); ++i) {
    const ContactPicture& picture = pictures[layout.chosen[i]];
    const char* const note = picture.vertices.empty() ? ": failed" : "";
    cells.push_back({painter.paint(picture), captions[i] + note});
  }
  return picture::composeGrid(cells, layout.shape);
}

// ------------------------------------------------------------------------------------------------
// Finds the fewest digits, at least three, that still distinguish different values, for one
// parameter at a time. Values of a range have nine digits (12.6991457), which would not fit in
// captions of small pictures.

namespace {

constexpr int kFewestDigits = 3;
/// Digits of the numbers of a range, as SweepRange::at() writes them. With this number, texts stay
/// unchanged.
constexpr int kMaxDigits = 9;

/// Whole numbers and texts stay as they are.
std::string rounded(const std::string& text, int digits) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(text.data(), end, number);
  // A number with neither point nor exponent is an integer. "0,0,-9.81" is parsed up to its first
  // comma, so it counts as a text.
  if (error != std::errc() || next != end || text.find_first_of(".e") == std::string::npos) {
    return text;
  }
  return fmt::format("{:.{}g}", number, digits);
}

/// Different values get different texts.
std::vector<std::string> shortened(const std::vector<std::string>& values) {
  const std::set<std::string> distinct(values.begin(), values.end());
  for (int digits = kFewestDigits; digits < kMaxDigits; ++digits) {
    std::set<std::string> texts;
    for (const std::string& value : distinct) texts.insert(rounded(value, digits));
    // Two values have the same text, so one more digit is needed.
    if (texts.size() < distinct.size()) continue;
    std::vector<std::string> chosen;
    chosen.reserve(values.size());
    for (const std::string& value : values) chosen.push_back(rounded(value, digits));
    return chosen;
  }
  return values;
}

/// In a human-readable spelling.
std::string withSpaces(std::string key) {
  std::replace(key.begin(), key.end(), '_', ' ');
  return key;
}

}  // namespace

std::vector<std::string> captionsOf(const std::vector<std::string>& keys,
                                    const std::vector<std::vector<std::string>>& runs) {
  std::vector<std::string> captions(runs.size());
  for (std::size_t k = 0; k < keys.size(); ++k) {
    std::vector<std::string> values;
    values.reserve(runs.size());
    for (const auto& run : runs) values.push_back(run[k]);
    values = shortened(values);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      captions[i] += fmt::format("{}{} {}", k == 0 ? "" : ", ", withSpaces(keys[k]), values[i]);
    }
  }
  return captions;
}

}  // namespace kirireel::sweep
