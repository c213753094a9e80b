/// Text files of numbers: lines and fields that know where they stand.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"

namespace kirireel::model {

/// One word of a line.
struct TextField {
  std::string_view text;  ///< lives as long as its TextTable
  int column = 0;         ///< of its first character, from 1
  int line = 0;           ///< from 1
};

/// One line that holds data.
struct TextLine {
  int number = 0;                 ///< from 1; of the first one if the file continues it
  std::vector<TextField> fields;  ///< at least 1
};

/// A text file in memory, read line by line. Blank lines and, unless asked for, what follows '#',
/// '%' or "//" are passed over; line ends of any system, a byte-order mark and commas between
/// numbers are accepted.
class TextTable {
 public:
  /// Most fields on a line: a tile of 300 vertices.
  static constexpr size_t kMaxFields = 900;

  /// What becomes of comments, and of commas.
  enum class Comments {
    Skip,  ///< comments are left out, commas part numbers
    Keep,  ///< as in OBJ: a line that begins with '#' is one of data, commas are parts of fields,
           ///< and a backslash at the end of a line continues it
  };

  /// Reads the whole file. `purpose` ends the message about a missing file: what it should hold.
  /// Throws InputError when the file is missing, unreadable, no regular file or larger than
  /// kMostTextBytes.
  TextTable(std::filesystem::path file, const std::string& purpose,
            Comments comments = Comments::Skip);

  /// Gives the next line that holds data; false at the end. Throws InputError above kMaxFields.
  /// The fields of the last line stay valid, since they point into the file's text.
  bool next(TextLine& line);

  /// Whether a comment was passed over: the file was left without data on purpose.
  bool hasComment() const { return hasComment_; }

  /// As it was given.
  const std::filesystem::path& file() const { return file_; }

  /// Where a field of the line stands.
  FileLocation at(const TextLine& line, const TextField& field) const {
    return {file_, field.line > 0 ? field.line : line.number, field.column};
  }

 private:
  bool readLine(TextLine& line);
  void splitFields(std::string_view text, TextLine& line) const;

  std::filesystem::path file_;
  Comments comments_;
  std::string text_;
  size_t position_ = 0;
  int number_ = 0;
  bool hasComment_ = false;
};

/// Largest coordinate that is accepted, metres; beyond it a number is a slip of the pen, and
/// distances of tiles would lose the digits that joints need.
inline constexpr double kMaxCoordinate = 1e6;

/// Reads a number, also with a leading plus or with the exponent of Fortran (1.0D+00). All of the
/// text has to be the number; false if it is not. Out of range gives an infinity.
bool readNumber(std::string_view text, double& value);

/// Whether a word stands for a missing number: NaN in any case, with or without a sign.
bool isNan(std::string_view text);

/// The coordinate in a field, metres, at most kMaxCoordinate in size. Throws InputError for
/// letters, NaN, infinities and numbers out of range.
double parseCoordinate(const TextField& field, const FileLocation& location);

/// The number in a field, from `least` to `most`. Throws InputError when it is none; `meaning`
/// names what it should be, e.g. "a stiffness, from 0 to 1e12 N m/rad".
double parseNumberWithin(const TextField& field, const FileLocation& location, double least,
                         double most, const std::string& meaning);

/// The whole number in a field, also as 3.0 or 3e0. Throws InputError when it is none; `meaning`
/// names what it should be, e.g. "a tile number".
int parseWholeNumber(const TextField& field, const FileLocation& location,
                     const std::string& meaning);

}  // namespace kirireel::model
