/// `kirireel record MODEL` and `kirireel simulate MODEL`, and the fingerprint of an order.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/cli/scene_options.h"
#include "render/record/record.h"
#include "sim/base/files.h"
#include "sim/model/model_checks.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_file.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

// ------------------------------------------------------------------------------------------------
// The fingerprint of an order to record.

/// The settings of a run, as they are once all is parsed and completed, in one spelling. Both are
/// UTF-8 where all names are.
struct OrderText {
  std::string scene;  ///< a scene file that makes the same run; names of files as they were given
  std::string terms;  ///< what decides the result: the command, and the scene without these names
};

/// Every option of a command that means anything in this scene, with the value that it has now,
/// however it was given or not given, and the scene file's timeline and obstacles. To be called
/// after parsing. `scene` is the scene with all settings, to find options without effect.
OrderText orderText(CLI::App& command, const scene::Scene& scene,
                    const scene::SceneFile& sceneFile);

/// A command's name and its options as they are now, where no scene file has a part in them.
/// Conditions are those of a scene with defaults.
std::string parametersText(CLI::App& command);

/// The input files of a run. A file that was opened twice is listed twice.
struct OrderInputs {
  std::string modelName;         ///< which its files bear
  std::vector<InputFile> files;  ///< in the order in which they were read
};

/// SHA-256 of all that decides a run's bytes: the versions of the program and its libraries, the
/// settings, the model's name and the content of all files that were read. Their paths do not
/// matter: `folders` are those whose files count by their names, see readModelFolder(). 64
/// hexadecimal digits. `terms` is OrderText::terms.
std::string orderFingerprint(const std::string& terms, const OrderInputs& inputs,
                             const std::vector<std::filesystem::path>& folders);

// ------------------------------------------------------------------------------------------------
// `kirireel record MODEL` and `kirireel simulate MODEL`.

/// What is to be deployed, and what it leaves. It is filled in three steps: by parsing, by
/// completeOrder() and, for what needs the model, by prepareOrder(). After parsing nothing in it
/// points to the parser.
struct RecordOrder {
  std::filesystem::path model;            ///< a folder or a file
  model::ReadSettings reading;            ///< of `model`
  std::optional<model::Model> madeModel;  ///< takes the place of reading `model`
  std::optional<model::FaceRule>
      faces;  ///< how joints' faces are chosen; absent: as the model has them
  std::optional<std::vector<int>> splitTiles;  ///< tiles that bend, all when empty; absent: none
  /// The word that selects PyKirigami's constants for what is not given; empty: none.
  std::string peerSpelling;
  scene::Scene scene =
      scene::openScene();  ///< everything but the model; the ground's height is not known yet.
                           ///< Its lengths are in the unit of the model until prepared
  SceneRequest request;    ///< what is added to the model
  record::RecordSettings settings;  ///< the folder is empty when --out was not given
  std::vector<InputFile> inputs;    ///< files that were read so far, but for the scene file
  OrderText text;                   ///< the settings, once the order is complete
  bool page = false;                ///< also write page.html, after the other files
  bool printJson = false;           ///< the summary on standard output as JSON
  bool verbose = false;             ///< print all findings, not only the six lines of a run
};

/// Adds `record`. The order must outlive the parsing.
CLI::App* addRecordCommand(CLI::App& program, RecordOrder& order);

/// Adds `simulate`, which paints nothing. The order must outlive the parsing.
CLI::App* addSimulateCommand(CLI::App& program, RecordOrder& order);

/// Checks that a model was named, reads its scene file, and writes down all settings. To be called
/// after parsing. Throws InputError for a missing model, contradictions, and a scene file that
/// cannot be read.
void completeOrder(CLI::App& command, RecordOrder& order);

/// Reads the files that a complete order names, in the order in which its run reads them, as far as
/// they can be read. Throws nothing for files that are wrong: the model's name is empty then.
OrderInputs readInputs(const RecordOrder& order);

/// The fingerprint of a complete order, see orderFingerprint(). 64 hexadecimal digits; the inputs
/// are those of readInputs() or of the run itself.
std::string fingerprintOf(const RecordOrder& order, const OrderInputs& inputs);

/// A run, before or after it was made. Before the run the summary is empty.
struct RecordResult {
  scene::Scene scene;               ///< with its model, complete
  record::RecordSettings settings;  ///< with their folder
  record::RunSummary summary;       ///< of the run, as far as it came
};

/// Reads the model of a complete order and all that it is deployed with; nothing runs yet. Throws
/// as readModel(); what a run can live with is appended to the warnings.
RecordResult prepareOrder(const RecordOrder& order, std::vector<std::string>& warnings);

/// Reads the model, runs it, leaves its files but no checkpoints. The order must be complete.
/// Throws as readModel() and record(). For sweeps: it prints only warnings, on standard error.
RecordResult runOrder(const RecordOrder& order, const record::ProgressObserver& observer);

/// Reads the model, runs it, leaves its files, prints the summary. Returns the exit code. Throws as
/// readModel() and record(). Signals are noted from here on and end the run between steps.
int carryOut(const RecordOrder& order);

}  // namespace kirireel::cli
