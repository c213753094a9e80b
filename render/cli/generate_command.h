/// `kirireel generate FAMILY FOLDER`.
#pragma once

#include <filesystem>

#include "sim/model/tessellation.h"

namespace CLI {
class App;
}

namespace kirireel {

/// A model to be made, and the folder that it goes to.
struct GenerateOrder {
  TessellationShape shape;
  std::filesystem::path folder;
};

/// Adds `generate` with its families. The order must outlive the parsing.
CLI::App* addGenerateCommand(CLI::App& program, GenerateOrder& order);

/// Throws InputError when no family was given.
void requireFamily(const CLI::App& generate);

/// Makes the model and writes its folder. Returns the exit code.
int carryOut(const GenerateOrder& order);

}  // namespace kirireel
