/// Errors and their messages.
#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace kirireel {

// ------------------------------------------------------------------------------------------------
// The errors that Kirireel throws. Only main catches them, prints them and picks the exit code.

/// Base of all errors for users. what() is one line: place, fault, allowed values, remedy.
class Error : public std::runtime_error {
 public:
  /// With the one line that a user reads.
  using std::runtime_error::runtime_error;
};

/// The input or the command line is wrong; the program ends with exit code 2.
class InputError : public Error {
 public:
  /// With the one line that a user reads.
  using Error::Error;
};

/// An output could not be written (disk, codec, GL context); exit code 1.
class OutputError : public Error {
 public:
  /// With the one line that a user reads.
  using Error::Error;
};

/// The run itself failed (diverged, could not be assembled); exit code 1.
class RunError : public Error {
 public:
  /// With the one line that a user reads.
  using Error::Error;
};

/// A position in a text file, in the format of compilers.
struct FileLocation {
  std::filesystem::path file;  ///< as given by the user
  int line = 0;                ///< counts from 1; 0: the whole file
  int column = 0;              ///< in characters, counts from 1; 0: the whole line
};

/// "file:line:column" with the known parts.
std::string toString(const FileLocation& location);

/// An InputError whose message is "file:line:column: error: message".
InputError inputErrorAt(const FileLocation& location, const std::string& message);

// ------------------------------------------------------------------------------------------------
// Text in messages: suggestions for mistyped words, and safe display of foreign text.

/// Number of letters to insert, delete or replace between two words (Levenshtein 1966).
int editDistance(std::string_view a, std::string_view b);

/// ", did you mean WORD?" for the nearest known word. Empty if none differs by at most a third of
/// the word's letters (at least 2).
std::string suggestion(std::string_view word, const std::vector<std::string>& knownWords);

/// A text with '?' for each control character. It takes one line, and terminals do not interpret
/// it.
std::string oneLine(std::string_view text);

/// A text of unknown origin for messages: at most `most` characters, then "...", with '?' for each
/// byte that is not printable ASCII.
std::string shown(std::string_view text, std::size_t most = 40);

/// The characters of a UTF-8 text; absent if it is not UTF-8.
std::optional<std::u32string> codePoints(std::string_view text);

}  // namespace kirireel
