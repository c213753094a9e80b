// A layer over CLI11. It gives every option a reader, a writer and its table in a scene file. CLI11
// has no place for the last two and for the list of words. They are stored in two places that it
// does not use here:
//
// - the writer in default_function, which CLI11 calls only to capture a default;
// - words and tables as inactive validators (active(false)) with a name and a text.
//
// A second list of options would have to be kept consistent with CLI11's.
#include "render/cli/option_group.h"

#include <cctype>
#include <charconv>
#include <limits>
#include <map>
#include <regex>
#include <sstream>
#include <string_view>

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>

#include "sim/base/error.h"

namespace kirireel::cli {
namespace {

// Notes on an option: the words that it accepts, and its table of a scene file.
constexpr const char* kWords = "words";
constexpr const char* kTable = "table";

/// Attaches a text to an option, as an inactive validator. `kind` is the validator's name for
/// noteOf().
void addNote(CLI::Option& option, const char* kind, const std::string& text) {
  CLI::Validator validator([](std::string&) { return std::string(); }, text, kind);
  option.check(validator.active(false));
}

/// The attached text; "" if there is none.
std::string noteOf(const CLI::Option& option, const char* kind) {
  try {
    // CLI11 returns the text of a check only while it is active, and has no constant getter.
    CLI::Validator validator = *const_cast<CLI::Option&>(option).get_validator(kind);
    return validator.active().get_description();
  } catch (const CLI::OptionNotFound&) {
    return "";
  }
}

/// As typed; all values of an option that takes several.
std::string typedText(const CLI::Option& option) {
  std::vector<std::string> texts;
  for (const std::string& text : option.results()) texts.push_back(scene::quotedText(text));
  return scene::quotedList(texts);
}

}  // namespace

OptionGroup::Statement& OptionGroup::Statement::serializedAs(const Writer& write) {
  // CLI11 stores this function and calls it only after parsing, so the help does not show its
  // result.
  option_->default_function(write);
  return *this;
}

OptionGroup::Statement& OptionGroup::Statement::excludeFromFingerprint() {
  return serializedAs([] { return std::string(); });
}

OptionGroup::Statement& OptionGroup::Statement::accepts(const std::vector<std::string>& words) {
  addNote(*option_, kWords, fmt::format("{}", fmt::join(words, "\n")));
  return *this;
}

OptionGroup::Statement OptionGroup::added(CLI::Option* option) {
  option->group(heading_);
  if (!table_.empty()) addNote(*option, kTable, table_);
  return Statement(option);
}

OptionGroup::Statement OptionGroup::value(const std::string& name, const std::string& unit,
                                          const std::string& defaultText, const std::string& help,
                                          const Reader& read) {
  // The help text contains the default, because CLI11 has no variable that it could print.
  const std::string text =
      defaultText.empty() ? help : fmt::format("{} (default {})", help, defaultText);
  const std::string firstName = name.substr(0, name.find(','));
  const auto readText = [firstName, read](const std::string& typed) { read({firstName, typed}); };
  CLI::Option* option = command_.add_option_function<std::string>(name, readText, text)
                            ->type_name(unit)
                            ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  return added(option).serializedAs([option] { return typedText(*option); });
}

OptionGroup::Statement OptionGroup::values(const std::string& name, const std::string& unit,
                                           const std::string& help, const Reader& read) {
  const auto readTexts = [name, read](const std::vector<std::string>& typed) {
    for (const std::string& text : typed) read({name, text});
  };
  CLI::Option* option =
      command_.add_option_function<std::vector<std::string>>(name, readTexts, help)
          ->type_name(unit)
          ->expected(1)
          ->allow_extra_args(false)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  return added(option).serializedAs([option] { return typedText(*option); });
}

void OptionGroup::setting(const scene::Setting& setting, scene::Scene& scene) {
  const std::string name = optionName(setting.key);
  const std::string help = spellOptions(setting.help);
  // Settings live as long as the program.
  const auto write = [&setting, &scene] { return setting.write(scene); };
  if (setting.isSwitch) {
    flag(name, help, [&setting, &scene, name] {
      setting.read(scene, {name, ""});
    }).serializedAs(write);
    return;
  }
  Statement statement =
      value(name, setting.unit, setting.defaultText, help,
            [&setting, &scene](const scene::TypedValue& typed) { setting.read(scene, typed); });
  statement.serializedAs(write);
  if (!setting.words.empty()) statement.accepts(setting.words);
}

void OptionGroup::number(const std::string& name, double& target, scene::Range range,
                         const std::string& unit, const std::string& help) {
  stored(name, target, unit, fmt::format("{:.4g}", target), help, numberIn(range),
         scene::numberText);
}

void OptionGroup::number(const std::string& name, std::optional<double>& target, scene::Range range,
                         const std::string& unit, const std::string& defaultText,
                         const std::string& help) {
  stored(name, target, unit, defaultText, help, numberIn(range), scene::numberText);
}

OptionGroup::Statement OptionGroup::flag(const std::string& name, bool& target,
                                         const std::string& help, bool given) {
  return flag(name, help, [&target, given] { target = given; }).serializedAs([&target, given] {
    return fmt::format("{}", target == given);
  });
}

OptionGroup::Statement OptionGroup::flag(const std::string& name, const std::string& help,
                                         const std::function<void()>& action) {
  CLI::Option* option = command_.add_flag_callback(name, action, help);
  return added(option).serializedAs([option] { return fmt::format("{}", option->count() > 0); });
}

/// Calls the option's writer: CLI11 stores its result as the default's text.
std::string serializedValue(CLI::Option& option) {
  return option.capture_default_str()->get_default_str();
}

std::vector<std::string> allowedWords(const CLI::Option& option) {
  std::vector<std::string> words;
  std::istringstream lines(noteOf(option, kWords));
  for (std::string word; std::getline(lines, word);) words.push_back(word);
  return words;
}

std::string settingTable(const CLI::Option& option) {
  return noteOf(option, kTable);
}

void addPlace(CLI::App& command, const std::string& name, std::filesystem::path& target,
              const std::string& help) {
  command.add_option(name, target, help)->type_name("");
}

void requireGiven(const std::filesystem::path& path, const char* what, const CLI::App& command) {
  if (!path.empty()) return;
  const std::string name = fullName(command);
  std::string places;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) places += " " + option->get_name(true);
  }
  throw InputError(
      fmt::format("error: {} is missing, as in {}{}; see {} --help", what, name, places, name));
}

const CLI::App& chosenCommand(const CLI::App& program) {
  const CLI::App* command = &program;
  // CLI11 lists the parsed commands; there is only one.
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  return *command;
}

std::string replacementOf(const std::string& option) {
  static const std::map<std::string, std::string> replacements = {
      {"--format", "--video NAME.WORD"},
      {"--guide-stiffness", "--spring-frequency HZ, and --joint-ratio R for softer joints"},
      {"--joint-stiffness", "--joint-ratio R"},
      {"--pitch", "--view AZ,EL with EL = -pitch"},
      {"--quadratic", "nothing, since it is the default"},
      {"--search", "--search-effort FACTOR (default 1)"},
      {"--state", "--states"},
      {"--yaw", "--view AZ,EL with AZ = yaw - 90"}};
  const auto found = replacements.find(option);
  return found == replacements.end() ? "" : "; give " + found->second;
}

std::string fullName(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return parent == nullptr ? command.get_name() : fullName(*parent) + " " + command.get_name();
}

// ------------------------------------------------------------------------------------------------
// Readers and writers in pairs: reading the text that the writer makes of a value gives the same
// value to the last bit. orderText(), which writes a scene file, relies on it. Degrees need care
// because x pi / 180 rounds: numberReadAs() searches the shortest number of degrees that reads back
// to the same radians.

namespace {

/// Pictures along each side; no page can show more than 10,000 pictures.
constexpr int kMaxGridCells = 100;

/// "3x4"; null if the text is not two whole numbers with an x between them.
std::optional<std::pair<long, long>> readPair(std::string_view text) {
  const std::vector<std::string_view> parts = scene::split(text, 'x');
  if (parts.size() != 2) return std::nullopt;
  const std::optional<long> first = scene::readWhole(parts[0]);
  const std::optional<long> second = scene::readWhole(parts[1]);
  if (!first || !second) return std::nullopt;
  return std::pair(*first, *second);
}

/// The parts of a caption in writing order: words and the members that they set. Reader and writer
/// share this list.
const scene::Choices<bool picture::CaptionParts::*>& captionChoices() {
  static const scene::Choices<bool picture::CaptionParts::*> choices = {
      {"progress", &picture::CaptionParts::progress},
      {"time", &picture::CaptionParts::time},
      {"angle", &picture::CaptionParts::angle},
      {"error", &picture::CaptionParts::error},
      {"gap", &picture::CaptionParts::gap}};
  return choices;
}

/// Both ends belong to the range.
bool isBetween(long number, long least, long most) {
  return number >= least && number <= most;
}

}  // namespace

/// Names of colours as in CSS.
const scene::Choices<picture::Colour>& namedColours() {
  static const scene::Choices<picture::Colour> names = {
      {"black", {0, 0, 0}},          {"white", {255, 255, 255}},  {"grey", {128, 128, 128}},
      {"gray", {128, 128, 128}},     {"silver", {192, 192, 192}}, {"lightgrey", {211, 211, 211}},
      {"darkgrey", {169, 169, 169}}, {"red", {255, 0, 0}},        {"darkred", {139, 0, 0}},
      {"crimson", {220, 20, 60}},    {"salmon", {250, 128, 114}}, {"coral", {255, 127, 80}},
      {"orange", {255, 165, 0}},     {"gold", {255, 215, 0}},     {"yellow", {255, 255, 0}},
      {"khaki", {240, 230, 140}},    {"beige", {245, 245, 220}},  {"tan", {210, 180, 140}},
      {"brown", {165, 42, 42}},      {"olive", {128, 128, 0}},    {"green", {0, 128, 0}},
      {"lime", {0, 255, 0}},         {"seagreen", {46, 139, 87}}, {"teal", {0, 128, 128}},
      {"turquoise", {64, 224, 208}}, {"cyan", {0, 255, 255}},     {"skyblue", {135, 206, 235}},
      {"steelblue", {70, 130, 180}}, {"blue", {0, 0, 255}},       {"navy", {0, 0, 128}},
      {"indigo", {75, 0, 130}},      {"purple", {128, 0, 128}},   {"violet", {238, 130, 238}},
      {"magenta", {255, 0, 255}},    {"pink", {255, 192, 203}}};
  return names;
}

picture::Colour parseColour(const scene::TypedValue& value) {
  for (const auto& [name, colour] : namedColours()) {
    if (value.text == name) return colour;
  }
  // from_chars also reads fewer than six digits and stops at other letters, so check length and
  // end.
  std::string_view digits = value.text;
  if (digits.starts_with('#')) digits.remove_prefix(1);
  unsigned bits = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), bits, 16);
  if (digits.size() != 6 || error != std::errc() || end != digits.data() + digits.size()) {
    throw scene::valueError(
        value,
        "red, green and blue in hexadecimal, for example 80AEDC, or a name of CSS "
        "such as teal, navy or grey");
  }
  // Red is in the highest of the three bytes.
  const auto channel = [bits](int shift) { return static_cast<std::uint8_t>(bits >> shift); };
  return {channel(16), channel(8), channel(0)};
}

std::vector<picture::CameraKey> parseCameraKeys(const scene::TypedValue& value) {
  std::vector<picture::CameraKey> keys;
  for (const std::string_view text : scene::split(value.text, ',')) {
    const std::vector<std::string_view> parts = scene::split(text, ':');
    // All four are required; without zoom the parts would be ambiguous.
    if (parts.size() != 4) {
      throw scene::valueError({value.name, std::string(text)},
                              "TIME:YAW:PITCH:ZOOM, for example 2.5:90:-20:1.5");
    }
    // Read each part as its own value: the error then quotes that part.
    const auto part = [&](int k, scene::Range range) {
      return scene::parseNumber({value.name, std::string(parts[k])}, range);
    };
    const picture::ViewAngles view =
        picture::viewFromYawPitch(part(1, {-36000, 36000}) * kDegree, part(2, {-90, 90}) * kDegree);
    keys.push_back({part(0, {0, 1e6}), view, part(3, {1e-3, 1e3})});
  }
  return keys;
}

picture::CaptionParts parseCaption(const scene::TypedValue& value) {
  picture::CaptionParts parts;
  // All parts are off from the start.
  if (value.text == "none") return parts;
  scene::Choices<bool picture::CaptionParts::*> choices = captionChoices();
  // The message for a wrong word lists "none" too. With other words it is an error.
  choices.emplace_back("none", nullptr);
  for (const std::string_view word : scene::split(value.text, ',')) {
    const auto part =
        scene::parseChoice<bool picture::CaptionParts::*>({value.name, std::string(word)}, choices);
    if (part == nullptr) throw scene::valueError(value, "none, or parts such as time,error");
    parts.*part = true;
  }
  return parts;
}

std::vector<record::FrameChoice> parseFrameChoices(const scene::TypedValue& value) {
  std::vector<record::FrameChoice> choices;
  for (const std::string_view text : scene::split(value.text, ',')) {
    // A fraction, [0, 1].
    const bool isShare = text.ends_with('%');
    const scene::TypedValue number{value.name, std::string(text.substr(0, text.size() - isShare))};
    if (isShare) {
      // Times are simulated seconds.
      choices.push_back(
          {scene::parseNumber(number, {0, 100}) / 100, record::FrameChoice::Unit::Share});
    } else {
      choices.push_back({scene::parseNumber(number, {0, 1e6}), record::FrameChoice::Unit::Seconds});
    }
  }
  return choices;
}

picture::FrameSize parseSize(const scene::TypedValue& value) {
  const auto pair = readPair(value.text);
  const bool fits = pair && isBetween(pair->first, 1, picture::kMaxFrameSide) &&
                    isBetween(pair->second, 1, picture::kMaxFrameSide);
  if (!fits) {
    throw scene::valueError(value,
                            fmt::format("WIDTHxHEIGHT in pixels, each from 1 to {}, as in 1280x720",
                                        picture::kMaxFrameSide));
  }
  return {static_cast<int>(pair->first), static_cast<int>(pair->second)};
}

double parseLength(const scene::TypedValue& value, const std::string& unit, scene::Range range) {
  const std::size_t end = value.text.find_last_of("0123456789.") + 1;
  const std::string name = value.text.substr(end);
  const std::optional<LengthUnit> given = findLengthUnit(name.empty() ? unit : name);
  const std::optional<double> number = scene::readNumber(value.text.substr(0, end));
  if (!given || !number) {
    std::vector<std::string> names;
    for (const LengthUnit& known : lengthUnits()) names.push_back(known.name);
    throw scene::valueError(
        value, fmt::format("a number in {}, or with one of {}", unit, fmt::join(names, ", ")));
  }
  const double length = inUnit(*number * given->metres, *findLengthUnit(unit));
  if (range.holds(length)) return length;
  throw scene::valueError(
      value, fmt::format("a length from {:g} to {:g} {}", range.least, range.most, unit));
}

picture::GridShape parseGrid(const scene::TypedValue& value) {
  const auto pair = readPair(value.text);
  const bool fits =
      pair && isBetween(pair->first, 1, kMaxGridCells) && isBetween(pair->second, 1, kMaxGridCells);
  if (!fits) {
    throw scene::valueError(
        value, fmt::format("ROWSxCOLUMNS, each from 1 to {}, as in 3x3", kMaxGridCells));
  }
  return {static_cast<int>(pair->first), static_cast<int>(pair->second)};
}

std::vector<int> parseIndices(const scene::TypedValue& value, std::size_t count,
                              const std::string& requested) {
  std::vector<int> numbers;
  for (const std::string_view part : scene::split(value.text, ',')) {
    const std::optional<long> number = scene::readWhole(part);
    if (!number || !isBetween(*number, 0, std::numeric_limits<int>::max()))
      throw scene::valueError(value, requested);
    numbers.push_back(static_cast<int>(*number));
  }
  if (count != 0 && numbers.size() != count) throw scene::valueError(value, requested);
  return numbers;
}

std::vector<int> parseTiles(const scene::TypedValue& value) {
  if (value.text == "all") return {};
  return parseIndices(value, 0, "all, or numbers of tiles, as in 3,7,8");
}

namespace {

/// "3,7,10-15"; absent for other text.
std::optional<std::vector<int>> tilesAndRanges(std::string_view text) {
  constexpr long kMaxTile = 1'000'000;
  std::vector<int> tiles;
  for (const std::string_view part : scene::split(text, ',')) {
    const std::size_t dash = part.find('-');
    const std::optional<long> first = scene::readWhole(part.substr(0, dash));
    const std::optional<long> last =
        dash == std::string_view::npos ? first : scene::readWhole(part.substr(dash + 1));
    if (!first || !last || *first < 0 || *last < *first || *last > kMaxTile) return std::nullopt;
    for (long tile = *first; tile <= *last; ++tile) tiles.push_back(static_cast<int>(tile));
  }
  return tiles;
}

}  // namespace

picture::TileColour parseTileColour(const scene::TypedValue& value) {
  constexpr const char* kAllowed = "numbers of tiles and a colour, as in 3,7,10-15=teal";
  const std::size_t equals = value.text.rfind('=');
  if (equals == std::string::npos) throw scene::valueError(value, kAllowed);
  const std::string whose = value.text.substr(0, equals);
  const std::size_t colon = whose.rfind(':');
  const bool isNamed = colon != std::string::npos;
  const auto tiles = tilesAndRanges(std::string_view(whose).substr(isNamed ? colon + 1 : 0));
  if (!tiles) throw scene::valueError(value, kAllowed);
  return {*tiles, parseColour({value.name, value.text.substr(equals + 1)}),
          isNamed ? whose.substr(0, colon) : std::string()};
}

picture::TileOpacity parseTileOpacity(const scene::TypedValue& value) {
  constexpr const char* kAllowed = "numbers of tiles and a share, as in 3,7,10-15=0.3";
  const std::size_t equals = value.text.find('=');
  if (equals == std::string::npos) throw scene::valueError(value, kAllowed);
  const auto tiles = tilesAndRanges(std::string_view(value.text).substr(0, equals));
  if (!tiles) throw scene::valueError(value, kAllowed);
  return {*tiles, scene::parseNumber({value.name, value.text.substr(equals + 1)}, {0, 1})};
}

std::string optionName(const std::string& key) {
  std::string name = "--" + key;
  std::ranges::replace(name, '_', '-');
  return name;
}

std::string spellOptions(const std::string& message) {
  static const std::regex setting("`([a-z][a-z0-9_]*)(?: = ([^`]*))?`");
  std::string text;
  auto rest = message.cbegin();
  for (std::sregex_iterator match(message.begin(), message.end(), setting), end; match != end;
       ++match) {
    text.append(rest, (*match)[0].first);
    rest = (*match)[0].second;
    const bool isOff = (*match)[2] == "false";
    text += isOff ? optionName("no_" + (*match)[1].str()) : optionName((*match)[1]);
    if ((*match)[2].matched && !isOff) text += " " + (*match)[2].str();
  }
  return text.append(rest, message.cend());
}

std::string wordsText(const std::vector<std::string>& words) {
  return scene::quotedText(fmt::format("{}", fmt::join(words, ",")));
}

std::string positiveText(double number) {
  return number > 0 ? scene::numberText(number) : "";
}

std::string sizeText(picture::FrameSize size) {
  return fmt::format("\"{}x{}\"", size.width, size.height);
}

std::string gridText(picture::GridShape grid) {
  return fmt::format("\"{}x{}\"", grid.rows, grid.columns);
}

std::string frameChoicesText(const std::vector<record::FrameChoice>& choices) {
  std::vector<std::string> texts;
  for (const auto& [value, unit] : choices) {
    const bool isShare = unit == record::FrameChoice::Unit::Share;
    texts.push_back(isShare ? scene::numberText(scene::numberReadAs(
                                  value, 100 * value, [](double share) { return share / 100; })) +
                                  '%'
                            : scene::numberText(value));
  }
  return wordsText(texts);
}

std::string colourText(picture::Colour colour) {
  return fmt::format("\"{:02X}{:02X}{:02X}\"", colour.red, colour.green, colour.blue);
}

TypedView typedView(const picture::ViewAngles& view) {
  // Yaw differs from azimuth by a constant, pitch from elevation by its sign; degrees are found by
  // guess and check.
  const picture::ViewAngles level = picture::viewFromYawPitch(0, 0);
  const auto azimuth = [](double yaw) {
    return picture::viewFromYawPitch(yaw * kDegree, 0).azimuth;
  };
  const auto elevation = [](double pitch) {
    return picture::viewFromYawPitch(0, pitch * kDegree).elevation;
  };
  return {scene::numberReadAs(view.azimuth, (view.azimuth - level.azimuth) / kDegree, azimuth),
          scene::numberReadAs(view.elevation, -view.elevation / kDegree, elevation)};
}

std::string tileColoursText(const std::vector<picture::TileColour>& colours) {
  std::vector<std::string> texts;
  for (const auto& [tiles, colour, name] : colours) {
    const std::string hex = colourText(colour);  // with its quotes
    texts.push_back(
        scene::quotedText(fmt::format("{}{}{}={}", name, name.empty() ? "" : ":",
                                      fmt::join(tiles, ","), hex.substr(1, hex.size() - 2))));
  }
  return scene::quotedList(texts);
}

std::string tileOpacitiesText(const std::vector<picture::TileOpacity>& opacities) {
  std::vector<std::string> texts;
  for (const auto& [tiles, opacity] : opacities) {
    texts.push_back(
        scene::quotedText(fmt::format("{}={}", fmt::join(tiles, ","), scene::numberText(opacity))));
  }
  return scene::quotedList(texts);
}

std::string cameraKeysText(const std::vector<picture::CameraKey>& keys) {
  std::vector<std::string> texts;
  for (const picture::CameraKey& key : keys) {
    const TypedView view = typedView(key.view);
    texts.push_back(fmt::format("{}:{}:{}:{}", key.time, view.yaw, view.pitch, key.zoom));
  }
  return wordsText(texts);
}

std::string captionText(const picture::CaptionParts& parts) {
  std::vector<std::string> words;
  for (const auto& [word, part] : captionChoices()) {
    if (parts.*part) words.push_back(word);
  }
  return words.empty() ? "\"none\"" : wordsText(words);
}

std::string tilesText(const std::vector<int>& tiles) {
  return tiles.empty() ? "\"all\"" : fmt::format("\"{}\"", fmt::join(tiles, ","));
}

}  // namespace kirireel::cli
