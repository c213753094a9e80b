/// The folder that a run leaves: the names of its files and their fingerprints, the right to
/// write there, and files that appear together.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/base/files.h"

namespace kirireel::output {

// ------------------------------------------------------------------------------------------------
// Fingerprints (SHA-256), by which a file is known to be the one that was written.

/// What a file holds, in short.
struct FileDigest {
  std::string name;          ///< relative to the run's folder
  std::uintmax_t bytes = 0;  ///< its size
  std::string sha256;        ///< 64 hexadecimal digits, of its bytes

  bool operator==(const FileDigest&) const = default;
};

/// The digest of a file in a folder. Throws InputError when it cannot be read. Reads the whole file
/// once.
FileDigest digestOf(const std::filesystem::path& folder, const std::string& name);

/// A JSON object's text (one key a line, ending in "\n}\n") with a last key "sha256" added, which
/// is the fingerprint of the text before. The text must end so, and must not be sealed yet.
std::string sealed(const std::string& json);

/// Whether a text is as sealed() left it, to the last byte.
bool isSealed(const std::string& text);

// ------------------------------------------------------------------------------------------------
// The names of what a run leaves in its folder, and the right to write there.

/// The names of a run's files: the deployment as a video.
inline constexpr const char* kVideo = "deployment.mp4";
/// The grid of pictures.
inline constexpr const char* kSnapshots = "snapshots.png";
/// The same as vector graphics.
inline constexpr const char* kSnapshotsSvg = "snapshots.svg";
/// The same for print.
inline constexpr const char* kSnapshotsPdf = "snapshots.pdf";
inline constexpr const char* kInitialMesh = "initial";  ///< .obj and .ply
inline constexpr const char* kFinalMesh = "final";      ///< .obj and .ply
/// The tiles at the end, in the format of vertices.txt.
inline constexpr const char* kFinalVertices = "final_vertices.txt";
/// All samples.
inline constexpr const char* kTrajectory = "trajectory.h5";
/// Of a run under grips: load, forces and displacements.
inline constexpr const char* kLoadCurve = "load_curve.csv";
/// What the run was and came to.
inline constexpr const char* kSummary = "summary.json";
inline constexpr const char* kContents = "contents.json";   ///< of export and render
inline constexpr const char* kStateMoment = "export";       ///< _0001.obj, .ply, ...
inline constexpr const char* kSnapshotMoment = "snapshot";  ///< _0001.png, ...
inline constexpr const char* kFrames = "frames";            ///< a folder
/// A folder, gone when the run is over: what is not whole yet.
inline constexpr const char* kUnfinished = ".unfinished";
inline constexpr const char* kCheckpoint = "checkpoint";  ///< a folder within that one

/// "frames/frame_00042.png". Numbers count from 0; more than 99,999 get more digits.
std::filesystem::path frameFile(int number);

/// "snapshot_01.svg": number counts from 1.
std::filesystem::path snapshotDrawing(int number);

/// "export_0001.obj": a file of the moments that a timeline asks for; `ending` with its dot. `name`
/// is kStateMoment or kSnapshotMoment.
std::string momentFile(const char* name, int number, const char* ending);

/// Holds a folder for one run at a time, across processes, until it goes away. Leaves no file.
/// Where the file system has no locks, it holds nothing.
class FolderLock {
 public:
  /// Throws OutputError when another run holds the folder, which must exist.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;  ///< of the system
};

/// Whether `nameOf` gives this name to some number from 0 on.
bool isNumbered(const std::string& name, const std::function<std::string(int)>& nameOf);

// ------------------------------------------------------------------------------------------------
// The files that Kirireel wrote into a folder. Nothing else in it is ever overwritten or removed.

/// Files by their names, relative to their folder.
using FileList = std::map<std::string, FileDigest>;

/// The files that a sealed record in a folder lists under "contents": summary.json or
/// contents.json. Empty if there is none, or it has changed. Entries whose names
/// lead out of the folder are left out.
FileList listedFiles(const std::filesystem::path& record);

/// The text of contents.json: the files, sealed.
std::string contentsText(const FileList& files);

/// The files that earlier runs, exports and renderings say they left in a folder. A record that was
/// changed since says nothing.
class LeftFiles {
 public:
  /// What is listed by the records in this folder, which need not exist.
  explicit LeftFiles(std::filesystem::path folder);

  /// Whether this name exists and is not a file as one of them left it: another file, a folder, a
  /// link that leads nowhere. A link to the very bytes may be replaced. Reads the file
  /// where its size agrees.
  bool isForeign(const std::string& name) const;

  /// Whether a file of this name is as one of them left it, and not reached through a link.
  bool isAsLeft(const std::string& name) const;

  /// All that the records list; what contents.json says of a file counts more than summary.json.
  const FileList& files() const { return files_; }

 private:
  std::filesystem::path folder_;
  FileList files_;
};

/// Whether a name means a file in the folder or below it.
bool staysInside(const std::filesystem::path& name);

/// What is wrong with a file in a folder; empty when it is as noted. One line without the file's
/// name.
std::string difference(const std::filesystem::path& folder, const FileDigest& noted);

// ------------------------------------------------------------------------------------------------
// Files that appear in a folder together, and in nobody else's place.
//
// They are written into a hidden folder within, `.unfinished`. When all of them are whole, the
// sealed record that lists them is written there too; then each is moved into place, what earlier
// runs left and this one did not write is removed, and the record is moved last. Whoever is killed
// on the way leaves the record next to what is not moved yet, and the next set in the folder
// continues from there. Until the record is whole, nothing outside `.unfinished` is changed.

/// One set of new files. Whatever happens to it, the folder holds the old files or the new ones.
class FileSet {
 public:
  /// Makes the folder, and those above it, and locks it for this set. `record` is the file
  /// that will list the others: summary.json takes the place of all that earlier runs left,
  /// contents.json adds to it. Finishes what a killed program has left to move; removes what one
  /// has left unfinished, but for its checkpoint. Throws OutputError; InputError where files of
  /// others are in the way of that.
  FileSet(std::filesystem::path folder, const char* record);
  /// Removes what is not in place, but for a checkpoint and a whole set that could not be moved.
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  /// Where to write files until they are committed.
  const std::filesystem::path& stage() const { return stage_; }

  /// Throws InputError that names the files in the folder, or one level below, of which
  /// `isRequested` is true and which no earlier run left as they are. A wanted folder ends in '/'.
  void requireFree(const std::function<bool(const std::string& name)>& isRequested) const;

  /// Removes the checkpoint of an earlier run.
  void dropCheckpoint() const;

  /// Puts all files in place that the text of the record lists. Throws InputError, and moves
  /// nothing, when files of others have come into their places meanwhile; OutputError. `recordText`
  /// is sealed; the listed files lie in stage() or in place.
  void commit(const std::string& recordText);

  /// The same for contents.json, which lists the files already there and these. Reads each
  /// new file once, for its hash.
  void commit(const std::vector<std::string>& names);

 private:
  std::filesystem::path folder_;
  std::filesystem::path stage_;
  const char* record_;
  FolderLock lock_;
};

}  // namespace kirireel::output
