/// Commands for existing runs: render, export, curves, page and verify.
#pragma once

#include <filesystem>
#include <vector>

#include "render/cli/option_group.h"
#include "render/export/export.h"
#include "render/page/page.h"
#include "render/record/curves.h"
#include "render/record/record.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

// ------------------------------------------------------------------------------------------------
// `kirireel render TRAJECTORY`.

/// Recorded runs to paint again, with settings. completeOrder() replaces each folder by its
/// trajectory file.
struct RenderOrder {
  /// Several: one grid with a row per run, and a video with the runs side by side.
  std::vector<std::filesystem::path> trajectories;
  record::PictureSettings settings;  ///< folder is empty if --out was not given
};

/// Adds `render`. The order must outlive the parsing.
CLI::App* addRenderCommand(CLI::App& program, RenderOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, RenderOrder& order);

/// Paints, and prints the written files. Returns the exit code, 4 if a signal ended the video
/// early. Throws InputError for a trajectory that cannot be read, OutputError for files.
int carryOut(const RenderOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel export TRAJECTORY`.

/// A trajectory and its exports. Defaults of the settings are those of the help.
struct ExportOrder {
  std::filesystem::path trajectory;  ///< a trajectory.h5, or its folder
  std::filesystem::path folder;      ///< empty: the trajectory's own
  exports::ExportSettings settings;  ///< states and formats
  bool isChecked = false;            ///< whether to run jobs with two element sizes
};

/// Adds the options for states and formats of an export. `formatOption` is the name of the option
/// for formats: "--format" in `export`, whose options may also have short names, "--export" in
/// `record`. The settings must outlive the parsing.
void addExportOptions(CLI::App& command, const std::string& formatOption,
                      exports::ExportSettings& settings);

/// Adds `export`. The order must outlive the parsing.
CLI::App* addExportCommand(CLI::App& program, ExportOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, ExportOrder& order);

/// Reads the trajectory, writes the files, prints their names. Returns the exit code. --check also
/// runs CalculiX and prints the effect of a mesh twice as fine. Throws InputError for unsuitable
/// states, formats and models, OutputError for files.
int carryOut(const ExportOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel curves RUN`.

/// Runs whose curves are written, and the formats. completeOrder() replaces a folder by its
/// trajectory file.
struct CurvesOrder {
  std::vector<std::filesystem::path> runs;  ///< trajectory.h5 files, or their folders
  record::CurvesSettings settings;          ///< folder is empty if --out was not given
};

/// Adds the options that select curves and their axis. The settings must outlive the parsing.
void addPlotOptions(OptionGroup& group, record::CurvesSettings& settings);

/// Adds `curves`. The order must outlive the parsing.
CLI::App* addCurvesCommand(CLI::App& program, CurvesOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, CurvesOrder& order);

/// Writes the files and prints their names. Returns the exit code. A run without dynamics has no
/// energies and forces, which is noted on standard error. Throws like TrajectoryReader and
/// writeCurves.
int carryOut(const CurvesOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel page RUN...`.

/// The runs of a page, and its settings. At least one run, at most kMaxPageRuns.
struct PageOrder {
  std::vector<std::filesystem::path> runs;  ///< each a trajectory.h5, or its folder
  page::WebPageSettings settings;           ///< folder is empty if --out was not given
};

/// Adds the options of a page. The settings must outlive the parsing.
void addPageOptions(CLI::App& command, page::WebPageSettings& settings);

/// Adds `page`. The order must outlive the parsing.
CLI::App* addPageCommand(CLI::App& program, PageOrder& order);

/// Throws InputError if an argument is missing or excessive. Call it after parsing.
void completeOrder(const CLI::App& command, PageOrder& order);

/// Writes the page, and prints its name and its size in megabytes of 10^6 bytes. Returns the exit
/// code. Throws InputError for a folder without a trajectory or a page above --most-size, and like
/// writePage.
int carryOut(const PageOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel verify FOLDER`.

/// The run to check, by its folder (--out).
struct VerifyOrder {
  std::filesystem::path folder;  ///< the run's folder
};

/// Adds `verify`. The order must outlive the parsing.
CLI::App* addVerifyCommand(CLI::App& program, VerifyOrder& order);

/// Throws InputError if an argument is missing. Call it after parsing.
void completeOrder(const CLI::App& command, VerifyOrder& order);

/// Checks the run and prints differences. Returns the exit code. Reads every file of the run and
/// the whole trajectory. Throws InputError for a folder without a finished run.
int carryOut(const VerifyOrder& order);

}  // namespace kirireel::cli
