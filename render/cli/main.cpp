/// kirireel: parses the command line, runs the command, and reports an error in one line.
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>

#include <fmt/format.h>

#include "render/cli/command_line.h"
#include "render/cli/option_group.h"
#include "render/cli/report.h"
#include "sim/base/error.h"

namespace {

using namespace kirireel;
using namespace kirireel::cli;

/// Prints one line on standard error. Returns the code.
int complain(int exitCode, const std::string& message) {
  fmt::print(stderr, "kirireel: {}\n", oneLine(spellOptions(message)));
  return exitCode;
}

/// Flushes the standard output, because printed text may still be in a buffer.
void requirePrinted() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw OutputError(
      fmt::format("error: standard output cannot be written ({}); the files were written",
                  std::strerror(errno)));
}

int carryOutOrder(const std::vector<std::string>& arguments) {
  // Outside the try block, because errors of parsing are not errors of printing.
  const Order order = parseCommandLine(arguments);
  try {
    const int exitCode =
        std::visit([](const auto& requested) { return carryOut(requested); }, order);
    requirePrinted();
    return exitCode;
  } catch (const std::system_error&) {
    // Error in printing a text longer than the buffer.
    requirePrinted();
    throw;
  }
}

int runProgram(const std::vector<std::string>& arguments) {
  try {
    return carryOutOrder(arguments);
  } catch (const InputError& error) {
    // An error of the user. The message contains the correction.
    return complain(kExitInputWrong, error.what());
  } catch (const std::bad_alloc&) {
    // Caught before its base class std::exception, because its what() explains nothing.
    return complain(
        kExitFailed,
        "error: there is too little memory; allow more, or use fewer tiles, a smaller --size or a "
        "smaller --grid. --resume continues a run from its last checkpoint");
  } catch (const std::exception& error) {
    return complain(kExitFailed, error.what());
  }
}

/// Ends the process without the exit handlers of libraries. Some wait for their threads, which may
/// never end: with little memory, OpenBLAS's threads (FFmpeg links it) try forever to allocate 128
/// MiB.
[[noreturn]] void endProcess(int exitCode) {
  std::fflush(nullptr);
#ifdef __SANITIZE_ADDRESS__
  std::exit(exitCode);  // runs the leak check
#else
  std::_Exit(exitCode);
#endif
}

}  // namespace

int main(int argumentCount, char** arguments) {
  endProcess(runProgram({arguments + 1, arguments + argumentCount}));
}
