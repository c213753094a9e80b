/// Studies: cases that leave rows of a table, how they are run and kept.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace kirireel::study {

// ------------------------------------------------------------------------------------------------
// A study's results: rows of cells under named columns, as CSV and back.

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
  Caption caption;              ///< what the numbers are of
  std::vector<Column> columns;  ///< after the first, which is "case", in their order
  std::vector<Row> rows;        ///< one a result

  /// The place of the column of that name. Throws InputError if there is none.
  std::size_t columnIndex(const std::string& name) const;
  /// The text in a cell. Throws InputError where there is no such column.
  const std::string& text(const Row& row, const std::string& column) const;
  /// The number in a cell; not a number where the cell is empty or holds words.
  double number(const Row& row, const std::string& column) const;
};

/// A number with the digits that a table shows; empty for what is not finite.
std::string cell(double number);
/// A whole number with all its digits.
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

// ------------------------------------------------------------------------------------------------
// A study: cases that are run one after the other, each leaving rows of a table.

/// How much of a study is run.
enum class Extent {
  Quick,  ///< fewer and smaller cases, all studies in minutes
  Full,   ///< all of it
};

/// One case. Its rows follow from nothing but its name.
struct StudyCase {
  std::string name;                       ///< the first cell of its rows
  std::function<std::vector<Row>()> run;  ///< gives the cells after the first, at least one row
};

/// A figure that a table comes down to.
struct Finding {
  std::string name;     ///< short: "exponent_planar"
  double value = 0;     ///< not a number where the table lacks the rows for it
  std::string meaning;  ///< one phrase, with the unit
};

/// One study.
struct Study {
  std::string name;             ///< as typed: "work-precision"
  std::string help;             ///< one phrase
  std::vector<Column> columns;  ///< after the first, which is "case"
  std::function<std::vector<StudyCase>(Extent)>
      cases;  ///< the cases of an extent, in the order in which they are run
  /// Only from the rows: a table that was read gives the same.
  std::function<std::vector<Finding>(const Table&)> findings;
};

/// All studies, in the order in which `all` runs them.
const std::vector<Study>& studies();

/// The study of that name. Throws InputError that suggests the nearest.
const Study& studyNamed(const std::string& name);

// The studies, one file each.
/// Error against CPU time.
Study workPrecisionStudy();
/// Precision in time of a sheet in motion.
Study movingStudy();
/// How CPU time grows with the number of tiles.
Study scalingStudy();
/// Rotating squares against their exact motion.
Study tessellationStudy();
/// A square that becomes a disk, against its exact path.
Study squareToDiskStudy();
/// What stiffness, damping and thickness do to the way the error falls.
Study sensitivityStudy();
/// Models that are hard to deploy.
Study hardCasesStudy();

// ------------------------------------------------------------------------------------------------
// Runs a study and keeps its results in files.

/// How a study is run.
struct StudySettings {
  std::filesystem::path folder;  ///< gets NAME.csv and NAME.json; made when absent
  Extent extent = Extent::Full;  ///< how much of it
  bool resume = false;  ///< keep the rows that an earlier run of the same extent has finished
  std::string command;  ///< that was typed, for the caption
  /// Of the program, what it is made with and the engines that are compared.
  std::string versions;
};

/// Called before each case; `done` of `total` are finished. Return false to stop.
using StudyObserver =
    std::function<bool(const std::string& caseName, std::size_t done, std::size_t total)>;

/// Runs the cases in order. The CSV file is written again whenever a case is finished: an
/// interrupted study keeps what it has. The JSON file, with the findings, comes at the end.
/// Returns the table, which lacks the cases after a stop. Throws InputError when `resume` meets a
/// file of another extent, OutputError when a file cannot be written.
Table runStudy(const Study& study, const StudySettings& settings, const StudyObserver& observer);

/// The table with its findings and the meaning of its columns as JSON.
std::string studyJson(const Study& study, const Table& table);

/// "NAME, CORES cores, SYSTEM" of this machine.
std::string machineText();

// ------------------------------------------------------------------------------------------------
// Exponents from measured points.

/// A point to be fitted; both above 0.
struct PowerPoint {
  double x = 0;  ///< above 0
  double y = 0;  ///< above 0
};

/// The exponent b of y = a x^b by least squares of the logarithms; not a number for fewer than two
/// different x.
double fittedExponent(const std::vector<PowerPoint>& points);

}  // namespace kirireel::study
