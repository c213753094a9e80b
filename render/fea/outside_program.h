/// Programs of others, run where they are installed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kirireel {

/// A folder for a program's files that vanishes with its owner.
class WorkFolder {
 public:
  /// Throws OutputError when it cannot be made.
  WorkFolder();
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  /// The path of a file of this name within the folder, which need not exist.
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// What a program has written into a file; empty where it has written nothing. Throws InputError
/// for files above 4 GiB or that cannot be read.
std::string writtenText(const std::string& file);

/// Runs a program, looked for on the path, with its output in the file `log`, and waits for it. It
/// runs in the folder of that file, where it may leave files of its own.
/// Returns how it ended, as waitpid says: 0 when all is well. Throws InputError when there is no
/// such program; `advice` says how to mend that. `words` are the program's name and its arguments,
/// none of them read by a shell.
int runProgram(std::vector<std::string> words, const std::string& log, const std::string& advice);

}  // namespace kirireel
