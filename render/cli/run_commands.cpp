// The commands of a finished run: render, export, curves, page, verify. They read trajectory.h5 and
// do not simulate.
#include "render/cli/run_commands.h"

#include <algorithm>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/cli/option_effect.h"
#include "render/cli/report.h"
#include "render/cli/scene_options.h"
#include "render/fea/outside_program.h"
#include "render/output/output_folder.h"
#include "render/record/summary.h"
#include "sim/base/error.h"

namespace kirireel::cli {
namespace {

/// The chosen folder, or that of the trajectory.
std::filesystem::path folderOr(const std::filesystem::path& chosen,
                               const std::filesystem::path& trajectory) {
  if (!chosen.empty()) return chosen;
  return trajectory.has_parent_path() ? trajectory.parent_path() : ".";
}

/// Adds a positional argument for one or more runs.
void addRuns(CLI::App& command, const char* name, std::vector<std::filesystem::path>& runs,
             const char* help) {
  command.add_option(name, runs, help)->type_name("")->expected(1, -1);
}

/// Replaces the folders of runs by their trajectories. Throws InputError if there is no run.
void completeRuns(const CLI::App& command, const char* name,
                  std::vector<std::filesystem::path>& runs) {
  requireGiven(runs.empty() ? "" : runs.front(), name, command);
  std::ranges::transform(runs, runs.begin(), output::trajectoryOf);
}

}  // namespace

// ------------------------------------------------------------------------------------------------
// render: paints a run again from its poses, so another camera, size or colour costs only the
// painting. Several trajectories make one grid with a row for each, and a video with the runs side
// by side if --video is given.

CLI::App* addRenderCommand(CLI::App& program, RenderOrder& order) {
  CLI::App* command = program.add_subcommand(
      "render", "make pictures and video of a recorded run again, without simulating");
  addRuns(*command, "TRAJECTORY", order.trajectories,
          "a trajectory.h5 of record or simulate, or its folder; several give one grid with a row "
          "of states each, and with --video a video with all side by side");
  OptionGroup output(*command, "Output");
  output.value("--out", "FOLDER", "next to TRAJECTORY", "folder for the files",
               [&order](const scene::TypedValue& typed) { order.settings.folder = typed.text; });
  output.integer("--fps", order.settings.framesPerSecond, {1, 240}, "COUNT",
                 "frames per second of video");
  addRowOptions(output, order.settings);
  addPictureOptions(*command, order.settings);
  addVideoOptions(*command, order.settings);
  command->footer(
      "States between two samples are interpolated, with their joints closed.\n\n"
      "Examples:\n"
      "  kirireel render out/tessellation_4x4 --view iso --out out/again\n"
      "  kirireel render out/tessellation_4x4 --video slow.gif --fps 25 --speed 0.5\n"
      "  kirireel render out/cylinder out/cap --grid 1x4 --width 180mm --font-size 7pt --out "
      "figure\n"
      "  kirireel render out/cylinder out/cap --video both.mp4 --no-snapshots --out both");
  return command;
}

void completeOrder(const CLI::App& command, RenderOrder& order) {
  completeRuns(command, "TRAJECTORY", order.trajectories);
  requireConsistentPace(command);
  if (order.trajectories.size() > 1 && order.settings.folder.empty()) {
    throw InputError("error: a figure of several runs needs its own folder; choose it with --out");
  }
  const std::set<std::string> given = givenOptions(command);
  // Several runs have a video only with --video.
  if (order.trajectories.size() > 1 && !given.contains("--video")) order.settings.video = false;
  requireEffect(
      {.command = &command, .pictures = &order.settings, .runs = order.trajectories.size()}, given);
}

int carryOut(const RenderOrder& order) {
  noteSignals();
  record::PictureSettings settings = order.settings;
  const std::filesystem::path& trajectory = order.trajectories.front();
  settings.folder = folderOr(settings.folder, trajectory);
  record::PictureReport report;
  {
    ProgressLine line;
    const record::ProgressObserver observer = [&line](const record::Progress& progress) {
      line.show(progress);
      return takeInterrupt();
    };
    report = order.trajectories.size() > 1
                 ? record::renderSeveral(order.trajectories, settings, observer)
                 : record::render(trajectory, settings, observer);
  }
  fmt::print("{}", describePictures(settings, report));
  return report.stoppedAt ? kExitInterrupted : kExitDone;
}

// ------------------------------------------------------------------------------------------------
// export: options of states, elements and decks, also for `record --export`. Every value that
// changes a byte of a file has serializedAs(), so the fingerprint contains it.

namespace {

void addStateOptions(OptionGroup& group, exports::ExportSettings& settings) {
  // The first typed state replaces the default, later ones are appended. CLI11 calls `append` after
  // this function has returned, so the flag is shared.
  const auto isTyped = std::make_shared<bool>(false);
  const auto append = [&settings, isTyped](const std::string& name) {
    exports::requireStateName(name);
    if (!*isTyped) settings.states.clear();
    *isTyped = true;
    settings.states.push_back(name);
  };
  group
      .values("--states", "LIST",
              "initial, final, all, fractions of the motion (25%), times (1.5s), angles by which a "
              "tile has rotated (30deg), separated by commas (initial,final); or event:TEXT",
              [append](const scene::TypedValue& typed) {
                // The text of an event may have commas.
                if (typed.text.starts_with("event:")) return append(typed.text);
                for (const std::string_view name : scene::split(typed.text, ',')) {
                  append(std::string(name));
                }
              })
      .serializedAs([&settings] {
        std::vector<std::string> names;
        for (const std::string& name : settings.states) names.push_back(scene::quotedText(name));
        return scene::quotedList(names);
      });
}

void addElementOptions(CLI::App& command, fea::ElementRule& elements) {
  OptionGroup group(command, "Elements (inp, msh)", "recording");
  // Defaults of the rule are below `least`. They are not serialized.
  const auto length = [&group](const char* name, const char* defaultText, const char* help,
                               double& target, double least = 1e-12) {
    group.stored(name, target, "LENGTH", defaultText, help, numberIn({least, 1e9}),
                 [least](double x) { return x >= least ? scene::numberText(x) : ""; });
  };
  group.stored("--elements-per-edge", elements.perEdge, "COUNT", "8",
               "elements along each edge of a tile", integerIn({1, 64}), positiveText);
  length("--element-size", "", "longest element edge, instead of the count", elements.size);
  group.integer("--elements-through", elements.through, {1, 64}, "COUNT",
                "elements through the thickness");
  group.flag("--linear", elements.quadratic,
             "8 nodes per element (C3D8I) instead of 20 (C3D20R); needs twice as many elements for "
             "the same accuracy",
             false);
  // The first word is the default.
  group.choice<fea::JointStyle>("--joints", elements.joints,
                                {{"shared", fea::JointStyle::Shared},
                                 {"equation", fea::JointStyle::Equation},
                                 {"patch", fea::JointStyle::Patch},
                                 {"neck", fea::JointStyle::Neck}},
                                "shared nodes, *EQUATION, rigid patches, or one sheet with necks");
  // Lengths of necks and patches are metres of the model, for any unit of the deck.
  length("--patch-radius", "a quarter of the shortest edge",
         "radius of rigid patches; below half of an edge", elements.patchRadius);
  length("--neck-width", "the model's", "width of necks, the material left at a joint",
         elements.neck.width);
  length("--neck-length", "the model's, else the kerf", "length of necks, from tile to tile",
         elements.neck.length, 0);
  group.number("--neck-radius", elements.neck.radius, {0, 1e9}, "LENGTH",
               "radius of the fillets at the ends of necks");
  length("--kerf", "the model's, else 0", "width of the cuts of a sheet with necks",
         elements.neck.kerf, 0);
  // Some --joints exclude --shells and --plane-stress: render/fea/element_mesh.cpp checks that.
  group.flag("--shells", "shells (S8R, S4), with an offset if joints are on one face",
             [&elements] { elements.family = fea::ElementFamily::Shell; });
  group.flag("--plane-stress", "plane elements of a sheet with necks (CPS8R, CPS4)",
             [&elements] { elements.family = fea::ElementFamily::Plane; });
}

/// "all", "edge", or numbers with commas. The numbers are checked after reading the model.
fea::DriveChoice parseDrive(const scene::TypedValue& typed) {
  if (typed.text == "all") return {fea::DriveChoice::All, {}};
  if (typed.text == "edge") return {fea::DriveChoice::Edge, {}};
  fea::DriveChoice drive{fea::DriveChoice::Some, {}};
  for (const std::string_view word : scene::split(typed.text, ',')) {
    drive.tiles.push_back(scene::parseInteger({typed.name, std::string(word)}, {0, 1e9}));
  }
  return drive;
}

/// `isOnlyGroup`: the command has only these options, with short names.
void addDeckOptions(CLI::App& command, fea::DeckSettings& decks, bool isOnlyGroup) {
  OptionGroup group(command, "Decks (inp)", "recording");
  // Within `record` the names --solver and --density belong to the simulation, so a deck's have a
  // prefix there.
  group.choice<fea::Solver>(isOnlyGroup ? "--solver,--deck-solver" : "--deck-solver", decks.solver,
                            {{"calculix", fea::Solver::Calculix}, {"abaqus", fea::Solver::Abaqus}},
                            "solver whose keywords are written if they differ");
  group.value("--sets", "WORD", "all up to 1000 tiles",
              "named sets of each tile and joint: none, joints, all",
              [&decks](const scene::TypedValue& typed) {
                decks.sets =
                    scene::parseChoice<fea::SetChoice>(typed, {{"none", fea::SetChoice::None},
                                                               {"joints", fea::SetChoice::Joints},
                                                               {"all", fea::SetChoice::All}});
              });
  // SI units for any --deck-unit. Only the deck is scaled.
  group.number("--youngs", decks.material.youngs, {1e-12, 1e18}, "PASCAL", "Young's modulus");
  // The limits of isotropic material are -1 and 0.5; at either, stiffness is singular.
  group.number("--poisson", decks.material.poisson, {-0.99, 0.499}, "RATIO", "Poisson's ratio");
  group.number(isOnlyGroup ? "--density,--deck-density" : "--deck-density", decks.material.density,
               {1e-12, 1e9}, "KG/M3", "density of the material");
  group.choice<fea::DeckUnit>(
      "--deck-unit", decks.unit,
      {{"m", fea::DeckUnit::Model}, {"mm-N", fea::DeckUnit::MillimetresNewtons}},
      "metres with Pa and kg/m3, or millimetres with MPa and t/mm3");
  group.value("--drive", "TILES", "",
              "a second job whose tiles move as in the trajectory: all, edge, or tiles (0,5,12)",
              [&decks](const scene::TypedValue& typed) { decks.drive = parseDrive(typed); });
  group.flag("--buckle", "a further job, for buckling loads", [&decks] { decks.buckling = true; });
  group.flag("--periodic",
             "a further job on a sheet that repeats: opposite ends tied to control nodes",
             [&decks] { decks.periodic = true; });
  group.number(
      "--deck-contacts", decks.contactFriction, {0, 10}, "FRICTION", "",
      "contact between flanks next to joints, with this coefficient of friction (0: none)");
  group.flag("--state-map",
             "jobs that move the first state's mesh to the other states, without stress",
             [&decks] { decks.stateMap = true; });
}

}  // namespace

void addExportOptions(CLI::App& command, const std::string& formatOption,
                      exports::ExportSettings& settings) {
  OptionGroup group(command, "Export", "recording");
  const std::vector<std::string> formats = exports::exportFormatNames();
  const std::string help = "formats, separated by commas: " + scene::listWords(formats);
  group
      .value(formatOption, "LIST", "", help,
             [&settings, formats](const scene::TypedValue& typed) {
               for (const std::string_view part : scene::split(typed.text, ',')) {
                 const std::string word(part);
                 if (!has(formats, word)) {
                   throw scene::valueError({typed.name, word}, scene::listWords(formats));
                 }
                 settings.formats.push_back(word);
               }
             })
      .serializedAs([&settings] { return wordsText(settings.formats); });
  addStateOptions(group, settings);
  group.stored("--hinge-width", settings.hingeWidth, "LENGTH", "the model's, else tile size / 20",
               "width of the necks in cut patterns (svg, dxf)", numberIn({1e-12, 1e9}),
               positiveText);
  group.choice<std::optional<LengthUnit>>("--export-unit", settings.unit, unitChoices(),
                                          "unit of exported files except glb, svg and step; auto: "
                                          "mm for stl and dxf, else the model's");
  addElementOptions(command, settings.elements);
  addDeckOptions(command, settings.decks, formatOption == "--format");
}

CLI::App* addExportCommand(CLI::App& program, ExportOrder& order) {
  CLI::App* command = program.add_subcommand(
      "export", "write states of a trajectory as meshes, finite element decks and drawings");
  addPlace(*command, "TRAJECTORY", order.trajectory, "a trajectory.h5, or the folder it is in");
  OptionGroup group(*command, "Output");
  group.value("--out", "FOLDER", "folder of the trajectory", "folder for the files",
              [&order](const scene::TypedValue& typed) { order.folder = typed.text; });
  addExportOptions(*command, "--format", order.settings);
  OptionGroup(*command, "Check (inp)")
      .flag("--check",
            "run the job of each deck in CalculiX, which must be installed; run it again with "
            "elements half as long and report the changes",
            [&order] { order.isChecked = true; });
  command->footer(
      "Examples:\n"
      "  kirireel export out/tessellation_4x4 --format obj,stl --states 0%,25%,50%,100%\n"
      "  kirireel export out/tessellation_4x4 --format inp --states final --joints patch\n"
      "  kirireel export out/tessellation_4x4 --format inp --joints neck --neck-width 0.1\n"
      "  kirireel export out/tessellation_4x4 --format vtu --states all\n"
      "  kirireel export out/tessellation_4x4 --format glb,svg --hinge-width 0.03\n\n"
      "Lengths are in the unit of the model, times simulated seconds.");
  return command;
}

void completeOrder(const CLI::App& command, ExportOrder& order) {
  requireGiven(order.trajectory, "TRAJECTORY", command);
  if (order.settings.formats.empty()) {
    throw InputError(
        "error: --format is missing, as in kirireel export TRAJECTORY --format obj,inp; "
        "see kirireel export --help");
  }
  requireEffect({.command = &command, .exports = &order.settings}, givenOptions(command));
}

int carryOut(const ExportOrder& order) {
  const std::filesystem::path file = output::trajectoryOf(order.trajectory);
  const trajectory::TrajectoryReader trajectory(file);
  const exports::ExportSettings settings =
      exports::inMetres(order.settings, trajectory.subject().model.unit);
  const std::filesystem::path folder = folderOr(order.folder, file);
  if (order.isChecked) fea::requireCalculix();
  // Warnings come before the files, which may take long.
  for (const std::string& line : exports::exportWarnings(trajectory, settings)) {
    fmt::print(stderr, "kirireel: {}\n", line);
  }
  for (const std::string& name : exports::exportStates(trajectory, settings, folder)) {
    fmt::print("{}\n", (folder / name).string());
  }
  // The check solves every deck twice and may take far longer than the export.
  if (!order.isChecked) return kExitDone;
  for (const std::string& line : exports::meshSensitivity(trajectory, settings)) {
    fmt::print("{}\n", line);
  }
  return kExitDone;
}

// ------------------------------------------------------------------------------------------------
// curves: curves are measured from the samples or stored with them. Options of figures are in print
// sizes (mm, points); see render/record/curves.h.

void addPlotOptions(OptionGroup& group, record::CurvesSettings& settings) {
  group.values("--curves", "LIST",
               "curves of the figures, separated by commas: target_error, opening_mean, radius, "
               "...; theta is the mean opening, load_curve the force of grips; all (default all)",
               [&settings](const scene::TypedValue& typed) {
                 for (const std::string_view name : scene::split(typed.text, ',')) {
                   if (name != "all") settings.selected.emplace_back(name);
                 }
               });
  group.values(
      "--column", "FILE.csv:NAME",
      "a column of a table, in the diagram of the curve of this name or its own",
      [&settings](const scene::TypedValue& typed) {
        const std::size_t colon = typed.text.rfind(':');
        if (colon == std::string::npos || colon + 1 == typed.text.size()) {
          throw scene::valueError(typed, "a file and a column, as in data.csv:radius_mm");
        }
        settings.columns.push_back({typed.text.substr(0, colon), typed.text.substr(colon + 1)});
      });
  group.choice<record::CurvesAgainst>("--against", settings.against,
                                      {{"time", record::CurvesAgainst::Time},
                                       {"progress", record::CurvesAgainst::Progress},
                                       {"opening", record::CurvesAgainst::Opening}},
                                      "quantity of the horizontal axes");
}

CLI::App* addCurvesCommand(CLI::App& program, CurvesOrder& order) {
  CLI::App* command = program.add_subcommand(
      "curves", "table and plot what a run measures over its time: sizes, areas, openings, ...");
  addRuns(*command, "RUN", order.runs,
          "a trajectory.h5, or the folder it is in; several share each diagram");
  OptionGroup output(*command, "Output");
  output.value("--out", "FOLDER", "next to RUN", "folder for the files",
               [&order](const scene::TypedValue& typed) { order.settings.folder = typed.text; });
  OptionGroup figures(*command, "Figures");
  addPlotOptions(figures, order.settings);
  figures.value("--plot", "LIST", "none", "the curves as figures: png, svg, pdf",
                [&order](const scene::TypedValue& typed) {
                  order.settings.plots = parsePages(
                      typed, {picture::kPageFormats.begin(), picture::kPageFormats.end()});
                });
  // Millimetres and points of the printed page. --dpi converts them to pixels, for PNG only.
  record::PlotSettings& plot = order.settings.plot;
  figures.stored("--width", plot.width, "MM", scene::numberText(plot.width),
                 "width of the figure in print", lengthIn("mm", {30, 1000}), scene::numberText);
  figures.stored("--font-size", plot.fontPoints, "PT", scene::numberText(plot.fontPoints),
                 "size of its text in print", lengthIn("pt", {3, 50}), scene::numberText);
  figures.number("--dpi", plot.dotsPerInch, {30, 2400}, "COUNT", "pixels per inch of a PNG");
  command->footer(
      "curves.csv has a row for each sample: width, height and depth of the sheet\n"
      "(along x, y, z), area and perimeter of its convex outline and the area that\n"
      "tiles cover (seen from above), porosity, Poisson's ratio since the start (of the\n"
      "tiles' centres), the smallest, mean and largest opening of the joints, kinetic\n"
      "energy, target error, joint gap and overlap, and each joint's opening. Runs\n"
      "with dynamics also have the energy in springs, the work of the drives, the\n"
      "losses in dampers, contacts and the integrator, and the forces of joints, pins,\n"
      "grips and contacts. A kinematic path has none of these. A field without a value\n"
      "is empty.\n\n"
      "Figures of a run under grips begin with its load curve: the force of each grip\n"
      "over its displacement, dashed if the equilibria are unstable. --curves\n"
      "load_curve selects it.\n\n"
      "Examples:\n"
      "  kirireel curves out/tessellation_4x4 --plot pdf\n"
      "  kirireel curves out/tessellation_4x4 --plot svg,png --against opening --width 85\n"
      "  kirireel curves out/soft out/stiff --curves target_error --plot pdf --out figure");
  return command;
}

void completeOrder(const CLI::App& command, CurvesOrder& order) {
  completeRuns(command, "RUN", order.runs);
  if (order.runs.size() > 1 && order.settings.folder.empty()) {
    throw InputError("error: curves of several runs need their own folder; choose it with --out");
  }
  requireEffect({.command = &command, .curves = &order.settings}, givenOptions(command));
}

int carryOut(const CurvesOrder& order) {
  record::CurvesSettings settings = order.settings;
  settings.folder = folderOr(settings.folder, order.runs.front());
  std::vector<record::NamedRun> runs;
  for (const std::filesystem::path& run : order.runs) {
    runs.push_back(record::openRun(run));
  }
  for (const std::string& name : record::writeCurves(runs, settings)) {
    fmt::print("{}\n", (settings.folder / name).string());
  }
  const bool allHaveForces = std::ranges::all_of(runs, [](const record::NamedRun& run) {
    return run.reader->hasMechanics() || run.loadCurve;
  });
  if (!allHaveForces) {
    fmt::print(stderr, "note: {}\n", spellOptions(trajectory::kNoMechanics));
  }
  return kExitDone;
}

// ------------------------------------------------------------------------------------------------
// page: of one run, or of two side by side. `record --page` makes a page of the new run with the
// settings of its pictures.

void addPageOptions(CLI::App& command, page::WebPageSettings& settings) {
  OptionGroup group(command, "Page");
  group
      .value("--samples", "COUNT", "201",
             "number of states in the page, at equal steps of motion; all: those of trajectory.h5",
             [&settings](const scene::TypedValue& typed) {
               settings.states.samples =
                   typed.text == "all" ? 0 : static_cast<int>(scene::parseInteger(typed, {2, 1e6}));
             })
      .excludeFromFingerprint();
  group.flag("--exact", settings.states.exact, "exact poses; else rounded to a fraction of a pixel")
      .excludeFromFingerprint();
  group
      .value("--embed", "LIST", "none",
             "files of the run to include in the page: videos play, pictures are shown, others can "
             "be saved, such as deployment.mp4,final.obj",
             [&settings](const scene::TypedValue& typed) {
               // The page searches files next to the trajectory.
               for (std::string& name : parseWords(typed)) {
                 settings.embedded.push_back(std::move(name));
               }
             })
      .excludeFromFingerprint();
  group
      .stored("--most-size", settings.maxMegabytes, "MB", "25",
              "largest size of a page; a larger page is an error", numberIn({0.1, 1e5}),
              scene::numberText)
      .excludeFromFingerprint();
}

CLI::App* addPageCommand(CLI::App& program, PageOrder& order) {
  CLI::App* command = program.add_subcommand(
      "page", "write one HTML file that shows a run in 3-D, in any browser, without a network");
  addRuns(*command, "RUN", order.runs,
          "a trajectory.h5, or its folder; two runs are shown side by side");
  OptionGroup output(*command, "Output");
  output.value("--out", "FOLDER", "that of the first RUN", "folder for page.html",
               [&order](const scene::TypedValue& typed) { order.settings.folder = typed.text; });
  addPageOptions(*command, order.settings);
  command->footer(
      "The page has the model in 3-D with a slider, its curves, and the summary in\n"
      "words. It needs no network and may be sent as it is.\n\n"
      "Examples:\n"
      "  kirireel page out/tessellation_4x4\n"
      "  kirireel page out/first out/second --out out/both --samples 101");
  return command;
}

void completeOrder(const CLI::App& command, PageOrder& order) {
  completeRuns(command, "RUN", order.runs);
  if (order.runs.size() > page::kMaxPageRuns) {
    throw InputError(
        fmt::format("error: {} runs are given, but a page shows at most {}; make several pages",
                    order.runs.size(), page::kMaxPageRuns));
  }
}

int carryOut(const PageOrder& order) {
  page::WebPageSettings settings = order.settings;
  settings.folder = folderOr(settings.folder, order.runs.front());
  page::writePage(order.runs, settings);
  const std::filesystem::path page = settings.folder / page::kPageFile;
  fmt::print("{}: {:.2f} MB\n", page.string(),
             static_cast<double>(std::filesystem::file_size(page)) / 1e6);
  return kExitDone;
}

// ------------------------------------------------------------------------------------------------
// verify: each disagreement is one line on standard output, because it is the result. The exit code
// is then 1.

CLI::App* addVerifyCommand(CLI::App& program, VerifyOrder& order) {
  CLI::App* command = program.add_subcommand(
      "verify",
      "check that a finished run's files are complete, unchanged and agree with its summary");
  addPlace(*command, "FOLDER", order.folder, "folder of a finished run");
  command->footer(
      "Compares every file with its size and SHA-256 in summary.json, and recomputes\n"
      "the figures of trajectory.h5 from its poses. Exit code 1 if something differs.\n\n"
      "Example:\n"
      "  kirireel verify out/tessellation_4x4");
  return command;
}

void completeOrder(const CLI::App& command, VerifyOrder& order) {
  requireGiven(order.folder, "FOLDER", command);
}

int carryOut(const VerifyOrder& order) {
  const record::VerifyReport report = record::verifyRun(order.folder);
  for (const std::string& complaint : report.complaints) fmt::print("{}\n", complaint);
  if (!report.complaints.empty()) return kExitFailed;
  fmt::print("{}: {} files and the figures of {} samples agree with the summary\n",
             order.folder.string(), report.files, report.samples);
  return kExitDone;
}

}  // namespace kirireel::cli
