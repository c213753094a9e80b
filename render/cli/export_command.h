/// `kirireel export TRAJECTORY`.
#pragma once

#include <filesystem>

#include "render/export/export.h"

namespace CLI {
class App;
}

namespace kirireel {

/// A trajectory and what is made of it. Defaults of the settings are those of the help.
struct ExportOrder {
  std::filesystem::path trajectory;  ///< a trajectory.h5, or the folder that it is in
  std::filesystem::path folder;      ///< empty for the trajectory's own
  ExportSettings settings;
  bool isChecked = false;  ///< whether jobs are run with two sizes of elements
};

/// Adds the options that say which states are exported as what; `formatOption` is the name of the
/// one for the formats. The settings must outlive the parsing. "--format" in `export`, where
/// options may also have short names, "--export" in `record`.
void addExportOptions(CLI::App& command, const std::string& formatOption, ExportSettings& settings);

/// Adds `export`. The order must outlive the parsing.
CLI::App* addExportCommand(CLI::App& program, ExportOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, ExportOrder& order);

/// Reads the trajectory, writes the files, prints their names. Returns the exit code. With --check
/// also runs CalculiX, and prints what a mesh twice as fine changes. Throws InputError for states,
/// formats and models that do not fit, OutputError for files.
int carryOut(const ExportOrder& order);

}  // namespace kirireel
