/// Errors, and the words in their messages.
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

/// An output could not be made or written (disk, codec, GL context); exit code 1.
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

/// A place in a text file, as compilers print it.
struct FileLocation {
  std::filesystem::path file;  ///< as it was given
  int line = 0;                ///< from 1; 0: the whole file
  int column = 0;              ///< from 1, in characters; 0: the whole line
};

/// "file:line:column" with the parts that are known.
std::string toString(const FileLocation& location);

/// An InputError whose message is "file:line:column: error: message".
InputError inputErrorAt(const FileLocation& location, const std::string& message);

// ------------------------------------------------------------------------------------------------
// Text in messages: suggestions for mistyped words, and safe display of foreign text.

/// Letters to insert, delete or replace to turn one word into the other (Levenshtein 1966).
int editDistance(std::string_view a, std::string_view b);

/// ", did you mean WORD?" for the nearest of the known words, or an empty text when none is within
/// a third of the word's letters (at least 2).
std::string suggestion(std::string_view word, const std::vector<std::string>& knownWords);

/// A text with '?' in place of each control character: it takes one line, and no terminal acts on
/// it.
std::string oneLine(std::string_view text);

/// A text of unknown origin as a message shows it: at most `most` characters, then "...", with '?'
/// in place of each byte that is not printable ASCII.
std::string shown(std::string_view text, std::size_t most = 40);

/// The characters of a text in UTF-8; absent when it is not UTF-8.
std::optional<std::u32string> codePoints(std::string_view text);

}  // namespace kirireel
