/// The folders that a sweep's runs are kept in: OUT/runs/HASH, there only when finished.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kirireel {

/// A file that one process at a time holds, whichever machine it runs on; let go when its process
/// ends, however it ends.
class FileLock {
 public:
  enum class IfHeld { Wait, GiveUp };

  /// The lock, or nothing when another process holds it. The file is made if need be. Throws
  /// OutputError when it cannot be. With Wait it blocks until the lock is free; it is nothing all
  /// the same when the file was moved away meanwhile.
  static std::optional<FileLock> take(const std::filesystem::path& file, IfHeld ifHeld);

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
  bool failed = false;
  std::string reason;  ///< one line why it failed; empty otherwise
  std::vector<std::pair<std::string, std::string>> inputs;  ///< keys and values, in order
};

/// The record of a finished run; nothing when there is none. Throws InputError for a damaged one.
std::optional<RunRecord> readRunRecord(const std::filesystem::path& runFolder);

/// The right to make one run, until it is finished or dropped. What is dropped leaves no finished
/// run.
class RunClaim {
 public:
  /// Claims the run of that name in the folder of all runs, and makes an empty folder to work in.
  /// Nothing when another process is at it or it is finished; a failed run counts as finished
  /// unless it is to be retried. Throws OutputError.
  static std::optional<RunClaim> take(const std::filesystem::path& runs, const std::string& name,
                                      bool retryFailed);

  /// Where to put the run's files: HASH.part beside the finished folder.
  const std::filesystem::path& folder() const { return folder_; }

  /// Removes the files of the run so far.
  void clear() const;

  /// Writes the record and puts the folder in place, whole. Throws OutputError.
  void finish(const RunRecord& record);

 private:
  RunClaim(FileLock lock, std::filesystem::path folder, std::filesystem::path finished)
      : lock_(std::move(lock)), folder_(std::move(folder)), finished_(std::move(finished)) {}

  FileLock lock_;
  std::filesystem::path folder_;
  std::filesystem::path finished_;
};

}  // namespace kirireel
