/// `kirireel render TRAJECTORY`.
#pragma once

#include <filesystem>
#include <vector>

#include "render/record/record.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Which recorded runs are to be painted again, and how. completeOrder() puts the file of each
/// folder in its place.
struct RenderOrder {
  std::vector<std::filesystem::path> trajectories;  ///< several: one grid with a row of each
  PictureSettings settings;  ///< the folder is empty when --out was not given
};

/// Adds `render`. The order must outlive the parsing.
CLI::App* addRenderCommand(CLI::App& program, RenderOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, RenderOrder& order);

/// Paints, and prints what was written. Returns the exit code. 4 when a signal ended the video
/// early. Throws InputError for a trajectory that cannot be read, OutputError for files.
int carryOut(const RenderOrder& order);

}  // namespace kirireel
