/// `kirireel verify FOLDER`.
#pragma once

#include <filesystem>

namespace CLI {
class App;
}

namespace kirireel {

/// Which run is to be checked. The folder is the one that was given to --out.
struct VerifyOrder {
  std::filesystem::path folder;
};

/// Adds `verify`. The order must outlive the parsing.
CLI::App* addVerifyCommand(CLI::App& program, VerifyOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, VerifyOrder& order);

/// Checks, and prints what does not agree. Returns the exit code. Reads every file of the run and
/// the whole trajectory. Throws InputError for a folder without a finished run.
int carryOut(const VerifyOrder& order);

}  // namespace kirireel
