// One command per family of models (sim/generate/families.h), made from the family's list of
// parameters: name, range, default, unit. A new family needs no change here.
#include "render/cli/model_commands.h"

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>
#include <unistd.h>

#include "render/cli/option_group.h"
#include "render/cli/report.h"
#include "render/cli/scene_options.h"
#include "render/picture/png.h"
#include "render/record/summary.h"
#include "render/report/inspection.h"
#include "sim/base/words.h"
#include "sim/formats/cut_pattern.h"
#include "sim/formats/drawing.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_model.h"
#include "sim/formats/tile_checks.h"
#include "sim/model/isometry.h"
#include "sim/study/stepped_scene.h"

namespace kirireel::cli {
namespace {

/// Values are stored by name. A missing value means the family's own default.
void addParameter(OptionGroup& group, const generate::FamilyParameter& parameter,
                  GenerateOrder& order) {
  const scene::Range range{parameter.least, parameter.most};
  const auto read = [&order, range, name = parameter.name,
                     whole = parameter.whole](const scene::TypedValue& typed) {
    order.values[name] =
        // Whole numbers are stored as doubles, exact up to 2^53.
        whole ? static_cast<double>(scene::parseInteger(typed, range))
              : scene::parseNumber(typed, range);
  };
  const auto write = [&order, parameter] {
    const auto given = order.values.find(parameter.name);
    return scene::numberText(given == order.values.end() ? parameter.defaultValue : given->second);
  };
  group
      .value("--" + parameter.name, parameter.unit, fmt::format("{:.6g}", parameter.defaultValue),
             parameter.help, read)
      .serializedAs(write);
}

}  // namespace

CLI::App* addFamily(CLI::App& generate, const generate::Family& family, GenerateOrder& order) {
  CLI::App* command = generate.add_subcommand(family.name, family.help);
  addPlace(*command, "FOLDER", order.folder, "folder for the model");
  OptionGroup shape(*command, kShapeGroup);
  for (const generate::FamilyParameter& parameter : family.parameters)
    addParameter(shape, parameter, order);
  shape.choice<std::optional<model::JointFace>>("--face", order.face,
                                                {{"auto", std::nullopt},
                                                 {"both", model::JointFace::Both},
                                                 {"bottom", model::JointFace::Bottom},
                                                 {"top", model::JointFace::Top}},
                                                "faces that joints lie on");
  // Called only for the given family. It stores the family's name.
  command->parse_complete_callback([&order, name = family.name] { order.family = name; });
  command->footer(fmt::format("Example:\n  kirireel generate {} my_model", family.name));
  return command;
}

CLI::App* addGenerateCommand(CLI::App& program, GenerateOrder& order) {
  CLI::App* generate = program.add_subcommand("generate", "make a model folder from parameters");
  for (const generate::Family& family : generate::families()) addFamily(*generate, family, order);
  generate->footer("kirireel generate FAMILY --help explains a family.");
  return generate;
}

void completeOrder(const CLI::App& generate, GenerateOrder& order) {
  if (generate.get_subcommands().empty()) {
    throw InputError(
        "error: no family given, as in kirireel generate tessellation FOLDER; see kirireel "
        "generate --help");
  }
  requireGiven(order.folder, "FOLDER", chosenCommand(generate));
}

model::Model makeModel(const GenerateOrder& order) {
  model::Model model = generate::generateModel(generate::familyNamed(order.family), order.values);
  if (order.face) {
    for (model::Joint& joint : model.joints) joint.face = *order.face;
  }
  return model;
}

int carryOut(const GenerateOrder& order) {
  const model::Model model = makeModel(order);
  formats::writeModelFolder(model, order.folder);
  fmt::print("{}: {}, {}\n", order.folder.string(), counted(model.tiles.size(), "tile"),
             counted(model.joints.size(), "joint"));
  return kExitDone;
}

// ------------------------------------------------------------------------------------------------
// Reads a model in any format of readModel() and writes it in the format of OUT's ending. Positions
// are written to the last bit. writeModel() reports data that a format cannot store (for example, a
// .fold file has no faces of joints in thick bricks).

CLI::App* addConvertCommand(CLI::App& program, ConvertOrder& order) {
  CLI::App* command = program.add_subcommand("convert", "write a model in another format");
  addPlace(*command, "IN", order.input, formats::kModelForms);
  addPlace(*command, "OUT", order.output,
           "a .fold file, an .obj file (the target goes to NAME_deployed.obj), NAME_vertices.txt "
           "for the planar files of the quasicrystal simulator, or a folder");
  OptionGroup group(*command, "Model");
  addTargetOption(group, order.target);
  addReadOptions(group, order.reading);
  command->footer(
      "Examples:\n  kirireel convert data/tessellation_4x4 sheet.fold\n"
      "  kirireel convert NAME_contracted.obj my_model\n"
      "  kirireel convert data/penrose_30 penrose_vertices.txt");
  return command;
}

void completeOrder(const CLI::App& command, ConvertOrder& order) {
  requireGiven(order.input, "IN", command);
  requireGiven(order.output, "OUT", command);
}

/// Parts of a model besides tiles and joints: a name, with {} for the plural's s, and a number.
std::vector<std::pair<const char*, std::ptrdiff_t>> contentsOf(const model::Model& model) {
  const auto count = [&](auto&& property) { return std::ranges::count_if(model.joints, property); };
  return {
      {"target{}", std::ssize(model.waypoints) + (model.target ? 1 : 0)},
      {"fold angle{}", std::ssize(model.foldAngles) / 2},
      {"neck{}", count([](const model::Joint& joint) { return static_cast<bool>(joint.neck); })},
      {"joint{} on the bottom face",
       count([](const model::Joint& joint) { return joint.face == model::JointFace::Bottom; })},
      {"joint{} on the top face",
       count([](const model::Joint& joint) { return joint.face == model::JointFace::Top; })}};
}

/// Warns of what a written file has not stored. `stored`: the model as read from it.
void warnOfLosses(const model::Model& model, const model::Model& stored,
                  const std::filesystem::path& output) {
  std::vector<std::string> lost;
  const auto before = contentsOf(model), after = contentsOf(stored);
  for (std::size_t i = 0; i < before.size(); ++i) {
    const std::ptrdiff_t count = before[i].second - after[i].second;
    if (count <= 0) continue;
    lost.push_back(fmt::format("{} {}", count,
                               fmt::format(fmt::runtime(before[i].first), count == 1 ? "" : "s")));
  }
  if (lost.empty()) return;
  printWarnings({fmt::format("{}: warning: this format cannot store {}; use a .fold file",
                             output.string(), fmt::join(lost, ", "))});
}

int carryOut(const ConvertOrder& order) {
  const model::Model model = readModelAt(order.input, order.target, order.reading);
  formats::writeModel(model, order.output);
  std::vector<std::string> warnings;
  const model::Model stored = formats::readModel(order.output, std::nullopt, warnings);
  warnOfLosses(model, stored, order.output);
  fmt::print("{}: {}, {}{}\n", order.output.string(), counted(stored.tiles.size(), "tile"),
             counted(stored.joints.size(), "joint"), stored.target ? ", a target" : "");
  return kExitDone;
}

// ------------------------------------------------------------------------------------------------
// Reads a model as `record` would, aligns its start to its target, and prints counts, mobility and
// faults. Does not run it.

namespace {

// Pixels of each of the two states.
constexpr picture::FrameSize kStateSize{1200, 1200};

/// The rank of the constraints takes long in large sheets. The line shows the stage.
report::Inspection inspectWithProgress(const scene::Scene& scene) {
  ProgressLine line;
  return report::inspect(scene, [&line](const char* what) { line.show(what); });
}

/// Reads the model. For an invalid tile it writes a picture and throws the error again.
model::Model readOrPaintFault(const InspectOrder& order) {
  try {
    return readModelAt(order.model, order.target, order.reading);
  } catch (const formats::CrossedTile& error) {
    if (!order.picture.empty()) {
      picture::writePng(report::crossingPicture(error.tile(), error.place(), kStateSize),
                        order.picture);
    }
    throw;
  } catch (const formats::DrawingFault& fault) {
    if (!order.picture.empty()) {
      picture::writePng(report::faultPicture(fault, kStateSize), order.picture);
    }
    throw;
  }
}

/// The lines of a drawing that are not cut. Null with a target, which moves the start away from its
/// drawing.
std::optional<std::vector<formats::DrawnPath>> ignoredLines(const InspectOrder& order,
                                                            const model::Model& model) {
  const std::filesystem::path file = findModel(order.model);
  if (!formats::isDrawing(file) || model.target) return std::nullopt;
  std::vector<std::string> known;  // readOrPaintFault() printed them
  return formats::readDrawnSheet(file, order.reading, known).ignored;
}

}  // namespace

CLI::App* addInspectCommand(CLI::App& program, InspectOrder& order) {
  CLI::App* command =
      program.add_subcommand("inspect", "report a model's tiles, joints, mobility and faults");
  addPlace(*command, "MODEL", order.model, formats::kModelForms);
  OptionGroup group(*command, "Model");
  addTargetOption(group, order.target);
  addReadOptions(group, order.reading);
  // Set the default in the scene first: adding the option copies it into the help.
  order.scene = scene::openScene();
  group.setting(scene::sceneSetting("thickness"), order.scene);
  OptionGroup output(*command, "Output");
  output.flag("--json", "print as JSON", [&order] { order.printJson = true; });
  output.value("--picture", "FILE", "",
               "write a PNG file of both states with tile numbers and marks on repairs, or of the "
               "faulty tile or drawing",
               [&order](const scene::TypedValue& typed) {
                 order.picture = typed.text;
                 if (order.picture.extension() != ".png")
                   throw scene::valueError(typed, "a name that ends with .png");
               });
  command->footer("Example:\n  kirireel inspect data/tessellation_4x4 --picture numbers.png");
  return command;
}

void completeOrder(const CLI::App& command, InspectOrder& order) {
  requireGiven(order.model, "MODEL", command);
}

int carryOut(const InspectOrder& order) {
  scene::Scene scene = order.scene;
  scene.model = readOrPaintFault(order);
  scene::fillFromModel(scene);
  std::vector<std::string> warnings;
  checkThickness(scene, warnings);
  printWarnings(warnings);
  // The needs of a run depend on the position of its start.
  if (scene.model.target) model::alignToStart(scene.model, *scene.model.target);
  const report::Inspection inspection = inspectWithProgress(scene);
  fmt::print("{}", order.printJson ? report::inspectionJson(inspection)
                                   : report::inspectionText(inspection));
  if (!order.picture.empty()) {
    picture::writePng(report::numberedPicture(scene, kStateSize, ignoredLines(order, scene.model)),
                      order.picture);
  }
  return kExitDone;
}

// ------------------------------------------------------------------------------------------------
// The models that findModel() knows, one per line.

CLI::App* addModelsCommand(CLI::App& program, ModelsOrder&) {
  CLI::App* command = program.add_subcommand(
      "models", "list the models in data/ and those installed with the program");
  command->footer("Each can be named without its folder, as in kirireel record fan.");
  return command;
}

void completeOrder(const CLI::App&, ModelsOrder&) {}

int carryOut(const ModelsOrder&) {
  const std::map<std::string, std::filesystem::path> models = knownModels();
  if (models.empty()) {
    throw InputError(
        "error: there are no models in data/, and none are installed; change to the folder of the "
        "sources, or install the program");
  }
  std::size_t width = 4;
  for (const auto& [name, place] : models) width = std::max(width, name.size());
  fmt::print("{:<{}}  {:>6}  {:>6}  target\n", "name", width, "tiles", "joints");
  for (const auto& [name, place] : models) {
    try {
      std::vector<std::string> ignored;
      const model::Model model = formats::readModel(place, {}, ignored);
      fmt::print("{:<{}}  {:>6}  {:>6}  {}\n", name, width, model.tiles.size(), model.joints.size(),
                 model.target ? "yes" : "no");
    } catch (const InputError& error) {
      fmt::print("{:<{}}  {}\n", name, width, oneLine(error.what()));
    }
  }
  return kExitDone;
}

// ------------------------------------------------------------------------------------------------
// Studies measure this machine: seconds of CPU time against error, of our solver and of Bullet's.
// Each finished row is stored, so an interrupted study continues with --resume.

namespace {

constexpr const char* kAll = "all";

std::string studyList() {
  std::string text;
  for (const study::Study& study : study::studies())
    text += fmt::format("{:<16}{}\n", study.name, study.help);
  return text + fmt::format("{:<16}{}\n", kAll, "these one after the other");
}

/// Throws InputError for an unknown name.
std::vector<const study::Study*> chosenStudies(const std::string& name) {
  std::vector<const study::Study*> chosen;
  if (name != kAll) return {&study::studyNamed(name)};
  for (const study::Study& study : study::studies()) chosen.push_back(&study);
  return chosen;
}

/// The command to repeat it, without --resume, which changes no result. For the caption of NAME.csv
/// and NAME.json.
std::string commandText(const StudyOrder& order) {
  return fmt::format("kirireel study {}{}", order.name.string(),
                     order.settings.extent == study::Extent::Quick ? " --quick" : "");
}

/// Versions that affect a timing: program, compiler, Eigen, Bullet.
std::string ownVersions() {
  std::vector<std::string> parts;
  for (const auto& [name, version] : record::allVersions()) {
    if (name == "kirireel" || name == "compiler" || name == "eigen" || name == "bullet") {
      parts.push_back(fmt::format("{} {}", name, version));
    }
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// Returns whether the study came to its end.
bool runOne(const study::Study& study, const study::StudySettings& settings) {
  const bool isTerminal = isatty(STDERR_FILENO) != 0;
  bool stopped = false;
  const study::Table table = study::runStudy(
      study, settings, [&](const std::string& name, std::size_t done, std::size_t total) {
        if (isTerminal) {
          fmt::print(stderr, "\r\033[K{} {}/{}: {}", study.name, done, total, name);
        }
        // Checked after each case.
        stopped = takeInterrupt().has_value();
        return !stopped;
      });
  // Removes the line of progress before printing results.
  if (isTerminal) fmt::print(stderr, "\r\033[K");
  if (stopped) return false;
  const std::filesystem::path file = settings.folder / (study.name + ".csv");
  fmt::print("{}: {} rows in {}\n", study.name, table.rows.size(), file.string());
  for (const study::Finding& finding : study.findings(table)) {
    fmt::print("  {:<40} {:<12.4g} {}\n", finding.name, finding.value, finding.meaning);
  }
  std::fflush(stdout);
  return true;
}

}  // namespace

CLI::App* addStudyCommand(CLI::App& program, StudyOrder& order) {
  order.settings.folder = "out/study";
  CLI::App* command = program.add_subcommand(
      "study", "measure speed against error on this machine, compared with Bullet");
  addPlace(*command, "NAME", order.name, "a study, or all; see --list");
  OptionGroup group(*command, "Study");
  group.flag("--list", "list the studies", [&order] { order.list = true; });
  group.flag("--quick", "fewer and smaller cases: all studies within five minutes",
             [&order] { order.settings.extent = study::Extent::Quick; });
  group.flag("--resume", "keep the finished rows of an earlier, interrupted run",
             [&order] { order.settings.resume = true; });
  group.value("--out", "FOLDER", order.settings.folder.string(),
              "folder for NAME.csv and NAME.json; scripts/plot-study plots them",
              [&order](const scene::TypedValue& typed) { order.settings.folder = typed.text; });
  command->footer("Example:\n  kirireel study work-precision --quick");
  return command;
}

void completeOrder(const CLI::App& command, StudyOrder& order) {
  if (!order.list) requireGiven(order.name, "NAME", command);
}

int carryOut(const StudyOrder& order) {
  if (order.list) {
    fmt::print("{}", studyList());
    return kExitDone;
  }
  const std::vector<const study::Study*> chosen = chosenStudies(order.name.string());
  study::StudySettings settings = order.settings;
  settings.command = commandText(order);
  settings.versions = ownVersions();
  noteSignals();
  for (const study::Study* study : chosen) {
    if (runOne(*study, settings)) continue;
    fmt::print(stderr, "kirireel: interrupted; --resume continues after the finished rows\n");
    return kExitInterrupted;
  }
  return kExitDone;
}

}  // namespace kirireel::cli
