/// `kirireel convert IN OUT`.
#pragma once

#include <filesystem>

#include "sim/model/mending.h"

namespace CLI {
class App;
}

namespace kirireel {

/// A model to be written in another format. The formats of both are told by their names.
struct ConvertOrder {
  std::filesystem::path input;
  ReadSettings reading;
  std::filesystem::path target;  ///< another model whose start is the target; empty for none
  std::filesystem::path output;  ///< its ending says the format
};

/// Adds `convert`. The order must outlive the parsing.
CLI::App* addConvertCommand(CLI::App& program, ConvertOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, ConvertOrder& order);

/// Reads and writes. Returns the exit code. Throws InputError for a model that cannot be read,
/// OutputError for a file that cannot be written.
int carryOut(const ConvertOrder& order);

}  // namespace kirireel
