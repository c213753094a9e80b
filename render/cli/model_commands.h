/// Commands about models: generate, convert, inspect, models and study.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "sim/formats/read_settings.h"
#include "sim/generate/families.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"
#include "sim/study/study.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

// ------------------------------------------------------------------------------------------------
// `kirireel generate FAMILY FOLDER`.

/// Request to generate a model. Lengths of parameters are in metres, angles in degrees, as in the
/// family's list.
struct GenerateOrder {
  std::string family;                    ///< name in sim/generate/families.h
  std::map<std::string, double> values;  ///< given parameters of the family
  std::optional<model::JointFace> face;  ///< of all joints; absent: by the deployed shape
  std::filesystem::path folder;          ///< output folder; created if absent
};

/// Adds `generate` with its families. The order must outlive the parsing.
CLI::App* addGenerateCommand(CLI::App& program, GenerateOrder& order);

/// The group of a family's parameters in its help.
inline constexpr const char* kShapeGroup = "Shape";

/// Adds one family with its parameters. The order must outlive the parsing. Returns its command.
CLI::App* addFamily(CLI::App& generate, const generate::Family& family, GenerateOrder& order);

/// Throws InputError if no family or no folder was given. Call it after parsing.
void completeOrder(const CLI::App& generate, GenerateOrder& order);

/// Makes the model; the order needs no folder. Throws like generateModel().
model::Model makeModel(const GenerateOrder& order);

/// Makes the model and writes its folder. Prints its number of tiles and joints. Returns the exit
/// code. Throws OutputError if the folder cannot be written.
int carryOut(const GenerateOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel convert IN OUT`.

/// Request to convert a model. The file names determine the formats.
struct ConvertOrder {
  std::filesystem::path input;   ///< the model, a folder or a file
  formats::ReadSettings reading;  ///< options for reading
  std::filesystem::path target;  ///< another model whose start is the target; empty: none
  std::filesystem::path output;  ///< its ending determines the format
};

/// Adds `convert`. The order must outlive the parsing.
CLI::App* addConvertCommand(CLI::App& program, ConvertOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, ConvertOrder& order);

/// Reads and writes the model. Returns the exit code. Throws InputError for a model that cannot be
/// read, OutputError for a file that cannot be written.
int carryOut(const ConvertOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel inspect MODEL`.

/// Request to inspect a model. The scene's thickness is an option, because mobility and needs
/// depend on it.
struct InspectOrder {
  std::filesystem::path model;    ///< a folder or a file
  formats::ReadSettings reading;  ///< options for reading
  std::filesystem::path target;   ///< another model whose start is the target; empty: none
  std::filesystem::path picture;  ///< file for a numbered picture; empty: none
  scene::Scene scene;             ///< all settings without the model
  bool printJson = false;         ///< the report as JSON on standard output, instead of text
};

/// Adds `inspect`. The order must outlive the parsing.
CLI::App* addInspectCommand(CLI::App& program, InspectOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, InspectOrder& order);

/// Reads the model, prints the inspection, and paints it on request. Returns the exit code. Throws
/// InputError for a model that cannot be read. For a tile that crosses itself, the picture is
/// written before.
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

/// Request to run a study. The name is a text. Its type is a path because positional arguments of
/// all commands are paths.
struct StudyOrder {
  std::filesystem::path name;     ///< name of a study, or "all"
  study::StudySettings settings;  ///< all settings except the caption's texts
  bool list = false;              ///< list the studies instead
};

/// Adds `study`. The order must outlive the parsing.
CLI::App* addStudyCommand(CLI::App& program, StudyOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, StudyOrder& order);

/// Runs one study or all, and prints the results. Takes minutes to hours. Returns the exit code, 4
/// after a signal.
int carryOut(const StudyOrder& order);

}  // namespace kirireel::cli
