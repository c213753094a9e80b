/// Text on several lines.
///
/// Widths are asked of the caller, so that the same code breaks lines of pixels and of a page of
/// vector graphics, whatever the font.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace kirireel {

/// Width of one line of text, in any unit.
using LineWidth = std::function<double(const std::string&)>;

/// Breaks a text into lines: at each line feed, and at spaces where a line would be wider than
/// `most`. A word that is wider by itself stays whole. Runs of spaces become one. At least one
/// line, which may be empty.
std::vector<std::string> wrapText(const std::string& text, const LineWidth& width, double most);

/// The width of the widest line; 0 for none.
double widestLine(const std::vector<std::string>& lines, const LineWidth& width);

}  // namespace kirireel
