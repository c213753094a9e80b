// Tables as CSV: lines of the caption that begin with '#', the columns' names, the rows. Cells hold
// no commas and no line ends, so that nothing needs quoting.
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

// Cells hold no commas, see cell().
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

// Lines that begin with '#' and name no part of the caption are skipped.
void readCaptionLine(const std::string& line, Caption& caption) {
  for (const auto& [name, value] : captionParts(caption)) {
    const std::string start = fmt::format("# {}: ", name);
    if (line.starts_with(start)) *value = line.substr(start.size());
  }
}

}  // namespace

// Throws InputError where the column is absent, as in a file of an earlier version.
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

// Not a number for empty cells and for text. strtod reads a point as the decimal sign as long as
// the program sets no other locale.
double Table::number(const Row& row, const std::string& column) const {
  const std::string& digits = text(row, column);
  char* end = nullptr;
  const double value = std::strtod(digits.c_str(), &end);
  const bool whole = !digits.empty() && *end == '\0';
  return whole ? value : std::numeric_limits<double>::quiet_NaN();
}

// Five significant digits; empty where there is no number. Times and errors are not known better.
std::string cell(double number) {
  return std::isfinite(number) ? fmt::format("{:.5g}", number) : "";
}

std::string cell(int number) {
  return fmt::format("{}", number);
}

std::string cell(bool flag) {
  return flag ? "yes" : "no";
}

// Commas and line ends would break the table, so that they are replaced.
std::string cell(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// The inverse of readCsv(), but for the columns' meanings, which the CSV does not hold.
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

// Throws InputError where the file cannot be read or a row has another number of cells than the
// table has columns.
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
