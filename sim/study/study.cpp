// Tables as CSV: lines of the caption that begin with '#', the columns' names, the rows. Cells hold
// no commas and no line ends: nothing needs quoting.
#include "sim/study/study.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <sys/utsname.h>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/scene/settings.h"

namespace kirireel::study {
namespace {

// Cells hold no commas, see cell().
Row splitCells(const std::string& line) {
  const std::vector<std::string_view> cells = scene::split(line, ',');
  return {cells.begin(), cells.end()};
}

// Lines that begin with '#' but name no part of the caption are skipped.
void readCaptionLine(const std::string& line, Caption& caption) {
  forEachField(caption, [&line](const auto& field, std::string& value) {
    const std::string start = fmt::format("# {}: ", field.name);
    if (line.starts_with(start)) value = line.substr(start.size());
  });
}

}  // namespace

std::size_t Table::columnIndex(const std::string& name) const {
  const auto found = std::ranges::find(columns, name, &Column::name);
  if (found == columns.end()) {
    throw InputError(
        fmt::format("error: the table of {} has no column {}; make it again with "
                    "kirireel study {}",
                    caption.study, name, caption.study));
  }
  return static_cast<std::size_t>(found - columns.begin());
}

const std::string& Table::text(const Row& row, const std::string& column) const {
  return row[columnIndex(column)];
}

// strtod reads a point as the decimal sign as long as the program
// sets no other locale.
double Table::number(const Row& row, const std::string& column) const {
  const std::string& digits = text(row, column);
  char* end = nullptr;
  const double value = std::strtod(digits.c_str(), &end);
  const bool whole = !digits.empty() && *end == '\0';
  return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

double Table::largest(const std::string& column, const std::string& engine,
                      const std::function<bool(const Row&)>& holds) const {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (const Row& row : rows) {
    if (text(row, "engine") != engine || !holds(row)) continue;
    largest = std::fmax(largest, number(row, column));
  }
  return largest;
}

// Five significant digits, which is the accuracy of times and errors.
std::string cell(double number) {
  return std::isfinite(number) ? fmt::format("{:.5g}", number) : "";
}

std::string cell(int number) {
  return fmt::format("{}", number);
}

std::string cell(bool flag) {
  return flag ? "yes" : "no";
}

std::string cell(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string csvText(const Table& table) {
  std::string text;
  forEachField(table.caption, [&text](const auto& field, const std::string& value) {
    text += fmt::format("# {}: {}\n", field.name, value);
  });
  Row names;
  for (const Column& column : table.columns) names.push_back(column.name);
  text += fmt::format("{}\n", fmt::join(names, ","));
  for (const Row& row : table.rows) text += fmt::format("{}\n", fmt::join(row, ","));
  return text;
}

Table readCsv(const std::filesystem::path& file) {
  std::ifstream stream = openInputFile(file);
  if (!stream) {
    throw InputError(
        fmt::format("{}: error: cannot be read; kirireel study makes it", file.string()));
  }
  Table table;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.starts_with('#')) {
      readCaptionLine(line, table.caption);
    } else if (table.columns.empty()) {
      for (const std::string& name : splitCells(line)) table.columns.push_back({name, ""});
    } else {
      table.rows.push_back(splitCells(line));
      if (table.rows.back().size() == table.columns.size()) continue;
      throw inputErrorAt({file, number, 0},
                         fmt::format("{} cells, but the table has {} columns; remove this line",
                                     table.rows.back().size(), table.columns.size()));
    }
  }
  return table;
}

// ------------------------------------------------------------------------------------------------
// Runs the cases of a study one after the other and stores finished ones. The rows of a case depend
// only on its name: a resumed study keeps the rows of an earlier file for every case that has some.
// The caption names the machine and the versions of a table, because times have no meaning without
// them.

namespace {

// Available on Linux; unknown on other systems.
std::string processorName() {
  std::ifstream file = openInputFile("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

// The properties that must agree to compare two tables, and the command that reproduces the table.
Caption makeCaption(const Study& study, const StudySettings& settings) {
  Caption caption;
  caption.study = study.name;
  caption.extent = settings.extent == Extent::Quick ? "quick" : "full";
  caption.command = settings.command;
  caption.machine = machineText();
  caption.versions = settings.versions;
  return caption;
}

std::filesystem::path csvPath(const Study& study, const StudySettings& settings) {
  return settings.folder / (study.name + ".csv");
}

/// The rows of an earlier run, which must have the same properties.
std::vector<Row> finishedRows(const Table& table, const StudySettings& settings,
                              const Study& study) {
  const std::filesystem::path file = csvPath(study, settings);
  if (!settings.resume || !exists(file)) return {};
  const Table earlier = readCsv(file);
  if (earlier.caption.extent != table.caption.extent) {
    throw InputError(
        fmt::format("{}: error: this is a {} study, which a {} one cannot resume; use the same "
                    "options or another folder",
                    file.string(), earlier.caption.extent, table.caption.extent));
  }
  if (earlier.columns.size() == table.columns.size()) return earlier.rows;
  throw InputError(
      fmt::format("{}: error: {} columns, but this version's study has {}; remove `resume`",
                  file.string(), earlier.columns.size(), table.columns.size()));
}

// Runs a case and puts its name in front of each row: the first column of every table.
std::vector<Row> rowsOf(const StudyCase& studyCase) {
  std::vector<Row> rows = studyCase.run();
  for (Row& row : rows) row.insert(row.begin(), studyCase.name);
  return rows;
}

}  // namespace

std::string machineText() {
  utsname system{};
  uname(&system);
  return fmt::format("{}, {} cores, {} {}", processorName(), std::thread::hardware_concurrency(),
                     system.sysname, system.machine);
}

Table runStudy(const Study& study, const StudySettings& settings, const StudyObserver& observer) {
  makeFolder(settings.folder);
  Table table;
  table.caption = makeCaption(study, settings);
  table.columns.push_back({"case", "what the row is a result of"});
  table.columns.insert(table.columns.end(), study.columns.begin(), study.columns.end());
  const std::vector<Row> earlier = finishedRows(table, settings, study);
  const std::vector<StudyCase> cases = study.cases(settings.extent);
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const std::size_t before = table.rows.size();
    for (const Row& row : earlier) {
      if (row.front() == cases[k].name) table.rows.push_back(row);
    }
    // The earlier run had finished this case.
    if (table.rows.size() > before) continue;
    if (!observer(cases[k].name, k, cases.size())) return table;
    const std::vector<Row> rows = rowsOf(cases[k]);
    table.rows.insert(table.rows.end(), rows.begin(), rows.end());
    writeTextFile(csvPath(study, settings), csvText(table));
  }
  writeTextFile(csvPath(study, settings), csvText(table));
  writeTextFile(settings.folder / (study.name + ".json"), studyJson(study, table));
  return table;
}

// Cells stay text, as they are in the CSV.
std::string studyJson(const Study& study, const Table& table) {
  const Caption& caption = table.caption;
  Json json;
  json["study"] = study.name;
  json["about"] = study.help;
  json["caption"] = {{"extent", caption.extent},
                     {"command", caption.command},
                     {"machine", caption.machine},
                     {"versions", caption.versions}};
  json["columns"] = Json::array();
  for (const Column& column : table.columns) {
    json["columns"].push_back({{"name", column.name}, {"meaning", column.meaning}});
  }
  json["rows"] = table.rows;
  json["findings"] = Json::array();
  for (const Finding& finding : study.findings(table)) {
    Json entry{{"name", finding.name}, {"value", nullptr}, {"meaning", finding.meaning}};
    // JSON has no NaN: null replaces it.
    if (std::isfinite(finding.value)) entry["value"] = finding.value;
    json["findings"].push_back(std::move(entry));
  }
  return jsonText(json, 1) + "\n";
}

// ------------------------------------------------------------------------------------------------
// The list of all studies.

const std::vector<Study>& studies() {
  static const std::vector<Study> all{workPrecisionStudy(), movingStudy(),       scalingStudy(),
                                      tessellationStudy(),  squareToDiskStudy(), sensitivityStudy(),
                                      hardCasesStudy()};
  return all;
}

const Study& studyNamed(const std::string& name) {
  std::vector<std::string> names;
  for (const Study& study : studies()) {
    if (study.name == name) return study;
    names.push_back(study.name);
  }
  names.emplace_back("all");
  throw InputError(fmt::format("error: there is no study {}{}; choose {}", name,
                               suggestion(name, names), fmt::join(names, ", ")));
}

}  // namespace kirireel::study
