/// `kirireel curves RUN`.
#pragma once

#include <filesystem>

#include "render/curves/curves.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Which run's curves are wanted, and as what. completeOrder() puts the file of a folder in its
/// place.
struct CurvesOrder {
  std::filesystem::path run;  ///< a trajectory.h5, or the folder that it is in
  CurvesSettings settings;    ///< the folder is empty when --out was not given
};

/// Adds `curves`. The order must outlive the parsing.
CLI::App* addCurvesCommand(CLI::App& program, CurvesOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, CurvesOrder& order);

/// Writes the files, prints their names. Returns the exit code. A run without dynamics has no
/// energies and forces: a note on standard error says so. Throws what TrajectoryReader and
/// writeCurves throw.
int carryOut(const CurvesOrder& order);

}  // namespace kirireel
