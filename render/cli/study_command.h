/// `kirireel study NAME`.
#pragma once

#include <filesystem>
#include <string>

#include "sim/study/run_study.h"

namespace CLI {
class App;
}

namespace kirireel {

/// A study to be run.
struct StudyOrder {
  std::filesystem::path name;  ///< of a study, or "all"
  StudySettings settings;      ///< everything but the caption's texts
  bool list = false;           ///< say which studies there are instead
};

/// Adds `study`. The order must outlive the parsing.
CLI::App* addStudyCommand(CLI::App& program, StudyOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, StudyOrder& order);

/// Runs one study or all, and prints what they come down to. Returns the exit code.
int carryOut(const StudyOrder& order);

}  // namespace kirireel
