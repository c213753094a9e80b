#include "render/fea/gmsh_program.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include "sim/base/error.h"
#include "sim/base/input_file.h"
#include "sim/base/pending_file.h"

extern char** environ;

namespace kirireel {
namespace {

/// A folder that vanishes with its owner.
class WorkFolder {
 public:
  WorkFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "kirireel-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw OutputError(fmt::format("{}: error: cannot be made ({})", name,
                                    std::generic_category().message(errno)));
    }
    path_ = name;
  }
  ~WorkFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  std::string operator/(const char* name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// What the program has written; empty where it has written nothing.
std::string textOf(const std::string& file) {
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{4} << 30;
  if (!std::filesystem::is_regular_file(file)) return {};
  return readTextFile(file, "", kMostBytes);
}

/// Runs a program with its output in a file. Returns how it ended, as waitpid says.
int run(std::vector<std::string> words, const std::string& log) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::posix_spawn_file_actions_adddup2(&actions, 1, 2);
  pid_t process = 0;
  const int failure =
      ::posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    throw InputError(
        fmt::format("error: the program {} cannot be run ({}); sheets with necks are meshed by it: "
                    "install it (Debian: apt-get install gmsh) or choose other --joints",
                    words[0], std::generic_category().message(failure)));
  }
  int end = 0;
  while (::waitpid(process, &end, 0) < 0 && errno == EINTR) {
  }
  return end;
}

}  // namespace

std::string meshedByGmsh(const std::string& geometry) {
  const WorkFolder folder;
  const std::string input = folder / "sheet.geo";
  const std::string output = folder / "sheet.msh";
  const std::string log = folder / "log";
  writeTextFile(input, geometry);
  const int end = run(
      {"gmsh", "-2", input, "-format", "msh22", "-o", output, "-nt", "1", "-v", "2", "-nopopup"},
      log);
  std::string mesh = textOf(output);
  if (end == 0 && !mesh.empty()) return mesh;
  std::string words = textOf(log);
  while (!words.empty() && words.back() == '\n') words.pop_back();
  throw RunError(
      fmt::format("error: gmsh cannot mesh this sheet ({})", words.substr(words.rfind('\n') + 1)));
}

}  // namespace kirireel
