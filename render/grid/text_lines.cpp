// Greedy: words are added to a line as long as it fits. For captions of a few words that is as good
// as any other way.
#include "render/grid/text_lines.h"

#include <algorithm>
#include <sstream>

namespace kirireel {
namespace {

/// Appends the lines of a text without line feeds.
void wrapParagraph(const std::string& text, const LineWidth& width, double most,
                   std::vector<std::string>& lines) {
  std::istringstream words(text);
  std::string line, word;
  while (words >> word) {
    const std::string longer = line.empty() ? word : line + ' ' + word;
    if (!line.empty() && width(longer) > most) {
      lines.push_back(line);
      line = word;
    } else {
      line = longer;
    }
  }
  lines.push_back(line);
}

}  // namespace

std::vector<std::string> wrapText(const std::string& text, const LineWidth& width, double most) {
  std::vector<std::string> lines;
  std::size_t first = 0;
  for (;;) {
    const std::size_t end = text.find('\n', first);
    wrapParagraph(text.substr(first, end - first), width, most, lines);
    if (end == std::string::npos) return lines;
    first = end + 1;
  }
}

double widestLine(const std::vector<std::string>& lines, const LineWidth& width) {
  double widest = 0;
  for (const std::string& line : lines) widest = std::max(widest, width(line));
  return widest;
}

}  // namespace kirireel
