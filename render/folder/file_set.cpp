// How files come into a folder all at once, on a file system that can rename one file atomically
// but not several (rename(2)):
//
// - 1. The folder is locked. `.unfinished` is made within it, marked by a text of ours, so that a
//   folder of that name which somebody else has made is never emptied.
// - 2. If a whole record lies there, a program was killed while it moved files: the moves are
//   finished.
// - 3. New files are written into `.unfinished`.
// - 4. The record (summary.json or contents.json) is written there, sealed. This is the moment at
//   which the new files count.
// - 5. Each listed file is renamed into place, stale files are removed, the record is renamed last.
//
// A kill before 4 leaves the old run whole. A kill after it leaves a record in `.unfinished`, which
// still names all files: those that have been moved are no longer there, and moveAll() skips them.
//
// Files of others are never touched: what stands in a place and is not, to the byte, what an
// earlier record lists (left_files.h), is refused before anything moves.
#include "render/folder/file_set.h"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/folder/left_files.h"
#include "sim/base/error.h"
#include "sim/base/input_file.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

/// Tells our hidden folder from anybody else's of that name.
constexpr const char* kMark = "kirireel.txt";
constexpr const char* kMarkText =
    "Kirireel works here. It moves whole files out of this folder and removes all others.\n";

/// So many files are named in a message.
constexpr std::size_t kMostNamed = 3;

[[noreturn]] void refuse(const fs::path& folder, const std::vector<std::string>& foreign) {
  const std::size_t named = std::min(kMostNamed, foreign.size());
  const std::vector<std::string> names(foreign.begin(),
                                       foreign.begin() + static_cast<std::ptrdiff_t>(named));
  const std::size_t others = foreign.size() - named;
  throw InputError(fmt::format(
      "{}: error: {}{} would be overwritten, but no earlier run left {} so; move {} away, or "
      "choose another folder with --out",
      folder.string(), fmt::join(names, ", "),
      others == 0 ? "" : fmt::format(" and {} more", others), foreign.size() == 1 ? "it" : "them",
      foreign.size() == 1 ? "it" : "them"));
}

/// Within one file system, since the stage lies within the folder.
void moveFile(const fs::path& from, const fs::path& to) {
  if (to.has_parent_path()) makeFolder(to.parent_path());
  std::error_code error;
  fs::rename(from, to, error);
  if (!error) return;
  throw OutputError(
      fmt::format("{}: error: cannot be put in place ({})", to.string(), error.message()));
}

bool isMarked(const fs::path& stage) {
  std::error_code ignored;
  return fs::is_regular_file(fs::symlink_status(stage / kMark, ignored)) &&
         readTextFile(stage / kMark, "") == kMarkText;
}

/// A real folder and no link to one; empty, or with our mark.
bool isOurs(const fs::path& stage) {
  std::error_code ignored;
  return fs::is_directory(fs::symlink_status(stage, ignored)) &&
         (fs::is_empty(stage, ignored) || isMarked(stage));
}

/// Where the mark cannot be written (a full disk), no empty folder stays behind.
void makeStage(const fs::path& folder, const fs::path& stage) {
  std::error_code ignored;
  if (fs::exists(fs::symlink_status(stage, ignored)) && !isOurs(stage)) {
    refuse(folder, {output::kUnfinished});
  }
  makeFolder(stage);
  try {
    if (!isMarked(stage)) writeTextFile(stage / kMark, kMarkText);
  } catch (const OutputError&) {
    fs::remove(stage, ignored);
    throw;
  }
}

/// Removes a folder and those above it up to `folder` as far as they are empty.
void removeEmpty(const fs::path& folder, const fs::path& name) {
  std::error_code ignored;
  for (fs::path part = name; !part.empty(); part = part.parent_path()) {
    if (!fs::remove(folder / part, ignored)) return;
  }
}

/// Keeps the checkpoint, which knows itself whose it is. Errors are ignored: it runs in a
/// destructor, and the next set tries again.
void clearStage(const fs::path& stage) {
  std::error_code ignored;
  if (!isOurs(stage)) return;
  for (const fs::directory_entry& entry : fs::directory_iterator(stage, ignored)) {
    const fs::path name = entry.path().filename();
    if (name != output::kCheckpoint && name != kMark) fs::remove_all(entry.path(), ignored);
  }
  if (fs::exists(stage / output::kCheckpoint)) return;
  fs::remove(stage / kMark, ignored);
  fs::remove(stage, ignored);
}

/// What earlier runs left and the new one does not list.
void removeStale(const fs::path& folder, const LeftFiles& left, const FileList& files) {
  for (const auto& [name, digest] : left.files()) {
    if (files.contains(name) || name == output::kSummary || !left.stands(name)) continue;
    std::error_code error;
    fs::remove(folder / name, error);
    if (error) {
      throw OutputError(fmt::format("{}: error: an earlier run's file cannot be removed ({})",
                                    (folder / name).string(), error.message()));
    }
    removeEmpty(folder, fs::path(name).parent_path());
  }
}

/// Moves what a whole record in the stage lists, and the record last.
void moveAll(const fs::path& folder, const fs::path& stage, const char* record) {
  const LeftFiles left(folder);
  const FileList files = listedFiles(stage / record);
  std::vector<std::string> foreign;
  if (left.isForeign(record)) foreign.emplace_back(record);
  for (const auto& [name, digest] : files) {
    if (fs::exists(stage / name) && left.isForeign(name)) foreign.push_back(name);
  }
  if (!foreign.empty()) refuse(folder, foreign);
  for (const auto& [name, digest] : files) {
    if (fs::exists(stage / name)) moveFile(stage / name, folder / name);
  }
  // Only a run takes the place of all before it; exports add to what is there.
  if (record == std::string(output::kSummary)) removeStale(folder, left, files);
  moveFile(stage / record, folder / record);
}

}  // namespace

FileSet::FileSet(fs::path folder, const char* record)
    : folder_(folder.empty() ? fs::path(".") : std::move(folder)),
      stage_(folder_ / output::kUnfinished),
      record_(record),
      lock_((makeFolder(folder_), folder_)) {
  requireWritableFolder(folder_);
  makeStage(folder_, stage_);
  for (const char* whole : {output::kSummary, output::kContents}) {
    if (!listedFiles(stage_ / whole).empty()) moveAll(folder_, stage_, whole);
  }
  clearStage(stage_);
  makeStage(folder_, stage_);
}

FileSet::~FileSet() {
  // A whole run that could not be moved stays for another attempt.
  const bool isWhole = !listedFiles(stage_ / output::kSummary).empty();
  if (!isWhole) clearStage(stage_);
}

void FileSet::dropCheckpoint() const {
  std::error_code ignored;
  fs::remove_all(stage_ / output::kCheckpoint, ignored);
}

void FileSet::requireFree(const std::function<bool(const std::string&)>& isWanted) const {
  const LeftFiles left(folder_);
  std::vector<std::string> foreign;
  const auto look = [&](const std::string& name, bool isFolder) {
    const bool isTaken = isWanted(name) && left.isForeign(name);
    if (isTaken || (isWanted(name + '/') && !isFolder)) foreign.push_back(name);
  };
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool isFolder = !entry.is_symlink(ignored) && entry.is_directory(ignored);
    // Links count as files: what they lead to is not ours.
    look(name, isFolder);
    if (!isFolder || name == output::kUnfinished) continue;
    for (const fs::directory_entry& inner : fs::directory_iterator(entry.path(), ignored)) {
      look(name + '/' + inner.path().filename().string(), false);
    }
  }
  std::sort(foreign.begin(), foreign.end());
  if (!foreign.empty()) refuse(folder_, foreign);
}

void FileSet::commit(const std::string& recordText) {
  writeTextFile(stage_ / record_, recordText);
  moveAll(folder_, stage_, record_);
}

void FileSet::commit(const std::vector<std::string>& names) {
  FileList files;
  const LeftFiles left(folder_);
  // What earlier exports have left and nobody has changed stays on the list.
  for (const auto& [name, digest] : listedFiles(folder_ / record_)) {
    if (left.stands(name)) files[name] = digest;
  }
  for (const std::string& name : names) files[name] = digestOf(stage_, name);
  commit(contentsText(files));
}

}  // namespace kirireel
