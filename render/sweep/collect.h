/// All finished runs of a sweep as one table.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace kirireel {

/// One column: its name, and a text for each row; a figure that does not exist is "".
struct TableColumn {
  std::string name;
  std::vector<std::string> cells;
};

/// All columns have equally many cells.
using SweepTable = std::vector<TableColumn>;

/// The runs of a sweep, in the order of the table.
struct SweepListing {
  std::filesystem::path runs;     ///< the folder of all runs
  std::uint64_t count = 0;        ///< of runs
  std::vector<std::string> keys;  ///< parameters that vary
  std::function<std::string(std::uint64_t)> name;
  std::function<std::vector<std::string>(std::uint64_t)> values;  ///< one for each key
};

/// One row of the table, as far as a picture of its end needs it.
struct SweepRow {
  std::string name;
  std::vector<std::string> values;  ///< of the parameters that vary
  bool failed = false;              ///< then it has no end state
  double thickness = 0;             ///< of its bricks, metres; 0 when it failed
};

/// What there is of a sweep. What is missing is not in the tables.
struct Gathered {
  /// A row for each finished run: its name, its parameters, its outcome and its measures. Nothing
  /// in it depends on when, where or in which order the runs were made.
  SweepTable results;
  SweepTable costs;  ///< a row for each run that is done: seconds and bytes, which differ every time
  std::vector<SweepRow> runs;  ///< one for each row of the results
  std::uint64_t failed = 0;       ///< of these
  std::uint64_t missing = 0;      ///< not made yet, or in work
};

/// Reads all finished runs, one after the other. Throws InputError for damaged records. Reads one
/// small file a run, and another one for each run that is done.
Gathered gather(const SweepListing& listing);

/// A table as text with commas (RFC 4180), its first line the names. Lines end in "\n"; texts are
/// in UTF-8.
std::string csvText(const SweepTable& table);

/// Writes a table as HDF5, each column an array of doubles or, where a cell is no number, of texts;
/// a missing number is NaN. The attribute "columns" has their order. Throws OutputError. The file
/// appears when it is whole.
void writeTableArrays(const SweepTable& table, const std::filesystem::path& file);

}  // namespace kirireel
