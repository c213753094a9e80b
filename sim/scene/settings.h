/// The settings of a scene, each written down once: what it is called, takes and means, and when it
/// counts. From this list come the options of the program, the keys of scene.toml and of sweeps,
/// the check of a scene that was made in code, the text that tells one order from another, the
/// settings in summary.json, and which scenes need dynamics.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/scene/scene.h"
#include "sim/scene/setting_values.h"

namespace kirireel {

/// What must hold for a setting to mean anything.
struct Condition {
  bool (*holds)(const Scene&);
  const char* needed;  ///< the options that make it hold, as in "--solver direct"
};

/// One setting of a scene.
struct Setting {
  std::string key;   ///< "brick_friction": of its table in scene.toml; --brick-friction
  std::string unit;  ///< for the help, as in "SECONDS"; of a switch empty
  std::string help;
  /// Sets it to what was typed; a switch, which is not typed, to what it switches on. Throws
  /// InputError for a value that is not allowed.
  std::function<void(Scene&, const TypedValue&)> read;
  /// Its value as a scene file has it (`0.02`, `true`, `"all"`, `[0, 0, -9.81]`), to the last bit;
  /// "" where there is nothing to say. Such a value is JSON, too.
  std::function<std::string(const Scene&)> write;
  std::string usual;               ///< the default in words; may be empty
  std::vector<std::string> words;  ///< the only values that it accepts; empty: see read()
  bool isSwitch = false;
  bool isNumber = false;  ///< what it writes can be read as it stands
  /// Why a scene in which it is not as usual needs dynamics, as in "there is friction"; empty where
  /// it needs none for that.
  std::string dynamics;
  std::vector<Condition> conditions;  ///< the first that does not hold is told

  /// The setting with a condition more.
  Setting with(bool (*holds)(const Scene&), const char* needed) &&;
  /// The setting as one of dynamics.
  Setting needsDynamics(const char* why) &&;

  /// The name of its option, "--brick-friction".
  std::string option() const;
};

/// Settings that stand together in the help, and in a table of scene.toml.
struct SettingGroup {
  std::string heading;  ///< "Springs to the target"
  std::string table;    ///< "actuation"
  std::vector<Setting> settings;
};

/// All settings of a scene, in the order of the help.
/// Built at the first use; it lives as long as the program.
const std::vector<SettingGroup>& sceneSettings();

/// The setting with this key. Throws std::out_of_range where there is none.
const Setting& sceneSetting(const std::string& key);

/// Throws InputError for the first number of a scene that is out of its range.
/// Words and switches cannot be out of range; texts such as file names are not looked at.
void requireRanges(const Scene& scene);

/// Why the settings of a scene need dynamics; empty where a path that is geometry serves them.
std::string whyDynamics(const Scene& scene);

}  // namespace kirireel
