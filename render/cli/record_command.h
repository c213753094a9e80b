/// `kirireel record MODEL` and `kirireel simulate MODEL`, and the fingerprint of an order.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/cli/scene_options.h"
#include "render/record/record.h"
#include "sim/base/files.h"
#include "sim/formats/joint_faces.h"
#include "sim/formats/read_settings.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_file.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

// ------------------------------------------------------------------------------------------------
// The fingerprint of an order to record.

/// The settings of a run after parsing and completion, in one spelling. UTF-8 if the names of files
/// are.
struct OrderText {
  std::string scene;  ///< a scene file for the same run; file names as given
  std::string terms;  ///< for the fingerprint: the command, and the scene without file names
};

/// Every effective option of a command in this scene with its current value, whether given or
/// default, and the scene file's timeline and obstacles. Call it after parsing. `scene` with all
/// settings shows which options have an effect.
OrderText orderText(CLI::App& command, const scene::Scene& scene,
                    const scene::SceneFile& sceneFile);

/// A command's name and its current options, for commands without a scene file. Conditions are
/// those of a scene with defaults.
std::string parametersText(CLI::App& command);

/// The input files of a run. A file that is read twice is listed twice.
struct OrderInputs {
  std::string modelName;         ///< as in its files
  std::vector<InputFile> files;  ///< in reading order
};

/// SHA-256 of all inputs of a run's bytes, 64 hexadecimal digits: the versions of the program and
/// its libraries, the settings, the model's name and the contents of all input files. Their paths
/// do not matter. `folders` are those whose file names count, see readModelFolder(). `terms` is
/// OrderText::terms.
std::string orderFingerprint(const std::string& terms, const OrderInputs& inputs,
                             const std::vector<std::filesystem::path>& folders);

// ------------------------------------------------------------------------------------------------
// `kirireel record MODEL` and `kirireel simulate MODEL`.

/// A deployment and its outputs. Filled in three steps: by parsing, by completeOrder() and, for
/// data that need the model, by prepareOrder(). After parsing it has no references to the parser.
struct RecordOrder {
  std::filesystem::path model;            ///< a folder or a file
  formats::ReadSettings reading;          ///< of `model`
  std::optional<model::Model> madeModel;  ///< replaces reading `model`
  std::optional<formats::FaceRule>
      faces;  ///< rule for the faces of the model's joints; absent: as in the model
  std::optional<std::vector<int>> splitTiles;  ///< tiles that bend; empty: all; absent: none
  /// The word that selects PyKirigami's constants as defaults; empty: none.
  std::string peerSpelling;
  scene::Scene scene =
      scene::openScene();  ///< everything but the model; the ground's height is not known yet.
                           ///< Its lengths are in the unit of the model until prepared
  SceneRequest request;    ///< additions to the model
  record::RecordSettings settings;  ///< folder is empty if --out was not given
  std::vector<InputFile> inputs;    ///< input files so far, except the scene file
  OrderText text;                   ///< the settings of a complete order
  bool page = false;                ///< also write page.html, after the other files
  bool printJson = false;           ///< prints the summary as JSON on standard output
  bool verbose = false;             ///< print all findings, not only the six lines of a run
};

/// Adds `record`. The order must outlive the parsing.
CLI::App* addRecordCommand(CLI::App& program, RecordOrder& order);

/// Adds `simulate`, which paints nothing. The order must outlive the parsing.
CLI::App* addSimulateCommand(CLI::App& program, RecordOrder& order);

/// Checks that a model was given, reads its scene file, and writes all settings. Call it after
/// parsing. Throws InputError for a missing model, contradictions, and a scene file that cannot be
/// read.
void completeOrder(CLI::App& command, RecordOrder& order);

/// Reads the files of a complete order in the order of its run, as far as possible. Does not throw
/// for invalid files: the model's name is then empty.
OrderInputs readInputs(const RecordOrder& order);

/// The fingerprint of a complete order, see orderFingerprint(). 64 hexadecimal digits; the inputs
/// are those of readInputs() or of the run itself.
std::string fingerprintOf(const RecordOrder& order, const OrderInputs& inputs);

/// A run, before or after it was made. Before the run the summary is empty.
struct RecordResult {
  scene::Scene scene;               ///< with its model, complete
  record::RecordSettings settings;  ///< with their folder
  record::RunSummary summary;       ///< of the run so far
};

/// Reads the model of a complete order and all other inputs, without running. Throws like
/// readModel(). Adds warnings for harmless faults.
RecordResult prepareOrder(const RecordOrder& order, std::vector<std::string>& warnings);

/// Reads the model, runs it, writes its files without checkpoints. The order must be complete.
/// Prints only warnings, on standard error (for sweeps). Throws like readModel() and record().
RecordResult runOrder(const RecordOrder& order, const record::ProgressObserver& observer);

/// Reads the model, runs it, writes its files, prints the summary. Returns the exit code. Throws
/// like readModel() and record(). From here on, signals end the run between steps.
int carryOut(const RecordOrder& order);

}  // namespace kirireel::cli
