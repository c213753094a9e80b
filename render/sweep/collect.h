/// The files of a sweep: one folder per run, one table and one page of all runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/picture/frame.h"
#include "render/picture/grid.h"

namespace kirireel::sweep {

// ------------------------------------------------------------------------------------------------
// Folders of a sweep's runs: OUT/runs/HASH, which exist only when finished.

/// A lock file for one process at a time, also across machines. It is released when its process
/// ends.
class FileLock {
 public:
  /// Action if another process holds the file.
  enum class IfHeld { Wait, GiveUp };

  /// Returns the lock, or null if another process holds it. Creates the file if needed. Throws
  /// OutputError if that fails. Wait blocks until the lock is free. Returns null if the file was
  /// moved meanwhile.
  static std::optional<FileLock> take(const std::filesystem::path& file, IfHeld ifHeld);

  /// Takes over the lock of the other.
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}
  /// False if the file was moved or removed during the wait.
  bool isOf(const std::filesystem::path& file) const;

  int descriptor_;
};

/// Outcome of a run.
struct RunRecord {
  bool failed = false;  ///< whether it ended with an error
  std::string reason;   ///< one line: reason of a failure; else empty
  std::vector<std::pair<std::string, std::string>> inputs;  ///< keys and values, in order
};

/// The record of a finished run, or null. Throws InputError for a damaged one.
std::optional<RunRecord> readRunRecord(const std::filesystem::path& runFolder);

/// Exclusive permission to make one run, until finish() or destruction. Without finish() there is
/// no finished run.
class RunClaim {
 public:
  /// Claims the run of that name in the folder of all runs, and makes an empty folder to work in.
  /// Null if another process makes it or it is finished. A failed run counts as finished unless
  /// `retryFailed`. Throws OutputError.
  static std::optional<RunClaim> take(const std::filesystem::path& runs, const std::string& name,
                                      bool retryFailed);

  /// Folder for the run's files: HASH.part next to the finished folder.
  const std::filesystem::path& folder() const { return folder_; }

  /// Removes the files of the run so far.
  void clear() const;

  /// Writes the record and renames the folder to its final name. Throws OutputError.
  void finish(const RunRecord& record);

 private:
  RunClaim(FileLock lock, std::filesystem::path folder, std::filesystem::path finished)
      : lock_(std::move(lock)), folder_(std::move(folder)), finished_(std::move(finished)) {}

  FileLock lock_;
  std::filesystem::path folder_;
  std::filesystem::path finished_;
};

// ------------------------------------------------------------------------------------------------
// All finished runs of a sweep as one table.

/// One column: its name, and a text for each row; "" for a missing value.
struct TableColumn {
  std::string name;                ///< in the table's first row
  std::vector<std::string> cells;  ///< one per row, from the top
};

/// All columns have equally many cells.
using SweepTable = std::vector<TableColumn>;

/// The runs of a sweep, in the order of the table.
struct SweepListing {
  std::filesystem::path runs;                                     ///< the folder of all runs
  std::uint64_t count = 0;                                        ///< of runs
  std::vector<std::string> keys;                                  ///< parameters that vary
  std::function<std::string(std::uint64_t)> name;                 ///< of a run and its folder
  std::function<std::vector<std::string>(std::uint64_t)> values;  ///< one for each key
};

/// One row of the table with the data for a picture of its end.
struct SweepRow {
  std::string name;                 ///< of the run
  std::vector<std::string> values;  ///< of the parameters that vary
  bool failed = false;              ///< true: no end state
  double thickness = 0;             ///< of its bricks, metres; 0 for a failed run
};

/// Existing results of a sweep. Missing runs are not in the tables.
struct Gathered {
  /// A row for each finished run: its name, its parameters, its outcome and its measures.
  /// Independent of time, place and order of the runs.
  SweepTable results;
  SweepTable
      costs;  ///< a row for each successful run: seconds and bytes, which vary between executions
  std::vector<SweepRow> runs;  ///< one for each row of the results
  std::uint64_t failed = 0;    ///< of these
  std::uint64_t missing = 0;   ///< not made yet, or in progress
};

/// Reads all finished runs. Throws InputError for damaged records. Reads one small file per run,
/// and another for each successful run.
Gathered gather(const SweepListing& listing);

/// A table as comma-separated UTF-8 text (RFC 4180), with the names in the first line. Lines end in
/// "\n".
std::string csvText(const SweepTable& table);

/// Writes a table as HDF5. Each column is an array of doubles, or of texts if a cell is not a
/// number. A missing number is NaN. The attribute "columns" has their order. The file appears when
/// it is complete. Throws OutputError.
void writeTableArrays(const SweepTable& table, const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------------
// The end states of a sweep on one page.

/// One finished run.
struct ContactPicture {
  std::filesystem::path vertices;   ///< tiles in the format of final_vertices.txt; empty: failed
  double thickness = 0;             ///< of its bricks, metres
  std::vector<std::string> values;  ///< of the parameters that vary
};

/// Maximum number of pictures on a page.
inline constexpr std::size_t kMaxContacts = 100;

/// Pictures on a page, row by row, and their positions.
struct ContactLayout {
  std::vector<std::size_t> chosen;  ///< indices of runs in the listing
  picture::GridShape shape;         ///< rows and columns of pictures
};

/// If pictures come in series of `series` (which differ only in the last parameter; 1: no series),
/// rows end with series: equal values are in one column. The page has about as many rows as
/// columns. If there are more than kMaxContacts pictures, series and pictures in each are sampled
/// evenly, including the first and the last. count: a multiple of series, > 0.
ContactLayout layOutContacts(std::size_t count, std::size_t series);

/// Pictures of end states with their parameters, each with its own scale; only the parameters for
/// failed runs. keys: names of the parameters. Throws InputError if there is no picture or a file
/// cannot be read, OutputError if painting fails. `pictures` in the order of the table; each has
/// one value per key. Paints up to 100 small pictures.
picture::Frame composeContactSheet(const std::vector<std::string>& keys,
                                   const std::vector<ContactPicture>& pictures);

// ------------------------------------------------------------------------------------------------
// Short captions that identify a run of a sweep.
//
// Digits are chosen for all captions of a page together, so a parameter has one format.

/// One caption per run, in their order: the names of the parameters and the run's values, "spring
/// stiffness 12.7, rows 4". Fractions have three significant digits, or more if values of a
/// parameter would otherwise be equal. `runs` has one value for each key in each row.
std::vector<std::string> captionsOf(const std::vector<std::string>& keys,
                                    const std::vector<std::vector<std::string>>& runs);

}  // namespace kirireel::sweep
