/// Studies: cases that add rows to a table, and their execution and storage.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/base/fields.h"

namespace kirireel::study {

// ------------------------------------------------------------------------------------------------
// A study's results: rows of cells under named columns, written to and read from CSV.

/// One column of a table.
struct Column {
  std::string name;     ///< short, with the unit: "gap_m"
  std::string meaning;  ///< one phrase
};

/// The cells of one row, in the order of the columns.
using Row = std::vector<std::string>;

/// Information that a reader needs to evaluate a table or to reproduce it.
struct Caption {
  std::string study;     ///< its name
  std::string extent;    ///< "quick" or "full"
  std::string command;   ///< command line
  std::string machine;   ///< processor, its cores, system
  std::string versions;  ///< of the program and of the engines compared

  bool operator==(const Caption&) const = default;
  static constexpr auto fields() {
    return describeFields<Caption>(
        field("study", &Caption::study), field("extent", &Caption::extent),
        field("command", &Caption::command), field("machine", &Caption::machine),
        field("versions", &Caption::versions));
  }
};

/// Rows under columns. The first column of every table is "case", the name of the row's case.
struct Table {
  Caption caption;              ///< describes the numbers
  std::vector<Column> columns;  ///< after the first, which is "case", in their order
  std::vector<Row> rows;        ///< one per result

  /// The index of the column with this name. Throws InputError if there is none.
  std::size_t columnIndex(const std::string& name) const;
  /// The text in a cell. Throws InputError if there is no such column.
  const std::string& text(const Row& row, const std::string& column) const;
  /// The number in a cell; NaN if the cell is empty or holds text.
  double number(const Row& row, const std::string& column) const;
  /// The largest number of a column in those rows of an engine; NaN if there is none.
  double largest(const std::string& column, const std::string& engine,
                 const std::function<bool(const Row&)>& holds) const;
};

/// A number with the digits of a table; empty if it is not finite.
std::string cell(double number);
/// A whole number with all its digits.
std::string cell(int number);
/// "yes" or "no".
std::string cell(bool flag);
/// The text with commas and line ends replaced, because they separate cells and rows.
std::string cell(std::string text);

/// The table as CSV: the caption as lines that start with '#', the names of the columns, the rows.
std::string csvText(const Table& table);

/// Reads the output of csvText(); it does not include the columns' meanings. Throws InputError for
/// a missing file, and for a row with too few or too many cells, with its line.
Table readCsv(const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------------
// A study: cases that run one after the other and add rows to a table.

/// Size of a study.
enum class Extent {
  Quick,  ///< fewer and smaller cases, all studies in minutes
  Full,   ///< all cases
};

/// One case. Its rows depend only on its name.
struct StudyCase {
  std::string name;                       ///< the first cell of its rows
  std::function<std::vector<Row>()> run;  ///< returns the cells after the first, at least one row
};

/// A figure that summarises a table.
struct Finding {
  std::string name;     ///< short: "exponent_planar"
  double value = 0;     ///< NaN if the table lacks the rows for it
  std::string meaning;  ///< one phrase, with the unit
};

/// One study.
struct Study {
  std::string name;             ///< as typed: "work-precision"
  std::string help;             ///< one phrase
  std::vector<Column> columns;  ///< after the first, which is "case"
  std::function<std::vector<StudyCase>(Extent)>
      cases;  ///< the cases of an extent, in the order of execution
  /// Depends only on the rows: a table that was read gives the same findings.
  std::function<std::vector<Finding>(const Table&)> findings;
};

/// All studies, in the order of `all`.
const std::vector<Study>& studies();

/// The study with this name. Throws InputError with the nearest name.
const Study& studyNamed(const std::string& name);

// The studies, one file each.
/// Error against CPU time.
Study workPrecisionStudy();
/// Precision in time of a sheet in motion.
Study movingStudy();
/// Growth of CPU time with the number of tiles.
Study scalingStudy();
/// Rotating squares against their exact motion.
Study tessellationStudy();
/// A square that becomes a disk, against its exact path.
Study squareToDiskStudy();
/// Effect of stiffness, damping and thickness on the decrease of the error.
Study sensitivityStudy();
/// Models that are hard to deploy.
Study hardCasesStudy();

// ------------------------------------------------------------------------------------------------
// Runs a study and stores its results in files.

/// Settings of a study's execution.
struct StudySettings {
  std::filesystem::path folder;  ///< receives NAME.csv and NAME.json; created if absent
  Extent extent = Extent::Full;  ///< size of the study
  bool resume = false;  ///< keep the rows that an earlier run of the same extent has finished
  std::string command;  ///< command line, for the caption
  /// Versions of the program, its libraries and the engines that are compared.
  std::string versions;
};

/// Called before each case; `done` of `total` are finished. Return false to stop.
using StudyObserver =
    std::function<bool(const std::string& caseName, std::size_t done, std::size_t total)>;

/// Runs the cases in order. The CSV file is written again after each case: an interrupted study
/// keeps its results. The JSON file, with the findings, is written at the end. Returns the table,
/// without the cases after a stop. Throws InputError if `resume` finds a file of another extent,
/// OutputError if a file cannot be written.
Table runStudy(const Study& study, const StudySettings& settings, const StudyObserver& observer);

/// The table with its findings and the meaning of its columns as JSON.
std::string studyJson(const Study& study, const Table& table);

/// "NAME, CORES cores, SYSTEM" for this machine.
std::string machineText();

// ------------------------------------------------------------------------------------------------
// Exponents from measured points.

/// A point for the fit.
struct PowerPoint {
  double x = 0;  ///< > 0
  double y = 0;  ///< > 0
};

/// The exponent b of y = a x^b by least squares of the logarithms; NaN for fewer than two different
/// x.
double fittedExponent(const std::vector<PowerPoint>& points);

}  // namespace kirireel::study
