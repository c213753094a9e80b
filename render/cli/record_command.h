/// `kirireel record MODEL` and `kirireel simulate MODEL`.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "render/cli/order_fingerprint.h"
#include "render/cli/scene_options.h"
#include "render/record/record.h"
#include "sim/model/face_choice.h"
#include "sim/model/mending.h"
#include "sim/scene/scene.h"

namespace CLI {
class App;
}

namespace kirireel {

/// What is to be deployed, and what it leaves. It is filled in three steps: by parsing, by
/// completeOrder() and, for what needs the model, by prepareOrder(). After parsing nothing in it
/// points to the parser.
struct RecordOrder {
  std::filesystem::path model;
  ReadSettings reading;            ///< of `model`
  std::optional<Model> madeModel;  ///< takes the place of reading `model`
  std::optional<FaceRule> faces;   ///< how joints' faces are chosen; absent: as the model has them
  std::optional<std::vector<int>> splitTiles;  ///< tiles that bend, all when empty; absent: none
  double unit = 1;  ///< of length in all files, metres; gravity and density are SI until prepared
  Scene scene = openScene();  ///< everything but the model; the ground's height is not known yet
  SceneRequest request;       ///< what is added to the model
  RecordSettings settings;    ///< the folder is empty when --out was not given
  std::vector<InputFile> inputs;  ///< files that were read so far, but for the scene file
  OrderText text;                 ///< the settings, once the order is complete
  bool page = false;              ///< page.html beside the other files, once they are in place
  bool printJson = false;         ///< the summary on standard output as JSON
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

/// What tells a complete order from all others, see orderFingerprint(). 64 hexadecimal digits; the
/// inputs are those of readInputs() or of the run itself.
std::string fingerprintOf(const RecordOrder& order, const OrderInputs& inputs);

/// A run, before or after it was made. Before the run the summary is empty.
struct RecordResult {
  Scene scene;
  RecordSettings settings;  ///< with their folder
  RunSummary summary;
};

/// Reads the model of a complete order and all that it is deployed with; nothing runs yet. Throws
/// as readModel(); what a run can live with is appended to the warnings.
RecordResult prepareOrder(const RecordOrder& order, std::vector<std::string>& warnings);

/// Reads the model, runs it, leaves its files but no checkpoints. The order must be complete.
/// Throws as readModel() and record(). For sweeps: what it prints are warnings alone, on standard
/// error.
RecordResult runOrder(const RecordOrder& order, const ProgressObserver& observer);

/// Reads the model, runs it, leaves its files, prints the summary. Returns the exit code. Throws as
/// readModel() and record(). Signals are noted from here on and end the run between steps.
int carryOut(const RecordOrder& order);

}  // namespace kirireel
