// A record has its own seal: its last key is the SHA-256 (FIPS 180-4) of the text without that key.
//
//     {                                   {
//       "a": 1            sealed()          "a": 1,
//     }                    ---->            "sha256": "<hash of the text on the left>"
//                                         }
//
// A reader can therefore detect any modified byte. It is not a signature: anyone who modifies the
// text on purpose can compute the hash again.
#include "render/output/output_folder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <unistd.h>

#include "sim/base/error.h"

namespace kirireel::output {
namespace {

constexpr const char* kEnd = "\n}\n";

/// Always of equal length, as isSealed() requires.
std::string sealOf(const std::string& json) {
  return fmt::format(",\n  \"sha256\": \"{}\"{}", sha256(json), kEnd);
}

}  // namespace

FileDigest digestOf(const std::filesystem::path& folder, const std::string& name) {
  std::ifstream file = openInputFile(folder / name);
  FileDigest digest{name, 0, ""};
  Sha256 hash;
  std::array<char, 1 << 16> bytes{};
  // Piece by piece, since videos and trajectories may be larger than memory. The last piece sets
  // eof.
  while (file.read(bytes.data(), bytes.size()), file.gcount() > 0) {
    hash.add({bytes.data(), static_cast<std::size_t>(file.gcount())});
    digest.bytes += static_cast<std::uintmax_t>(file.gcount());
  }
  if (!file.eof() || file.bad()) {
    throw InputError(fmt::format(
        "{}: error: the file cannot be read; check that it exists and that you may read it",
        (folder / name).string()));
  }
  digest.sha256 = hash.finish();
  return digest;
}

std::string sealed(const std::string& json) {
  return json.substr(0, json.size() - std::string(kEnd).size()) + sealOf(json);
}

bool isSealed(const std::string& text) {
  // Removes the seal, computes it again and compares.
  const std::size_t sealSize = sealOf("").size();
  if (text.size() < sealSize) return false;
  const std::string json = text.substr(0, text.size() - sealSize) + kEnd;
  return text == sealed(json);
}

// ------------------------------------------------------------------------------------------------
// All file names of a run, for writing, for the check of files in the way, and for programs that
// read a run's folder. Numbers have leading zeros, so names sort in order.

namespace fs = std::filesystem;

fs::path frameFile(int number) {
  return fs::path(kFrames) / fmt::format("frame_{:05}.png", number);
}

fs::path snapshotDrawing(int number) {
  return fmt::format("snapshot_{:02}.svg", number);
}

std::string momentFile(const char* name, int number, const char* ending) {
  return fmt::format("{}_{:04}{}", name, number, ending);
}

FolderLock::FolderLock(const fs::path& folder)
    : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  // flock(2) on the folder itself: the kernel releases it when the process ends. Errors other than
  // a held lock mean that the file system has no locks.
  if (file_ < 0 || ::flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(file_);
  throw OutputError(
      fmt::format("{}: error: another run is writing into this folder; wait for its end, or choose "
                  "another with --out",
                  folder.string()));
}

FolderLock::~FolderLock() {
  if (file_ >= 0) ::close(file_);
}

bool isNumbered(const std::string& name, const std::function<std::string(int)>& nameOf) {
  // The first digits are the number. The name for that number must equal this name, including
  // leading zeros.
  const std::size_t digits = std::min(name.find_first_of("0123456789"), name.size());
  int number = 0;
  const auto [end, error] =
      std::from_chars(name.data() + digits, name.data() + name.size(), number);
  return error == std::errc() && nameOf(number) == name;
}

// ------------------------------------------------------------------------------------------------
// A record (summary.json, contents.json) lists files as
//
//     "contents": { "NAME": { "bytes": SIZE, "sha256": "64 digits" }, ... }
//
// with names relative to its folder. A file is ours if its size and hash are those in a sealed
// record. The size is compared first, since it needs no reading. Names outside the folder are
// ignored: a forged record cannot cause the removal of files elsewhere.

namespace {

/// The text of a record; "" if it cannot be read.
std::string sealedText(const fs::path& record) {
  std::error_code ignored;
  if (!isFile(record)) return "";
  try {
    const std::string text = readTextFile(record, "");
    return isSealed(text) ? text : "";
  } catch (const InputError&) {
    return "";
  }
}

/// Includes dangling links, for which exists() is false.
bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(fs::symlink_status(path, ignored));
}

/// Whether a folder between the two is a link. Files beyond it are not ours.
bool leadsThroughLink(const fs::path& folder, const fs::path& name) {
  std::error_code ignored;
  fs::path place = folder;
  for (const fs::path& part : name.parent_path()) {
    place /= part;
    if (fs::is_symlink(place, ignored)) return true;
  }
  return false;
}

}  // namespace

FileList listedFiles(const fs::path& record) {
  FileList files;
  const Json json = parseJsonOrDiscard(sealedText(record));
  try {
    if (!json.is_object()) return {};
    for (const auto& [name, noted] : json.at("contents").items()) {
      if (!staysInside(name)) continue;
      files[name] = {name, noted.at("bytes").get<std::uintmax_t>(),
                     noted.at("sha256").get<std::string>()};
    }
  } catch (const Json::exception&) {
    return {};  // sealed, but not a record of ours
  }
  return files;
}

std::string contentsText(const FileList& files) {
  Json contents = Json::object();
  for (const auto& [name, file] : files) {
    contents[name] = {{"bytes", file.bytes}, {"sha256", file.sha256}};
  }
  return sealed(jsonText(Json{{"contents", contents}}, 2) + "\n");
}

RecordedFiles::RecordedFiles(fs::path folder) : folder_(std::move(folder)) {
  // merge() keeps existing entries, so contents.json has priority.
  for (const char* record : {kContents, kSummary}) {
    const std::string text = sealedText(folder_ / record);
    if (text.empty()) continue;
    files_.merge(listedFiles(folder_ / record));
    // The records themselves are also ours.
    files_[record] = {record, text.size(), sha256(text)};
  }
}

bool RecordedFiles::isForeign(const std::string& name) const {
  return isThere(folder_ / name) && !isUnchanged(name);
}

bool RecordedFiles::isUnchanged(const std::string& name) const {
  const auto noted = files_.find(name);
  return noted != files_.end() && !leadsThroughLink(folder_, name) &&
         difference(folder_, noted->second).empty();
}

bool staysInside(const fs::path& name) {
  return !name.empty() && name.is_relative() &&
         std::none_of(name.begin(), name.end(), [](const fs::path& part) { return part == ".."; });
}

std::string difference(const fs::path& folder, const FileDigest& noted) {
  if (!staysInside(noted.name)) return "this is not the name of a file in the folder";
  std::error_code ignored;
  if (!isFile(folder / noted.name)) return "the file is missing";
  const std::uintmax_t bytes = fs::file_size(folder / noted.name, ignored);
  if (bytes != noted.bytes)
    return fmt::format("{} bytes, but the run wrote {}", bytes, noted.bytes);
  try {
    if (digestOf(folder, noted.name).sha256 == noted.sha256) return "";
  } catch (const InputError&) {
    return "the file cannot be read";
  }
  return "other bytes than the run wrote";
}

// ------------------------------------------------------------------------------------------------
// Updates several files at once on a file system that can rename only one file atomically
// (rename(2)):
//
// - 1. Lock the folder and make `.unfinished` within it, marked by a text file of ours. A folder
//   with that name without the mark is never emptied.
// - 2. If it has a complete record, a program was killed during its moves: complete the moves.
// - 3. Write new files to `.unfinished`.
// - 4. Write the sealed record (summary.json or contents.json) there. From now on the new files are
//   valid.
// - 5. Rename each listed file into place, remove stale files, rename the record last.
//
// A kill before step 4 leaves the old run complete. A kill after it leaves a record in
// `.unfinished` that names all files. moveAll() skips files that are no longer there.
//
// Files that Kirireel did not write are never changed. If a file in the way differs from an earlier
// record in any byte (output_folder.h), the run is refused before anything moves.

namespace {

/// Distinguishes our hidden folder from others with the same name.
constexpr const char* kMark = "kirireel.txt";
constexpr const char* kMarkText =
    "Kirireel works here. It moves whole files out of this folder and removes all others.\n";

/// Maximum number of files in a message.
constexpr std::size_t kMaxNamed = 3;

[[noreturn]] void refuse(const fs::path& folder, const std::vector<std::string>& foreign) {
  const std::size_t named = std::min(kMaxNamed, foreign.size());
  const std::vector<std::string> names(foreign.begin(),
                                       foreign.begin() + static_cast<std::ptrdiff_t>(named));
  const std::size_t others = foreign.size() - named;
  throw InputError(
      fmt::format("{}: error: {}{} would be overwritten, but no earlier run wrote {} in this form; "
                  "move {} away, or choose another folder with --out",
                  folder.string(), fmt::join(names, ", "),
                  others == 0 ? "" : fmt::format(" and {} more", others),
                  foreign.size() == 1 ? "it" : "them", foreign.size() == 1 ? "it" : "them"));
}

/// Both are in one file system, since the stage is inside the folder.
void moveIntoPlace(const fs::path& from, const fs::path& to) {
  if (to.has_parent_path()) makeFolder(to.parent_path());
  moveFile(from, to);
}

bool isMarked(const fs::path& stage) {
  std::error_code ignored;
  return fs::is_regular_file(fs::symlink_status(stage / kMark, ignored)) &&
         readTextFile(stage / kMark, "") == kMarkText;
}

/// A real folder and not a link; empty, or with our mark.
bool isOurs(const fs::path& stage) {
  std::error_code ignored;
  return fs::is_directory(fs::symlink_status(stage, ignored)) &&
         (fs::is_empty(stage, ignored) || isMarked(stage));
}

/// If the mark cannot be written (full disk), no empty folder remains.
void makeStage(const fs::path& folder, const fs::path& stage) {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(stage, ignored)) && !isOurs(stage)) {
    refuse(folder, {kUnfinished});
  }
  makeFolder(stage);
  try {
    if (!isMarked(stage)) writeTextFile(stage / kMark, kMarkText);
  } catch (const OutputError&) {
    fs::remove(stage, ignored);
    throw;
  }
}

/// Removes a folder and its parents up to `folder` if they are empty.
void removeEmpty(const fs::path& folder, const fs::path& name) {
  std::error_code ignored;
  for (fs::path part = name; !part.empty(); part = part.parent_path()) {
    if (!fs::remove(folder / part, ignored)) return;
  }
}

/// Keeps the checkpoint, which stores its owner. Errors are ignored, because this runs in a
/// destructor and the next set tries again.
void clearStage(const fs::path& stage) {
  std::error_code ignored;
  if (!isOurs(stage)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(stage, ignored)) {
    const fs::path name = entry.path().filename();
    if (name != kCheckpoint && name != kMark) fs::remove_all(entry.path(), ignored);
  }
  if (isPresent(stage / kCheckpoint)) return;
  fs::remove(stage / kMark, ignored);
  fs::remove(stage, ignored);
}

/// Removes files of earlier runs that the new record does not list.
void removeStale(const fs::path& folder, const RecordedFiles& left, const FileList& files) {
  for (const auto& [name, digest] : left.files()) {
    if (files.contains(name) || name == kSummary || !left.isUnchanged(name)) continue;
    std::error_code error;
    fs::remove(folder / name, error);
    if (error) {
      throw OutputError(fmt::format("{}: error: an earlier run's file cannot be removed ({})",
                                    (folder / name).string(), error.message()));
    }
    removeEmpty(folder, fs::path(name).parent_path());
  }
}

/// Moves all files in a complete record of the stage, and the record last.
void moveAll(const fs::path& folder, const fs::path& stage, const char* record) {
  const RecordedFiles left(folder);
  const FileList files = listedFiles(stage / record);
  std::vector<std::string> foreign;
  if (left.isForeign(record)) foreign.emplace_back(record);
  for (const auto& [name, digest] : files) {
    if (isPresent(stage / name) && left.isForeign(name)) foreign.push_back(name);
  }
  if (!foreign.empty()) refuse(folder, foreign);
  for (const auto& [name, digest] : files) {
    if (isPresent(stage / name)) moveIntoPlace(stage / name, folder / name);
  }
  // Only a run replaces all earlier files; exports add to them.
  if (record == std::string(kSummary)) removeStale(folder, left, files);
  moveIntoPlace(stage / record, folder / record);
}

/// The folders of a path that do not exist, the innermost first.
std::vector<fs::path> missingFolders(fs::path folder) {
  std::vector<fs::path> missing;
  for (; !folder.empty() && !isPresent(folder); folder = folder.parent_path()) {
    missing.push_back(folder);
  }
  return missing;
}

}  // namespace

FileSet::FileSet(fs::path folder, const char* record)
    : folder_(folder.empty() ? fs::path(".") : std::move(folder)),
      made_(missingFolders(folder_)),
      stage_(folder_ / kUnfinished),
      record_(record),
      lock_((makeFolder(folder_), folder_)) {
  requireWritableFolder(folder_);
  makeStage(folder_, stage_);
  for (const char* whole : {kSummary, kContents}) {
    if (!listedFiles(stage_ / whole).empty()) moveAll(folder_, stage_, whole);
  }
  clearStage(stage_);
  makeStage(folder_, stage_);
}

FileSet::~FileSet() {
  // A complete set whose moves failed stays for another attempt, since some files may have been
  // moved.
  const bool isWhole = !listedFiles(stage_ / record_).empty();
  if (!isWhole) clearStage(stage_);
  // Removes only empty folders. Without any file, a run leaves nothing.
  std::error_code ignored;
  for (const fs::path& folder : made_) fs::remove(folder, ignored);
}

void FileSet::dropCheckpoint() const {
  std::error_code ignored;
  fs::remove_all(stage_ / kCheckpoint, ignored);
}

void FileSet::requireFree(const std::function<bool(const std::string&)>& isRequested) const {
  const RecordedFiles left(folder_);
  std::vector<std::string> foreign;
  const auto check = [&](const std::string& name, bool isFolder) {
    const bool isTaken = (name == record_ || isRequested(name)) && left.isForeign(name);
    if (isTaken || (isRequested(name + '/') && !isFolder)) foreign.push_back(name);
  };
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool isFolder = !entry.is_symlink(ignored) && entry.is_directory(ignored);
    // Links count as files: their targets are not ours.
    check(name, isFolder);
    if (!isFolder || name == kUnfinished) continue;
    for (const fs::directory_entry& inner : fs::directory_iterator(entry.path(), ignored)) {
      check(name + '/' + inner.path().filename().string(), false);
    }
  }
  std::sort(foreign.begin(), foreign.end());
  if (!foreign.empty()) refuse(folder_, foreign);
}

void FileSet::requireFree(const std::vector<std::string>& names) const {
  requireFree(
      [&names](const std::string& name) { return std::ranges::find(names, name) != names.end(); });
}

void FileSet::commit(const std::string& recordText) {
  writeTextFile(stage_ / record_, recordText);
  moveAll(folder_, stage_, record_);
}

void FileSet::commit(const std::vector<std::string>& names) {
  FileList files;
  const RecordedFiles left(folder_);
  // Unmodified files of earlier exports stay in the list.
  for (const auto& [name, digest] : listedFiles(folder_ / record_)) {
    if (left.isUnchanged(name)) files[name] = digest;
  }
  for (const std::string& name : names) files[name] = digestOf(stage_, name);
  commit(contentsText(files));
}

}  // namespace kirireel::output
