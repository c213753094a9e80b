/// The names of what a run leaves in its folder, and the right to write there.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace kirireel {

/// Names of the files that a run leaves.
namespace output {
inline constexpr const char* kVideo = "deployment.mp4";
inline constexpr const char* kSnapshots = "snapshots.png";
inline constexpr const char* kSnapshotsSvg = "snapshots.svg";
inline constexpr const char* kSnapshotsPdf = "snapshots.pdf";
inline constexpr const char* kInitialMesh = "initial";  ///< .obj and .ply
inline constexpr const char* kFinalMesh = "final";      ///< .obj and .ply
inline constexpr const char* kFinalVertices = "final_vertices.txt";
inline constexpr const char* kTrajectory = "trajectory.h5";
inline constexpr const char* kLoadCurve = "load_curve.csv";
inline constexpr const char* kSummary = "summary.json";
inline constexpr const char* kContents = "contents.json";   ///< of export and render
inline constexpr const char* kStateMoment = "export";       ///< _0001.obj, .ply, ...
inline constexpr const char* kSnapshotMoment = "snapshot";  ///< _0001.png, ...
inline constexpr const char* kFrames = "frames";            ///< a folder
/// A folder, gone when the run is over: what is not whole yet.
inline constexpr const char* kUnfinished = ".unfinished";
inline constexpr const char* kCheckpoint = "checkpoint";  ///< a folder within that one
}  // namespace output

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

}  // namespace kirireel
