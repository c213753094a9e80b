/// `kirireel generate FAMILY FOLDER`.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "sim/generate/families.h"
#include "sim/model/model.h"

namespace CLI {
class App;
}

namespace kirireel {

/// A model to be made, and the place that it goes to. Lengths of parameters are metres, angles
/// degrees, as the family's list says.
struct GenerateOrder {
  std::string family;
  std::map<std::string, double> values;  ///< of the family's parameters, those that were given
  std::optional<JointFace> face;         ///< of all joints; absent: chosen from the deployed shape
  std::filesystem::path folder;
};

/// Adds `generate` with its families. The order must outlive the parsing.
CLI::App* addGenerateCommand(CLI::App& program, GenerateOrder& order);

/// The group of a family's parameters in its help.
inline constexpr const char* kShapeGroup = "Shape";

/// Adds one family with its parameters. The order must outlive the parsing. Returns its command.
CLI::App* addFamily(CLI::App& generate, const Family& family, GenerateOrder& order);

/// Throws InputError when no family or no folder was given. To be called after parsing.
void completeOrder(const CLI::App& generate, GenerateOrder& order);

/// Makes the model; the order needs no folder. Throws as generateModel().
Model makeModel(const GenerateOrder& order);

/// Makes the model and writes its folder. Returns the exit code. Prints how many tiles and joints
/// it has. Throws OutputError where the folder cannot be written.
int carryOut(const GenerateOrder& order);

}  // namespace kirireel
