// Lines and fields of text files from people and other programs.
//
// The whole file is in memory, and fields are views of its text. The reader accepts a byte-order
// mark, line ends of any system, comments of three languages and commas, because none of these is
// ambiguous. Numbers are strict: std::from_chars ignores the locale, rejects other text and rounds
// correctly.
#include "sim/formats/text_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <system_error>

#include <fmt/format.h>

#include "sim/base/files.h"

namespace kirireel::formats {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";
constexpr std::string_view kCommas = ",;";

std::string quoted(std::string_view text) {
  return fmt::format("'{}'", shown(text, 24));
}

/// Position of a comment in a line; npos if there is none.
std::size_t commentBegin(std::string_view text) {
  return std::min({text.find('#'), text.find('%'), text.find("//")});
}

std::string_view withoutCommas(std::string_view field) {
  if (!field.empty() && kCommas.find(field.back()) != kCommas.npos) field.remove_suffix(1);
  if (!field.empty() && kCommas.find(field.front()) != kCommas.npos) field.remove_prefix(1);
  return field;
}

}  // namespace

std::string readPlainText(const std::filesystem::path& file, const std::string& purpose) {
  std::string text = readTextFile(file, purpose);
  const bool isLittle = text.starts_with("\xFF\xFE");
  if (isLittle || text.starts_with("\xFE\xFF")) {
    std::string narrow;
    for (std::size_t k = 2; k + 1 < text.size(); k += 2) {
      const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
      const unsigned letter = byte(isLittle ? k + 1 : k) * 256U + byte(isLittle ? k : k + 1);
      if (letter < 0x80) {
        narrow += static_cast<char>(letter);
      } else if (letter < 0x800) {
        narrow +=
            {static_cast<char>(0xC0 | letter >> 6), static_cast<char>(0x80 | (letter & 0x3F))};
      } else if (letter < 0xD800 || letter > 0xDFFF) {
        narrow +=
            {static_cast<char>(0xE0 | letter >> 12), static_cast<char>(0x80 | (letter >> 6 & 0x3F)),
             static_cast<char>(0x80 | (letter & 0x3F))};
      } else {
        narrow += '?';  // half of a character beyond 16 bits, in names only
      }
    }
    text = std::move(narrow);
  }
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  if (text.find('\n') == text.npos) std::ranges::replace(text, '\r', '\n');
  return text;
}

TextTable::TextTable(std::filesystem::path file, const std::string& purpose, Comments comments)
    : file_(std::move(file)), comments_(comments) {
  text_ = readPlainText(file_, purpose);
}

bool TextTable::next(TextLine& line) {
  line.fields.clear();
  while (position_ < text_.size() && line.fields.empty()) {
    line.number = number_ + 1;
    // Skipped lines are counted too.
    while (readLine(line)) continue;
  }
  return !line.fields.empty();
}

/// Appends the fields of the next line; true if another one continues it.
bool TextTable::readLine(TextLine& line) {
  const size_t end = std::min(text_.find('\n', position_), text_.size());
  std::string_view text(text_.data() + position_, end - position_);
  position_ = end + 1;
  ++number_;
  const bool isObj = comments_ == Comments::Keep;
  const size_t comment = isObj ? text.find('#') : commentBegin(text);
  hasComment_ = hasComment_ || comment != text.npos;
  // In OBJ only a comment after data is removed. A full line may be one of Kirireel's own comments.
  const bool isWholeLine = line.fields.empty() && text.find_first_not_of(kBlanks) == comment;
  // substr(0, npos) is the whole line.
  if (!isObj || !isWholeLine) text = text.substr(0, comment);
  const size_t last = text.find_last_not_of(kBlanks);
  const bool continues = isObj && comment == text.npos && last != text.npos && text[last] == '\\';
  splitFields(continues ? text.substr(0, last) : text, line);
  return continues && position_ < text_.size();
}

void TextTable::splitFields(std::string_view text, TextLine& line) const {
  // Commas separate numbers if there are no blanks, as in "0,1". In "0,5 1" it is a decimal comma.
  size_t begin = text.find_first_not_of(kBlanks);
  const size_t last = text.find_last_not_of(kBlanks);
  const bool hasBlanks = begin != text.npos && text.find_first_of(kBlanks, begin) < last;
  const std::string parting = std::string(kBlanks) + std::string(hasBlanks ? "" : kCommas);
  const bool isNumbers = comments_ == Comments::Skip;
  const std::string_view parts = isNumbers ? std::string_view(parting) : kBlanks;
  while (begin != text.npos) {
    const size_t end = std::min(text.find_first_of(parts, begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    const std::string_view field = isNumbers ? withoutCommas(word) : word;
    const auto column = static_cast<int>(field.data() - text.data()) + 1;
    if (!field.empty()) line.fields.push_back({field, column, number_});
    if (line.fields.size() > kMaxFields) {
      throw inputErrorAt(
          at(line, line.fields.back()),
          fmt::format("this line has more than {} numbers, but a tile has at most {} vertices. "
                      "Break the line if it has several rows, or split the tile",
                      kMaxFields, kMaxFields / 3));
    }
    begin = text.find_first_not_of(parts, end);
  }
}

bool readNumber(std::string_view text, double& value) {
  // from_chars rejects a leading plus and the exponent D, which other programs write.
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.remove_prefix(1);
  std::string fortran;
  const size_t exponent = text.find_first_of("dD");
  if (exponent != text.npos && exponent > 0 && exponent + 1 < text.size()) {
    fortran = text;
    fortran[exponent] = 'e';
    text = fortran;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::invalid_argument || end != text.data() + text.size()) return false;
  // Zero for a number below the smallest one, an infinity for one above the largest.
  if (error == std::errc::result_out_of_range)
    value = std::strtod(std::string(text).c_str(), nullptr);
  return true;
}

bool isNan(std::string_view text) {
  double value = 0;
  return readNumber(text, value) && std::isnan(value);
}

double parseCoordinate(const TextField& field, const FileLocation& location) {
  double value = 0;
  // The next check reports numbers that are too large for a double.
  if (!readNumber(field.text, value)) {
    const bool hasComma = std::ranges::count(field.text, ',') == 1;
    throw inputErrorAt(location,
                       fmt::format("{} is not a number; write coordinates, "
                                   "{}separated by blanks",
                                   quoted(field.text), hasComma ? "with a decimal point, " : ""));
  }
  if (!(std::abs(value) <= kMaxCoordinate)) {
    throw inputErrorAt(
        location,
        fmt::format("{} is not a coordinate in [-{:g}, {:g}]. Correct it or scale the model",
                    quoted(field.text), kMaxCoordinate, kMaxCoordinate));
  }
  return value;
}

double parseNumberWithin(const TextField& field, const FileLocation& location, double least,
                         double most, const std::string& meaning) {
  double value = 0;
  if (readNumber(field.text, value) && value >= least && value <= most) return value;
  throw inputErrorAt(location,
                     fmt::format("{} is not {}; correct it", quoted(field.text), meaning));
}

int parseWholeNumber(const TextField& field, const FileLocation& location,
                     const std::string& meaning) {
  // Programs with only floating-point numbers write 3 as 3.0000000e+00.
  double value = 0;
  const bool isWhole = readNumber(field.text, value) && value >= std::numeric_limits<int>::min() &&
                       value <= std::numeric_limits<int>::max() && value == std::trunc(value);
  if (!isWhole) {
    throw inputErrorAt(
        location, fmt::format("{} is not {}; write a whole number, at most {}", quoted(field.text),
                              meaning, std::numeric_limits<int>::max()));
  }
  return static_cast<int>(value);
}

std::string unitLine(const LengthUnit& unit) {
  return unit.metres == 1 ? "" : fmt::format("# unit {}\n", unit.name);
}

std::optional<LengthUnit> unitInComments(const std::filesystem::path& file) {
  constexpr int kFirstLines = 20;
  std::ifstream stream = openInputFile(file);
  std::string line;
  for (int k = 0; k < kFirstLines && std::getline(stream, line); ++k) {
    std::istringstream words(line);
    std::string comment, key, name, more;
    if (!(words >> comment >> key >> name) || words >> more) continue;
    if ((comment == "#" || comment == "comment") && key == "unit") return findLengthUnit(name);
  }
  return std::nullopt;
}

}  // namespace kirireel::formats
