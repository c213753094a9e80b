/// Options for the model's additions (targets, pins, other joints, the scene file) and for
/// pictures.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "render/cli/option_group.h"
#include "render/picture/state_painter.h"
#include "render/record/record.h"
#include "sim/formats/read_settings.h"
#include "sim/model/model.h"
#include "sim/scene/scene_file.h"
#include "sim/scene/scene_parts.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace kirireel::cli {

/// Additions of the command line to a scene. Parts are kept as typed, because the model, whose
/// numbers they use, has not been read yet.
struct SceneRequest {
  std::filesystem::path file;  ///< of --scene; empty if not given
  scene::SceneParts parts;     ///< additions to the model
};

/// Adds all settings of a scene, see sceneSettings(). The scene must outlive the parsing, which
/// writes values to the scene and checks their ranges.
void addSceneOptions(CLI::App& command, scene::Scene& scene);

/// Adds --scene, --target, --pin, --fix, --link, and --no-align, which writes to `alignment`. The
/// request and `alignment` must outlive the parsing.
void addSceneRequestOptions(CLI::App& command, SceneRequest& request,
                            scene::StartAlignment& alignment);

/// Reads the requested scene file, or scene.toml in the model's folder if it exists, into the
/// variables of the command's options, the scene's timeline, its obstacles and its grips. Returns
/// it, or an empty one. `all`: see applySceneFile(). Call it after parsing. Throws InputError.
scene::SceneFile readSceneFileOf(CLI::App& command, CLI::App& all,
                                 const std::filesystem::path& modelFolder,
                                 const SceneRequest& request, scene::Scene& scene);

// ------------------------------------------------------------------------------------------------
// scene.toml as options of a command: every long option is a key in the table of its group.

/// Reads a scene file into the variables of a command's options: `brick_friction = 0.3` in
/// [environment] is `--brick-friction 0.3`. Options of the command line have priority.
/// `all` is a command with the keys of every scene file. Those that `command` lacks are checked but
/// have no effect, so one file serves `record` and `simulate`. Returns the whole file. Call it
/// after parsing. Throws InputError with file:line:column for unknown keys (suggesting the
/// nearest), keys in the wrong table, and values that the option refuses.
scene::SceneFile applySceneFile(CLI::App& command, CLI::App& all,
                                const std::filesystem::path& file);

/// The key of an option in a file, "brick_friction" for --brick-friction; empty for a positional.
std::string settingKey(const CLI::Option& option);

/// Gives an option the values of a setting, unless the command line set it. Call it after parsing.
/// Throws InputError with file:line:column for values that the option refuses. A switch that is
/// false in the file stays unchanged.
void applySetting(CLI::Option& option, const scene::SceneSetting& setting);

// ------------------------------------------------------------------------------------------------
// Models on the command line.

/// Adds --target, which sets `target`; empty if not given. It must outlive the parsing.
void addTargetOption(OptionGroup& group, std::filesystem::path& target);

/// Adds --joints-file, --frame, --fold, --join-coplanar, --strict and options of drawings. They
/// only affect reading. In a command with its own necks, --neck-width belongs to these. The
/// settings must outlive the parsing.
void addReadOptions(OptionGroup& group, formats::ReadSettings& settings, bool hasNecks = false);

/// The words of --unit and --export-unit: "auto" (absent), then the names of all units.
scene::Choices<std::optional<LengthUnit>> unitChoices();

/// The path of a model: as given, else in data/, else among the installed models. A path that does
/// not exist is returned unchanged, so the error has the user's text.
std::filesystem::path findModel(const std::filesystem::path& named);

/// The folders of models next to the current folder (data/) and those installed with the program,
/// by name. findModel() uses the first of two models with the same name.
std::map<std::string, std::filesystem::path> knownModels();

/// Reads the model that findModel() finds. Adds warnings, including tiles that overlap at the
/// start. Throws InputError.
model::Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                         const formats::ReadSettings& settings, std::vector<std::string>& warnings);

/// The same; warnings go to standard error.
model::Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                         const formats::ReadSettings& settings);

/// Adds a warning if bricks are thicker than a tenth of the tiles' mean edge or thinner than a
/// thousandth: usually their unit of length differs from that of the tiles.
void checkThickness(const scene::Scene& scene, std::vector<std::string>& warnings);

/// Prints warnings on standard error, each on one line.
void printWarnings(const std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// Options of all painting commands: style, camera, video.

/// Splits at commas; a comma at the end adds no empty word.
std::vector<std::string> parseWords(const scene::TypedValue& value);

/// "svg,png": each format once, in the order of first mention.
std::vector<picture::PageFormat> parsePages(const scene::TypedValue& value,
                                            const scene::Choices<picture::PageFormat>& choices);

/// Adds the options of a grid of pictures, without its files and its size in print. The settings
/// must outlive the parsing, as for all functions below.
void addGridOptions(OptionGroup& group, record::PictureSettings& settings);

/// Adds --same-view and --same-scale, for grids of several runs.
void addRowOptions(OptionGroup& group, record::PictureSettings& settings);

/// Adds the options of a page in print: width, text, letters, dots per inch.
void addPrintOptions(OptionGroup& group, record::PictureSettings& settings);

/// Adds the options of pictures and their outputs. The settings must outlive the parsing. The group
/// in a scene file is [recording]; style and camera have their own groups. Each value is checked
/// here. record() and render() check their combination.
void addPictureOptions(CLI::App& command, record::PictureSettings& settings);

// ------------------------------------------------------------------------------------------------
// Options of the style and the camera of pictures.

/// Adds the options of style and camera, the same for every painting command. The appearance must
/// outlive the parsing. The help has two groups, "Style" ([style] in a scene file) and "Camera"
/// ([camera]).
void addAppearanceOptions(CLI::App& command, picture::Appearance& appearance);

// ------------------------------------------------------------------------------------------------
// Options of the video.

/// Adds the options of the video, except its frames per second. The settings must outlive the
/// parsing. They are in [recording] of a scene file.
void addVideoOptions(CLI::App& command, record::PictureSettings& settings);

}  // namespace kirireel::cli
