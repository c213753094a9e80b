/// Text files of numbers, with the position of each line and field.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/length_unit.h"

namespace kirireel::formats {

/// One word of a line.
struct TextField {
  std::string_view text;  ///< valid as long as its TextTable
  int column = 0;         ///< of its first character, >= 1
  int line = 0;           ///< >= 1
};

/// One line with data.
struct TextLine {
  int number = 0;                 ///< >= 1; of the first line if the file continues it
  std::vector<TextField> fields;  ///< at least 1
};

/// A text file in memory, read line by line. Ignores blank lines and, by default, text after '#',
/// '%' or "//". Accepts line ends of any system, a byte-order mark, and commas between numbers.
class TextTable {
 public:
  /// Maximum number of fields on a line: a tile of 300 vertices.
  static constexpr size_t kMaxFields = 900;

  /// Treatment of comments and commas.
  enum class Comments {
    Skip,  ///< ignore comments; commas separate numbers
    Keep,  ///< as in OBJ: lines that begin with '#' are data, commas are parts of fields, and a
           ///< backslash at the end of a line continues it
  };

  /// Reads the whole file. `purpose` ends the message about a missing file: its expected contents.
  /// Throws InputError if the file is missing, unreadable, not a regular file, or larger than
  /// kMaxTextBytes.
  TextTable(std::filesystem::path file, const std::string& purpose,
            Comments comments = Comments::Skip);

  /// Gives the next line with data; false at the end. Throws InputError above kMaxFields. The
  /// fields of the last line stay valid, since they point to the file's text.
  bool next(TextLine& line);

  /// Whether a comment was ignored, which shows that a file is empty on purpose.
  bool hasComment() const { return hasComment_; }

  /// Path as given by the user.
  const std::filesystem::path& file() const { return file_; }

  /// Position of a field of the line.
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

/// A text file as UTF-8 without a byte-order mark, with `\n` in place of the line ends of old
/// Macintosh programs. Windows programs write UTF-16. See readTextFile().
std::string readPlainText(const std::filesystem::path& file, const std::string& purpose);

/// Largest accepted coordinate, in the file's unit. Larger numbers have no decimals as doubles, so
/// they would lose the precision that joints need.
inline constexpr double kMaxCoordinate = 1e15;

/// Reads a number, also with a leading plus or a Fortran exponent (1.0D+00). False if the text is
/// not completely a number. Above the largest double it gives an infinity, below the smallest one
/// 0.
bool readNumber(std::string_view text, double& value);

/// Whether a word is a missing number: NaN in upper or lower case, with or without a sign.
bool isNan(std::string_view text);

/// The coordinate in a field, in the file's unit, [-kMaxCoordinate, kMaxCoordinate]. Throws
/// InputError for letters, NaN, infinities and numbers out of range.
double parseCoordinate(const TextField& field, const FileLocation& location);

/// The number in a field, in [least, most]. Throws InputError for other text; `meaning` describes
/// the allowed values, e.g. "a stiffness, from 0 to 1e12 N m/rad".
double parseNumberWithin(const TextField& field, const FileLocation& location, double least,
                         double most, const std::string& meaning);

/// The whole number in a field, also as 3.0 or 3e0. Throws InputError for other text; `meaning`
/// describes the expected value, e.g. "a tile number".
int parseWholeNumber(const TextField& field, const FileLocation& location,
                     const std::string& meaning);

/// A first line that declares the unit of a text file, "# unit mm". Empty for metres, the unit of
/// files without such a line.
std::string unitLine(const LengthUnit& unit);

/// The unit that such a line, or "comment unit mm" of a PLY file, declares among the first lines of
/// a file, if any.
std::optional<LengthUnit> unitInComments(const std::filesystem::path& file);

}  // namespace kirireel::formats
