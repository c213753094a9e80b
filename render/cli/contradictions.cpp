// Each setting carries its conditions (sim/scene/settings.h), such as "--solver direct". A setting
// that was given although one of them does not hold would be read and do nothing, which is worse
// than an error: a user would draw conclusions from a number that nothing has used. So it is
// refused, with what it needs.
//
// Conditions of single settings stand with the settings. What is left here concerns two settings at
// once, or options of pictures, which are no settings of a scene.
#include "render/cli/contradictions.h"

#include <algorithm>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/scene/settings.h"

namespace kirireel {
namespace {

/// The project's own solver: other engines have no pins, links or guided paths.
bool isDirect(const Scene& scene) {
  return scene.solver.kind == SolverKind::Direct;
}

/// What must hold for an option of this command to mean anything.
std::vector<Condition> conditionsOf(const std::string& option) {
  // Of a model's parts, which are no settings.
  if (option == "--pin" || option == "--link") return {{isDirect, "--solver direct"}};
  for (const SettingGroup& group : sceneSettings()) {
    const auto found = std::ranges::find(group.settings, option, &Setting::option);
    if (found != group.settings.end()) return found->conditions;
  }
  return {};
}

/// On the command line or by a scene file, which adds its values to the same option.
bool isGiven(const CLI::App& command, const char* option) {
  const CLI::Option* found = command.get_option_no_throw(option);
  return found && found->count() > 0;
}

[[noreturn]] void refuse(const std::string& option, const char* needed) {
  throw InputError(fmt::format("error: {} works with {} alone; give that too, or leave {} away",
                               option, needed, option));
}

/// Whether an option was given with this word; the last one counts.
bool isChosen(const CLI::App& command, const char* option, const char* word) {
  return isGiven(command, option) && command.get_option(option)->results().back() == word;
}

}  // namespace

bool hasEffect(const std::string& option, const Scene& scene) {
  return std::ranges::all_of(conditionsOf(option),
                             [&](const Condition& condition) { return condition.holds(scene); });
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
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    for (const Condition& condition : conditionsOf(option->get_name())) {
      if (!condition.holds(scene)) refuse(option->get_name(), condition.needed);
    }
  }
  // A guided path moves tiles towards the target in steps of its own, by the direct solver alone.
  const bool isLed = scene.path.kind == PathKind::Led;
  const Drive drive = scene.actuation.drive;
  const bool pullsToTarget = drive == Drive::Target || drive == Drive::Auto;
  if (isLed && !isDirect(scene)) refuse("--path led", "--solver direct");
  if (isLed && !pullsToTarget) refuse("--path led", "--actuation target");
  if (isLed && scene.solver.isToleranceGiven()) {
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
