/// Options that do nothing next to others, and options that contradict each other.
///
/// What a setting of a scene needs is listed with the setting (sim/scene/settings.h). What all
/// other options need is listed here.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "render/record/curves.h"
#include "render/record/record.h"
#include "sim/scene/scene.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

/// What the options of a command were read into. Null where the command has no such options.
struct OptionContext {
  const CLI::App* command = nullptr;                  ///< that was parsed
  const record::PictureSettings* pictures = nullptr;  ///< of record and render
  const exports::ExportSettings* exports = nullptr;   ///< of record, simulate and export
  const record::CurvesSettings* curves = nullptr;     ///< of curves
  const scene::Scene* scene = nullptr;                ///< of record and simulate
  bool page = false;                                  ///< whether page.html is made
  std::size_t runs = 1;                               ///< that are shown
};

/// When an option has an effect.
struct OptionEffect {
  const char* option;  ///< its long name; or the heading of a group of options in the help
  bool (*holds)(const OptionContext&);  ///< whether it has one
  const char* reason;                   ///< why not, as in "without a video"
  const char* remedy;                   ///< what to do, as in "Remove --no-video"
};

/// All of them. For one option, the first that does not hold is reported.
const std::vector<OptionEffect>& optionEffects();

/// The long names of the options that were given so far, with their hyphens.
std::set<std::string> givenOptions(const CLI::App& command);

/// Throws InputError for the first option among the given that has no effect.
void requireEffect(const OptionContext& context, const std::set<std::string>& given);

/// Throws InputError for an option that was given, on the command line or in a scene file, although
/// another choice leaves it without effect. The message names what it needs. To be called once all
/// settings are read.
void requireConsistent(const CLI::App& command, const scene::Scene& scene);

/// The same for how a video's time follows the run. --speed needs --pace real, --length an even
/// pace.
void requireConsistentPace(const CLI::App& command);

/// Whether an option, named with hyphens, has an effect in this scene. True for options that are no
/// settings of a scene. The fingerprint of a run leaves out what has no effect.
bool hasEffect(const std::string& option, const scene::Scene& scene);

}  // namespace kirireel::cli
