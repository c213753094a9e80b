/// Options of commands: declared in groups, read as values, checked against each other.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/picture/camera.h"
#include "render/picture/frame.h"
#include "render/picture/grid.h"
#include "render/record/record.h"
#include "sim/scene/settings.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace kirireel::cli {

/// Whether a name is in a (short) list.
inline bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

// ------------------------------------------------------------------------------------------------
// Reads the values of options about pictures and exports. sim/scene/settings.h reads those of a
// scene. Every function throws InputError with the option, the value and what is allowed.

/// "1280x720": a valid frame size. Width before height, in pixels, each from 1 to kMaxFrameSide.
picture::FrameSize parseSize(const scene::TypedValue& value);

/// "180mm", "18cm" or "7pt": a number in `unit`, or with another one of lengthUnits(). Returns the
/// length in `unit`, which is also the unit of the range.
double parseLength(const scene::TypedValue& value, const std::string& unit, scene::Range range);

/// Readers of a number, a whole number, a length in print (parseLength), and of any text.
inline auto numberIn(scene::Range range) {
  return [range](const scene::TypedValue& typed) { return scene::parseNumber(typed, range); };
}
template <typename Integer = int>
auto integerIn(scene::Range range) {
  return [range](const scene::TypedValue& typed) {
    return static_cast<Integer>(scene::parseInteger(typed, range));
  };
}
inline auto lengthIn(const std::string& unit, scene::Range range) {
  return [unit, range](const scene::TypedValue& typed) { return parseLength(typed, unit, range); };
}
inline std::string asTyped(const scene::TypedValue& typed) {
  return typed.text;
}

/// "3x4": rows x columns, each 1 to 100.
picture::GridShape parseGrid(const scene::TypedValue& value);

/// "0,1.5,50%": seconds >= 0, or fractions of the progress in [0%, 100%].
std::vector<record::FrameChoice> parseFrameChoices(const scene::TypedValue& value);

/// "80AEDC" or "#80AEDC": red, green and blue in hexadecimal; or a CSS name, "teal".
picture::Colour parseColour(const scene::TypedValue& value);

/// "0:50:-35:1,2.5:90:-20:1.5": keys of a camera as TIME:YAW:PITCH:ZOOM, seconds and degrees. Yaw
/// and pitch are PyKirigami's; zoom is a factor. CameraPath checks that times ascend.
std::vector<picture::CameraKey> parseCameraKeys(const scene::TypedValue& value);

/// "time,error": parts of a caption, or "none". Parts are progress, time, angle, error and gap;
/// "none" excludes the others.
picture::CaptionParts parseCaption(const scene::TypedValue& value);

/// "3,0,7": whole numbers >= 0; exactly `count` of them if it is not 0. `requested` describes them
/// in the error.
std::vector<int> parseIndices(const scene::TypedValue& value, std::size_t count,
                              const std::string& requested);

/// Each list as "3,4", all of them in scene file syntax.
template <typename List>
std::string listsText(const std::vector<List>& lists) {
  std::vector<std::string> texts;
  for (const List& list : lists)
    texts.push_back(scene::quotedText(fmt::format("{}", fmt::join(list, ","))));
  return scene::quotedList(texts);
}

/// "all" or numbers of tiles, e.g. "3,7,8"; empty for all.
std::vector<int> parseTiles(const scene::TypedValue& value);

/// "3,7,10-15=teal": numbers of tiles, or ranges of them, and a colour; "hinge row:3,7=teal": also
/// a name for the legend.
picture::TileColour parseTileColour(const scene::TypedValue& value);

/// "3,7,10-15=0.3": numbers of tiles, or ranges of them, and an opacity in [0, 1].
picture::TileOpacity parseTileOpacity(const scene::TypedValue& value);

/// The option that sets a key: "--brick-friction" for "brick_friction".
std::string optionName(const std::string& key);

/// A message of sim/ as the command line shows it: "`key`" becomes "--key", "`key = value`" becomes
/// "--key value", and "`key = false`" becomes "--no-key".
std::string spellOptions(const std::string& message);

/// The functions below write values as in a scene file; the functions above read them.

/// Words with commas, in quotation marks; "" without words.
std::string wordsText(const std::vector<std::string>& words);
/// A number > 0; "" for others.
std::string positiveText(double number);

/// "1280x720" in quotation marks.
std::string sizeText(picture::FrameSize size);
/// Rows by columns, "3x4".
std::string gridText(picture::GridShape grid);
/// Fractions with a per cent sign, seconds without.
std::string frameChoicesText(const std::vector<record::FrameChoice>& choices);
/// Six hexadecimal digits in capitals.
std::string colourText(picture::Colour colour);
/// Each as TILES=COLOUR or NAME:TILES=COLOUR.
std::string tileColoursText(const std::vector<picture::TileColour>& colours);
/// Each as TILES=SHARE.
std::string tileOpacitiesText(const std::vector<picture::TileOpacity>& opacities);
/// TIME:YAW:PITCH:ZOOM with commas; degrees.
std::string cameraKeysText(const std::vector<picture::CameraKey>& keys);
/// Words with commas; "none" if there is no part.
std::string captionText(const picture::CaptionParts& parts);
/// Numbers with commas, "all" for none.
std::string tilesText(const std::vector<int>& tiles);

/// The typed yaw and pitch.
struct TypedView {
  double yaw = 0;    ///< of the camera, degrees
  double pitch = 0;  ///< of the camera, degrees
};
/// The shortest degrees that read back to this view, to the last bit.
TypedView typedView(const picture::ViewAngles& view);

// ------------------------------------------------------------------------------------------------
// Options of one group in a command's help.

/// Adds options of one group to a command; each has a reader for its value. Every wrong value is
/// reported in the same words. Variables are set while CLI11 parses, in the order of the words.
class OptionGroup {
 public:
  /// `table`: of a scene file that can also set these options; empty if none can. `command` and
  /// every variable given below must outlive the parsing.
  OptionGroup(CLI::App& command, std::string heading, std::string table = "")
      : command_(command), heading_(std::move(heading)), table_(std::move(table)) {}

  /// Stores the value of the option. Throws InputError for a value that is not allowed.
  using Reader = std::function<void(const scene::TypedValue&)>;
  /// Returns the current value as in a scene file.
  using Writer = std::function<std::string()>;

  /// How an option enters the fingerprint of a run. By default it does, with its value as typed.
  class Statement {
   public:
    /// For this option, which must outlive it.
    explicit Statement(CLI::Option* option) : option_(option) {}

    /// `write` returns the option's value as in a scene file (`0.02`, `true`, `"all"`, `["3,4",
    /// "5,6"]`), which reads back to the last bit; "" without a value.
    Statement& serializedAs(const Writer& write);

    /// For options that do not change the result or that another option reports.
    Statement& excludeFromFingerprint();

    /// Stores the allowed values of the option, see allowedWords().
    Statement& accepts(const std::vector<std::string>& words);

   private:
    CLI::Option* option_;
  };

  /// An option with a value that `read` understands. `unit` and `defaultText` (empty: no default)
  /// are for the help. Given several times, the last one counts. `name` may list several names with
  /// commas, "--a,-b"; the first long one is the key of a scene file.
  Statement value(const std::string& name, const std::string& unit, const std::string& defaultText,
                  const std::string& help, const Reader& read);

  /// The same for an option that may be given several times. Each value is read in turn, and the
  /// reader must append it.
  Statement values(const std::string& name, const std::string& unit, const std::string& help,
                   const Reader& read);

  /// An option that sets a variable. `read` converts the text. `write` converts the variable, or
  /// the value of an optional one, as in a scene file. Without a value nothing is written.
  template <typename Target, typename Read, typename Write>
  Statement stored(const std::string& name, Target& target, const std::string& unit,
                   const std::string& defaultText, const std::string& help, const Read& read,
                   const Write& write) {
    return value(name, unit, defaultText, help,
                 [&target, read](const scene::TypedValue& typed) { target = read(typed); })
        .serializedAs([&target, write]() -> std::string {
          if constexpr (std::is_invocable_v<Write, const Target&>) {
            return write(target);
          } else {
            return target ? write(*target) : "";
          }
        });
  }

  /// An option that may be given several times and appends to a list. `write` converts the list.
  template <typename Entry, typename Read, typename Write>
  Statement appended(const std::string& name, std::vector<Entry>& list, const std::string& unit,
                     const std::string& help, const Read& read, const Write& write) {
    return values(name, unit, help,
                  [&list, read](const scene::TypedValue& typed) { list.push_back(read(typed)); })
        .serializedAs([&list, write] { return write(list); });
  }

  /// A setting of a scene. Name, unit, help, reader and writer are those of the setting. The scene
  /// must outlive the parsing.
  void setting(const scene::Setting& setting, scene::Scene& scene);

  /// A number within a range; the variable's value is the default. Both ends of the range are
  /// accepted, unless `excludesMost` is set.
  void number(const std::string& name, double& target, scene::Range range, const std::string& unit,
              const std::string& help);

  /// A number that may be absent; `defaultText` describes its effect then.
  void number(const std::string& name, std::optional<double>& target, scene::Range range,
              const std::string& unit, const std::string& defaultText, const std::string& help);

  /// A whole number within a range; the variable's value is the default.
  template <typename Integer>
  void integer(const std::string& name, Integer& target, scene::Range range,
               const std::string& unit, const std::string& help) {
    stored(name, target, unit, fmt::format("{}", target), help, integerIn<Integer>(range),
           [](Integer number) { return fmt::format("{}", number); });
  }

  /// One of several words; the first is the default.
  template <typename T, typename Target>
  /// A word that is not in the list is an error that names the list.
  Statement choice(const std::string& name, Target& target, const scene::Choices<T>& choices,
                   const std::string& help) {
    const std::vector<std::string> words = scene::choiceNames(choices);
    return stored(
               name, target, "WORD", words.front(),
               fmt::format("{}: {}", help, scene::listWords(words)),
               [choices](const scene::TypedValue& typed) {
                 return scene::parseChoice(typed, choices);
               },
               [choices](const Target& chosen) {
                 return scene::quotedText(scene::nameOfChoice(choices, chosen));
               })
        .accepts(words);
  }

  /// An option without a value, which sets the variable to `given`. It is written as true if the
  /// variable equals `given`.
  Statement flag(const std::string& name, bool& target, const std::string& help, bool given = true);

  /// An option without a value that does something else.
  Statement flag(const std::string& name, const std::string& help,
                 const std::function<void()>& action);

 private:
  Statement added(CLI::Option* option);

  CLI::App& command_;
  std::string heading_;
  std::string table_;
};

/// The current value of an option, see OptionGroup::Statement; "" if it is not in the fingerprint.
std::string serializedValue(CLI::Option& option);

/// The only values that an option accepts; empty if any value is allowed.
std::vector<std::string> allowedWords(const CLI::Option& option);

/// The option's table in a scene file; empty if a scene file cannot set it.
std::string settingTable(const CLI::Option& option);

/// Adds a positional argument. The variable stays empty if it is missing, see requireGiven().
void addPlace(CLI::App& command, const std::string& name, std::filesystem::path& target,
              const std::string& help);

/// Throws InputError if an argument is missing. `what`: its name. `command`: for the example in the
/// message.
void requireGiven(const std::filesystem::path& path, const char* what, const CLI::App& command);

/// The replacement for an option of former versions, "; give ..."; empty for others.
std::string replacementOf(const std::string& option);

/// The command with its parents, e.g. "kirireel generate tessellation". For messages that refer to
/// the help.
std::string fullName(const CLI::App& command);

/// The innermost command that was given, e.g. "generate tessellation". The program itself if no
/// command was given.
const CLI::App& chosenCommand(const CLI::App& program);

}  // namespace kirireel::cli
