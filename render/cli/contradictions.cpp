#include "render/cli/contradictions.h"

#include <algorithm>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/scene/scene.h"

namespace kirireel {
namespace {

/// An option, and what must hold for it to mean anything.
struct Rule {
  const char* option;
  bool (*holds)(const Scene&);
  const char* needed;
};

bool isLed(const Scene& scene) {
  return scene.path.kind == PathKind::Led;
}
bool isDirect(const Scene& scene) {
  return scene.solver.kind == SolverKind::Direct;
}
bool isBullet(const Scene& scene) {
  return scene.solver.kind == SolverKind::Bullet;
}
bool hasHingeSprings(const Scene& scene) {
  return scene.hinges.stiffness > 0 || scene.hinges.neck || !scene.hinges.file.empty();
}
bool hasNecks(const Scene& scene) {
  return scene.hinges.neck.has_value();
}
/// Whether no tolerance in time was given that steps of a given length would not keep.
bool mayHaveFixedSteps(const Scene& scene) {
  return scene.solver.tolerance == 0 || scene.solver.tolerance == kUsualTolerance;
}
bool isDirectOrFixed(const Scene& scene) {
  return isDirect(scene) || mayHaveFixedSteps(scene);
}
bool pullsToTarget(const Scene& scene) {
  return scene.actuation.drive == Drive::Target || scene.actuation.drive == Drive::Auto;
}
bool pullsToCurve(const Scene& scene) {
  return scene.actuation.drive == Drive::Boundary;
}
bool weighsByVolume(const Scene& scene) {
  return scene.brick.mass == MassRule::Prism;
}

/// The first that does not hold is reported.
const std::vector<Rule>& rules() {
  static const std::vector<Rule> all = {
      {"--joint-stiffness", isDirect, "--solver direct"},
      {"--pin", isDirect, "--solver direct"},
      {"--link", isDirect, "--solver direct"},
      {"--hinge-stiffness", isDirect, "--solver direct"},
      {"--hinge-neck", isDirect, "--solver direct"},
      {"--hinge-damping", isDirect, "--solver direct"},
      {"--hinge-file", isDirect, "--solver direct"},
      {"--ligaments", hasNecks, "--hinge-neck"},
      {"--hinge-rest", hasHingeSprings, "--hinge-stiffness, --hinge-neck or --hinge-file"},
      {"--iterations", isBullet, "--solver bullet"},
      {"--tolerance", isDirectOrFixed, "--solver direct"},
      {"--substeps", mayHaveFixedSteps, "--tolerance 0"},
      {"--open-time", isLed, "--path led"},
      {"--led-time", isLed, "--path led"},
      {"--led-stiffness", isLed, "--path led"},
      {"--joint-stiffness", isLed, "--path led"},
      {"--boundary-size", pullsToCurve, "--actuation boundary"},
      {"--boundary-aspect", pullsToCurve, "--actuation boundary"},
      {"--density", weighsByVolume, "--mass prism"},
  };
  return all;
}

bool isGiven(const CLI::App& command, const char* option) {
  const CLI::Option* found = command.get_option_no_throw(option);
  return found && found->count() > 0;
}

[[noreturn]] void refuse(const char* option, const char* needed) {
  throw InputError(fmt::format("error: {} works with {} alone; give that too, or leave {} away",
                               option, needed, option));
}

bool isChosen(const CLI::App& command, const char* option, const char* word) {
  return isGiven(command, option) && command.get_option(option)->results().back() == word;
}

}  // namespace

bool hasEffect(const std::string& option, const Scene& scene) {
  return std::ranges::all_of(
      rules(), [&](const Rule& rule) { return rule.option != option || rule.holds(scene); });
}

void requireConsistentPace(const CLI::App& command) {
  if (isGiven(command, "--speed") && isChosen(command, "--pace", "even")) {
    refuse("--speed", "--pace real");
  }
  if (isGiven(command, "--length") && isChosen(command, "--pace", "real")) {
    refuse("--length", "--pace even");
  }
  if (isGiven(command, "--length") && isGiven(command, "--speed")) {
    throw InputError(
        "error: --length is for an even pace and --speed for real time; leave one of them away");
  }
}

void requireConsistent(const CLI::App& command, const Scene& scene) {
  requireConsistentPace(command);
  for (const Rule& rule : rules()) {
    if (isGiven(command, rule.option) && !rule.holds(scene)) refuse(rule.option, rule.needed);
  }
  if (isLed(scene) && !isDirect(scene)) refuse("--path led", "--solver direct");
  if (isLed(scene) && !pullsToTarget(scene)) refuse("--path led", "--actuation target");
  if (isLed(scene) && !mayHaveFixedSteps(scene)) {
    throw InputError(
        "error: --path led moves tiles in fixed steps, which keep no --tolerance; leave one of "
        "them away");
  }
  if (isGiven(command, "--faces") && isGiven(command, "--auto-detect-connections")) {
    throw InputError(
        "error: --auto-detect-connections is --faces pykirigami; leave one of them away");
  }
}

}  // namespace kirireel
