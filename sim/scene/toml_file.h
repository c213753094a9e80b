/// TOML files as plain values that know their places. No TOML header is needed to use them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/base/error.h"

namespace kirireel::scene {

struct TomlEntry;
struct TomlValue;

/// The entries of a table, by key.
using TomlTable = std::vector<TomlEntry>;

/// One value with its place in its file.
struct TomlValue {
  /// A date or a time, which nothing here asks for.
  struct Other {};

  /// The value itself; Other is what no setting takes, as a date.
  std::variant<Other, bool, std::int64_t, double, std::string, std::vector<TomlValue>, TomlTable>
      content;
  FileLocation where;  ///< where it stands

  /// The truth; null where it is none.
  const bool* truth() const { return std::get_if<bool>(&content); }
  /// The whole number; null where it is none.
  const std::int64_t* whole() const { return std::get_if<std::int64_t>(&content); }
  /// A number of either kind.
  std::optional<double> number() const;
  /// The text; null where it is none.
  const std::string* text() const { return std::get_if<std::string>(&content); }
  /// The values in brackets; null where there are none.
  const std::vector<TomlValue>* array() const {
    return std::get_if<std::vector<TomlValue>>(&content);
  }
  /// The table; null where it is none.
  const TomlTable* table() const { return std::get_if<TomlTable>(&content); }
};

/// One key of a table and its value.
struct TomlEntry {
  std::string key;     ///< as it is written
  FileLocation where;  ///< of the key
  TomlValue value;     ///< what it is set to
};

/// Reads a file. `hint` says what could be named when there is none. Throws InputError with
/// file:line:column for what is no TOML.
/// At most 8 MiB; the whole file is held in memory.
TomlTable readTomlFile(const std::filesystem::path& path, const std::string& hint);

/// A number, text or truth as it would be typed on a command line; an array of numbers as
/// "0,0,-9.81". Throws InputError for anything else.
std::string typedText(const TomlValue& value);

/// A text in quotation marks, as a TOML file has it.
std::string tomlText(const std::string& text);

/// A value as a TOML file has it, in one spelling whatever the file's was: numbers in their
/// shortest digits, keys in order, tables within braces.
std::string tomlText(const TomlValue& value);

/// The value of a key; null when the table does not have it.
const TomlValue* find(const TomlTable& table, const std::string& key);

/// A number from `least` to `most`. Throws InputError that says what is wanted.
double requireNumber(const TomlValue& value, double least, double most, const std::string& allowed);

/// Throws "FILE:LINE:COLUMN: error: this value is not allowed; give WANTED".
[[noreturn]] void refuseValue(const TomlValue& value, const std::string& allowed);

/// Throws an InputError for a key that does not exist, suggesting the nearest of those that do.
[[noreturn]] void refuseKey(const TomlEntry& entry, const std::string& what,
                            const std::vector<std::string>& known);

}  // namespace kirireel::scene
