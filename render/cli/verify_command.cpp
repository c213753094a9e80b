// Prints what does not agree, one line each, on standard output, because that is the result; exit
// code 1 then.
#include "render/cli/verify_command.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/exit_codes.h"
#include "render/cli/option_group.h"
#include "render/verify/verify.h"

namespace kirireel {

CLI::App* addVerifyCommand(CLI::App& program, VerifyOrder& order) {
  CLI::App* command = program.add_subcommand(
      "verify", "check that a finished run's files are those it left and bear its figures out");
  addPlace(*command, "FOLDER", order.folder, "that of a finished run");
  command->footer(
      "Compares every file with its size and SHA-256 in summary.json, and computes the figures of\n"
      "trajectory.h5 again from its poses. Exit code 1 when something does not agree.\n\n"
      "Example:\n  kirireel verify out/tessellation_4x4");
  return command;
}

void completeOrder(const CLI::App& command, VerifyOrder& order) {
  requireGiven(order.folder, "FOLDER", command);
}

int carryOut(const VerifyOrder& order) {
  const VerifyReport report = verifyRun(order.folder);
  for (const std::string& complaint : report.complaints) fmt::print("{}\n", complaint);
  if (!report.complaints.empty()) return kExitFailed;
  fmt::print("{}: {} files and the figures of {} samples agree with the summary\n",
             order.folder.string(), report.files, report.samples);
  return kExitDone;
}

}  // namespace kirireel
