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
// The folders that a sweep's runs are kept in: OUT/runs/HASH, there only when finished.

/// A lock file that one process at a time holds, also across machines. It is released when its
/// process ends.
class FileLock {
 public:
  /// What to do while another process holds the file.
  enum class IfHeld { Wait, GiveUp };

  /// Returns the lock, or null if another process holds it. Creates the file if needed. Throws
  /// OutputError if that fails. Wait blocks until the lock is free. It returns null if the file was
  /// moved meanwhile.
  static std::optional<FileLock> take(const std::filesystem::path& file, IfHeld ifHeld);

  /// Takes over the lock of the other.
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;
  ~FileLock();

 private:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}
  /// False when the file was moved or removed while we waited for it.
  bool isOf(const std::filesystem::path& file) const;

  int descriptor_;
};

/// How a run ended.
struct RunRecord {
  bool failed = false;  ///< whether it ended with an error
  std::string reason;   ///< one line why it failed; empty otherwise
  std::vector<std::pair<std::string, std::string>> inputs;  ///< keys and values, in order
};

/// The record of a finished run, or null. Throws InputError for a damaged one.
std::optional<RunRecord> readRunRecord(const std::filesystem::path& runFolder);

/// The right to make one run, until finish() or destruction. Without finish() there is no finished
/// run.
class RunClaim {
 public:
  /// Claims the run of that name in the folder of all runs, and makes an empty folder to work in.
  /// Null if another process makes it or it is finished. A failed run counts as finished unless
  /// `retryFailed`. Throws OutputError.
  static std::optional<RunClaim> take(const std::filesystem::path& runs, const std::string& name,
                                      bool retryFailed);

  /// Where to put the run's files: HASH.part next to the finished folder.
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

/// One column: its name, and a text for each row; a figure that does not exist is "".
struct TableColumn {
  std::string name;                ///< as the table's first row has it
  std::vector<std::string> cells;  ///< one a row, from the top
};

/// All columns have equally many cells.
using SweepTable = std::vector<TableColumn>;

/// The runs of a sweep, in the order of the table.
struct SweepListing {
  std::filesystem::path runs;                      ///< the folder of all runs
  std::uint64_t count = 0;                         ///< of runs
  std::vector<std::string> keys;                   ///< parameters that vary
  std::function<std::string(std::uint64_t)> name;  ///< of a run, which is its folder's too
  std::function<std::vector<std::string>(std::uint64_t)> values;  ///< one for each key
};

/// One row of the table, as far as a picture of its end needs it.
struct SweepRow {
  std::string name;                 ///< of the run
  std::vector<std::string> values;  ///< of the parameters that vary
  bool failed = false;              ///< then it has no end state
  double thickness = 0;             ///< of its bricks, metres; 0 when it failed
};

/// What there is of a sweep. What is missing is not in the tables.
struct Gathered {
  /// A row for each finished run: its name, its parameters, its outcome and its measures. Nothing
  /// in it depends on when, where or in which order the runs were made.
  SweepTable results;
  SweepTable
      costs;  ///< a row for each run that is done: seconds and bytes, which differ every time
  std::vector<SweepRow> runs;  ///< one for each row of the results
  std::uint64_t failed = 0;    ///< of these
  std::uint64_t missing = 0;   ///< not made yet, or in work
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

// ------------------------------------------------------------------------------------------------
// The end states of a sweep on one page.

/// One finished run.
struct ContactPicture {
  std::filesystem::path vertices;   ///< tiles as final_vertices.txt has them; empty: it failed
  double thickness = 0;             ///< of its bricks, metres
  std::vector<std::string> values;  ///< of the parameters that vary
};

/// Most pictures on a page.
inline constexpr std::size_t kMostContacts = 100;

/// Which pictures are on a page, row by row, and their places.
struct ContactLayout {
  std::vector<std::size_t> chosen;  ///< runs, by their place in the listing
  picture::GridShape shape;         ///< rows and columns of pictures
};

/// If pictures come in series of `series` (those that differ only in the last parameter; 1 for
/// none), rows end where series do: equal values are in one column. The page is about
/// as many pictures high as wide. Of more than kMostContacts pictures every so many series are
/// shown, and of them every so many pictures, the first and the last among them. count: a multiple
/// of series, positive.
ContactLayout layOutContacts(std::size_t count, std::size_t series);

/// Pictures of end states with their parameters, each in its own scale; nothing but the parameters
/// for runs that failed. keys: names of the parameters. Throws InputError when there is no picture
/// or a file cannot be read, OutputError when nothing can be painted. `pictures` in the order of
/// the table; each has as many values as there are keys. Paints up to 100 small pictures.
picture::Frame composeContactSheet(const std::vector<std::string>& keys,
                                   const std::vector<ContactPicture>& pictures);

// ------------------------------------------------------------------------------------------------
// Short captions that identify a run of a sweep.
//
// Digits are chosen for all captions of a page together: one parameter looks alike on all.

/// One caption for each run: the names of the parameters and the run's values, "spring stiffness
/// 12.7, rows 4". Fractions have three significant digits, more where the values of a parameter
/// would be alike otherwise. `runs` has one value for each key in each row. Returns as many
/// captions as there are runs, in their order.
std::vector<std::string> captionsOf(const std::vector<std::string>& keys,
                                    const std::vector<std::vector<std::string>>& runs);

}  // namespace kirireel::sweep
