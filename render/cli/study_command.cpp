// Studies measure this machine: seconds of CPU time against error, of our solver and of engines
// that were found when the program was built. Rows are kept as they are finished, so an interrupted
// study goes on with --resume.
#include "render/cli/study_command.h"

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>
#include <unistd.h>

#include "render/cli/exit_codes.h"
#include "render/cli/interrupt.h"
#include "render/cli/option_group.h"
#include "render/record/versions.h"
#include "sim/study/engines.h"

namespace kirireel {
namespace {

constexpr const char* kAll = "all";

std::string studyList() {
  std::string text;
  for (const Study& study : studies()) text += fmt::format("{:<16}{}\n", study.name, study.help);
  return text + fmt::format("{:<16}{}\n", kAll, "these one after the other");
}

/// Throws InputError for a name that no study has.
std::vector<const Study*> chosenStudies(const std::string& name) {
  std::vector<const Study*> chosen;
  if (name != kAll) return {&studyNamed(name)};
  for (const Study& study : studies()) chosen.push_back(&study);
  return chosen;
}

/// As it could be typed again; --resume changes no result. It stands in the caption of NAME.csv and
/// NAME.json.
std::string commandText(const StudyOrder& order) {
  return fmt::format("kirireel study {}{}", order.name.string(),
                     order.settings.extent == Extent::Quick ? " --quick" : "");
}

/// What a timing depends on: program, compiler, Eigen.
std::string ownVersions() {
  std::vector<std::string> parts;
  for (const auto& [name, version] : allVersions()) {
    if (name == "kirireel" || name == "compiler" || name == "eigen") {
      parts.push_back(fmt::format("{} {}", name, version));
    }
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

/// Engines are found when the program is built; a study leaves out those that were not.
void sayWhatIsMissing() {
  const std::vector<std::pair<Engine, const char*>> packages = {
      {Engine::Chipmunk, "libchipmunk-dev"},
      {Engine::Box2d, "libbox2d-dev"},
      {Engine::Mujoco, "libmujoco-dev"}};
  for (const auto& [engine, package] : packages) {
    if (isAvailable(engine)) continue;
    fmt::print(stderr,
               "kirireel: built without {0}, which is left out; install {1} and build again to "
               "compare with it\n",
               toString(engine), package);
  }
}

/// Returns whether the study came to its end.
bool runOne(const Study& study, const StudySettings& settings) {
  const bool isTerminal = isatty(STDERR_FILENO) != 0;
  bool stopped = false;
  const Table table =
      runStudy(study, settings, [&](const std::string& name, std::size_t done, std::size_t total) {
        if (isTerminal) {
          fmt::print(stderr, "\r\033[K{} {}/{}: {}", study.name, done, total, name);
        }
        // Asked after each case.
        stopped = takeInterrupt().has_value();
        return !stopped;
      });
  // Takes the line of progress away before results are printed.
  if (isTerminal) fmt::print(stderr, "\r\033[K");
  if (stopped) return false;
  const std::filesystem::path file = settings.folder / (study.name + ".csv");
  fmt::print("{}: {} rows in {}\n", study.name, table.rows.size(), file.string());
  for (const Finding& finding : study.findings(table)) {
    fmt::print("  {:<40} {:<12.4g} {}\n", finding.name, finding.value, finding.meaning);
  }
  std::fflush(stdout);
  return true;
}

}  // namespace

CLI::App* addStudyCommand(CLI::App& program, StudyOrder& order) {
  order.settings.folder = "out/study";
  CLI::App* command = program.add_subcommand(
      "study", "measure speed against error, beside other engines, on this machine");
  addPlace(*command, "NAME", order.name, "a study, or all; see --list");
  OptionGroup group(*command, "Study");
  group.flag("--list", "say which studies there are", [&order] { order.list = true; });
  group.flag("--quick", "fewer and smaller cases: all studies within five minutes",
             [&order] { order.settings.extent = Extent::Quick; });
  group.flag("--resume", "keep the rows that an earlier, interrupted run has finished",
             [&order] { order.settings.resume = true; });
  group.value("--out", "FOLDER", order.settings.folder.string(),
              "where NAME.csv and NAME.json go; scripts/plot-study draws them",
              [&order](const TypedValue& typed) { order.settings.folder = typed.text; });
  command->footer("Example:\n  kirireel study work-precision --quick");
  return command;
}

void completeOrder(const CLI::App& command, StudyOrder& order) {
  if (!order.list) requireGiven(order.name, "NAME", command);
}

int carryOut(const StudyOrder& order) {
  if (order.list) {
    fmt::print("{}", studyList());
    return kExitDone;
  }
  const std::vector<const Study*> chosen = chosenStudies(order.name.string());
  StudySettings settings = order.settings;
  settings.command = commandText(order);
  settings.versions = ownVersions();
  sayWhatIsMissing();
  noteSignals();
  for (const Study* study : chosen) {
    if (runOne(*study, settings)) continue;
    fmt::print(stderr, "kirireel: interrupted; --resume goes on after the finished rows\n");
    return kExitInterrupted;
  }
  return kExitDone;
}

}  // namespace kirireel
