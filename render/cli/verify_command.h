/// `kirireel verify FOLDER`.
#pragma once

#include <filesystem>

namespace CLI {
class App;
}

namespace kirireel {

/// Which run is to be checked.
struct VerifyOrder {
  std::filesystem::path folder;
};

/// Adds `verify`. The order must outlive the parsing.
CLI::App* addVerifyCommand(CLI::App& program, VerifyOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, VerifyOrder& order);

/// Checks, and prints what does not agree. Returns the exit code.
int carryOut(const VerifyOrder& order);

}  // namespace kirireel
