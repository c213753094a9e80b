/// The errors that Kirireel throws. Only main catches them, prints them and picks the exit code.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace kirireel {

/// Base of every error that a user can meet; what() is one line that says where, what was found,
/// what is allowed and how to mend it.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The input or the command line is wrong; the program ends with exit code 2.
class InputError : public Error {
 public:
  using Error::Error;
};

/// An output could not be made or written (disk, codec, GL context); exit code 1.
class OutputError : public Error {
 public:
  using Error::Error;
};

/// The run itself failed (diverged, could not be assembled); exit code 1.
class RunError : public Error {
 public:
  using Error::Error;
};

/// A place in a text file, as compilers print it.
struct FileLocation {
  std::filesystem::path file;
  int line = 0;    ///< from 1; 0 when the whole file is meant
  int column = 0;  ///< from 1, in characters; 0 when the whole line is meant
};

/// "file:line:column" with the parts that are known.
std::string toString(const FileLocation& location);

/// An InputError whose message is "file:line:column: error: message".
InputError inputErrorAt(const FileLocation& location, const std::string& message);

}  // namespace kirireel
