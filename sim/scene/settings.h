/// The settings of a scene: each is written down once here, with how its values are read.
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
// Reads the values of settings as people type them, and writes them again. Every function that
// reads throws InputError that names the setting, the value found and what is allowed.

/// A value as typed, and what it was given for.
struct TypedValue {
  std::string name;  ///< of an option with its hyphens, or a key of a scene file
  std::string text;  ///< that was typed
};

/// The numbers that a setting accepts.
struct Range {
  double least = -std::numeric_limits<double>::max();  ///< accepted itself
  double most = std::numeric_limits<double>::max();    ///< accepted, unless excludesMost
  bool excludesMost = false;                           ///< accept only values < most

  /// Whether a number is among them.
  bool holds(double number) const {
    return number >= least && (excludesMost ? number < most : number <= most);
  }
};

/// A number; a plus sign may precede it. Nothing where the text is none, or more than that.
std::optional<double> readNumber(std::string_view text);

/// The same for whole numbers.
std::optional<long> readWhole(std::string_view text);

/// The parts of a text between separators, one more than there are separators.
std::vector<std::string_view> split(std::string_view text, char separator);

/// A finite number within the range.
double parseNumber(const TypedValue& value, Range range);

/// A whole number within the range (which must lie within the numbers of a long).
long parseInteger(const TypedValue& value, Range range);

/// "-9.81" (along z, as in PyKirigami) or "0,0,-9.81".
Vector3 parseGravity(const TypedValue& value);

/// "2e9" or "2e9,0.3": Young's modulus, above 0, and Poisson's ratio of the model's necks; or
/// "0.1,0.3,2e9" or "0.1,0.3,2e9,0.3": a neck's width, length, Young's modulus, each above 0, and
/// Poisson's ratio.
HingeNeck parseNeck(const TypedValue& value);

/// "2e9", "2e9,0.3" or "2e9,0.3,0.05": Young's modulus, > 0, Poisson's ratio and the length
/// scale of folds, >= 0.
PanelMaterial parsePanels(const TypedValue& value);

/// The error of a value that is not allowed: "NAME: 'TEXT' is not allowed; give WANTED".
InputError valueError(const TypedValue& value, const std::string& requested);

/// The words that a setting accepts, with what each means.
template <typename T>
using Choices = std::vector<std::pair<std::string, T>>;

/// The functions below write what those above read, as values of a scene file.

/// The shortest digits that read back as the same double.
std::string numberText(double number);

/// A text in quotation marks; "" stays "".
std::string quotedText(const std::string& text);

/// Values of a setting that may be given several times: nothing, the one, or all in brackets.
std::string quotedList(const std::vector<std::string>& values);

/// The shortest number near `guess` that `read` converts to `requested`: the inverse of a unit
/// conversion.
double numberReadAs(double requested, double guess, const std::function<double(double)>& read);

/// "[0, 0, -9.81]".
std::string vectorText(const Vector3& vector);
/// A neck as parseNeck() reads it.
std::string neckText(const HingeNeck& neck);
/// A material as parsePanels() reads it.
std::string panelsText(const PanelMaterial& panels);

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
// The settings of a scene, each written down once: what it is called, takes and means, and when it
// counts. From this list come the options of the program, the keys of scene.toml and of sweeps, the
// check of a scene that was made in code, the fingerprint of an order, the settings in
// summary.json, and which scenes need dynamics.

/// What must hold for a setting to mean anything.
struct Condition {
  bool (*holds)(const Scene&);  ///< whether the scene is so
  const char* needed;           ///< what makes it hold, as in "`solver = direct`"
  bool isWithout = false;       ///< `needed` is equivalent to the setting and must not be given
};

/// One setting of a scene.
struct Setting {
  std::string key;   ///< unique, as in "brick_friction"; of its table in scene.toml
  std::string unit;  ///< for the help, as in "SECONDS"; of a switch empty
  std::string help;  ///< one phrase, for people
  /// Sets it to what was typed; a switch, which is not typed, to what it switches on. Throws
  /// InputError for a value that is not allowed.
  std::function<void(Scene&, const TypedValue&)> read;
  /// Its value in the spelling of a scene file (`0.02`, `true`, `"all"`, `[0, 0, -9.81]`), to the
  /// last bit; "" if it has no value. Such a value is also valid JSON.
  std::function<std::string(const Scene&)> write;
  std::string defaultText;         ///< the default in words; may be empty
  std::vector<std::string> words;  ///< the only values that it accepts; empty: see read()
  bool isSwitch = false;           ///< whether it is given without a value
  bool isNumber = false;           ///< read() accepts what write() returns
  /// Why a scene needs dynamics if this is not the default, as in "there is friction"; empty if it
  /// does not.
  std::string dynamics;
  std::vector<Condition> conditions;  ///< the first that does not hold is reported
  /// Whether a scene has to be in space for it; null: never.
  bool (*isSpatial)(const Scene&) = nullptr;
  std::string space;  ///< why, as in "tiles bend"

  /// The setting with a condition more.
  Setting with(bool (*holds)(const Scene&), const char* needed) &&;
  /// The setting as an equivalent of others; `holds` if these are not given.
  Setting without(bool (*holds)(const Scene&), const char* others) &&;
  /// The setting as one that may need space: where `holds`, for this reason.
  Setting needsSpace(bool (*holds)(const Scene&), const char* why) &&;
  /// The setting as one of dynamics.
  Setting needsDynamics(const char* why) &&;
};

/// Settings of one group in the help and one table in scene.toml.
struct SettingGroup {
  std::string heading;            ///< "Springs to the target"
  std::string table;              ///< "actuation"
  std::vector<Setting> settings;  ///< in the order of the help
};

/// All settings of a scene, in the order of the help.
/// Built at the first use; it lives as long as the program.
const std::vector<SettingGroup>& sceneSettings();

/// The setting with this key. Throws std::out_of_range where there is none.
const Setting& sceneSetting(const std::string& key);

/// Throws InputError for the first number of a scene that is out of its range. Words and switches
/// cannot be out of range; texts such as file names are not checked.
/// All numbers are checked as their options are, in the order of the help.
void requireRanges(const Scene& scene);

/// Why the settings of a scene need three dimensions; empty where a planar one serves them.
std::string whySpace(const Scene& scene);

/// Why the settings of a scene need dynamics; empty where a path that is geometry serves them.
std::string whyDynamics(const Scene& scene);

}  // namespace kirireel::scene
