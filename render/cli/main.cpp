/// kirireel: reads the order, carries it out, says in one line what went wrong.
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

/// One line on standard error, whatever line breaks the message holds. Returns the code.
int complain(int exitCode, const std::string& message) {
  fmt::print(stderr, "kirireel: {}\n", oneLine(spellOptions(message)));
  return exitCode;
}

/// What was printed may still wait in a buffer.
void requirePrinted() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw OutputError(
      fmt::format("error: standard output cannot be written ({}); files are written all the same",
                  std::strerror(errno)));
}

int carryOutOrder(const std::vector<std::string>& arguments) {
  // Out of the try block: errors of parsing are no errors of printing.
  const Order order = parseCommandLine(arguments);
  try {
    const int exitCode =
        std::visit([](const auto& requested) { return carryOut(requested); }, order);
    requirePrinted();
    return exitCode;
  } catch (const std::system_error&) {
    // Of printing, where a text is longer than the buffer.
    requirePrinted();
    throw;
  }
}

int runProgram(const std::vector<std::string>& arguments) {
  try {
    return carryOutOrder(arguments);
  } catch (const InputError& error) {
    // Of the user: what to mend stands in the message.
    return complain(kExitInputWrong, error.what());
  } catch (const std::bad_alloc&) {
    // Caught before std::exception, from which it descends, for what() says nothing.
    return complain(
        kExitFailed,
        "error: there is too little memory; allow more, or ask for less: fewer tiles, a "
        "smaller --size or --grid. --resume goes on with a run from its last checkpoint");
  } catch (const std::exception& error) {
    return complain(kExitFailed, error.what());
  }
}

/// Ends the process without the end functions of libraries. Some wait for threads of theirs, which
/// may never end: with little memory, OpenBLAS's threads (FFmpeg links it) repeat forever to
/// allocate 128 MiB.
[[noreturn]] void endProcess(int exitCode) {
  std::fflush(nullptr);
#ifdef __SANITIZE_ADDRESS__
  std::exit(exitCode);  // looks for leaks
#else
  std::_Exit(exitCode);
#endif
}

}  // namespace

int main(int argumentCount, char** arguments) {
  endProcess(runProgram({arguments + 1, arguments + argumentCount}));
}
