#include "sim/scene/toml_file.h"

#include <algorithm>
#include <cstdint>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "sim/base/spelling.h"
#include "sim/base/text_file.h"

namespace kirireel {
namespace {

// A timeline of 100,000 entries; what the parser makes of a byte can take a hundred.
constexpr std::uintmax_t kMostBytes = 8u << 20;
constexpr int kMostDots = 64;
constexpr int kDeepest = 16;

FileLocation placeIn(const std::filesystem::path& file, const toml::source_region& region) {
  return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

/// Refuses keys such as a.b.c of many parts: each makes a table within a table, and the parser,
/// which bounds the depth of brackets alone, would not come back from a million.
void requireShortKeys(const std::filesystem::path& file, std::string_view text) {
  int line = 1;
  int dots = 0;
  char before = '\n';
  for (const char letter : text) {
    if (letter == ' ' || letter == '\t') continue;
    if (letter == '\n') ++line;
    if (letter == '.' && before != '.') ++dots;  // rows of dots adorn comments
    if (std::string_view("\n=,[]{}#").find(letter) != std::string_view::npos) dots = 0;
    before = letter;
    if (dots < kMostDots) continue;
    throw inputErrorAt({file, line}, fmt::format("there are {} dots in a key or a text here; write "
                                                 "less than that",
                                                 kMostDots));
  }
}

/// Turns what the parser found into our own values.
class Translator {
 public:
  explicit Translator(std::filesystem::path file) : file_(std::move(file)) {}

  TomlTable tableOf(const toml::table& table, int depth) const {
    TomlTable entries;
    for (const auto& [key, node] : table) {
      entries.push_back(
          {std::string(key.str()), placeIn(file_, key.source()), valueOf(node, depth)});
    }
    return entries;
  }

 private:
  TomlValue valueOf(const toml::node& node, int depth) const {
    TomlValue value{{}, placeIn(file_, node.source())};
    if (depth > kDeepest) {
      throw inputErrorAt(value.where,
                         fmt::format("tables and arrays are more than {} deep here; nothing needs "
                                     "more than a few: take brackets away",
                                     kDeepest));
    }
    if (const auto* truth = node.as_boolean()) value.content = truth->get();
    if (const auto* whole = node.as_integer()) value.content = whole->get();
    if (const auto* real = node.as_floating_point()) value.content = real->get();
    if (const auto* text = node.as_string()) value.content = text->get();
    if (const auto* table = node.as_table()) value.content = tableOf(*table, depth + 1);
    if (const auto* array = node.as_array()) {
      std::vector<TomlValue> elements;
      for (const toml::node& element : *array) elements.push_back(valueOf(element, depth + 1));
      value.content = std::move(elements);
    }
    return value;
  }

  std::filesystem::path file_;
};

}  // namespace

std::optional<double> TomlValue::number() const {
  if (const std::int64_t* integer = whole()) return static_cast<double>(*integer);
  if (const double* real = std::get_if<double>(&content)) return *real;
  return std::nullopt;
}

TomlTable readTomlFile(const std::filesystem::path& path, const std::string& hint) {
  const std::string text = readTextFile(path, "name " + hint, kMostBytes);
  requireShortKeys(path, text);
  try {
    return Translator(path).tableOf(toml::parse(text), 1);
  } catch (const toml::parse_error& error) {
    throw inputErrorAt(placeIn(path, error.source()),
                       fmt::format("this is no TOML: {}", shown(error.description(), 160)));
  }
}

std::string typedText(const TomlValue& value) {
  if (const std::string* text = value.text()) return *text;
  if (const bool* truth = value.truth()) return *truth ? "true" : "false";
  if (const std::int64_t* whole = value.whole()) return fmt::format("{}", *whole);
  if (const auto real = value.number()) return fmt::format("{}", *real);
  const std::vector<TomlValue>* array = value.array();
  if (!array) refuseValue(value, "a number, a text, true, false or an array");
  std::vector<std::string> parts;
  for (const TomlValue& element : *array) {
    if (!element.number()) refuseValue(element, "a number");
    parts.push_back(typedText(element));
  }
  return fmt::format("{}", fmt::join(parts, ","));
}

const TomlValue* find(const TomlTable& table, const std::string& key) {
  const auto found = std::find_if(table.begin(), table.end(),
                                  [&key](const TomlEntry& entry) { return entry.key == key; });
  return found == table.end() ? nullptr : &found->value;
}

double requireNumber(const TomlValue& value, double least, double most, const std::string& wanted) {
  const std::optional<double> number = value.number();
  if (!number || !(*number >= least && *number <= most)) refuseValue(value, wanted);
  return *number;
}

void refuseValue(const TomlValue& value, const std::string& wanted) {
  throw inputErrorAt(value.where, fmt::format("this value is not allowed; give {}", wanted));
}

void refuseKey(const TomlEntry& entry, const std::string& what,
               const std::vector<std::string>& known) {
  throw inputErrorAt(entry.where,
                     fmt::format("unknown {} {}{}; there are {}", what, shown(entry.key),
                                 suggestion(entry.key, known), fmt::join(known, ", ")));
}

}  // namespace kirireel
