#include "render/sweep/collect.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "render/record/output_folder.h"
#include "render/sweep/run_folder.h"
#include "sim/base/error.h"
#include "sim/base/pending_file.h"
#include "sim/trajectory/array_file.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// A column of the results and where summary.json has it.
struct Figure {
  std::string column;
  Json::json_pointer place;
};

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

Json readSummary(const fs::path& folder) {
  const fs::path file = folder / output::kSummary;
  std::ifstream stream(file);
  Json summary = Json::parse(stream, nullptr, false);
  if (!summary.is_object() || !summary.contains("accuracy")) {
    throw inputErrorAt({file}, "this is no summary of a run; remove its folder to run it again");
  }
  return summary;
}

std::string cellOf(const Json& summary, const Figure& figure) {
  if (!summary.contains(figure.place)) return "";
  const Json& value = summary.at(figure.place);
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// A finished run.
struct Row {
  std::string name;
  std::vector<std::string> values;
  RunRecord record;
  Json summary;  ///< null when it failed
};

/// Adds rows to a table whose columns are told by a list of figures.
void addFigures(const std::vector<Row>& rows, const std::vector<Figure>& figures, Table& table) {
  for (const Figure& figure : figures) {
    TableColumn column{figure.column, {}};
    for (const Row& row : rows) column.cells.push_back(cellOf(row.summary, figure));
    table.push_back(std::move(column));
  }
}

template <typename Cell>
TableColumn makeColumn(const std::string& name, const std::vector<Row>& rows, const Cell& cell) {
  TableColumn column{name, {}};
  for (const Row& row : rows) column.cells.push_back(cell(row));
  return column;
}

Table makeResults(const std::vector<Row>& rows, const std::vector<std::string>& keys) {
  Table table = {makeColumn("run", rows, [](const Row& row) { return row.name; })};
  for (std::size_t k = 0; k < keys.size(); ++k) {
    table.push_back(makeColumn(keys[k], rows, [k](const Row& row) { return row.values[k]; }));
  }
  table.push_back(makeColumn("status", rows, [](const Row& row) {
    return std::string(row.record.failed ? "failed" : "done");
  }));
  table.push_back(makeColumn("reason", rows, [](const Row& row) { return row.record.reason; }));
  for (const Row& row : rows) {
    if (row.record.failed) continue;
    addFigures(rows, measures(row.summary), table);
    break;
  }
  return table;
}

std::string captionOf(const Row& row, const std::vector<std::string>& keys) {
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    parts.push_back(fmt::format("{} {}", keys[k], row.values[k]));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\n") == std::string::npos) return cell;
  std::string text = "\"";
  for (const char letter : cell)
    text += letter == '"' ? std::string("\"\"") : std::string(1, letter);
  return text + "\"";
}

/// NaN for an empty cell; nothing for a text.
std::optional<double> numberIn(const std::string& cell) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double number = 0;
  const char* const end = cell.data() + cell.size();
  const auto [next, error] = std::from_chars(cell.data(), end, number);
  return error == std::errc() && next == end ? std::optional(number) : std::nullopt;
}

void writeColumn(const TableColumn& column, ArrayWriter& writer) {
  std::vector<double> numbers;
  bool isText = true;
  for (const std::string& cell : column.cells) {
    const std::optional<double> number = numberIn(cell);
    if (!number) {
      writer.write(column.name, column.cells);
      return;
    }
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
  std::vector<Row> rows;
  std::vector<Row> doneRows;
  for (std::uint64_t index = 0; index < listing.count; ++index) {
    Row row{listing.name(index), listing.values(index), {}, nullptr};
    const std::optional<RunRecord> record = readRunRecord(listing.runs / row.name);
    if (!record) {
      ++gathered.missing;
      continue;
    }
    row.record = *record;
    gathered.failed += record->failed ? 1 : 0;
    if (!record->failed) {
      row.summary = readSummary(listing.runs / row.name);
      gathered.done.push_back(row.name);
      gathered.captions.push_back(captionOf(row, listing.keys));
      doneRows.push_back(row);
    }
    rows.push_back(std::move(row));
  }
  gathered.results = makeResults(rows, listing.keys);
  gathered.costs = {makeColumn("run", doneRows, [](const Row& row) { return row.name; })};
  addFigures(doneRows, costFigures(), gathered.costs);
  return gathered;
}

std::string csvText(const Table& table) {
  std::vector<std::string> names;
  for (const TableColumn& column : table) names.push_back(quoted(column.name));
  std::string text = fmt::format("{}\n", fmt::join(names, ","));
  const std::size_t rows = table.empty() ? 0 : table.front().cells.size();
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = 0; k < table.size(); ++k) {
      text += (k == 0 ? "" : ",") + quoted(table[k].cells[row]);
    }
    text += '\n';
  }
  return text;
}

void writeTableArrays(const Table& table, const fs::path& file) {
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
