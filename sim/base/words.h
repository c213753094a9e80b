/// Words of messages.
#pragma once

#include <string>
#include <string_view>

namespace kirireel {

/// "1 tile", "12 tiles". `many`: the plural if it is not `one` and an s.
inline std::string counted(std::size_t count, std::string_view one, std::string_view many = "") {
  std::string text = std::to_string(count) + ' ';
  if (count == 1) return text.append(one);
  return many.empty() ? text.append(one) + 's' : text.append(many);
}

}  // namespace kirireel
