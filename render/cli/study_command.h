/// `kirireel study NAME`.
#pragma once

#include <filesystem>
#include <string>

#include "sim/study/run_study.h"

namespace CLI {
class App;
}

namespace kirireel {

/// A study to be run. The name is a text; it is a path only because it stands as an argument like
/// other commands'.
struct StudyOrder {
  std::filesystem::path name;  ///< of a study, or "all"
  StudySettings settings;      ///< everything but the caption's texts
  bool list = false;           ///< say which studies there are instead
};

/// Adds `study`. The order must outlive the parsing.
CLI::App* addStudyCommand(CLI::App& program, StudyOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, StudyOrder& order);

/// Runs one study or all, and prints what they come down to. Returns the exit code. Takes minutes
/// to hours. 4 when a signal ended it.
int carryOut(const StudyOrder& order);

}  // namespace kirireel
