// The command reads trajectory.h5 alone: everything that curves show is measured from the samples,
// or was stored with them. Options of figures are in print sizes (mm, points); see curves/plot.h
// for what follows from them.
#include "render/cli/curves_command.h"

#include <algorithm>
#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/exit_codes.h"
#include "render/cli/option_group.h"
#include "render/folder/output_folder.h"

namespace kirireel {
namespace {

/// "svg,png": each format once, in the order of their first naming.
std::vector<PageFormat> parsePlots(const TypedValue& typed) {
  std::vector<PageFormat> plots;
  std::istringstream words(typed.text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto format = parseChoice<PageFormat>(
        {typed.name, word},
        {{"png", PageFormat::Png}, {"svg", PageFormat::Svg}, {"pdf", PageFormat::Pdf}});
    if (std::ranges::find(plots, format) == plots.end()) plots.push_back(format);
  }
  return plots;
}

}  // namespace

CLI::App* addCurvesCommand(CLI::App& program, CurvesOrder& order) {
  CLI::App* command = program.add_subcommand(
      "curves", "table and plot what a run measures over its time: sizes, areas, openings, ...");
  addPlace(*command, "RUN", order.run, "a trajectory.h5, or the folder it is in");
  OptionGroup output(*command, "Output");
  output.value("--out", "FOLDER", "that of RUN", "where the files go",
               [&order](const TypedValue& typed) { order.settings.folder = typed.text; });
  OptionGroup figures(*command, "Figures");
  figures.value("--plot", "LIST", "none", "the curves as figures: png, svg, pdf",
                [&order](const TypedValue& typed) { order.settings.plots = parsePlots(typed); });
  figures.choice<CurvesAgainst>("--against", order.settings.against,
                                {{"time", CurvesAgainst::Time},
                                 {"progress", CurvesAgainst::Progress},
                                 {"opening", CurvesAgainst::Opening}},
                                "what lies along the horizontal axes");
  // Millimetres and points are those of print; --dpi turns them into pixels of a PNG alone.
  PlotSettings& plot = order.settings.plot;
  figures.number("--width", plot.width, {30, 1000}, "MM", "of the figure in print");
  figures.number("--font-size", plot.fontPoints, {3, 50}, "PT", "of its text in print");
  figures.number("--dpi", plot.dotsPerInch, {30, 2400}, "COUNT", "pixels per inch of a PNG");
  command->footer(
      "curves.csv has a row for each sample: width, height and depth of the sheet (along x, y, "
      "z),\n"
      "area and perimeter of its convex outline and the area that tiles cover (seen along z),\n"
      "porosity, Poisson's ratio since the start, the least, mean and largest opening of the "
      "joints,\n"
      "kinetic energy, target error, joint gap and overlap, and each joint's opening. Runs with\n"
      "dynamics also have the energy in springs, the work of the drives, what dampers, contacts "
      "and\n"
      "the integrator took, and the forces of joints, pins, grips and contacts; a path of the\n"
      "mechanism is geometry and has none. Fields are empty where there is no value.\n\n"
      "Examples:\n"
      "  kirireel curves out/tessellation_4x4 --plot pdf\n"
      "  kirireel curves out/tessellation_4x4 --plot svg,png --against opening --width 85");
  return command;
}

void completeOrder(const CLI::App& command, CurvesOrder& order) {
  requireGiven(order.run, "RUN", command);
  if (std::filesystem::is_directory(order.run)) order.run /= output::kTrajectory;
}

int carryOut(const CurvesOrder& order) {
  CurvesSettings settings = order.settings;
  // Beside the trajectory; a bare file name has no parent, so the current folder.
  if (settings.folder.empty()) settings.folder = order.run.parent_path();
  if (settings.folder.empty()) settings.folder = ".";
  const TrajectoryReader run(order.run);
  for (const std::string& name : writeCurves(run, settings)) {
    fmt::print("{}\n", (settings.folder / name).string());
  }
  if (!run.hasMechanics()) fmt::print(stderr, "note: {}\n", kNoMechanics);
  return kExitDone;
}

}  // namespace kirireel
