/// Files that appear in a folder together, and in nobody else's place.
///
/// They are written into a hidden folder within, `.unfinished`. When all of them are whole, the
/// sealed record that lists them is written there too; then each is moved into place, what earlier
/// runs left and this one did not write is removed, and the record is moved last. Whoever is killed
/// on the way leaves the record beside what is not moved yet, and the next set in the folder goes
/// on from there. Until the record is whole, nothing outside `.unfinished` is touched.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "render/folder/output_folder.h"

namespace kirireel {

/// One set of new files. Whatever happens to it, the folder holds the old files or the new ones.
class FileSet {
 public:
  /// Makes the folder, and those above it, and holds it for this set alone. `record` is the file
  /// that will list the others: summary.json takes the place of all that earlier runs left,
  /// contents.json adds to it. Finishes what a killed program has left to move; removes what one
  /// has left unfinished, but for its checkpoint. Throws OutputError; InputError where files of
  /// others are in the way of that.
  FileSet(std::filesystem::path folder, const char* record);
  /// Removes what is not in place, but for a checkpoint.
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  /// Where to write files until they are committed.
  const std::filesystem::path& stage() const { return stage_; }

  /// Throws InputError that names the files in the folder, or one level below, of which `isWanted`
  /// is true and which no earlier run left as they are. A wanted folder ends in '/'.
  void requireFree(const std::function<bool(const std::string& name)>& isWanted) const;

  /// Removes the checkpoint of an earlier run.
  void dropCheckpoint() const;

  /// Puts all files in place that the text of the record lists. Throws InputError, and moves
  /// nothing, when files of others have come into their places meanwhile; OutputError. `recordText`
  /// is sealed; the listed files lie in stage() or in place.
  void commit(const std::string& recordText);

  /// The same for contents.json, which lists what stands there already and these files. Reads each
  /// new file once, for its hash.
  void commit(const std::vector<std::string>& names);

 private:
  std::filesystem::path folder_;
  std::filesystem::path stage_;
  const char* record_;
  FolderLock lock_;
};

}  // namespace kirireel
