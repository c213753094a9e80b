#include "render/cli/command_line.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <regex>

#include <CLI/CLI.hpp>

#include "render/cli/option_values.h"
#include "render/cli/peer_spellings.h"
#include "render/cli/spelling.h"
#include "render/record/versions.h"

namespace kirireel {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;
constexpr Range kFromZero{0, 1e12};

/// Adds options of one group to a command; each knows how to read its value, so that every wrong
/// value is reported in the same words.
class OptionGroup {
 public:
  OptionGroup(CLI::App& command, std::string group) : command_(command), group_(std::move(group)) {}

  using Reader = std::function<void(const OptionValue&)>;

  void value(const std::string& name, const std::string& unit, const std::string& usual,
             const std::string& help, const Reader& read) {
    const std::string text = usual.empty() ? help : fmt::format("{} (default {})", help, usual);
    const auto readText = [name, read](const std::string& typed) { read({name, typed}); };
    command_.add_option_function<std::string>(name, readText, text)
        ->type_name(unit)
        ->group(group_)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  }

  void number(const std::string& name, double& target, Range range, const std::string& unit,
              const std::string& help) {
    value(name, unit, fmt::format("{:.4g}", target), help,
          [&target, range](const OptionValue& typed) { target = parseNumber(typed, range); });
  }

  template <typename Integer>
  void integer(const std::string& name, Integer& target, Range range, const std::string& unit,
               const std::string& help) {
    value(name, unit, fmt::format("{}", target), help, [&target, range](const OptionValue& typed) {
      target = static_cast<Integer>(parseInteger(typed, range));
    });
  }

  /// The first choice is the default.
  template <typename T, typename Target>
  void choice(const std::string& name, Target& target, const Choices<T>& choices,
              const std::string& help) {
    const std::vector<std::string> words = choiceNames(choices);
    value(name, "WORD", words.front(), fmt::format("{}: {}", help, listWords(words)),
          [&target, choices](const OptionValue& typed) { target = parseChoice(typed, choices); });
  }

  void flag(const std::string& name, const std::string& help, const std::function<void()>& action) {
    command_.add_flag_callback(name, action, help)->group(group_);
  }

 private:
  CLI::App& command_;
  std::string group_;
};

void addBrickOptions(CLI::App& command, BrickRule& brick) {
  OptionGroup group(command, "Bricks");
  group.number("--thickness", brick.thickness, {1e-9, 1e9}, "METRES", "thickness of the bricks");
  group.choice<MassRule>("--mass", brick.mass,
                         {{"unit", MassRule::Unit}, {"prism", MassRule::Prism}},
                         "mass of a brick, 1 kg whatever its size or by volume");
  group.number("--density", brick.density, {1e-9, 1e12}, "KG/M3", "density, with --mass prism");
}

void addSpringOptions(CLI::App& command, TargetSpringSettings& springs) {
  OptionGroup group(command, "Springs to the target");
  group.number("--spring-stiffness", springs.springStiffness, kFromZero, "N/M",
               "pull on each vertex towards its target");
  group.number("--torque-stiffness", springs.torqueStiffness, kFromZero, "N/M",
               "the same pull where it only turns the brick");
  group.number("--force-damping", springs.forceDamping, kFromZero, "N*S/M",
               "damping of a brick's velocity");
  group.number("--torque-damping", springs.torqueDamping, kFromZero, "N*M*S",
               "damping of a brick's turning");
  group.flag("--no-adaptive", "keep the stiffness when the error stalls, instead of doubling it",
             [&springs] { springs.adaptive = false; });
}

void addEnvironmentOptions(CLI::App& command, Environment& environment) {
  OptionGroup group(command, "Environment");
  group.value("--gravity", "M/S2", "0", "acceleration along z, or X,Y,Z",
              [&](const OptionValue& typed) { environment.gravity = parseGravity(typed); });
  const auto setGround = [&environment] {
    if (!environment.ground) environment.ground = Ground{};
  };
  group.flag("--ground", "put a horizontal plane under the lowest point of start and target",
             setGround);
  group.value("--ground-friction", "RATIO", "0.5",
              "Coulomb friction of the ground; implies --ground",
              [&environment, setGround](const OptionValue& typed) {
                setGround();
                environment.ground->friction = parseNumber(typed, {0, 1e3});
              });
  group.choice<ContactFilter>("--contacts", environment.contacts,
                              {{"all", ContactFilter::All},
                               {"unjoined", ContactFilter::Unjoined},
                               {"none", ContactFilter::None}},
                              "pairs of bricks that may touch; others pass through each other");
  group.number("--brick-friction", environment.brickFriction, {0, 1e3}, "RATIO",
               "Coulomb friction between bricks");
  group.number("--linear-damping", environment.linearDamping, {0, 1}, "SHARE",
               "part of the velocity lost a second");
  group.number("--angular-damping", environment.angularDamping, {0, 1}, "SHARE",
               "part of the turning lost a second");
}

void addSolverOptions(CLI::App& command, SolverSettings& solver) {
  OptionGroup group(command, "Solver");
  group.choice<SolverKind>("--solver", solver.kind,
                           {{"direct", SolverKind::Direct}, {"bullet", SolverKind::Bullet}},
                           "how joints are held, exactly or by Bullet's impulses");
  group.number("--timestep", solver.timestep, {1e-7, 1}, "SECONDS", "longest step");
  group.value("--substeps", "COUNT", "1 direct, 20 bullet", "solver steps in each step",
              [&solver](const OptionValue& typed) {
                solver.substeps = static_cast<int>(parseInteger(typed, {1, 10000}));
              });
  group.integer("--iterations", solver.iterations, {1, 1000000}, "COUNT",
                "of Bullet's solver in each step");
  group.choice<std::optional<bool>>("--planar", solver.planar,
                                    {{"auto", std::nullopt}, {"on", true}, {"off", false}},
                                    "keep bricks in their plane");
  group.integer("--seed", solver.seed, {0, 4294967295.0}, "NUMBER",
                "of the nudge that leaves a start where no direction is preferred");
}

void addStopOptions(CLI::App& command, StopRules& stop) {
  OptionGroup group(command, "End of the run");
  group.number("--duration", stop.duration, {1e-6, 1e6}, "SECONDS",
               "simulated time at most; a run that comes to rest ends earlier");
}

void addFolderOptions(CLI::App& command, RecordOrder& order) {
  OptionGroup group(command, "Output");
  group.value("--out", "FOLDER", "out/NAME of the model", "where the files go",
              [&order](const OptionValue& typed) { order.settings.folder = typed.text; });
  group.flag("--json", "print the summary as JSON", [&order] { order.printJson = true; });
}

void addPictureOptions(CLI::App& command, RecordSettings& settings) {
  OptionGroup group(command, "Pictures");
  group.value("--size", "WxH", "1280x720", "of each picture, pixels",
              [&](const OptionValue& typed) { settings.size = parseSize(typed); });
  group.choice<std::optional<ViewAngles>>(
      "--view", settings.view,
      {{"auto", std::nullopt},
       {"top", kTopView},
       {"front", kFrontView},
       {"iso", kIsometricView},
       {"oblique", kObliqueView}},
      "where the camera stands, auto is top for a flat model, else iso");
  group.value("--grid", "RxC", "3x3", "rows and columns of the snapshot grid",
              [&](const OptionValue& typed) { settings.grid = parseGrid(typed); });
  group.choice<SnapshotSpacing>(
      "--snapshots", settings.spacing,
      {{"progress", SnapshotSpacing::Progress}, {"time", SnapshotSpacing::Time}},
      "spacing of the grid's pictures, in equal shares of way or of time");
  group.flag("--frames", "write every frame of the video as a PNG into frames/",
             [&settings] { settings.frames = true; });
  group.flag("--no-video", "no deployment.mp4", [&settings] { settings.video = false; });
  group.flag("--no-snapshots", "no snapshots.png", [&settings] { settings.snapshots = false; });
  group.flag("--no-meshes", "no OBJ and PLY files", [&settings] { settings.meshes = false; });
}

void addRunOptions(CLI::App& command, RecordOrder& order) {
  command
      .add_option("MODEL", order.model,
                  "folder with vertices.txt, constraints.txt and optionally target.txt, pull.txt")
      ->type_name("");
  addFolderOptions(command, order);
  OptionGroup(command, "Output")
      .integer("--fps", order.settings.framesPerSecond, {1, 240}, "COUNT",
               "frames, and samples, a simulated second");
  addBrickOptions(command, order.scene.brick);
  addSpringOptions(command, order.scene.springs);
  addEnvironmentOptions(command, order.scene.environment);
  addStopOptions(command, order.scene.stop);
  addSolverOptions(command, order.scene.solver);
}

constexpr const char* kPeerNote =
    "Lengths are metres, times simulated seconds, masses kilograms. PyKirigami's spellings work\n"
    "too: --model, --brick_thickness, --spring_stiffness, --force_damping, --ground_plane,\n"
    "--no_collision (the same as --contacts unjoined), -ss, -fd, -bt, -gp, -gf. --headless is\n"
    "accepted and does nothing: no window is ever opened.";

CLI::App* addRecordCommand(CLI::App& program, RecordOrder& order) {
  CLI::App* command =
      program.add_subcommand("record", "deploy a model; leave video, pictures, meshes, summary");
  addRunOptions(*command, order);
  addPictureOptions(*command, order.settings);
  command->footer(
      fmt::format("Examples:\n"
                  "  kirireel record data/tessellation_4x4\n"
                  "  kirireel record data/tessellation_4x4 --out out/figure --grid 2x3 --view top "
                  "--size 800x600\n"
                  "  kirireel record MODEL --ground --gravity -9.81 --spring-stiffness 25\n\n{}",
                  kPeerNote));
  return command;
}

CLI::App* addSimulateCommand(CLI::App& program, RecordOrder& order) {
  CLI::App* command =
      program.add_subcommand("simulate", "deploy a model; leave the end state and the summary");
  addRunOptions(*command, order);
  RecordSettings& settings = order.settings;
  settings.video = settings.snapshots = settings.meshes = false;
  command->footer(fmt::format(
      "Example:\n  kirireel simulate data/tessellation_4x4 --solver bullet --json\n\n{}",
      kPeerNote));
  return command;
}

CLI::App* addGenerateCommand(CLI::App& program, GenerateOrder& order) {
  CLI::App* generate = program.add_subcommand("generate", "make a model folder from parameters");
  CLI::App* command =
      generate->add_subcommand("tessellation", "rotating rectangles, joined at their corners");
  command->add_option("FOLDER", order.folder, "where the model goes")->type_name("");
  OptionGroup group(*command, "Shape");
  TessellationShape& shape = order.shape;
  group.integer("--columns", shape.columns, {1, 1000}, "COUNT", "tiles along x");
  group.integer("--rows", shape.rows, {1, 1000}, "COUNT", "tiles along y");
  group.number("--length", shape.length, {1e-9, 1e9}, "METRES", "of a tile along x when closed");
  group.number("--width", shape.width, {1e-9, 1e9}, "METRES", "of a tile along y when closed");
  const auto angle = [&group](const std::string& name, double& target, const std::string& help) {
    group.value(name, "DEGREES", fmt::format("{:g}", target / kDegree), help,
                [&target](const OptionValue& typed) {
                  target = parseNumber(typed, {0, 180}) * kDegree;
                });
  };
  angle("--start-angle", shape.startAngle, "between neighbours at the start, 0 is closed");
  angle("--target-angle", shape.targetAngle, "between neighbours at the target");
  group.choice<JointFace>(
      "--face", shape.face,
      {{"both", JointFace::Both}, {"bottom", JointFace::Bottom}, {"top", JointFace::Top}},
      "faces that joints lie on");
  command->footer("Example:\n  kirireel generate tessellation my_model --columns 8 --rows 5");
  return generate;
}

std::vector<std::string> optionNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> commandNames(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::App* sub : command.get_subcommands({})) names.push_back(sub->get_name());
  return names;
}

/// The innermost command that was given, e.g. "generate tessellation".
const CLI::App& chosenCommand(const CLI::App& program) {
  const CLI::App* command = &program;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  return *command;
}

std::string fullName(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent == nullptr ? command.get_name() : fullName(*parent) + " " + command.get_name();
}

std::string helpText(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  // CLI11 leaves two blank lines between groups; one will do.
  const std::string help = command.help(parent == nullptr ? "" : fullName(*parent));
  const std::string text = std::regex_replace(help, std::regex("\n\n\n+"), "\n\n");
  return text.ends_with('\n') ? text : text + '\n';
}

/// Arguments that no option and no place took: the first unknown option, else the first of all.
void requireNothingLeft(const CLI::App& program) {
  std::vector<std::string> left = program.remaining(true);
  std::erase(left, "--");
  if (left.empty()) return;
  const CLI::App& command = chosenCommand(program);
  const std::string help = fmt::format("see {} --help", fullName(command));
  for (const std::string& argument : left) {
    if (!argument.starts_with('-')) continue;
    const std::string name = argument.substr(0, argument.find('='));
    throw InputError(fmt::format("error: unknown option {}{}; {}", name,
                                 suggestion(name, optionNames(command)), help));
  }
  const std::vector<std::string> commands = commandNames(command);
  if (!commands.empty()) {
    throw InputError(fmt::format("error: unknown command {}{}; {}", left.front(),
                                 suggestion(left.front(), commands), help));
  }
  throw InputError(fmt::format("error: '{}' is one argument too many; {}", left.front(), help));
}

/// CLI11's text starts with the option that lacks its value and a colon.
InputError missingValue(const std::string& text, const CLI::App& command) {
  return InputError(fmt::format("error: {} needs a value; see {} --help",
                                text.substr(0, text.find(':')), fullName(command)));
}

/// Parses into what the program's options point at, or gives the page that was asked for instead.
std::optional<PrintOrder> parseInto(CLI::App& program, const std::vector<std::string>& arguments) {
  // CLI11 takes the arguments from the back.
  std::vector<std::string> reversed = translatePeerSpellings(arguments);
  std::reverse(reversed.begin(), reversed.end());
  try {
    program.parse(reversed);
  } catch (const CLI::CallForVersion& call) {
    return PrintOrder{call.what()};
  } catch (const CLI::CallForHelp&) {
    return PrintOrder{helpText(chosenCommand(program))};
  } catch (const CLI::ArgumentMismatch& error) {
    throw missingValue(error.what(), chosenCommand(program));
  } catch (const CLI::ParseError& error) {
    throw InputError(
        fmt::format("error: {}; see {} --help", error.what(), fullName(chosenCommand(program))));
  }
  return std::nullopt;
}

void requireFamily(const CLI::App& generate) {
  if (!generate.get_subcommands().empty()) return;
  throw InputError(
      "error: no family given, as in kirireel generate tessellation FOLDER; see kirireel generate "
      "--help");
}

void requireGiven(const std::filesystem::path& path, const char* what, const CLI::App& command) {
  if (!path.empty()) return;
  const std::string name = fullName(command);
  throw InputError(fmt::format("error: {0} is missing, as in {1} {0}; see {1} --help", what, name));
}

}  // namespace

Order parseCommandLine(const std::vector<std::string>& arguments) {
  RecordOrder record;
  RecordOrder simulate;
  GenerateOrder generate;
  CLI::App program("Records kirigami deployments off screen.", "kirireel");
  program.allow_extras();
  program.set_version_flag("--version", versionText());
  const CLI::App* recordCommand = addRecordCommand(program, record);
  const CLI::App* simulateCommand = addSimulateCommand(program, simulate);
  const CLI::App* generateCommand = addGenerateCommand(program, generate);
  program.footer("kirireel COMMAND --help explains a command.");

  if (const std::optional<PrintOrder> page = parseInto(program, arguments)) return *page;
  requireNothingLeft(program);
  if (recordCommand->parsed()) {
    requireGiven(record.model, "MODEL", *recordCommand);
    return record;
  }
  if (simulateCommand->parsed()) {
    requireGiven(simulate.model, "MODEL", *simulateCommand);
    return simulate;
  }
  if (generateCommand->parsed()) {
    requireFamily(*generateCommand);
    requireGiven(generate.folder, "FOLDER", chosenCommand(program));
    return generate;
  }
  throw InputError(
      "error: no command given; choose record, simulate or generate, see kirireel --help");
}

}  // namespace kirireel
