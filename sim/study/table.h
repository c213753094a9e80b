/// A study's results: rows of cells under named columns, as CSV and back.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kirireel {

/// One column of a table.
struct Column {
  std::string name;     ///< short, with the unit: "gap_m"
  std::string meaning;  ///< one phrase
};

/// The cells of one row, in the order of the columns.
using Row = std::vector<std::string>;

/// What a reader must know to judge a table or to make it again.
struct Caption {
  std::string study;     ///< its name
  std::string extent;    ///< "quick" or "full"
  std::string command;   ///< that was typed
  std::string machine;   ///< processor, its cores, system
  std::string versions;  ///< of the program and of the engines compared

  bool operator==(const Caption&) const = default;
};

/// Rows under columns. The first column of every table is "case": what the row is a result of.
struct Table {
  Caption caption;
  std::vector<Column> columns;
  std::vector<Row> rows;

  /// The place of the column of that name. Throws InputError when there is none.
  std::size_t columnIndex(const std::string& name) const;
  const std::string& text(const Row& row, const std::string& column) const;
  /// The number in a cell; not a number where the cell is empty or holds words.
  double number(const Row& row, const std::string& column) const;
};

/// A number with the digits that a table shows; empty for what is not finite.
std::string cell(double number);
std::string cell(int number);
/// "yes" or "no".
std::string cell(bool flag);
/// A text as it is, but for commas and line ends, which separate cells and rows.
std::string cell(std::string text);

/// The table as CSV: the caption as lines that start with '#', the names of the columns, the rows.
std::string csvText(const Table& table);

/// Reads what csvText wrote; the columns' meanings are not in it. Throws InputError for a file that
/// is missing, and for a row with too few or too many cells, with its line.
Table readCsv(const std::filesystem::path& file);

}  // namespace kirireel
