/// Commands about models: generate, convert, inspect, models and study.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "sim/generate/families.h"
#include "sim/model/model.h"
#include "sim/model/model_checks.h"
#include "sim/scene/scene.h"
#include "sim/study/study.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

// ------------------------------------------------------------------------------------------------
// `kirireel generate FAMILY FOLDER`.

/// A model to be made, and the place that it goes to. Lengths of parameters are metres, angles
/// degrees, as in the family's list.
struct GenerateOrder {
  std::string family;                    ///< as sim/generate/families.h names it
  std::map<std::string, double> values;  ///< of the family's parameters, those that were given
  std::optional<model::JointFace> face;  ///< of all joints; absent: chosen from the deployed shape
  std::filesystem::path folder;          ///< where the model goes; made when absent
};

/// Adds `generate` with its families. The order must outlive the parsing.
CLI::App* addGenerateCommand(CLI::App& program, GenerateOrder& order);

/// The group of a family's parameters in its help.
inline constexpr const char* kShapeGroup = "Shape";

/// Adds one family with its parameters. The order must outlive the parsing. Returns its command.
CLI::App* addFamily(CLI::App& generate, const generate::Family& family, GenerateOrder& order);

/// Throws InputError when no family or no folder was given. To be called after parsing.
void completeOrder(const CLI::App& generate, GenerateOrder& order);

/// Makes the model; the order needs no folder. Throws as generateModel().
model::Model makeModel(const GenerateOrder& order);

/// Makes the model and writes its folder. Returns the exit code. Prints how many tiles and joints
/// it has. Throws OutputError where the folder cannot be written.
int carryOut(const GenerateOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel convert IN OUT`.

/// A model to be written in another format. The file names decide the formats.
struct ConvertOrder {
  std::filesystem::path input;   ///< the model, a folder or a file
  model::ReadSettings reading;   ///< how it is read
  std::filesystem::path target;  ///< another model whose start is the target; empty for none
  std::filesystem::path output;  ///< its ending decides the format
};

/// Adds `convert`. The order must outlive the parsing.
CLI::App* addConvertCommand(CLI::App& program, ConvertOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, ConvertOrder& order);

/// Reads and writes. Returns the exit code. Throws InputError for a model that cannot be read,
/// OutputError for a file that cannot be written.
int carryOut(const ConvertOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel inspect MODEL`.

/// A model to be inspected. The scene's thickness is an option, because mobility and needs depend
/// on it.
struct InspectOrder {
  std::filesystem::path model;    ///< a folder or a file
  model::ReadSettings reading;    ///< how it is read
  std::filesystem::path target;   ///< another model whose start is the target; empty for none
  std::filesystem::path picture;  ///< where a numbered picture goes; empty for none
  scene::Scene scene;             ///< everything but the model
  bool printJson = false;         ///< the report as JSON on standard output, instead of text
};

/// Adds `inspect`. The order must outlive the parsing.
CLI::App* addInspectCommand(CLI::App& program, InspectOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, InspectOrder& order);

/// Reads the model, prints what it is, paints it if asked. Returns the exit code. Throws InputError
/// for a model that cannot be read; for one with a tile that crosses itself the picture is written
/// first.
int carryOut(const InspectOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel models`.

/// Lists the models that findModel() knows. It has no options.
struct ModelsOrder {};

/// Adds `models`.
CLI::App* addModelsCommand(CLI::App& program, ModelsOrder& order);

/// Accepts every order.
void completeOrder(const CLI::App& command, ModelsOrder& order);

/// Prints name, tiles, joints and target of each model. Returns the exit code.
int carryOut(const ModelsOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel study NAME`.

/// A study to be run. The name is a text; its type is a path because it is a positional argument
/// like other commands'.
struct StudyOrder {
  std::filesystem::path name;     ///< of a study, or "all"
  study::StudySettings settings;  ///< everything but the caption's texts
  bool list = false;              ///< list the studies instead
};

/// Adds `study`. The order must outlive the parsing.
CLI::App* addStudyCommand(CLI::App& program, StudyOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, StudyOrder& order);

/// Runs one study or all, and prints what they come down to. Returns the exit code. Takes minutes
/// to hours. 4 when a signal ended it.
int carryOut(const StudyOrder& order);

}  // namespace kirireel::cli
