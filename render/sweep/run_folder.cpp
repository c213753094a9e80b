// A run is made in OUT/runs/HASH.part and renamed to OUT/runs/HASH when it is whole. rename(2) is
// atomic within a file system, so a finished folder is either there with all its files or not at
// all.
//
// Who makes a run holds an advisory lock (flock(2)) on HASH.part/lock. The kernel drops it when the
// process ends in whatever way, so no stale lock has to be guessed by its age. On NFS Linux turns
// flock into locks of the server, which holds across machines.
//
// The order in take() matters. Between the first look and the lock another process may finish the
// run: it renames the folder, with the lock in it. So after locking, isOf() checks that the locked
// file still is the one that the name leads to, and the finished folder is looked for again.
#include "render/sweep/run_folder.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "sim/base/error.h"
#include "sim/base/input_file.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kRecord = "run.json";
constexpr const char* kLock = "lock";

/// The folder that it replaces must not exist, or be empty (rename(2)).
void putInPlace(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (!error) return;
  throw OutputError(
      fmt::format("{}: error: cannot be put in place ({})", to.string(), error.message()));
}

/// Empties a folder but for its lock: what a killed run has left.
void removeLeftovers(const fs::path& folder) {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename() != kLock) fs::remove_all(entry.path());
  }
}

/// Whether a run is still to be made.
bool isOpen(const fs::path& finished, bool retryFailed) {
  const std::optional<RunRecord> record = readRunRecord(finished);
  return !record || (retryFailed && record->failed);
}

/// An object with the keys status ("done" or "failed"), reason and inputs.
std::string recordText(const RunRecord& record) {
  Json inputs = Json::object();
  for (const auto& [key, value] : record.inputs) inputs[key] = value;
  const Json json = {
      {"status", record.failed ? "failed" : "done"}, {"reason", record.reason}, {"inputs", inputs}};
  // A reason may name a file whose name is not UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::optional<FileLock> FileLock::take(const fs::path& file, IfHeld ifHeld) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  // The folder may just have been put in place by the one who held the lock.
  if (descriptor < 0 && errno == ENOENT && ifHeld == IfHeld::GiveUp) return std::nullopt;
  if (descriptor < 0) {
    throw OutputError(
        fmt::format("{}: error: cannot be made ({}); choose another folder with --out",
                    file.string(), std::strerror(errno)));
  }
  // From here on the descriptor is closed whatever happens.
  FileLock lock(descriptor);
  const int patience = ifHeld == IfHeld::GiveUp ? LOCK_NB : 0;
  int result = 0;
  do {
    result = ::flock(descriptor, LOCK_EX | patience);
  } while (result != 0 && errno == EINTR);
  if (result == 0) return lock.isOf(file) ? std::optional(std::move(lock)) : std::nullopt;
  if (errno == EWOULDBLOCK) return std::nullopt;
  throw OutputError(
      fmt::format("{}: error: cannot be locked ({}); choose a folder on another disk "
                  "with --out",
                  file.string(), std::strerror(errno)));
}

/// A file that was renamed keeps its inode, and the name then leads elsewhere or nowhere.
bool FileLock::isOf(const fs::path& file) const {
  struct stat held = {};
  struct stat named = {};
  // The same device and inode: the same file.
  return ::fstat(descriptor_, &held) == 0 && ::stat(file.c_str(), &named) == 0 &&
         held.st_dev == named.st_dev && held.st_ino == named.st_ino;
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock::~FileLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::optional<RunRecord> readRunRecord(const fs::path& runFolder) {
  const fs::path file = runFolder / kRecord;
  std::ifstream stream = openInputFile(file);
  if (!stream) return std::nullopt;
  try {
    const Json json = Json::parse(stream);
    RunRecord record{json.at("status") == "failed", json.at("reason"), {}};
    for (const auto& [key, value] : json.at("inputs").items()) {
      record.inputs.emplace_back(key, value);
    }
    return record;
  } catch (const Json::exception&) {
    throw inputErrorAt({file}, "this is no run's record; remove its folder to run it again");
  }
}

std::optional<RunClaim> RunClaim::take(const fs::path& runs, const std::string& name,
                                       bool retryFailed) {
  const fs::path finished = runs / name;
  if (!isOpen(finished, retryFailed)) return std::nullopt;
  const fs::path folder = runs / (name + ".part");
  makeFolder(folder);
  std::optional<FileLock> lock = FileLock::take(folder / kLock, FileLock::IfHeld::GiveUp);
  if (!lock) return std::nullopt;
  // It may have been finished by another since the first look; then this folder is ours alone.
  if (!isOpen(finished, retryFailed)) {
    fs::remove_all(folder);
    return std::nullopt;
  }
  removeLeftovers(folder);
  return RunClaim(std::move(*lock), folder, finished);
}

void RunClaim::clear() const {
  removeLeftovers(folder_);
}

void RunClaim::finish(const RunRecord& record) {
  writeTextFile(folder_ / kRecord, recordText(record));
  // A failed run that is made again has a folder already. It is moved aside first and removed last,
  // so that one of the two is always there.
  const fs::path former = finished_.string() + ".old.part";
  std::error_code ignored;
  fs::remove_all(former, ignored);
  if (fs::exists(finished_)) putInPlace(finished_, former);
  putInPlace(folder_, finished_);
  fs::remove(finished_ / kLock, ignored);
  fs::remove_all(former, ignored);
}

}  // namespace kirireel
