/// What tells one order to record from another.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/input_file.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_file.h"

namespace CLI {
class App;
}

namespace kirireel {

/// The settings of a run, as they are once all is parsed and completed, in one spelling. Both are
/// UTF-8 where all names are.
struct OrderText {
  std::string scene;  ///< a scene file that makes the same run; names of files as they were given
  std::string terms;  ///< what decides the result: the command, and the scene without these names
};

/// Every option of a command that means anything in this scene, with the value that it has now,
/// however it was given or not given, and the scene file's timeline and obstacles. To be called
/// after parsing. `scene` is the scene with all settings, by which options without effect are told.
OrderText orderText(CLI::App& command, const Scene& scene, const SceneFile& sceneFile);

/// A command's name and its options as they are now, where no scene file has a part in them.
/// Conditions are those of a scene with defaults.
std::string parametersText(CLI::App& command);

/// What a run is made from, beside its settings. A file that was opened twice is listed twice.
struct OrderInputs {
  std::string modelName;         ///< which its files bear
  std::vector<InputFile> files;  ///< in the order in which they were read
};

/// SHA-256 of all that decides a run's bytes: the versions of the program and its libraries, the
/// settings, the model's name and the content of all files that were read. Where these stand does
/// not matter: `folders` are those whose files count by their names, see readModelFolder(). 64
/// hexadecimal digits. `terms` is OrderText::terms.
std::string orderFingerprint(const std::string& terms, const OrderInputs& inputs,
                             const std::vector<std::filesystem::path>& folders);

}  // namespace kirireel
