// Options of a page and the command `page`. A page is made of one run or of two side by side;
// `record --page` makes one of the run that has just ended, with the same settings' look.
#include "render/cli/page_command.h"

#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/exit_codes.h"
#include "render/cli/option_group.h"
#include "render/folder/output_folder.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// 0 stands for all samples of the trajectory.
int parseSamples(const TypedValue& typed) {
  return typed.text == "all" ? 0 : static_cast<int>(parseInteger(typed, {2, 1e6}));
}

/// The trajectory of a run that was named by its folder or its file. A file is taken as it is; a
/// folder without a trajectory is refused with what to do.
std::filesystem::path trajectoryOf(const std::filesystem::path& run) {
  if (!std::filesystem::is_directory(run)) return run;
  const std::filesystem::path file = run / output::kTrajectory;
  if (std::filesystem::exists(file)) return file;
  throw InputError(
      fmt::format("{}: error: this folder has no {}, which a page is made from; record its "
                  "model again",
                  run.string(), output::kTrajectory));
}

}  // namespace

void addPageOptions(CLI::App& command, WebPageSettings& settings) {
  OptionGroup group(command, "Page");
  group
      .value(
          "--samples", "COUNT", "201",
          "states that the page has, at equal steps of motion, or all: those of trajectory.h5",
          [&settings](const TypedValue& typed) { settings.states.samples = parseSamples(typed); })
      .decidesNothing();
  group
      .flag("--exact", settings.states.exact,
            "poses as they are, to the last bit; else to a fraction of a pixel")
      .decidesNothing();
  group
      .value("--embed", "LIST", "none",
             "files of the run that go into the page: videos play, pictures show, others can be "
             "saved from it, such as deployment.mp4,final.obj",
             [&settings](const TypedValue& typed) {
               // Names are looked for beside the trajectory when the page is made.
               std::istringstream names(typed.text);
               for (std::string name; std::getline(names, name, ',');) {
                 settings.embedded.push_back(name);
               }
             })
      .decidesNothing();
  group
      .value("--most-size", "MB", "25", "of a page; a larger one is refused",
             [&settings](const TypedValue& typed) {
               settings.mostMegabytes = parseNumber(typed, {0.1, 1e5});
             })
      .decidesNothing();
}

CLI::App* addPageCommand(CLI::App& program, PageOrder& order) {
  CLI::App* command = program.add_subcommand(
      "page", "write one HTML file that shows a run in 3-D, in any browser, without a network");
  command
      ->add_option("RUN", order.runs,
                   "a trajectory.h5, or the folder it is in; two stand side by side")
      ->type_name("")
      ->expected(1, -1);
  OptionGroup output(*command, "Output");
  output.value("--out", "FOLDER", "that of the first RUN", "where page.html goes",
               [&order](const TypedValue& typed) { order.settings.folder = typed.text; });
  addPageOptions(*command, order.settings);
  command->footer(
      "The page has the model in 3-D with a slider, its curves, and the summary in words. It "
      "needs\n"
      "no network and may be sent as it is.\n\n"
      "Examples:\n"
      "  kirireel page out/tessellation_4x4\n"
      "  kirireel page out/first out/second --out out/both --samples 101");
  return command;
}

void completeOrder(const CLI::App& command, PageOrder& order) {
  // CLI11 is told to expect one at least, but --help and our own message come before its error.
  requireGiven(order.runs.empty() ? "" : order.runs.front(), "RUN", command);
  if (order.runs.size() > kMostPageRuns) {
    throw InputError(
        fmt::format("error: {} runs are given, and a page shows {} at most; make "
                    "several pages",
                    order.runs.size(), kMostPageRuns));
  }
}

int carryOut(const PageOrder& order) {
  WebPageSettings settings = order.settings;
  std::vector<std::filesystem::path> trajectories;
  for (const std::filesystem::path& run : order.runs) trajectories.push_back(trajectoryOf(run));
  if (settings.folder.empty()) settings.folder = trajectories.front().parent_path();
  if (settings.folder.empty()) settings.folder = ".";
  writePage(trajectories, settings);
  const std::filesystem::path page = settings.folder / kPageFile;
  fmt::print("{}: {:.2f} MB\n", page.string(),
             static_cast<double>(std::filesystem::file_size(page)) / 1e6);
  return kExitDone;
}

}  // namespace kirireel
