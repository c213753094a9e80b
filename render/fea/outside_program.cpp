// Starts programs by posix_spawnp (POSIX.1-2008) and not by a shell: arguments are passed as they
// are, so that no name can be read as a command. Input is /dev/null, so that a program that asks a
// question ends instead of waiting; output and errors go to one log, in the order in which they
// came.
#include "render/fea/outside_program.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include "sim/base/error.h"
#include "sim/base/input_file.h"
#include "sim/base/pending_file.h"

extern char** environ;

namespace kirireel {
WorkFolder::WorkFolder() {
  // mkdtemp replaces the six X and makes the folder for its user alone (mode 0700).
  std::string name = (std::filesystem::temp_directory_path() / "kirireel-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw OutputError(fmt::format("{}: error: cannot be made ({})", name,
                                  std::generic_category().message(errno)));
  }
  path_ = name;
}

WorkFolder::~WorkFolder() {
  // A destructor must not throw; what cannot be removed stays in the temporary folder.
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string writtenText(const std::string& file) {
  // Results of large meshes have gigabytes; more than four are not read into memory.
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{4} << 30;
  if (!std::filesystem::is_regular_file(file)) return {};
  return readTextFile(file, "", kMostBytes);
}

int runProgram(std::vector<std::string> words, const std::string& log, const std::string& advice) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  // The list of arguments ends with a null pointer, as execvp has it.
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::posix_spawn_file_actions_adddup2(&actions, 1, 2);
  const std::string folder = std::filesystem::path(log).parent_path().string();
  // The "np" means that it is not in POSIX.1-2008; glibc has it from 2.29 on.
  ::posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t process = 0;
  const int failure =
      ::posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    throw InputError(fmt::format("error: the program {} cannot be run ({}); {}", words[0],
                                 std::generic_category().message(failure), advice));
  }
  int end = 0;
  // A signal that the caller handles ends the wait early; the program still runs.
  while (::waitpid(process, &end, 0) < 0 && errno == EINTR) {
  }
  return end;
}

}  // namespace kirireel
