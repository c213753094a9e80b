/// `kirireel inspect MODEL`.
#pragma once

#include <filesystem>

#include "sim/model/mending.h"
#include "sim/scene/scene.h"

namespace CLI {
class App;
}

namespace kirireel {

/// A model to be looked at. The scene's thickness is an option, since mobility and needs depend on
/// it.
struct InspectOrder {
  std::filesystem::path model;
  ReadSettings reading;
  std::filesystem::path target;   ///< another model whose start is the target; empty for none
  std::filesystem::path picture;  ///< where a numbered picture goes; empty for none
  Scene scene;                    ///< everything but the model
  bool printJson = false;
};

/// Adds `inspect`. The order must outlive the parsing.
CLI::App* addInspectCommand(CLI::App& program, InspectOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, InspectOrder& order);

/// Reads the model, prints what it is, paints it if asked. Returns the exit code. Throws InputError
/// for a model that cannot be read; for one with a tile that crosses itself the picture is written
/// first.
int carryOut(const InspectOrder& order);

}  // namespace kirireel
