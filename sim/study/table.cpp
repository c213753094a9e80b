#include "sim/study/table.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/input_file.h"

namespace kirireel {
namespace {

/// The caption's parts under the names that they have in a file.
template <typename CaptionType>
auto captionParts(CaptionType& caption) {
  struct Part {
    const char* name;
    decltype(&caption.study) value;
  };
  return std::vector<Part>{{"study", &caption.study},
                           {"extent", &caption.extent},
                           {"command", &caption.command},
                           {"machine", &caption.machine},
                           {"versions", &caption.versions}};
}

Row splitCells(const std::string& line) {
  Row cells(1);
  for (const char letter : line) {
    if (letter == ',') {
      cells.emplace_back();
    } else {
      cells.back() += letter;
    }
  }
  return cells;
}

void readCaptionLine(const std::string& line, Caption& caption) {
  for (const auto& [name, value] : captionParts(caption)) {
    const std::string start = fmt::format("# {}: ", name);
    if (line.starts_with(start)) *value = line.substr(start.size());
  }
}

}  // namespace

std::size_t Table::columnIndex(const std::string& name) const {
  const auto found = std::find_if(columns.begin(), columns.end(),
                                  [&](const Column& column) { return column.name == name; });
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

double Table::number(const Row& row, const std::string& column) const {
  const std::string& digits = text(row, column);
  char* end = nullptr;
  const double value = std::strtod(digits.c_str(), &end);
  const bool whole = !digits.empty() && *end == '\0';
  return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

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
  for (const auto& [name, value] : captionParts(table.caption)) {
    text += fmt::format("# {}: {}\n", name, *value);
  }
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

}  // namespace kirireel
