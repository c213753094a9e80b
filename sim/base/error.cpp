#include "sim/base/error.h"

#include <fmt/format.h>

namespace kirireel {

std::string toString(const FileLocation& location) {
  std::string text = location.file.string();
  if (location.line > 0) text += fmt::format(":{}", location.line);
  if (location.line > 0 && location.column > 0) text += fmt::format(":{}", location.column);
  return text;
}

InputError inputErrorAt(const FileLocation& location, const std::string& message) {
  return InputError(fmt::format("{}: error: {}", toString(location), message));
}

}  // namespace kirireel
