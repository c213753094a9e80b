/// The output folder of a run: names and fingerprints of its files, permission to overwrite files,
/// and atomic updates.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/base/file_kinds.h"
#include "sim/base/files.h"

namespace kirireel::output {

// ------------------------------------------------------------------------------------------------
// Fingerprints (SHA-256), which identify a file as the one that was written.

/// Size and hash of a file.
struct FileDigest {
  std::string name;          ///< relative to the run's folder
  std::uintmax_t bytes = 0;  ///< size
  std::string sha256;        ///< of its bytes, 64 hexadecimal digits

  bool operator==(const FileDigest&) const = default;
};

/// The digest of a file in a folder. Reads the whole file once. Throws InputError if it cannot be
/// read.
FileDigest digestOf(const std::filesystem::path& folder, const std::string& name);

/// A JSON object's text (one key per line, ending in "\n}\n") with an additional last key "sha256",
/// the fingerprint of the original text. The text must end so and must not be sealed yet.
std::string sealed(const std::string& json);

/// Whether sealed() produced this text, to the last byte.
bool isSealed(const std::string& text);

// ------------------------------------------------------------------------------------------------
// Names of a run's files in its folder, and the lock of the folder.

/// Name of a run's video of the deployment.
inline constexpr const char* kVideo = "deployment.mp4";
/// The grid of pictures.
inline constexpr const char* kSnapshots = "snapshots.png";
/// The same as vector graphics, .svg and .pdf.
inline constexpr const char* kSnapshotPages = "snapshots";
inline constexpr const char* kInitialMesh = "initial";  ///< .obj and .ply
inline constexpr const char* kFinalMesh = "final";      ///< .obj and .ply
/// The tiles at the end, in the format of vertices.txt.
inline constexpr const char* kFinalVertices = "final_vertices.txt";
/// All samples.
inline constexpr const char* kTrajectory = "trajectory.h5";
/// The trajectory of a run that is named by its file or its folder.
inline std::filesystem::path trajectoryOf(const std::filesystem::path& run) {
  return isFolder(run) ? run / kTrajectory : run;
}
/// Load, forces and displacements of a run under grips.
inline constexpr const char* kLoadCurve = "load_curve.csv";
/// Settings and results of the run.
inline constexpr const char* kSummary = "summary.json";
inline constexpr const char* kContents = "contents.json";   ///< of export and render
inline constexpr const char* kStateMoment = "export";       ///< _0001.obj, .ply, ...
inline constexpr const char* kSnapshotMoment = "snapshot";  ///< _0001.png, ...
inline constexpr const char* kFrames = "frames";            ///< a folder
/// A temporary folder for incomplete files, removed after the run.
inline constexpr const char* kUnfinished = ".unfinished";
inline constexpr const char* kCheckpoint = "checkpoint";  ///< a folder in kUnfinished

/// "frames/frame_00042.png". Numbers are zero-based. Numbers above 99,999 get more digits.
std::filesystem::path frameFile(int number);

/// "snapshot_01.svg". Numbers are one-based.
std::filesystem::path snapshotDrawing(int number);

/// "export_0001.obj": a file of a moment that a timeline requests. `ending` includes its dot.
/// `name` is kStateMoment or kSnapshotMoment.
std::string momentFile(const char* name, int number, const char* ending);

/// Locks a folder for one run at a time, across processes, during its lifetime. Leaves no file. Has
/// no effect on file systems without locks.
class FolderLock {
 public:
  /// Throws OutputError if another run has locked the folder, which must exist.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;  ///< file descriptor
};

/// Whether `nameOf` gives this name for some number >= 0.
bool isNumbered(const std::string& name, const std::function<std::string(int)>& nameOf);

// ------------------------------------------------------------------------------------------------
// The files that Kirireel wrote to a folder. Other files are never overwritten or removed.

/// Files by their name, relative to their folder.
using FileList = std::map<std::string, FileDigest>;

/// The files that a sealed record in a folder lists under "contents": summary.json or
/// contents.json. Empty if there is no record or it was modified. Entries outside the folder are
/// ignored.
FileList listedFiles(const std::filesystem::path& record);

/// The text of contents.json: the files, sealed.
std::string contentsText(const FileList& files);

/// The files of earlier runs, exports and renderings in a folder, according to its records.
/// Modified records are ignored.
class RecordedFiles {
 public:
  /// Reads the records in this folder, which need not exist.
  explicit RecordedFiles(std::filesystem::path folder);

  /// Whether this name exists but is not a file in its recorded state: another file, a folder, a
  /// dangling link. A link to identical bytes may be replaced. Reads the file if its size matches.
  bool isForeign(const std::string& name) const;

  /// Whether a file with this name is in its recorded state and not reached through a link.
  bool isUnchanged(const std::string& name) const;

  /// All files in the records; contents.json has priority over summary.json.
  const FileList& files() const { return files_; }

 private:
  std::filesystem::path folder_;
  FileList files_;
};

/// Whether a name refers to a file in the folder or below it.
bool staysInside(const std::filesystem::path& name);

/// Difference between a file and its recorded state, one line without the file's name; empty if
/// there is none.
std::string difference(const std::filesystem::path& folder, const FileDigest& noted);

// ------------------------------------------------------------------------------------------------
// Atomic replacement of a set of files in a folder, without overwriting other files.
//
// Files are written to a hidden folder within, `.unfinished`. When all are complete, the sealed
// record that lists them is written there too. Then each file is moved into place, old files that
// this run did not write are removed, and the record is moved last. If the process is killed during
// these moves, the record stays next to the remaining files. The next set in the folder then
// continues the moves. Before the record is complete, nothing outside `.unfinished` changes.

/// One set of new files. In any case the folder has either the old files or the new ones.
class FileSet {
 public:
  /// Creates the folder with its parents and locks it for this set. `record` is the file that will
  /// list the others: summary.json replaces all files of earlier runs, contents.json adds to them.
  /// Completes the moves of a killed program. Removes its incomplete files except its checkpoint.
  /// Throws OutputError, and InputError if a move would overwrite a file that Kirireel did not
  /// write.
  FileSet(std::filesystem::path folder, const char* record);
  /// Removes files that are not in place, except a checkpoint and a complete, unmoved set.
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  /// Folder for new files until they are committed.
  const std::filesystem::path& stage() const { return stage_; }

  /// Throws InputError with the names of requested files and the record, in the folder or one level
  /// below, that exist and are not in the state of an earlier run. A requested folder ends in '/'.
  void requireFree(const std::function<bool(const std::string& name)>& isRequested) const;
  /// The same for files with these names.
  void requireFree(const std::vector<std::string>& names) const;

  /// Removes the checkpoint of an earlier run.
  void dropCheckpoint() const;

  /// Moves all files in the record's text into place. Throws InputError, and moves nothing, if
  /// files that Kirireel did not write have appeared there. Throws OutputError. `recordText` is
  /// sealed. The listed files are in stage() or in place.
  void commit(const std::string& recordText);

  /// The same for contents.json, which lists the existing and these files. Reads each new file
  /// once, for its hash.
  void commit(const std::vector<std::string>& names);

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_;  // by this object, the innermost first
  std::filesystem::path stage_;
  const char* record_;
  FolderLock lock_;
};

}  // namespace kirireel::output
