#include "sim/scene/toml_file.h"

#include <algorithm>
#include <fstream>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "sim/base/spelling.h"

namespace kirireel {
namespace {

FileLocation placeIn(const std::filesystem::path& file, const toml::source_region& region) {
  return {file, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

TomlValue valueOf(const std::filesystem::path& file, const toml::node& node);

TomlTable tableOf(const std::filesystem::path& file, const toml::table& table) {
  TomlTable entries;
  for (const auto& [key, node] : table) {
    entries.push_back({std::string(key.str()), placeIn(file, key.source()), valueOf(file, node)});
  }
  return entries;
}

TomlValue valueOf(const std::filesystem::path& file, const toml::node& node) {
  TomlValue value{{}, placeIn(file, node.source())};
  if (const auto* truth = node.as_boolean()) value.content = truth->get();
  if (const auto* whole = node.as_integer()) value.content = whole->get();
  if (const auto* real = node.as_floating_point()) value.content = real->get();
  if (const auto* text = node.as_string()) value.content = text->get();
  if (const auto* table = node.as_table()) value.content = tableOf(file, *table);
  if (const auto* array = node.as_array()) {
    std::vector<TomlValue> elements;
    for (const toml::node& element : *array) elements.push_back(valueOf(file, element));
    value.content = std::move(elements);
  }
  return value;
}

}  // namespace

std::optional<double> TomlValue::number() const {
  if (const std::int64_t* integer = whole()) return static_cast<double>(*integer);
  if (const double* real = std::get_if<double>(&content)) return *real;
  return std::nullopt;
}

TomlTable readTomlFile(const std::filesystem::path& path, const std::string& hint) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw inputErrorAt({path}, "there is no such file; name " + hint);
  }
  if (!std::ifstream(path)) throw inputErrorAt({path}, "cannot be read; check its permissions");
  try {
    return tableOf(path, toml::parse_file(path.string()));
  } catch (const toml::parse_error& error) {
    throw inputErrorAt(placeIn(path, error.source()),
                       fmt::format("this is no TOML: {}", error.description()));
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
                     fmt::format("unknown {} {}{}; there are {}", what, entry.key,
                                 suggestion(entry.key, known), fmt::join(known, ", ")));
}

}  // namespace kirireel
