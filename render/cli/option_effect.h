/// Options without effect in combination with others, and contradicting options.
///
/// The conditions of a scene's settings are listed with the settings (sim/scene/settings.h). The
/// conditions of all other options are listed here.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "render/record/curves.h"
#include "render/record/record.h"
#include "sim/scene/scene.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

/// Settings that the options of a command write. Null if the command has no such options.
struct OptionContext {
  const CLI::App* command = nullptr;                  ///< parsed command
  const record::PictureSettings* pictures = nullptr;  ///< of record and render
  const exports::ExportSettings* exports = nullptr;   ///< of record, simulate and export
  const record::CurvesSettings* curves = nullptr;     ///< of curves
  const scene::Scene* scene = nullptr;                ///< of record and simulate
  bool page = false;                                  ///< whether to make page.html
  std::size_t runs = 1;                               ///< number of shown runs
};

/// Condition for an effect of an option.
struct OptionEffect {
  /// Its long name, or the heading of a group of options in the help. In the table one or more,
  /// separated by commas.
  std::string_view option;
  bool (*holds)(const OptionContext&);  ///< whether it has an effect
  const char* reason;                   ///< why not, such as "without a video"
  const char* remedy;                   ///< advice, such as "Remove --no-video"
  /// Whether the command has the settings that `holds` reads; set in optionEffects().
  bool (*isApplicable)(const OptionContext&) = nullptr;
};

/// All of them. For one option, the first that does not hold is reported.
const std::vector<OptionEffect>& optionEffects();

/// The long names of the options given so far, with their hyphens.
std::set<std::string> givenOptions(const CLI::App& command);

/// Throws InputError for the first given option without effect.
void requireEffect(const OptionContext& context, const std::set<std::string>& given);

/// Throws InputError for an option, on the command line or in a scene file, that has no effect
/// because of another choice. The message states the required choice. Call it after reading all
/// settings.
void requireConsistent(const CLI::App& command, const scene::Scene& scene);

/// The same for the relation of a video's time to the run. --speed needs --pace real, --length an
/// even pace.
void requireConsistentPace(const CLI::App& command);

/// Whether an option, named with hyphens, has an effect in this scene. True for options that are no
/// settings of a scene. The fingerprint of a run leaves out what has no effect.
bool hasEffect(const std::string& option, const scene::Scene& scene);

}  // namespace kirireel::cli
