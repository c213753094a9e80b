// A page file has one table for each panel. The keys of a table are the long names of options with
// underscores, as in scene files: those of `render` for pictures, those of `curves` for plots. They
// are read by the options themselves, so their values, ranges and messages exist once.
#include "render/cli/figure_command.h"

#include <algorithm>
#include <set>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/cli/option_effect.h"
#include "render/cli/option_group.h"
#include "render/cli/report.h"
#include "render/cli/run_commands.h"
#include "render/cli/scene_options.h"
#include "render/output/output_folder.h"
#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/scene/scene_file.h"
#include "sim/scene/toml_file.h"

namespace kirireel::cli {
namespace {

namespace fs = std::filesystem;

// Keys with a form of their own.
constexpr const char* kRows = "rows";
constexpr const char* kPanel = "panel";
constexpr const char* kCurves = "curves";
constexpr const char* kColumn = "column";
constexpr const char* kRun = "run";
/// Group of the options of every panel.
constexpr const char* kPanelGroup = "Panel";
/// States of a run in a panel.
constexpr picture::GridShape kPanelGrid = {1, 3};

/// Options that only a file sets, with the keys of one table.
class TableOptions {
 public:
  /// `what`: the kind of key in messages. `others`: keys that are not options.
  TableOptions(std::string what, std::vector<std::string> others = {})
      : what_(std::move(what)), others_(std::move(others)) {
    app_.set_help_flag();
  }

  CLI::App& app() { return app_; }

  /// Reads all keys of the table. Throws InputError with the position of the first wrong one.
  void read(const scene::TomlTable& table) {
    for (const scene::TomlEntry& entry : table) {
      if (!has(others_, entry.key)) applySetting(option(entry), scene::settingOf("", entry));
    }
  }

 private:
  CLI::Option& option(const scene::TomlEntry& entry) {
    std::vector<std::string> known = others_;
    for (CLI::Option* option : app_.get_options()) {
      if (settingKey(*option) == entry.key) return *option;
      known.push_back(settingKey(*option));
    }
    scene::refuseKey(entry, what_, known);
  }

  CLI::App app_;
  std::string what_;
  std::vector<std::string> others_;
};

/// The names of runs in a folder, for messages.
std::vector<std::string> runsIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (!isPresent(entry.path() / output::kTrajectory)) continue;
    names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

/// The trajectory of a run, named by its folder or its file from the folder of the page file.
fs::path trajectoryOf(const fs::path& folder, const scene::TypedValue& typed) {
  fs::path run = (folder / typed.text).lexically_normal();
  if (!run.has_filename()) run = run.parent_path();  // without a slash at the end
  if (isFile(run)) return run;
  if (isPresent(run / output::kTrajectory)) return run / output::kTrajectory;
  const fs::path place = run.has_parent_path() ? run.parent_path() : ".";
  const std::vector<std::string> names = runsIn(place);
  throw InputError(
      names.empty()
          ? fmt::format("error: there is no run {}, and no run in {}", run.string(), place.string())
          : fmt::format("error: there is no run {}{}; {} has {}", run.string(),
                        suggestion(run.filename().string(), names), place.string(),
                        fmt::join(names, ", ")));
}

/// Options of every panel.
void addPanelOptions(OptionGroup& group, const fs::path& folder, record::FigurePanel& panel) {
  group.values("--run", "FOLDER", "runs", [&panel, folder](const scene::TypedValue& typed) {
    panel.runs.push_back(trajectoryOf(folder, typed));
  });
  group.value("--title", "TEXT", "", "text next to the letter",
              [&panel](const scene::TypedValue& typed) { panel.title = typed.text; });
  group.number("--share", panel.share, {1e-3, 1e3}, "NUMBER", "of the row's width");
  group.value("--height", "MM", "", "height", [&panel](const scene::TypedValue& typed) {
    panel.height = parseLength(typed, "mm", {1, 10000});
  });
}

void readPlot(const scene::TomlTable& table, const fs::path& folder, record::FigurePanel& panel) {
  record::CurvesSettings& curves = panel.curves.emplace();
  TableOptions options("key of a plot");
  OptionGroup group(options.app(), kPanelGroup);
  addPanelOptions(group, folder, panel);
  addPlotOptions(group, curves);
  options.read(table);
  for (record::FileColumn& column : curves.columns) column.file = folder / column.file;
}

void readPictures(const scene::TomlTable& table, const fs::path& folder,
                  record::FigurePanel& panel) {
  panel.pictures.grid = kPanelGrid;
  TableOptions options("key of a panel of pictures");
  CLI::App& app = options.app();
  OptionGroup own(app, kPanelGroup);
  addPanelOptions(own, folder, panel);
  OptionGroup group(app, "Pictures");
  addGridOptions(group, panel.pictures);
  addRowOptions(group, panel.pictures);
  addAppearanceOptions(app, panel.pictures.appearance);
  // Pages are opaque.
  app.remove_option(app.get_option("--transparent"));
  options.read(table);
  std::set<std::string> given = givenOptions(app);
  // `render` has other options of the same names, such as --title.
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group() == kPanelGroup) given.erase(option->get_name());
  }
  try {
    requireEffect({.command = &app, .pictures = &panel.pictures, .runs = panel.runs.size()}, given);
  } catch (const InputError& error) {
    throw scene::locatedAt(panel.where, error);
  }
}

record::FigurePanel readPanel(const scene::TomlEntry& entry, const fs::path& folder) {
  const scene::TomlTable* table = entry.value.table();
  if (!table) scene::refuseValue(entry.value, fmt::format("a table, [panel.{}]", entry.key));
  record::FigurePanel panel;
  panel.where = entry.where;
  if (!scene::find(*table, kRun)) {
    throw inputErrorAt(entry.where,
                       fmt::format("panel {} has no run; give run = \"FOLDER\"", entry.key));
  }
  if (scene::find(*table, kCurves) || scene::find(*table, kColumn)) {
    readPlot(*table, folder, panel);
  } else {
    readPictures(*table, folder, panel);
  }
  return panel;
}

constexpr const char* kRowsForm = "lists with the names of panels, as in [[\"a\"], [\"b\", \"c\"]]";

/// The names of panels, row by row, with their positions.
std::vector<std::vector<scene::TomlValue>> readRows(const scene::TomlValue& value) {
  const std::vector<scene::TomlValue>* list = value.array();
  if (!list || list->empty()) scene::refuseValue(value, kRowsForm);
  std::vector<std::vector<scene::TomlValue>> rows;
  for (const scene::TomlValue& row : *list) {
    if (!row.array() || row.array()->empty()) scene::refuseValue(row, kRowsForm);
    for (const scene::TomlValue& name : *row.array()) {
      if (!name.text()) scene::refuseValue(name, kRowsForm);
    }
    rows.push_back(*row.array());
  }
  return rows;
}

/// The panel of this name, which is removed from the list.
record::FigurePanel takePanel(const scene::TomlValue& name, const scene::TomlTable& panels,
                              std::vector<std::string>& left, const fs::path& folder) {
  std::vector<std::string> names;
  for (const scene::TomlEntry& entry : panels) {
    names.push_back(entry.key);
    if (entry.key != *name.text()) continue;
    if (std::erase(left, entry.key) == 0) {
      throw inputErrorAt(name.where, fmt::format("panel {} is in rows twice", entry.key));
    }
    return readPanel(entry, folder);
  }
  throw inputErrorAt(name.where,
                     fmt::format("there is no panel {}{}; there are {}", shown(*name.text()),
                                 suggestion(*name.text(), names), fmt::join(names, ", ")));
}

void readPanels(const scene::TomlTable& table, const fs::path& file, record::FigurePage& page) {
  const scene::TomlValue* rows = scene::find(table, kRows);
  const scene::TomlValue* panels = scene::find(table, kPanel);
  if (!rows || !panels) {
    throw inputErrorAt({file}, rows ? "there is no panel; add tables [panel.NAME]"
                                    : fmt::format("rows is missing; give {}", kRowsForm));
  }
  if (!panels->table()) scene::refuseValue(*panels, "tables, [panel.NAME]");
  std::vector<std::string> left;
  for (const scene::TomlEntry& entry : *panels->table()) left.push_back(entry.key);
  for (const std::vector<scene::TomlValue>& row : readRows(*rows)) {
    page.rows.emplace_back();
    for (const scene::TomlValue& name : row) {
      page.rows.back().push_back(takePanel(name, *panels->table(), left, file.parent_path()));
    }
  }
  if (left.empty()) return;
  throw inputErrorAt(scene::find(*panels->table(), left.front())->where,
                     fmt::format("panel {} is not in rows; add or remove it", left.front()));
}

}  // namespace

record::FigurePage readFigurePage(const fs::path& file) {
  const scene::TomlTable table = scene::readTomlFile(file, "a page file, like figure.toml");
  record::FigurePage page;
  record::PictureSettings print;
  print.letters = page.letters;
  TableOptions options("key of a page", {kRows, kPanel});
  OptionGroup group(options.app(), "Page");
  addPrintOptions(group, print);
  options.read(table);
  page.width = print.gridWidth.value_or(page.width);
  page.fontPoints = print.fontPoints.value_or(page.fontPoints);
  page.dotsPerInch = print.gridDotsPerInch();
  page.font = print.font;
  page.letters = print.letters;
  readPanels(table, file, page);
  return page;
}

CLI::App* addFigureCommand(CLI::App& program, FigureOrder& order) {
  CLI::App* command = program.add_subcommand(
      "figure", "compose a figure of pictures and curves of runs on one page, from a page file");
  addPlace(*command, "PAGE", order.file, "a page file, such as figure.toml");
  OptionGroup output(*command, "Output");
  output.values(
      "--out", "FILE",
      "the figure; its ending gives the format: .pdf, .svg, .png; may be repeated (default PAGE "
      "with .pdf)",
      [&order](const scene::TypedValue& typed) { order.outputs.emplace_back(typed.text); });
  command->footer(
      "A page file has rows of panels:\n\n"
      "  width = \"180mm\"\n"
      "  rows = [[\"cap\"], [\"error\", \"radius\"]]\n\n"
      "  [panel.cap]\n"
      "  run = \"out/cap\"\n"
      "  grid = \"1x4\"\n\n"
      "  [panel.error]\n"
      "  run = [\"out/cap\", \"out/fan\"]\n"
      "  curves = \"target_error\"\n\n"
      "  [panel.radius]\n"
      "  run = [\"out/cap\", \"out/fan\"]\n"
      "  curves = \"radius\"\n\n"
      "Keys of the page: width, font_size, font, letters, dpi. Keys of all panels:\n"
      "run, title, share (of the row's width), height. A panel with curves or column\n"
      "is a plot, with the options of `kirireel curves`. Other panels are pictures,\n"
      "with the options of `kirireel render` for layout, style and camera. Runs and\n"
      "tables are found from the folder of the page file.\n\n"
      "Example:\n"
      "  kirireel figure figure.toml --out figure.pdf --out figure.png");
  return command;
}

void completeOrder(const CLI::App& command, FigureOrder& order) {
  requireGiven(order.file, "PAGE", command);
  if (order.outputs.empty()) {
    order.outputs.push_back(fs::path(order.file).replace_extension(".pdf"));
  }
  std::vector<std::string> files;
  const fs::path folder = order.outputs.front().parent_path();
  for (const fs::path& output : order.outputs) {
    files.push_back(output.filename().string());
    record::pageFormatOf(files.back());
    if (output.parent_path() == folder) continue;
    throw InputError(fmt::format("error: {} and {} are in different folders; give one folder",
                                 order.outputs.front().string(), output.string()));
  }
  order.page = readFigurePage(order.file);
  order.page.folder = folder.empty() ? "." : folder;
  order.page.files = files;
}

int carryOut(const FigureOrder& order) {
  record::writeFigure(order.page);
  for (const fs::path& output : order.outputs) fmt::print("{}\n", output.string());
  return kExitDone;
}

}  // namespace kirireel::cli
