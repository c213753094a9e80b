// Options of states, elements and decks, which `record` and `simulate` have too (behind --export),
// and the command that exports a finished run. Every value that decides the bytes of a file says
// itself by saidAs(), so that the fingerprint of a run holds it; aliases (--states beside --state,
// --quadratic beside --linear) decide nothing.
#include "render/cli/export_command.h"

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>

#include "render/cli/exit_codes.h"
#include "render/cli/option_group.h"
#include "render/export/sensitivity.h"
#include "render/export/state_choice.h"
#include "render/folder/output_folder.h"

namespace kirireel {
namespace {

/// One word more than there are commas; empty ones stay, and are refused by those who read them.
std::vector<std::string> splitAtCommas(const TypedValue& value) {
  std::vector<std::string> words;
  std::size_t begin = 0;
  while (begin <= value.text.size()) {
    const std::size_t end = std::min(value.text.find(',', begin), value.text.size());
    words.push_back(value.text.substr(begin, end - begin));
    begin = end + 1;
  }
  return words;
}

void addStateOptions(OptionGroup& group, ExportSettings& settings) {
  // What is typed takes the place of the default.
  // The default is two states. The first state that is typed empties the list, later ones add to
  // it; the flag is shared by both options and outlives this function.
  const auto isTyped = std::make_shared<bool>(false);
  const auto append = [&settings, isTyped](const std::string& name) {
    requireStateName(name);
    if (!*isTyped) settings.states.clear();
    *isTyped = true;
    settings.states.push_back(name);
  };
  group
      .values("--states", "LIST",
              "initial, final, all, shares (25%), times (1.5s), angles that some tile has turned "
              "(30deg), separated by commas (initial,final)",
              [append](const TypedValue& typed) {
                for (const std::string& name : splitAtCommas(typed)) append(name);
              })
      .decidesNothing();  // --state says it
  group
      .values("--state", "NAME", "one of them, or event:TEXT",
              [append](const TypedValue& typed) { append(typed.text); })
      .saidAs([&settings] {
        std::vector<std::string> names;
        for (const std::string& name : settings.states) names.push_back(quotedText(name));
        return quotedList(names);
      });
}

void addElementOptions(CLI::App& command, ElementRule& elements) {
  OptionGroup group(command, "Elements (inp, msh)", "recording");
  // Lengths of 0 mean "as usual" in the rule, so a typed one starts above it.
  const auto length = [&group](const char* name, const char* usual, const char* help,
                               double& target) {
    group
        .value(name, "METRES", usual, help,
               [&target](const TypedValue& typed) {
                 target = parseNumber(typed, {1e-12, 1e9});
               })
        .saidAs([&target] { return target > 0 ? numberText(target) : ""; });
  };
  group
      .value("--elements-per-edge", "COUNT", "8", "along each edge of a tile",
             [&elements](const TypedValue& typed) {
               elements.perEdge = static_cast<int>(parseInteger(typed, {1, 64}));
             })
      .saidAs([&elements] { return elements.perEdge > 0 ? numberText(elements.perEdge) : ""; });
  // Empty words for the default: the count per edge is in force then.
  length("--element-size", "", "the longest element edge, in place of the count", elements.size);
  group.integer("--elements-through", elements.through, {1, 64}, "COUNT", "through the thickness");
  group.flag("--linear", elements.quadratic,
             "8 nodes an element (C3D8I); needs twice as many for the same accuracy", false);
  group
      .flag("--quadratic", "20 nodes an element (C3D20R); the default",
            [&elements] { elements.quadratic = true; })
      .decidesNothing();
  // The first word is the default.
  group.choice<JointStyle>("--joints", elements.joints,
                           {{"shared", JointStyle::Shared},
                            {"equation", JointStyle::Equation},
                            {"patch", JointStyle::Patch},
                            {"neck", JointStyle::Neck}},
                           "shared nodes, *EQUATION, rigid patches, or one sheet with necks");
  // Lengths of necks and patches are metres of the model, whatever the deck's unit.
  length("--patch-radius", "a quarter of the shortest edge",
         "of rigid patches; below half of an edge", elements.patchRadius);
  length("--neck-width", "", "of necks: the material that stays at a joint", elements.neck.width);
  length("--neck-length", "the kerf", "of necks, from tile to tile", elements.neck.length);
  length("--neck-radius", "0", "of the fillets at the ends of necks", elements.neck.radius);
  length("--kerf", "0", "width of the cuts of a sheet with necks", elements.neck.kerf);
  // --shells and --plane-stress exclude each other with some joints; the element rule says so.
  group.flag("--shells", "shells (S8R, S4), offset where joints lie on one face",
             [&elements] { elements.family = ElementFamily::Shell; });
  group.flag("--plane-stress", "plane elements of a sheet with necks (CPS8R, CPS4)",
             [&elements] { elements.family = ElementFamily::Plane; });
}

/// "all", "edge", or numbers with commas; whether the model has such tiles is seen when it is read.
DriveChoice parseDrive(const TypedValue& typed) {
  if (typed.text == "all") return {DriveChoice::All, {}};
  if (typed.text == "edge") return {DriveChoice::Edge, {}};
  DriveChoice drive{DriveChoice::Some, {}};
  for (const std::string& word : splitAtCommas(typed)) {
    drive.tiles.push_back(parseInteger({typed.name, word}, {0, 1e9}));
  }
  return drive;
}

/// `isAlone` tells the command whose options are these alone: names may be short there.
void addDeckOptions(CLI::App& command, DeckSettings& decks, bool isAlone) {
  OptionGroup group(command, "Decks (inp)", "recording");
  // Within `record` the names --solver and --density belong to the simulation, so a deck's have a
  // prefix there.
  group.choice<Solver>(isAlone ? "--solver,--deck-solver" : "--deck-solver", decks.solver,
                       {{"calculix", Solver::Calculix}, {"abaqus", Solver::Abaqus}},
                       "whose keywords are written where they differ");
  group.value(
      "--sets", "WORD", "all up to 1000 tiles",
      "named sets of each tile and joint: none, joints, all", [&decks](const TypedValue& typed) {
        decks.sets = parseChoice<SetChoice>(
            typed,
            {{"none", SetChoice::None}, {"joints", SetChoice::Joints}, {"all", SetChoice::All}});
      });
  // SI units here whatever --deck-unit says; the deck is what is scaled.
  group.number("--youngs", decks.material.youngs, {1e-12, 1e18}, "PASCAL", "Young's modulus");
  // The limits of isotropic material are -1 and 0.5; at either, stiffness is singular.
  group.number("--poisson", decks.material.poisson, {-0.99, 0.499}, "", "Poisson's ratio");
  group.number(isAlone ? "--density,--deck-density" : "--deck-density", decks.material.density,
               {1e-12, 1e9}, "KG/M3", "of the material");
  group.choice<DeckUnit>("--deck-unit", decks.unit,
                         {{"m", DeckUnit::Model}, {"mm-N", DeckUnit::MillimetresNewtons}},
                         "metres with Pa and kg/m3, or millimetres with MPa and t/mm3");
  group.value("--drive", "TILES", "",
              "a second job whose tiles move as in the trajectory: all, edge, or tiles (0,5,12), "
              "numbered as in the model's file, planar ones from 1",
              [&decks](const TypedValue& typed) { decks.drive = parseDrive(typed); });
  group.flag("--buckle", "a further job, for buckling loads", [&decks] { decks.buckling = true; });
  group.flag("--periodic",
             "a further job on a sheet that repeats: opposite ends tied to control nodes",
             [&decks] { decks.periodic = true; });
  group
      .value("--deck-contacts", "FRICTION", "",
             "contact between flanks beside joints, with this coefficient of friction (0: none)",
             [&decks](const TypedValue& typed) {
               decks.contactFriction = parseNumber(typed, {0, 10});
             })
      // Absent contact is no contact; a coefficient of 0 is contact without friction.
      .saidAs([&decks] {
        return decks.contactFriction ? numberText(*decks.contactFriction) : std::string();
      });
  group.flag("--state-map",
             "jobs that move the first state's mesh to the other states, without stress",
             [&decks] { decks.stateMap = true; });
}

/// A folder stands for the trajectory.h5 in it.
std::filesystem::path trajectoryFile(const std::filesystem::path& given) {
  return std::filesystem::is_directory(given) ? given / output::kTrajectory : given;
}

}  // namespace

void addExportOptions(CLI::App& command, const std::string& formatOption,
                      ExportSettings& settings) {
  OptionGroup group(command, "Export", "recording");
  // The list follows the enum, so a new format shows up in the help by itself.
  std::string help = "formats, separated by commas: " + listWords(choiceNames(exportFormatNames()));
  group
      .value(formatOption, "LIST", "", help,
             [&settings](const TypedValue& typed) {
               for (const std::string& word : splitAtCommas(typed)) {
                 settings.formats.push_back(parseChoice({typed.name, word}, exportFormatNames()));
               }
             })
      .saidAs([&settings] {
        std::vector<std::string> names;
        for (const ExportFormat format : settings.formats) {
          names.push_back(nameOfChoice(exportFormatNames(), format));
        }
        return quotedText(fmt::format("{}", fmt::join(names, ",")));
      });
  addStateOptions(group, settings);
  group
      .value("--hinge-width", "METRES", "tile size / 20", "of the necks in cut patterns (svg, dxf)",
             [&settings](const TypedValue& typed) {
               settings.hingeWidth = parseNumber(typed, {1e-12, 1e9});
             })
      .saidAs(
          [&settings] { return settings.hingeWidth > 0 ? numberText(settings.hingeWidth) : ""; });
  addElementOptions(command, settings.elements);
  addDeckOptions(command, settings.decks, formatOption == "--format");
}

CLI::App* addExportCommand(CLI::App& program, ExportOrder& order) {
  CLI::App* command = program.add_subcommand(
      "export", "write states of a trajectory as meshes, finite element decks and drawings");
  addPlace(*command, "TRAJECTORY", order.trajectory, "a trajectory.h5, or the folder it is in");
  OptionGroup group(*command, "Output");
  group.value("--out", "FOLDER", "where the trajectory is", "where the files go",
              [&order](const TypedValue& typed) { order.folder = typed.text; });
  addExportOptions(*command, "--format", order.settings);
  OptionGroup(*command, "Check (inp)")
      .flag(
          "--check",
          "runs the job of each deck in CalculiX, which must be installed, and again with elements "
          "half as long, and says what changes",
          [&order] { order.isChecked = true; });
  command->footer(
      "Examples:\n"
      "  kirireel export out/tessellation_4x4 --format obj,stl --states 0%,25%,50%,100%\n"
      "  kirireel export out/tessellation_4x4 --format inp --state final --joints patch\n"
      "  kirireel export out/tessellation_4x4 --format inp --joints neck --neck-width 0.1\n"
      "  kirireel export out/tessellation_4x4 --format vtu --states all\n"
      "  kirireel export out/tessellation_4x4 --format glb,svg --hinge-width 0.03\n\n"
      "Lengths are metres, times simulated seconds.");
  return command;
}

void completeOrder(const CLI::App& command, ExportOrder& order) {
  requireGiven(order.trajectory, "TRAJECTORY", command);
  if (!order.settings.formats.empty()) return;
  throw InputError(
      "error: --format is missing, as in kirireel export TRAJECTORY --format obj,inp; "
      "see kirireel export --help");
}

int carryOut(const ExportOrder& order) {
  const std::filesystem::path file = trajectoryFile(order.trajectory);
  const TrajectoryReader trajectory(file);
  const std::filesystem::path folder = order.folder.empty() ? file.parent_path() : order.folder;
  // Warnings come before the files, which may take long.
  for (const std::string& line : exportWarnings(trajectory, order.settings)) {
    fmt::print(stderr, "kirireel: {}\n", line);
  }
  for (const std::string& name : exportStates(trajectory, order.settings, folder)) {
    fmt::print("{}\n", (folder / name).string());
  }
  // The check solves every deck twice and may take far longer than the export.
  if (!order.isChecked) return kExitDone;
  for (const std::string& line : meshSensitivity(trajectory, order.settings)) {
    fmt::print("{}\n", line);
  }
  return kExitDone;
}

}  // namespace kirireel
