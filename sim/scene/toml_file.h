/// TOML files as plain values with their file positions. Needs no TOML header.
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

/// One value with its position in the file.
struct TomlValue {
  /// A date or a time, which no setting accepts.
  struct Other {};

  /// The value; Other is a type that no setting accepts.
  std::variant<Other, bool, std::int64_t, double, std::string, std::vector<TomlValue>, TomlTable>
      content;
  FileLocation where;  ///< position in the file

  /// The boolean; null for other types.
  const bool* truth() const { return std::get_if<bool>(&content); }
  /// The whole number; null for other types.
  const std::int64_t* whole() const { return std::get_if<std::int64_t>(&content); }
  /// A number, whole or real; absent for other types.
  std::optional<double> number() const;
  /// The text; null for other types.
  const std::string* text() const { return std::get_if<std::string>(&content); }
  /// The elements of an array; null for other types.
  const std::vector<TomlValue>* array() const {
    return std::get_if<std::vector<TomlValue>>(&content);
  }
  /// The table; null for other types.
  const TomlTable* table() const { return std::get_if<TomlTable>(&content); }
};

/// One key of a table and its value.
struct TomlEntry {
  std::string key;     ///< key as written
  FileLocation where;  ///< position of the key
  TomlValue value;     ///< value of the key
};

/// Reads a file. `hint` is advice for a missing file. Throws InputError with file:line:column for
/// invalid TOML. The limit is 8 MiB. The whole file is read into memory.
TomlTable readTomlFile(const std::filesystem::path& path, const std::string& hint);

/// A number, text or boolean in its command line form. An array of numbers becomes "0,0,-9.81".
/// Throws InputError for other values.
std::string typedText(const TomlValue& value);

/// A text in quotation marks, in TOML syntax.
std::string tomlText(const std::string& text);

/// A value in TOML syntax, independent of the file's spelling: numbers with their shortest digits,
/// keys in order, tables in braces.
std::string tomlText(const TomlValue& value);

/// The value of a key; null if the table does not have it.
const TomlValue* find(const TomlTable& table, const std::string& key);

/// A number in [least, most]. Throws InputError with `allowed` in its message.
double requireNumber(const TomlValue& value, double least, double most, const std::string& allowed);

/// Throws "FILE:LINE:COLUMN: error: VALUE is not allowed; give ALLOWED".
[[noreturn]] void refuseValue(const TomlValue& value, const std::string& allowed);

/// Throws InputError for an unknown key, with the most similar known key as a suggestion.
[[noreturn]] void refuseKey(const TomlEntry& entry, const std::string& what,
                            const std::vector<std::string>& known);

}  // namespace kirireel::scene
