#include "render/cli/export_command.h"

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>

#include "render/cli/exit_codes.h"
#include "render/cli/option_group.h"
#include "render/export/state_choice.h"
#include "render/folder/output_folder.h"

namespace kirireel {
namespace {

std::vector<std::string> splitAtCommas(const OptionValue& value) {
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
              [append](const OptionValue& typed) {
                for (const std::string& name : splitAtCommas(typed)) append(name);
              })
      .decidesNothing();  // --state says it
  group
      .values("--state", "NAME", "one of them, or event:TEXT",
              [append](const OptionValue& typed) { append(typed.text); })
      .saidAs([&settings] {
        std::vector<std::string> names;
        for (const std::string& name : settings.states) names.push_back(quotedText(name));
        return quotedList(names);
      });
}

void addElementOptions(CLI::App& command, ElementRule& elements) {
  OptionGroup group(command, "Elements (inp, msh)");
  group.integer("--elements-per-edge", elements.perEdge, {1, 64}, "COUNT",
                "along each edge of a tile");
  group.integer("--elements-through", elements.through, {1, 64}, "COUNT", "through the thickness");
  group.flag("--quadratic", elements.quadratic, "20 and 15 nodes an element, for bending");
  group.choice<JointStyle>("--joints", elements.joints,
                           {{"shared", JointStyle::Shared},
                            {"equation", JointStyle::Equation},
                            {"patch", JointStyle::Patch}},
                           "shared nodes, *EQUATION, or rigid patches");
  group.number("--patch-radius", elements.patchRadius, {0, 1e9}, "METRES",
               "of rigid patches; below half of an edge");
}

std::filesystem::path trajectoryFile(const std::filesystem::path& given) {
  return std::filesystem::is_directory(given) ? given / output::kTrajectory : given;
}

}  // namespace

void addExportOptions(CLI::App& command, const std::string& formatOption,
                      ExportSettings& settings) {
  OptionGroup group(command, "Export");
  std::string help = "formats, separated by commas: " + listWords(choiceNames(exportFormatNames()));
  group
      .value(formatOption, "LIST", "", help,
             [&settings](const OptionValue& typed) {
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
             [&settings](const OptionValue& typed) {
               settings.hingeWidth = parseNumber(typed, {1e-12, 1e9});
             })
      .saidAs(
          [&settings] { return settings.hingeWidth > 0 ? numberText(settings.hingeWidth) : ""; });
  addElementOptions(command, settings.elements);
}

CLI::App* addExportCommand(CLI::App& program, ExportOrder& order) {
  CLI::App* command = program.add_subcommand(
      "export", "write states of a trajectory as meshes, finite element decks and drawings");
  addPlace(*command, "TRAJECTORY", order.trajectory, "a trajectory.h5, or the folder it is in");
  OptionGroup group(*command, "Output");
  group.value("--out", "FOLDER", "where the trajectory is", "where the files go",
              [&order](const OptionValue& typed) { order.folder = typed.text; });
  addExportOptions(*command, "--format", order.settings);
  command->footer(
      "Examples:\n"
      "  kirireel export out/tessellation_4x4 --format obj,stl --states 0%,25%,50%,100%\n"
      "  kirireel export out/tessellation_4x4 --format inp --state final --quadratic\n"
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
  for (const std::string& name : exportStates(trajectory, order.settings, folder)) {
    fmt::print("{}\n", (folder / name).string());
  }
  return kExitDone;
}

}  // namespace kirireel
