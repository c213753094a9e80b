/// Commands about runs that are there: render, export, curves, page and verify.
#pragma once

#include <filesystem>
#include <vector>

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

/// Which recorded runs to paint again, and how. completeOrder() puts the file of each folder in its
/// place.
struct RenderOrder {
  std::vector<std::filesystem::path> trajectories;  ///< several: one grid with a row of each
  record::PictureSettings settings;  ///< the folder is empty when --out was not given
};

/// Adds `render`. The order must outlive the parsing.
CLI::App* addRenderCommand(CLI::App& program, RenderOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, RenderOrder& order);

/// Paints, and prints what was written. Returns the exit code. 4 when a signal ended the video
/// early. Throws InputError for a trajectory that cannot be read, OutputError for files.
int carryOut(const RenderOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel export TRAJECTORY`.

/// A trajectory and what is made of it. Defaults of the settings are those of the help.
struct ExportOrder {
  std::filesystem::path trajectory;  ///< a trajectory.h5, or the folder that it is in
  std::filesystem::path folder;      ///< empty for the trajectory's own
  exports::ExportSettings settings;  ///< which states as what
  bool isChecked = false;            ///< whether jobs are run with two sizes of elements
};

/// Adds the options that choose states and formats for export; `formatOption` is the name of the
/// one for the formats. The settings must outlive the parsing. "--format" in `export`, where
/// options may also have short names, "--export" in `record`.
void addExportOptions(CLI::App& command, const std::string& formatOption,
                      exports::ExportSettings& settings);

/// Adds `export`. The order must outlive the parsing.
CLI::App* addExportCommand(CLI::App& program, ExportOrder& order);

/// Throws InputError where something is missing. To be called after parsing.
void completeOrder(const CLI::App& command, ExportOrder& order);

/// Reads the trajectory, writes the files, prints their names. Returns the exit code. With --check
/// also runs CalculiX, and prints what a mesh twice as fine changes. Throws InputError for states,
/// formats and models that do not fit, OutputError for files.
int carryOut(const ExportOrder& order);

// ------------------------------------------------------------------------------------------------
// `kirireel curves RUN`.

/// Runs whose curves are written, and the formats. completeOrder() replaces a folder by its
/// trajectory file.
struct CurvesOrder {
  std::vector<std::filesystem::path> runs;  ///< trajectory.h5 files, or their folders
  record::CurvesSettings settings;          ///< folder is empty if --out was not given
};

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

/// The runs of a page, and its settings. At least one run, at most kMostPageRuns.
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
