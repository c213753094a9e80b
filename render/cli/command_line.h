/// The command line: what kirireel is asked to do.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "render/cli/convert_command.h"
#include "render/cli/curves_command.h"
#include "render/cli/export_command.h"
#include "render/cli/generate_command.h"
#include "render/cli/inspect_command.h"
#include "render/cli/page_command.h"
#include "render/cli/record_command.h"
#include "render/cli/render_command.h"
#include "render/cli/study_command.h"
#include "render/cli/sweep_command.h"
#include "render/cli/verify_command.h"

namespace kirireel {

/// `--help` and `--version`. The text is the whole page, made while parsing.
struct PrintOrder {
  std::string text;
};

/// Prints the text. Returns the exit code. Always 0.
int carryOut(const PrintOrder& order);

/// One of the things that kirireel does. It holds all values that carryOut() needs; no parser is
/// left when it is returned.
using Order =
    std::variant<RecordOrder, RenderOrder, ExportOrder, GenerateOrder, InspectOrder, ConvertOrder,
                 StudyOrder, SweepOrder, VerifyOrder, CurvesOrder, PageOrder, PrintOrder>;

/// A model in memory, with what a run of it must know beside.
struct LoadedModel {
  Model model;
  std::filesystem::path place;        ///< that it was read from, as it was named; may be empty
  std::vector<std::string> options;   ///< of `record` that it was read with
  std::vector<InputFile> inputs;      ///< files that it was read from
  std::vector<std::string> warnings;  ///< about these, one line each
};

/// Reads a model as `kirireel record MODEL OPTIONS` does; of its options --joints-file and --strict
/// alone. Throws as readModel() and parseCommandLine().
LoadedModel loadModel(const std::filesystem::path& place, const std::vector<std::string>& options);

/// The complete order of `kirireel record` with these options for a model in memory. Throws as
/// parseCommandLine().
RecordOrder parseRunOptions(const LoadedModel& loaded, const std::vector<std::string>& options);

/// Reads the arguments that follow the program's name. Throws InputError for an unknown option
/// (suggesting the nearest), a value out of range, a missing or surplus argument. Scene files that
/// the arguments name are read; models are not.
Order parseCommandLine(const std::vector<std::string>& arguments);

}  // namespace kirireel
