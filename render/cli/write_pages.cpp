/// kirireel_pages FOLDER: writes the man pages and the completions of this build.
/// kirireel_pages --stub FILE: writes the type stubs of its Python module.
/// Part of the build, not installed.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "render/cli/manual.h"
#include "render/record/summary.h"
#include "sim/base/files.h"

namespace {

using namespace kirireel;
using namespace kirireel::cli;

/// FOLDER/man1/NAME.1 and FOLDER/completions/kirireel.SHELL, where CMake installs them from.
void writePages(const std::filesystem::path& folder) {
  const CommandDescription program = describeProgram();
  makeFolder(folder / "man1");
  for (const auto& [name, text] : manPages(program, record::programVersion())) {
    writeTextFile(folder / "man1" / name, text);
  }
  makeFolder(folder / "completions");
  writeTextFile(folder / "completions" / "kirireel.bash", bashCompletion(program));
  writeTextFile(folder / "completions" / "kirireel.zsh", zshCompletion(program));
  writeTextFile(folder / "completions" / "kirireel.fish", fishCompletion(program));
}

}  // namespace

int main(int argumentCount, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + argumentCount);
  try {
    if (words.size() == 1) {
      writePages(words.front());
    } else if (words.size() == 2 && words.front() == "--stub") {
      writeTextFile(words.back(), pythonStub(describeProgram()));
    } else {
      fmt::print(stderr, "use: kirireel_pages FOLDER | --stub FILE\n");
      return 2;
    }
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "kirireel_pages: {}\n", error.what());
    return 1;
  }
}
