// `record` and `simulate` differ in their outputs, not in the run: both fill a RecordOrder. The
// steps are:
//
// - completeOrder: reads the scene file to the options, refuses contradictions, writes all settings
//   in one spelling (record_command.h).
// - readScene: reads the model, adds parts (targets, pins, links), converts lengths, applies faces
//   and splits, puts the ground below the lowest point.
// - record(): the run itself (render/record).
// - exitCode: the result for scripts.
//
// With --resume a finished run with the same fingerprint is kept, and an unfinished one continues
// from its checkpoint.
//
// Units. --unit U is the unit of the model's files and of all lengths that the user gives. They are
// converted to metres once, in readScene. Other quantities are given in SI units.
#include "render/cli/record_command.h"

#include <algorithm>
#include <map>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/option_effect.h"
#include "render/cli/option_group.h"
#include "render/cli/report.h"
#include "render/cli/run_commands.h"
#include "render/output/output_folder.h"
#include "render/page/page.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_model.h"

namespace kirireel::cli {
namespace {

/// None of them changes the output bytes, so none is in the fingerprint.
void addFolderOptions(CLI::App& command, RecordOrder& order) {
  OptionGroup group(command, "Output", "recording");
  group
      .value("--out", "FOLDER", "out/NAME of the model", "folder for the files",
             [&order](const scene::TypedValue& typed) { order.settings.folder = typed.text; })
      .excludeFromFingerprint();
  group
      .flag("--resume", order.settings.resume,
            "keep a finished run with the same settings; continue an interrupted one, to the same "
            "bytes")
      .excludeFromFingerprint();
  group
      .flag("--page", order.page,
            "also write page.html: the run in 3-D for any browser, see kirireel page")
      .excludeFromFingerprint();
  group.flag("--json", order.printJson, "print the summary as JSON").excludeFromFingerprint();
  group.flag("--verbose", order.verbose, "print all findings and warnings of the run")
      .excludeFromFingerprint();
}

void addModelOptions(CLI::App& command, RecordOrder& order) {
  OptionGroup group(command, "Model", "model");
  addReadOptions(group, order.reading, true);
  group.choice<std::optional<formats::FaceRule>>(
      "--faces", order.faces,
      {{"model", std::nullopt},
       {"fold", formats::FaceRule::Fold},
       {"pykirigami", formats::FaceRule::PyKirigami}},
      "face of each joint, the model's or by the target's folds");
  group.stored("--split-tiles", order.splitTiles, "LIST", "none",
               "tiles that bend, as hinged triangles: all, or 3,7,8", parseTiles, tilesText);
}

/// Groups are in the order of the help.
void addRunOptions(CLI::App& command, RecordOrder& order) {
  addPlace(command, "MODEL", order.model, formats::kModelForms);
  addFolderOptions(command, order);
  OptionGroup(command, "Output", "recording")
      .integer("--fps", order.settings.framesPerSecond, {1, record::kMaxSampleRate}, "COUNT",
               "samples per simulated second, and frames per second of video, at most 240");
  addModelOptions(command, order);
  addSceneRequestOptions(command, order.request, order.scene.alignment);
  addSceneOptions(command, order.scene);
  addExportOptions(command, "--export", order.settings.exports);
}

constexpr const char* kPeerNote =
    "Lengths are in the unit of the model, times simulated seconds, masses\n"
    "kilograms. PyKirigami's spellings work too: --model, --brick_thickness (-bt),\n"
    "--spring_stiffness (-ss), --force_damping (-fd), --ground_plane (-gp), -gf,\n"
    "--headless, --no_collision (--contacts unjoined), --filter_collision\n"
    "(--contacts none). They, and --like pykirigami, select its dynamics, constants\n"
    "and collisions.\n\n";

/// Harmless faults are added to the warnings; all others throw.
scene::Scene readScene(const RecordOrder& order, std::vector<std::string>& warnings) {
  scene::Scene scene = order.scene;
  scene.model =
      order.madeModel ? *order.madeModel : readModelAt(order.model, {}, order.reading, warnings);
  if (order.madeModel && order.reading.unit && scene.model.unit == LengthUnit{}) {
    scene.model.unit = *order.reading.unit;
    model::scaleLengths(scene.model, scene.model.unit.metres);
  }
  scene::scaleLengths(scene, scene.model.unit.metres);
  scene::completeScene(order.request.parts, scene, warnings);
  scene::fillFromModel(scene);
  if (order.faces) formats::chooseJointFaces(scene.model, *order.faces);
  // After faces, since the triangles of a split tile inherit its joints.
  if (order.splitTiles) scene::splitTiles(*order.splitTiles, scene);
  // The ground is below the bricks at their start, for any thickness.
  if (scene.environment.ground) scene.environment.ground->height = scene::lowestPoint(scene);
  checkThickness(scene, warnings);
  return scene;
}

/// The outcome in the words of summary.json, and whether the run has a shortfall. Diverged is a
/// failure; interrupted has its own code.
int exitCode(const std::string& outcome, bool isShort) {
  if (outcome == run::toString(run::Outcome::Interrupted)) return kExitInterrupted;
  if (outcome == run::toString(run::Outcome::Diverged)) return kExitFailed;
  return isShort ? kExitShort : kExitDone;
}

/// Folders that an order uses in place of files. The names of their files are part of the
/// fingerprint, see roleOf there.
std::vector<std::filesystem::path> foldersOf(const RecordOrder& order) {
  std::vector<std::filesystem::path> folders = {findModel(order.model)};
  folders.insert(folders.end(), order.request.parts.targets.begin(),
                 order.request.parts.targets.end());
  for (const scene::TimelineEntry& entry : order.scene.timeline) {
    if (const auto* target = std::get_if<scene::timeline::GoTo>(&entry.action)) {
      folders.push_back(target->file);
    }
  }
  return folders;
}

/// prepareOrder() with the warnings printed.
RecordResult prepareWithWarnings(const RecordOrder& order) {
  std::vector<std::string> warnings;
  RecordResult result = prepareOrder(order, warnings);
  printWarnings(warnings);
  return result;
}

/// A process may be killed while it moves a complete run into place, or just before it removes the
/// checkpoint. Absent if the folder has another run, an unfinished one, or modified files.
std::optional<record::FinishedRun> findFinished(const record::RecordSettings& settings) {
  std::optional<output::FileSet> files;
  // Opening the set completes moves of a killed process.
  if (isPresent(settings.folder / output::kUnfinished)) {
    files.emplace(settings.folder, output::kSummary);
  }
  std::optional<record::FinishedRun> finished =
      record::findFinishedRun(settings.folder, settings.order);
  if (files && finished) files->dropCheckpoint();
  return finished;
}

/// A file given by its path, or by its name in the model's folder.
std::filesystem::path besideModel(const std::filesystem::path& file,
                                  const std::filesystem::path& model) {
  if (file.empty() || model.empty()) return file;
  const std::filesystem::path place = findModel(model);
  return namedFile(file, isFolder(place) ? place : place.parent_path());
}

}  // namespace

CLI::App* addRecordCommand(CLI::App& program, RecordOrder& order) {
  CLI::App* command =
      program.add_subcommand("record", "deploy a model; write video, pictures, meshes, summary");
  addRunOptions(*command, order);
  addPictureOptions(*command, order.settings);
  addVideoOptions(*command, order.settings);
  OptionGroup(*command, "Output", "recording")
      .flag("--no-meshes", order.settings.meshes, "no OBJ and PLY files", false);
  command->footer(
      fmt::format("Examples:\n"
                  "  kirireel record data/tessellation_4x4\n"
                  "  kirireel record data/tessellation_4x4 --grid 2x3 --view top "
                  "--size 800x600\n"
                  "  kirireel record MODEL --ground --gravity -9.81 --spring-stiffness 25\n\n{}{}",
                  kPeerNote, kExitCodesHelp));
  return command;
}

CLI::App* addSimulateCommand(CLI::App& program, RecordOrder& order) {
  CLI::App* command =
      program.add_subcommand("simulate", "deploy a model; write the end state and the summary");
  addRunOptions(*command, order);
  record::RecordSettings& settings = order.settings;
  settings.video = settings.snapshots = settings.meshes = false;
  command->footer(fmt::format(
      "Example:\n  kirireel simulate data/tessellation_4x4 --solver bullet --json\n\n{}{}",
      kPeerNote, kExitCodesHelp));
  return command;
}

/// Sets PyKirigami's defaults for options that its command line does not give, unless the scene
/// file sets them. Springs move masses of 1 kg, or nothing without a target. Springs are in N/m,
/// equal for all bricks. Bricks collide and are 0.02 m thick. Steps have fixed length (tolerance
/// 0).
void applyPeerDefaults(CLI::App& command) {
  const scene::TargetSpringSettings springs = scene::paperSprings();
  struct PeerDefault {
    const char* option;
    std::string value;
    const char* other = nullptr;  // an equivalent option
  };
  const PeerDefault defaults[] = {
      {"--spring-stiffness", scene::numberText(*springs.springStiffness), "--spring-frequency"},
      {"--torque-stiffness", scene::numberText(*springs.torqueStiffness), "--spring-frequency"},
      {"--force-damping", scene::numberText(*springs.forceDamping), "--damping-ratio"},
      {"--torque-damping", scene::numberText(*springs.torqueDamping), "--damping-ratio"},
      {"--path", "dynamic"},
      {"--contacts", "all"},
      {"--thickness", "0.02"},
      {"--actuation", "target"},
      {"--tolerance", "0"}};
  for (const auto& [option, value, other] : defaults) {
    if (other && command.get_option(other)->count() > 0) continue;
    applySetting(*command.get_option(option), {.table = {}, .key = option, .values = {value}});
  }
}

void completeOrder(CLI::App& command, RecordOrder& order) {
  if (!order.madeModel) requireGiven(order.model, "MODEL", command);
  const std::set<std::string> typed = givenOptions(command);
  // During the lifetime of the record, files that the scene file reads are added to the order's
  // inputs.
  scene::SceneFile file;
  {
    const InputRecord record(order.inputs);
    // A model that was not read from a file has no folder for a scene file.
    if (!order.model.empty() || !order.request.file.empty()) {
      CLI::App program("", "kirireel");
      RecordOrder unused;
      file = readSceneFileOf(command, *addRecordCommand(program, unused), findModel(order.model),
                             order.request, order.scene);
    }
  }
  const bool isLikePeer = !order.peerSpelling.empty();
  order.scene.alignment.movesStart = isLikePeer;
  if (isLikePeer) applyPeerDefaults(command);
  // The order's text holds the values of the scene file.
  std::erase_if(order.inputs, [&](const InputFile& input) { return input.path == file.path; });
  requireConsistent(command, order.scene);
  const bool paints = command.get_option_no_throw("--video") != nullptr;
  requireEffect({.command = &command,
                 .pictures = paints ? &order.settings : nullptr,
                 .exports = &order.settings.exports,
                 // PyKirigami accepts any combination of its options.
                 .scene = isLikePeer ? nullptr : &order.scene,
                 .page = order.page},
                typed);
  order.text = orderText(command, order.scene, file);
  // After the text was made, which has the name as typed.
  order.scene.hinges.file = besideModel(order.scene.hinges.file, order.model);
}

OrderInputs readInputs(const RecordOrder& order) {
  OrderInputs inputs{{}, order.inputs};
  const InputRecord record(inputs.files);
  std::vector<std::string> ignored;
  try {
    scene::Scene scene = order.scene;
    scene.model = order.madeModel
                      ? *order.madeModel
                      : formats::readModel(findModel(order.model), {}, ignored, order.reading);
    scene::SceneParts parts;
    // Pins and links read no files; targets do.
    parts.targets = order.request.parts.targets;
    scene::completeScene(parts, scene, ignored);
    inputs.modelName = scene.model.name;
  } catch (const InputError&) {
    inputs.modelName.clear();  // the run reports the fault
  }
  return inputs;
}

std::string fingerprintOf(const RecordOrder& order, const OrderInputs& inputs) {
  return orderFingerprint(order.text.terms, inputs, foldersOf(order));
}

RecordResult prepareOrder(const RecordOrder& order, std::vector<std::string>& warnings) {
  OrderInputs inputs{{}, order.inputs};
  RecordResult result;
  {
    const InputRecord record(inputs.files);
    result.scene = readScene(order, warnings);
  }
  inputs.modelName = result.scene.model.name;
  result.settings = order.settings;
  result.settings.exports = exports::inMetres(order.settings.exports, result.scene.model.unit);
  result.settings.sceneText = order.text.scene;
  result.settings.peerSpelling = order.peerSpelling;
  result.settings.inputs = inputs.files;
  result.settings.order = fingerprintOf(order, inputs);
  if (result.settings.folder.empty()) {
    result.settings.folder = std::filesystem::path("out") / result.scene.model.name;
  }
  return result;
}

RecordResult runOrder(const RecordOrder& order, const record::ProgressObserver& observer) {
  RecordResult result = prepareWithWarnings(order);
  // A caller in code keeps no checkpoints: a run without a fingerprint cannot be resumed.
  result.settings.order.clear();
  result.summary = record::record(result.scene, result.settings, observer);
  return result;
}

/// Makes the page of a run with completed files.
void addPage(const RecordOrder& order, const std::filesystem::path& folder) {
  if (!order.page) return;
  page::WebPageSettings settings;
  settings.folder = folder;
  settings.appearance = order.settings.appearance;
  page::writePage({folder / output::kTrajectory}, settings);
}

int carryOut(const RecordOrder& order) {
  noteSignals();
  // Before the run, which may take hours.
  if (order.page) page::requirePages();
  RecordResult result = prepareWithWarnings(order);
  // The model must be read first, since its bytes identify the finished run.
  if (order.settings.resume) {
    const auto finished = findFinished(result.settings);
    if (finished) {
      addPage(order, result.settings.folder);
      fmt::print("{}", order.printJson
                           ? finished->summary
                           : fmt::format("{}: finished already, {}\n",
                                         result.settings.folder.string(), finished->outcome));
      return exitCode(finished->outcome, finished->isShort);
    }
  }
  {
    ProgressLine line;
    result.summary =
        record::record(result.scene, result.settings, [&](const record::Progress& progress) {
          const bool isShown = order.verbose || !progress.isRemarkInSummary;
          if (isShown && !progress.remark.empty()) {
            printWarnings({progress.remark});
          }
          line.show(progress);
          return takeInterrupt();
        });
  }
  const auto& [scene, settings, summary] = result;
  addPage(order, settings.folder);
  fmt::print("{}", order.printJson ? record::summaryJson(scene, settings, summary)
                   : order.verbose ? describeRun(scene, settings, summary)
                                   : describeRunBriefly(scene, settings, summary));
  return exitCode(run::toString(summary.outcome), !summary.shortfall.empty());
}

// ------------------------------------------------------------------------------------------------
// Two orders are equal if they give the same bytes. The fingerprint is the SHA-256 (FIPS 180-4) of
// a text:
//
//     versions of the program and its libraries
//     command
//     key = value          every effective option, by table, with its current value
//     [[timeline]] ...     the scene file's lists, in one spelling
//     model NAME
//     SHA-256 ROLE         each input file, in the order in which it was read
//
// Values are taken after parsing, including defaults. It does not matter how a setting was given. A
// default that changes with a version changes the fingerprint. Options without effect in this scene
// and options that do not change the output (--out, --painters) are left out. Hashes replace file
// names: a copy of a model elsewhere is the same model. Within a folder the names count, because
// the reader finds vertices.txt by its name.
//
// Hashing the typed words would be simpler but wrong: the same order has many spellings.

namespace {

namespace fs = std::filesystem;

/// The tables of a scene file, in the order of their names. Options that a scene file cannot set
/// are under "".
std::string tablesText(CLI::App& command, const scene::Scene& scene, bool withFileNames) {
  // Sorted by name; within a table options keep the order in which they were added.
  std::map<std::string, std::string> tables;
  for (CLI::Option* option : command.get_options()) {
    const std::string key = settingKey(*option);
    // An empty text: the option is not in the fingerprint.
    std::string value = key.empty() ? "" : serializedValue(*option);
    if (value.empty() || !hasEffect(option->get_name(), scene)) continue;
    // Hashes identify files, so their names are left out.
    const bool namesFiles = key == "target" || key == "joints_file" || key == "hinge_file";
    if (namesFiles && !withFileNames) value = fmt::format("{} files", option->count());
    tables[settingTable(*option)] += fmt::format("{} = {}\n", key, value);
  }
  std::string text;
  for (const auto& [table, lines] : tables) {
    if (!text.empty()) text += '\n';
    if (!table.empty()) text += fmt::format("[{}]\n", table);
    text += lines;
  }
  return text;
}

/// The identity of an input file. Files of a folder have fixed names, which count: the name. For
/// other files only the ending counts.
std::string roleOf(const fs::path& file, const std::vector<fs::path>& folders) {
  const bool isInFolder = std::ranges::any_of(folders, [&](const fs::path& folder) {
    return !folder.empty() && folder / file.filename() == file;
  });
  return (isInFolder ? file.filename() : file.extension()).string();
}

}  // namespace

OrderText orderText(CLI::App& command, const scene::Scene& scene,
                    const scene::SceneFile& sceneFile) {
  return {tablesText(command, scene, true) + scene::entriesText(sceneFile, true),
          fmt::format("{}\n{}{}", command.get_name(), tablesText(command, scene, false),
                      scene::entriesText(sceneFile, false))};
}

std::string parametersText(CLI::App& command) {
  return fmt::format("{}\n{}", command.get_name(), tablesText(command, {}, true));
}

std::string orderFingerprint(const std::string& terms, const OrderInputs& inputs,
                             const std::vector<fs::path>& folders) {
  std::string text =
      fmt::format("{}\n{}\nmodel {}\n", record::versionText(), terms, inputs.modelName);
  for (const InputFile& file : inputs.files) {
    text += fmt::format("{} {}\n", file.sha256, roleOf(file.path, folders));
  }
  return sha256(text);
}

}  // namespace kirireel::cli
