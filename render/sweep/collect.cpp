// Gathers the summaries of all finished runs in the order of the plan, so that the same runs give
// the same table whatever order they were made in. Two tables come of it:
//
//     results   run, parameters..., status, reason, measures...
//     costs     run, seconds and bytes of each stage
//
// Costs are apart because they differ from time to time; the results of two machines can be
// compared byte by byte.
//
// The measures are read from summary.json by JSON pointers (RFC 6901): all that stands under
// /accuracy, whatever a version puts there, and some more. Their names are those of the first run
// that is done; runs that failed have empty cells there.
//
// Only the cells are kept, not the summaries, so that memory grows with the table alone.
//
// HDF5: each column is a data set in the root group. A column of numbers is an array of doubles
// with NaN where a cell is empty; one with any other text is an array of texts.
#include "render/sweep/collect.h"

#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "render/folder/output_folder.h"
#include "render/sweep/run_folder.h"
#include "render/sweep/sweep_plan.h"
#include "sim/base/error.h"
#include "sim/base/input_file.h"
#include "sim/base/pending_file.h"
#include "sim/trajectory/array_file.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// A table's pictures need it, in metres.
const Json::json_pointer kThickness("/settings/model/thickness");

/// A column of the results and where summary.json has it.
struct Figure {
  std::string column;
  Json::json_pointer place;
};

/// Columns that are called as their key below `parent`.
std::vector<Figure> figuresOf(const std::string& parent, const std::vector<std::string>& names) {
  std::vector<Figure> figures;
  for (const std::string& name : names) {
    figures.push_back({name, Json::json_pointer(parent + "/" + name)});
  }
  return figures;
}

/// The measures of a run; all that its accuracy states are among them. Their names are not those of
/// parameters, of which "tiles" and "path" are some.
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

/// Parsing throws nothing: what is no object is refused below.
Json readSummary(const fs::path& folder) {
  const fs::path file = folder / output::kSummary;
  std::ifstream stream = openInputFile(file);
  Json summary = Json::parse(stream, nullptr, false);
  if (!summary.is_object() || !summary.contains("accuracy") || !summary.contains(kThickness)) {
    throw inputErrorAt({file}, "this is no summary of a run; remove its folder to run it again");
  }
  return summary;
}

/// Numbers in the digits that the summary has them in, so that no precision is lost on the way.
std::string cellOf(const Json& summary, const Figure& figure) {
  if (!summary.contains(figure.place)) return "";
  const Json& value = summary.at(figure.place);
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// A table that grows by rows, each a cell for each name. All columns have as many cells as there
/// are rows, at any time.
class TableBuilder {
 public:
  void addColumns(const std::vector<std::string>& names) {
    // Rows that came before have nothing there.
    for (const std::string& name : names) table_.push_back({name, {rows_, ""}});
  }

  /// Columns that the row does not reach stay empty.
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

/// Takes finished runs one after the other and keeps their figures alone, not their summaries.
class Gatherer {
 public:
  explicit Gatherer(const std::vector<std::string>& keys) {
    results_.addColumns({"run"});
    results_.addColumns(keys);
    results_.addColumns({"status", "reason"});
    costs_.addColumns({"run"});
    costs_.addColumns(namesOf(costFigures()));
  }

  /// summary: null when the run failed.
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
  std::vector<Figure> measures_;  ///< known from the first run that is done
  TableBuilder results_;
  TableBuilder costs_;
};

/// RFC 4180, section 2: cells with commas, quotation marks or line breaks stand in quotation marks,
/// and marks within are doubled. Names of files may hold any of these.
std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos) return cell;
  std::string text = "\"";
  for (const char letter : cell)
    text += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return text + "\"";
}

/// NaN for an empty cell; nothing for a text.
std::optional<double> numberInCell(const std::string& cell) {
  return cell.empty() ? std::numeric_limits<double>::quiet_NaN() : numberIn(cell);
}

void writeColumn(const TableColumn& column, ArrayWriter& writer) {
  std::vector<double> numbers;
  bool isText = true;
  for (const std::string& cell : column.cells) {
    const std::optional<double> number = numberInCell(cell);
    // One text makes the whole column texts.
    if (!number) {
      writer.write(column.name, column.cells);
      return;
    }
    // It stays true where all cells are empty.
    isText = isText && std::isnan(*number);
    numbers.push_back(*number);
  }
  // Reasons that nobody had to give are texts all the same.
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
    // No record: never made, in work, or its worker was killed.
    if (!record) {
      ++gathered.missing;
      continue;
    }
    run.failed = record->failed;
    gathered.failed += run.failed ? 1 : 0;
    Json summary;
    if (!run.failed) {
      summary = readSummary(listing.runs / run.name);
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
  ArrayWriter writer(pending.path(), file);
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

}  // namespace kirireel
