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

bool isOpen(const fs::path& finished, bool retryFailed) {
  const std::optional<RunRecord> record = readRunRecord(finished);
  return !record || (retryFailed && record->failed);
}

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

bool FileLock::isOf(const fs::path& file) const {
  struct stat held = {};
  struct stat named = {};
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
  const fs::path former = finished_.string() + ".old.part";
  std::error_code ignored;
  fs::remove_all(former, ignored);
  if (fs::exists(finished_)) putInPlace(finished_, former);
  putInPlace(folder_, finished_);
  fs::remove(finished_ / kLock, ignored);
  fs::remove_all(former, ignored);
}

}  // namespace kirireel
