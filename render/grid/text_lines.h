/// Text on several lines.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace kirireel {

/// Width of one line of text, in any unit.
using LineWidth = std::function<double(const std::string&)>;

/// Breaks a text into lines: at each line feed, and at spaces where a line would be wider than
/// `most`. A word that is wider by itself stays whole.
std::vector<std::string> wrapText(const std::string& text, const LineWidth& width, double most);

/// The width of the widest line; 0 for none.
double widestLine(const std::vector<std::string>& lines, const LineWidth& width);

}  // namespace kirireel
