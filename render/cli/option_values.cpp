// Readers and writers in pairs: for every value x that a reader gives, reading what the writer
// makes of x gives x again, to the last bit. orderText() relies on it, for what it writes is a
// scene file. Degrees are the hard case, since x pi / 180 rounds: numberReadAs() looks for the
// shortest number of degrees that reads back to the same radians.
#include "render/cli/option_values.h"

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include <fmt/ranges.h>

#include "sim/base/geometry.h"

namespace kirireel {
namespace {

/// Along each side; more pictures than 10,000 no page can show.
constexpr int kMostGridCells = 100;

/// "3x4"; nothing where there is no single x or a part is no whole number.
std::optional<std::pair<long, long>> readPair(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, 'x');
  if (parts.size() != 2) return std::nullopt;
  const std::optional<long> first = readWhole(parts[0]);
  const std::optional<long> second = readWhole(parts[1]);
  if (!first || !second) return std::nullopt;
  return std::pair(*first, *second);
}

/// The parts of a caption, in the order in which they are written. Words and the members that they
/// switch on; reader and writer share the list.
const Choices<bool CaptionParts::*>& captionChoices() {
  static const Choices<bool CaptionParts::*> choices = {{"progress", &CaptionParts::progress},
                                                        {"time", &CaptionParts::time},
                                                        {"angle", &CaptionParts::angle},
                                                        {"error", &CaptionParts::error},
                                                        {"gap", &CaptionParts::gap}};
  return choices;
}

/// Both ends belong to the range.
bool isBetween(long number, long least, long most) {
  return number >= least && number <= most;
}

}  // namespace

/// Names of colours as CSS has them.
const Choices<Colour>& namedColours() {
  static const Choices<Colour> names = {
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

Colour parseColour(const TypedValue& value) {
  for (const auto& [name, colour] : namedColours()) {
    if (value.text == name) return colour;
  }
  // from_chars would also read fewer than six digits and stop at other letters, so length and end
  // are checked.
  std::string_view digits = value.text;
  if (digits.starts_with('#')) digits.remove_prefix(1);
  unsigned bits = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), bits, 16);
  if (digits.size() != 6 || error != std::errc() || end != digits.data() + digits.size()) {
    throw valueError(value,
                     "red, green and blue in hexadecimal, for example 80AEDC, or a name of CSS "
                     "such as teal, navy or grey");
  }
  // Red is in the highest of the three bytes.
  const auto channel = [bits](int shift) { return static_cast<std::uint8_t>(bits >> shift); };
  return {channel(16), channel(8), channel(0)};
}

std::vector<CameraKey> parseCameraKeys(const TypedValue& value) {
  std::vector<CameraKey> keys;
  for (const std::string_view text : split(value.text, ',')) {
    const std::vector<std::string_view> parts = split(text, ':');
    // All four are needed: a key that left zoom out would be read as another order of parts.
    if (parts.size() != 4) {
      throw valueError({value.name, std::string(text)},
                       "TIME:YAW:PITCH:ZOOM, for example 2.5:90:-20:1.5");
    }
    // Each part is read as an option's value of its own, so that its error names what was typed.
    const auto part = [&](int k, Range range) {
      return parseNumber({value.name, std::string(parts[k])}, range);
    };
    const ViewAngles view =
        viewFromYawPitch(part(1, {-36000, 36000}) * kDegree, part(2, {-90, 90}) * kDegree);
    keys.push_back({part(0, {0, 1e6}), view, part(3, {1e-3, 1e3})});
  }
  return keys;
}

CaptionParts parseCaption(const TypedValue& value) {
  CaptionParts parts;
  // All parts are off from the start.
  if (value.text == "none") return parts;
  Choices<bool CaptionParts::*> choices = captionChoices();
  // "none" is among the words so that the message for a wrong word lists it; beside others it is
  // refused.
  choices.emplace_back("none", nullptr);
  for (const std::string_view word : split(value.text, ',')) {
    const auto part = parseChoice<bool CaptionParts::*>({value.name, std::string(word)}, choices);
    if (part == nullptr) throw valueError(value, "none alone, or parts such as time,error");
    parts.*part = true;
  }
  return parts;
}

std::vector<FrameChoice> parseFrameChoices(const TypedValue& value) {
  std::vector<FrameChoice> choices;
  for (const std::string_view text : split(value.text, ',')) {
    // A share is kept as 0 to 1.
    const bool isShare = text.ends_with('%');
    const TypedValue number{value.name, std::string(text.substr(0, text.size() - isShare))};
    if (isShare) {
      // Times are simulated seconds.
      choices.push_back({parseNumber(number, {0, 100}) / 100, FrameChoice::Unit::Share});
    } else {
      choices.push_back({parseNumber(number, {0, 1e6}), FrameChoice::Unit::Seconds});
    }
  }
  return choices;
}

FrameSize parseSize(const TypedValue& value) {
  const auto pair = readPair(value.text);
  const bool fits =
      pair && isBetween(pair->first, 1, kMaxFrameSide) && isBetween(pair->second, 1, kMaxFrameSide);
  if (!fits) {
    throw valueError(value, fmt::format("WIDTHxHEIGHT in pixels, each from 1 to {}, as in 1280x720",
                                        kMaxFrameSide));
  }
  return {static_cast<int>(pair->first), static_cast<int>(pair->second)};
}

GridShape parseGrid(const TypedValue& value) {
  const auto pair = readPair(value.text);
  const bool fits = pair && isBetween(pair->first, 1, kMostGridCells) &&
                    isBetween(pair->second, 1, kMostGridCells);
  if (!fits) {
    throw valueError(value,
                     fmt::format("ROWSxCOLUMNS, each from 1 to {}, as in 3x3", kMostGridCells));
  }
  return {static_cast<int>(pair->first), static_cast<int>(pair->second)};
}

std::vector<int> parseTiles(const TypedValue& value) {
  std::vector<int> tiles;
  if (value.text == "all") return tiles;
  for (const std::string_view part : split(value.text, ',')) {
    const std::optional<long> number = readWhole(part);
    if (!number || !isBetween(*number, 0, std::numeric_limits<int>::max()))
      throw valueError(value, "all, or numbers of tiles, as in 3,7,8");
    tiles.push_back(static_cast<int>(*number));
  }
  return tiles;
}

TileColour parseTileColour(const TypedValue& value) {
  constexpr const char* kAllowed = "numbers of tiles and a colour, as in 3,7,10-15=teal";
  constexpr long kMostTile = 1'000'000;
  const std::size_t equals = value.text.find('=');
  if (equals == std::string::npos) throw valueError(value, kAllowed);
  TileColour made{{}, parseColour({value.name, value.text.substr(equals + 1)})};
  for (const std::string_view part : split(std::string_view(value.text).substr(0, equals), ',')) {
    const std::size_t dash = part.find('-');
    const std::optional<long> first = readWhole(part.substr(0, dash));
    const std::optional<long> last =
        dash == std::string_view::npos ? first : readWhole(part.substr(dash + 1));
    if (!first || !last || *first < 0 || *last < *first || *last > kMostTile) {
      throw valueError(value, kAllowed);
    }
    for (long tile = *first; tile <= *last; ++tile) made.tiles.push_back(static_cast<int>(tile));
  }
  return made;
}

std::string sizeText(FrameSize size) {
  return fmt::format("\"{}x{}\"", size.width, size.height);
}

std::string gridText(GridShape grid) {
  return fmt::format("\"{}x{}\"", grid.rows, grid.columns);
}

std::string frameChoicesText(const std::vector<FrameChoice>& choices) {
  std::vector<std::string> texts;
  for (const auto& [value, unit] : choices) {
    const bool isShare = unit == FrameChoice::Unit::Share;
    texts.push_back(isShare ? numberText(numberReadAs(value, 100 * value,
                                                      [](double share) { return share / 100; })) +
                                  '%'
                            : numberText(value));
  }
  return quotedText(fmt::format("{}", fmt::join(texts, ",")));
}

std::string colourText(Colour colour) {
  return fmt::format("\"{:02X}{:02X}{:02X}\"", colour.red, colour.green, colour.blue);
}

TypedView typedView(const ViewAngles& view) {
  // Yaw differs from azimuth by a constant, pitch from elevation by its sign; degrees are found by
  // guess and check.
  const ViewAngles level = viewFromYawPitch(0, 0);
  const auto azimuth = [](double yaw) { return viewFromYawPitch(yaw * kDegree, 0).azimuth; };
  const auto elevation = [](double pitch) {
    return viewFromYawPitch(0, pitch * kDegree).elevation;
  };
  return {numberReadAs(view.azimuth, (view.azimuth - level.azimuth) / kDegree, azimuth),
          numberReadAs(view.elevation, -view.elevation / kDegree, elevation)};
}

std::string tileColoursText(const std::vector<TileColour>& colours) {
  std::vector<std::string> texts;
  for (const auto& [tiles, colour] : colours) {
    const std::string hex = colourText(colour);  // with its quotes
    texts.push_back(
        quotedText(fmt::format("{}={}", fmt::join(tiles, ","), hex.substr(1, hex.size() - 2))));
  }
  return quotedList(texts);
}

std::string cameraKeysText(const std::vector<CameraKey>& keys) {
  std::vector<std::string> texts;
  for (const CameraKey& key : keys) {
    const TypedView view = typedView(key.view);
    texts.push_back(fmt::format("{}:{}:{}:{}", key.time, view.yaw, view.pitch, key.zoom));
  }
  return quotedText(fmt::format("{}", fmt::join(texts, ",")));
}

std::string captionText(const CaptionParts& parts) {
  std::vector<std::string> words;
  for (const auto& [word, part] : captionChoices()) {
    if (parts.*part) words.push_back(word);
  }
  return words.empty() ? "\"none\"" : fmt::format("\"{}\"", fmt::join(words, ","));
}

std::string tilesText(const std::vector<int>& tiles) {
  return tiles.empty() ? "\"all\"" : fmt::format("\"{}\"", fmt::join(tiles, ","));
}

}  // namespace kirireel
