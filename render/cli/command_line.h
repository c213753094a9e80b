/// The command line: what kirireel is asked to do.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "render/cli/convert_command.h"
#include "render/cli/export_command.h"
#include "render/cli/generate_command.h"
#include "render/cli/inspect_command.h"
#include "render/cli/record_command.h"
#include "render/cli/render_command.h"
#include "render/cli/study_command.h"
#include "render/cli/sweep_command.h"
#include "render/cli/verify_command.h"

namespace kirireel {

/// `--help` and `--version`.
struct PrintOrder {
  std::string text;
};

/// Prints the text. Returns the exit code.
int carryOut(const PrintOrder& order);

/// One of the things that kirireel does.
using Order = std::variant<RecordOrder, RenderOrder, ExportOrder, GenerateOrder, InspectOrder,
                           ConvertOrder, StudyOrder, SweepOrder, VerifyOrder, PrintOrder>;

/// Reads the arguments that follow the program's name. Throws InputError for an unknown option
/// (suggesting the nearest), a value out of range, a missing or surplus argument.
Order parseCommandLine(const std::vector<std::string>& arguments);

}  // namespace kirireel
