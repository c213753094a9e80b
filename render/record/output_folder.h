/// The folder that a run's files go into.
#pragma once

#include <filesystem>
#include <string>

namespace kirireel {

/// Names of the files that a run leaves.
namespace output {
inline constexpr const char* kVideo = "deployment.mp4";
inline constexpr const char* kSnapshots = "snapshots.png";
inline constexpr const char* kInitialMesh = "initial";  ///< .obj and .ply
inline constexpr const char* kFinalMesh = "final";      ///< .obj and .ply
inline constexpr const char* kFinalVertices = "final_vertices.txt";
inline constexpr const char* kTrajectory = "trajectory.h5";
inline constexpr const char* kSummary = "summary.json";
inline constexpr const char* kStateMoment = "export";       ///< _0001.obj, .ply, ...
inline constexpr const char* kSnapshotMoment = "snapshot";  ///< _0001.png, ...
inline constexpr const char* kFrames = "frames";            ///< a folder
inline constexpr const char* kCheckpoint = ".checkpoint";   ///< a folder, gone when the run is over
}  // namespace output

/// "frames/frame_00042.png".
std::filesystem::path frameFile(int number);

/// "snapshot_01.svg": number counts from 1.
std::filesystem::path snapshotDrawing(int number);

/// "export_0001.obj": a file of the moments that a timeline asks for; `ending` with its dot.
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

/// Makes the folder of single frames within a run's folder, in place of a link of that name. Throws
/// OutputError.
void makeFramesFolder(const std::filesystem::path& folder);

/// Makes the folder, checks that it can be written, and removes what an earlier run left under the
/// names above, so that files of two runs never stand side by side. Nothing else is touched:
/// links under these names are removed themselves, not what they lead to.
/// Throws OutputError.
void prepareOutputFolder(const std::filesystem::path& folder);

}  // namespace kirireel
