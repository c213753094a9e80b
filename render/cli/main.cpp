/// kirireel: reads the order, carries it out, says in one line what went wrong.
#include <exception>

#include <fmt/format.h>

#include "render/cli/command_line.h"
#include "render/cli/exit_codes.h"
#include "sim/base/error.h"
#include "sim/base/spelling.h"

int main(int argumentCount, char** arguments) {
  using namespace kirireel;
  try {
    const Order order = parseCommandLine({arguments + 1, arguments + argumentCount});
    return std::visit([](const auto& wanted) { return carryOut(wanted); }, order);
  } catch (const InputError& error) {
    fmt::print(stderr, "kirireel: {}\n", oneLine(error.what()));
    return kExitInputWrong;
  } catch (const std::exception& error) {
    fmt::print(stderr, "kirireel: {}\n", oneLine(error.what()));
    return kExitRunFailed;
  }
}
