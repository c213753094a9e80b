#include "sim/model/text_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>

#include <fmt/format.h>

#include "sim/base/input_file.h"
#include "sim/base/spelling.h"

namespace kirireel {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string quoted(std::string_view text) {
  return fmt::format("'{}'", shown(text, 24));
}

/// from_chars knows no leading plus, which other programs write.
std::string_view withoutPlus(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
  return plus ? text.substr(1) : text;
}

}  // namespace

TextTable::TextTable(std::filesystem::path file, const std::string& purpose, Comments comments)
    : file_(std::move(file)), comments_(comments) {
  text_ = readTextFile(file_, purpose);
  if (text_.starts_with(kByteOrderMark)) text_.erase(0, kByteOrderMark.size());
}

bool TextTable::next(TextLine& line) {
  line.fields.clear();
  while (position_ < text_.size() && line.fields.empty()) {
    const size_t end = std::min(text_.find('\n', position_), text_.size());
    const std::string_view text(text_.data() + position_, end - position_);
    position_ = end + 1;
    line.number = ++number_;
    const size_t begin = text.find_first_not_of(kBlanks);
    if (begin == text.npos) continue;
    const bool isComment = text[begin] == '#';
    hasComment_ = hasComment_ || isComment;
    if (!isComment || comments_ == Comments::Keep) splitFields(text, line);
  }
  return !line.fields.empty();
}

void TextTable::splitFields(std::string_view text, TextLine& line) const {
  size_t begin = text.find_first_not_of(kBlanks);
  while (begin != text.npos) {
    const size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
    line.fields.push_back({text.substr(begin, end - begin), static_cast<int>(begin) + 1});
    if (line.fields.size() > kMaxFields) {
      throw inputErrorAt(
          at(line, line.fields.back()),
          fmt::format(
              "this line has more than {} numbers, and a tile has at most {} vertices; break "
              "the line where it holds several rows, or split the tile",
              kMaxFields, kMaxFields / 3));
    }
    begin = text.find_first_not_of(kBlanks, end);
  }
}

double parseCoordinate(const TextField& field, const FileLocation& location) {
  const std::string_view text = withoutPlus(field.text);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::invalid_argument || end != text.data() + text.size()) {
    throw inputErrorAt(location, fmt::format("{} is not a number; write coordinates in metres, "
                                             "separated by blanks",
                                             quoted(field.text)));
  }
  const bool beyond = error == std::errc::result_out_of_range || std::isinf(value);
  if (beyond || std::isnan(value) || std::abs(value) > kMaxCoordinate) {
    throw inputErrorAt(
        location,
        fmt::format("{} cannot be a coordinate, which lies between -{:g} and {:g} metres; "
                    "correct it or scale the model",
                    quoted(field.text), kMaxCoordinate, kMaxCoordinate));
  }
  return value;
}

int parseWholeNumber(const TextField& field, const FileLocation& location,
                     const std::string& meaning) {
  const std::string_view text = withoutPlus(field.text);
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw inputErrorAt(
        location, fmt::format("{} is not {}; write a whole number, at most {}", quoted(field.text),
                              meaning, std::numeric_limits<int>::max()));
  }
  return value;
}

}  // namespace kirireel
