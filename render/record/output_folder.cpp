#include "render/record/output_folder.h"

#include <cerrno>
#include <regex>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "sim/base/error.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

/// The name that a file would have got; a killed run leaves "deployment.part.mp4".
std::string finalName(const fs::path& file) {
  static const std::regex pending("(\\.whole)?\\.part(?=\\.[a-z0-9]+$)");
  return std::regex_replace(file.filename().string(), pending, "");
}

bool isRunFile(const fs::path& file) {
  static const std::regex names(
      "deployment\\.(mp4|webm|gif|apng|mkv|glb|pvd|fold)|cut_pattern\\.(svg|dxf)|"
      "snapshots\\.png|snapshot_[0-9]+\\.(svg|png)|(initial|final|export_[0-9]+)\\.(obj|mtl|ply)|"
      "final_vertices\\.txt|trajectory\\.h5|summary\\.json|"
      "state_[0-9]{4,}\\.(obj|ply|stl|msh|vtu)|"
      "state_[0-9]{4,}_(mesh\\.inp|job\\.inp|planar\\.obj|vertices\\.txt)");
  return std::regex_match(finalName(file), names);
}

bool isFrameFile(const fs::path& file) {
  static const std::regex names("frame_[0-9]{5,}\\.png");
  return std::regex_match(finalName(file), names);
}

void removeFiles(const fs::path& folder, bool (*isOurs)(const fs::path&)) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const bool isFile = entry.is_symlink() || !entry.is_directory();
    if (isFile && isOurs(entry.path())) fs::remove(entry.path(), error);
    if (error) {
      throw OutputError(fmt::format("{}: error: an earlier run's file cannot be removed ({})",
                                    entry.path().string(), error.message()));
    }
  }
}

/// Frames go into the run's folder, not where a link of that name leads.
void removeLink(const fs::path& folder) {
  std::error_code ignored;
  if (fs::is_symlink(folder, ignored)) fs::remove(folder, ignored);
}

}  // namespace

fs::path frameFile(int number) {
  return fs::path(output::kFrames) / fmt::format("frame_{:05}.png", number);
}

fs::path snapshotDrawing(int number) {
  return fmt::format("snapshot_{:02}.svg", number);
}

std::string momentFile(const char* name, int number, const char* ending) {
  return fmt::format("{}_{:04}{}", name, number, ending);
}

FolderLock::FolderLock(const fs::path& folder)
    : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
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

void makeFramesFolder(const fs::path& folder) {
  removeLink(folder / output::kFrames);
  makeFolder(folder / output::kFrames);
}

void prepareOutputFolder(const fs::path& folder) {
  makeFolder(folder);
  // Made and dropped: checks that files can be written, before hours of simulation.
  const PendingFile probe(folder / output::kSummary);
  removeFiles(folder, isRunFile);
  removeLink(folder / output::kFrames);
  removeFiles(folder / output::kFrames, isFrameFile);
}

}  // namespace kirireel
