/// The settings of a scene. Each is defined once here, with the parser of its values.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/scene/scene.h"

namespace kirireel::scene {

// ------------------------------------------------------------------------------------------------
// Parsers and writers of setting values. Every parser throws InputError with the name of the
// setting, the value and the allowed values.

/// A value as typed, with its setting.
struct TypedValue {
  std::string name;  ///< option name with hyphens, or key of a scene file
  std::string text;  ///< text as typed
};

/// Range of accepted numbers.
struct Range {
  double least = -std::numeric_limits<double>::max();  ///< inclusive
  double most = std::numeric_limits<double>::max();    ///< inclusive, unless excludesMost
  bool excludesMost = false;                           ///< accepts only values < most

  /// Whether the range contains a number.
  bool holds(double number) const {
    return number >= least && (excludesMost ? number < most : number <= most);
  }
};

/// A number, possibly with a plus sign. Absent for any other text.
std::optional<double> readNumber(std::string_view text);

/// The same for whole numbers.
std::optional<long> readWhole(std::string_view text);

/// The parts of a text between separators, one more than the number of separators.
std::vector<std::string_view> split(std::string_view text, char separator);

/// A finite number within the range.
double parseNumber(const TypedValue& value, Range range);

/// A whole number in the range, which must be within the range of long.
long parseInteger(const TypedValue& value, Range range);

/// "-9.81" (along z, as in PyKirigami) or "0,0,-9.81".
Vector3 parseGravity(const TypedValue& value);

/// The error for an invalid value: "NAME: 'TEXT' is not allowed; give ALLOWED".
InputError valueError(const TypedValue& value, const std::string& requested);

/// The words that a setting accepts, with their values.
template <typename T>
using Choices = std::vector<std::pair<std::string, T>>;

/// Writers: the inverse of the parsers above, in the syntax of a scene file.

/// The shortest digits that read back as the same double.
std::string numberText(double number);

/// A text in quotation marks; "" stays "".
std::string quotedText(const std::string& text);

/// Values of a repeatable setting: nothing, one value, or all in brackets.
std::string quotedList(const std::vector<std::string>& values);

/// The shortest number near `guess` that `read` converts to `requested`: the inverse of a unit
/// conversion.
double numberReadAs(double requested, double guess, const std::function<double(double)>& read);

/// "all, unjoined or none".
std::string listWords(const std::vector<std::string>& words);

/// The names of the choices, in order.
template <typename T>
std::vector<std::string> choiceNames(const Choices<T>& choices) {
  std::vector<std::string> names;
  for (const auto& choice : choices) names.push_back(choice.first);
  return names;
}

/// The name of a value among the choices; "" if it is not among them.
template <typename T, typename Value>
std::string nameOfChoice(const Choices<T>& choices, const Value& value) {
  for (const auto& [name, meaning] : choices) {
    if (Value(meaning) == value) return name;
  }
  return "";
}

/// The choice with this name. Throws InputError if there is none.
template <typename T>
T parseChoice(const TypedValue& value, const Choices<T>& choices) {
  for (const auto& [name, meaning] : choices) {
    if (name == value.text) return meaning;
  }
  throw valueError(value, listWords(choiceNames(choices)));
}

// ------------------------------------------------------------------------------------------------
// The settings of a scene. Each has its name, values, meaning and conditions, defined once. This
// list gives the options of the program, the keys of scene.toml and of sweeps, the check of scenes
// made in code, the fingerprint of an order, the settings in summary.json, and the scenes that need
// dynamics.

/// Condition for a setting to have an effect.
struct Condition {
  bool (*holds)(const Scene&);  ///< whether the scene fulfils it
  const char* needed;           ///< how to fulfil it, such as "`solver = direct`"
  bool isWithout = false;       ///< `needed` is equivalent to the setting and must not be given
};

/// One setting of a scene.
struct Setting {
  std::string key;   ///< unique, such as "brick_friction"; key of its table in scene.toml
  std::string unit;  ///< for the help, such as "SECONDS"; empty for a switch
  std::string help;  ///< one phrase, for the user
  /// Sets it to the typed value, or a switch to its "on" value. Throws InputError for an invalid
  /// value.
  std::function<void(Scene&, const TypedValue&)> read;
  /// Its value in scene file syntax (`0.02`, `true`, `"all"`, `[0, 0, -9.81]`), to the last bit; ""
  /// if it has no value. The text is also valid JSON.
  std::function<std::string(const Scene&)> write;
  std::string defaultText;         ///< the default in words; may be empty
  std::vector<std::string> words;  ///< the only accepted values; empty: see read()
  bool isSwitch = false;           ///< whether it is used without a value
  bool isNumber = false;           ///< read() accepts what write() returns
  /// Why a scene needs dynamics if this is not the default, such as "there is friction"; empty if
  /// it does not.
  std::string dynamics;
  std::vector<Condition> conditions;  ///< the first unfulfilled one is reported
  /// Whether a scene must be spatial because of it; null: never.
  bool (*isSpatial)(const Scene&) = nullptr;
  std::string space;  ///< the reason, such as "tiles bend"

  /// The setting with an additional condition.
  Setting with(bool (*holds)(const Scene&), const char* needed) &&;
  /// The setting as an equivalent of others; `holds` if these are not set.
  Setting without(bool (*holds)(const Scene&), const char* others) &&;
  /// The setting as one that needs space if `holds`, with this reason.
  Setting needsSpace(bool (*holds)(const Scene&), const char* why) &&;
  /// The setting as one that needs dynamics.
  Setting needsDynamics(const char* why) &&;
};

/// Settings of one group in the help and one table in scene.toml.
struct SettingGroup {
  std::string heading;            ///< "Springs to the target"
  std::string table;              ///< "actuation"
  std::vector<Setting> settings;  ///< in the order of the help
};

/// All settings of a scene, in the order of the help. Built at first use, with static lifetime.
const std::vector<SettingGroup>& sceneSettings();

/// The setting with this key. Throws std::out_of_range if there is none.
const Setting& sceneSetting(const std::string& key);

/// Throws InputError for the first number of a scene that is out of range. Words and switches are
/// always valid. Texts such as file names are not checked. Numbers are checked like their options,
/// in the order of the help.
void requireRanges(const Scene& scene);

/// Why the settings of a scene need space; empty if a planar scene is sufficient.
std::string whySpace(const Scene& scene);

/// Why the settings of a scene need dynamics; empty if a kinematic path is sufficient.
std::string whyDynamics(const Scene& scene);

}  // namespace kirireel::scene
