/// Options of the program: what adds to the model (targets, pins, other joints, the scene file),
/// and pictures.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "render/cli/option_group.h"
#include "render/picture/state_painter.h"
#include "render/record/record.h"
#include "sim/model/model.h"
#include "sim/model/model_checks.h"
#include "sim/scene/scene_file.h"
#include "sim/scene/scene_parts.h"

namespace CLI {
class App;
}

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace kirireel::cli {

/// What the command line adds to a scene before it can run. Parts are kept as they were typed: the
/// model, whose numbers they use, has not been read yet.
struct SceneRequest {
  std::filesystem::path file;  ///< of --scene; empty when not given
  scene::SceneParts parts;     ///< what is added to the model that is read
};

/// Adds all settings of a scene, see sceneSettings(). The scene must outlive the parsing. What is
/// typed is written into the scene while the command line is parsed; ranges are checked there.
void addSceneOptions(CLI::App& command, scene::Scene& scene);

/// Adds --scene, --target, --pin, --fix and --link. The request must outlive the parsing. Adds
/// --no-align too, which writes into `alignment`. Both must outlive the parsing.
void addSceneRequestOptions(CLI::App& command, SceneRequest& request,
                            scene::StartAlignment& alignment);

/// The scene file that was named, else scene.toml in the model's folder; it need not be there.
std::filesystem::path sceneFileOf(const std::filesystem::path& modelFolder,
                                  const SceneRequest& request);

/// Reads the scene file that was named, else scene.toml in the model's folder where there is one,
/// into what the command's options point at, the scene's timeline, its obstacles and its grips.
/// Returns it, or an empty one. To be called after parsing. Throws InputError.
scene::SceneFile readSceneFileOf(CLI::App& command, const std::filesystem::path& modelFolder,
                                 const SceneRequest& request, scene::Scene& scene);

// ------------------------------------------------------------------------------------------------
// scene.toml as a command's options: every long option is a key of the table that its group names.

/// Reads a scene file into what a command's options point at: `brick_friction = 0.3` in
/// [environment] is `--brick-friction 0.3`. Options that the command line gave stay as they are.
/// Returns the whole file. To be called after parsing.
/// Throws InputError with file:line:column for unknown keys (suggesting the nearest), keys in the
/// wrong table, and values that the option refuses.
scene::SceneFile applySceneFile(CLI::App& command, const std::filesystem::path& file);

/// The key of an option in a file, "brick_friction" for --brick-friction; empty for a place.
std::string settingKey(const CLI::Option& option);

/// Gives an option the values of a setting, unless the option was given before. To be called after
/// parsing. Throws InputError with file:line:column for values that the option refuses. A switch
/// that is false in the file is left as it is.
void applySetting(CLI::Option& option, const scene::SceneSetting& setting);

// ------------------------------------------------------------------------------------------------
// Models as they are named on the command line.

/// The help of the argument MODEL.
inline constexpr const char* kModelHelp =
    "folder with vertices.txt and constraints.txt, any file of a planar model (NAME_vertices.txt "
    "with NAME_constraints.txt in the same folder), a .fold file, a contracted .obj file, a .ply "
    "mesh, or a "
    "cut pattern (.svg, .dxf)";

/// Adds --target. Empty when it was not given. The target must outlive the parsing.
void addTargetOption(OptionGroup& group, std::filesystem::path& target);

/// Adds --joints-file, --frame, --fold, --join-coplanar, --strict and options of drawings. They
/// only decide how files are read. In a command that has necks of its own, --neck-width is theirs.
/// The settings must outlive the parsing.
void addReadOptions(OptionGroup& group, model::ReadSettings& settings, bool hasNecks = false);

/// The words of --unit and --export-unit: "auto" (absent), then the names of all units.
scene::Choices<std::optional<LengthUnit>> unitChoices();

/// The path of a model: as named, else in data/, else among the installed models. As named if it
/// does not exist: the error then names what the user typed.
std::filesystem::path findModel(const std::filesystem::path& named);

/// The folders of models next to the current folder (data/) and those installed with the program,
/// by name; of two models of one name, findModel() knows only the first.
std::map<std::string, std::filesystem::path> knownModels();

/// Reads the model that findModel() finds. Warnings are appended, also of tiles that overlap at the
/// start. Throws InputError.
model::Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                         const model::ReadSettings& settings, std::vector<std::string>& warnings);

/// The same; warnings go to standard error.
model::Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                         const model::ReadSettings& settings);

/// Appends a warning where bricks are thicker than a tenth of the tiles' mean edge or thinner than
/// a thousandth: most often they are in another unit of length than the tiles.
void checkThickness(const scene::Scene& scene, std::vector<std::string>& warnings);

/// Prints warnings on standard error, each on one line.
void printWarnings(const std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// Options of everything that paints: style, camera, video.

// ------------------------------------------------------------------------------------------------
// Options of everything that paints.

/// Adds the options of pictures and what is made of them. The settings must outlive the parsing.
/// The group in a scene file is [recording]; style and camera follow in their own groups. Values
/// are checked one by one here, and together by record() and render().
void addPictureOptions(CLI::App& command, record::PictureSettings& settings);

// ------------------------------------------------------------------------------------------------
// Options of the style and the camera of pictures.

/// Adds the options of style and camera, the same for every command that paints. The look must
/// outlive the parsing. Two groups in the help, "Look" ([style] in a scene file) and "Camera"
/// ([camera]).
void addLookOptions(CLI::App& command, picture::Look& look);

// ------------------------------------------------------------------------------------------------
// Options of the video.

/// Adds the options of the video, but for its frames a second. The settings must outlive the
/// parsing. They are in [recording] of a scene file.
void addVideoOptions(CLI::App& command, record::PictureSettings& settings);

}  // namespace kirireel::cli
