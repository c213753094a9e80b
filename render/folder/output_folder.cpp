// Names of files in one place, so that a run, the check of what stands in the way, and the programs
// that read a run's folder agree. Numbers in names have leading zeros, so that a listing by name is
// in order.
#include "render/folder/output_folder.h"

#include <algorithm>
#include <cerrno>
#include <charconv>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "sim/base/error.h"

namespace kirireel {
namespace fs = std::filesystem;

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
  // flock(2) on the folder itself: the kernel lets go when the process ends. Errors other than a
  // held lock mean that the file system has none.
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
  // The first run of digits is taken for the number; writing the name of that number again tells
  // whether the rest fits, leading zeros too.
  const std::size_t digits = std::min(name.find_first_of("0123456789"), name.size());
  int number = 0;
  const auto [end, error] =
      std::from_chars(name.data() + digits, name.data() + name.size(), number);
  return error == std::errc() && nameOf(number) == name;
}

}  // namespace kirireel
