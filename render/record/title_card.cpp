// The title is 7% of the picture's height in its em, the subtitle 4.5%, lines are 1.35 em apart.
// Lines are broken at 90% of the width; if all together are still too wide or too high, all shrink
// by one factor.
#include "render/record/title_card.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "render/grid/label.h"
#include "render/grid/text_lines.h"
#include "sim/base/error.h"
#include "sim/base/spelling.h"

namespace kirireel {
namespace {

constexpr double kTitleSize = 0.07;      // em, in heights of the picture
constexpr double kSubtitleSize = 0.045;  // likewise
constexpr double kLineEms = 1.35;        // from line to line
constexpr double kMostWidth = 0.9;       // of the picture that text may take
constexpr double kMostHeight = 0.9;

/// A line of a card.
struct CardLine {
  std::string text;
  double em = 0;  ///< pixels
};

void append(std::vector<CardLine>& lines, const std::string& text, double em, double most) {
  if (text.empty()) return;
  const LabelWriter writer(std::max(1, static_cast<int>(em)));
  const auto width = [&writer](const std::string& line) -> double { return writer.width(line); };
  for (std::string& line : wrapText(text, width, most)) lines.push_back({std::move(line), em});
}

double widthOf(const CardLine& line) {
  return LabelWriter(std::max(1, static_cast<int>(line.em))).width(line.text);
}

/// Makes all lines smaller by what the widest, or all together, take too much.
void shrinkToFit(std::vector<CardLine>& lines, FrameSize size) {
  double widest = 1, height = 1;
  for (const CardLine& line : lines) {
    widest = std::max(widest, widthOf(line));
    height += kLineEms * line.em;
  }
  const double share =
      std::min({1.0, kMostWidth * size.width / widest, kMostHeight * size.height / height});
  for (CardLine& line : lines) line.em *= share;
}

}  // namespace

void requireTitle(const Title& title) {
  requireDrawable("--title", title.title);
  requireDrawable("--subtitle", title.subtitle);
}

Frame titleCard(const Title& title, FrameSize size, Colour background, Colour ink) {
  std::vector<CardLine> lines;
  append(lines, title.title, kTitleSize * size.height, kMostWidth * size.width);
  append(lines, title.subtitle, kSubtitleSize * size.height, kMostWidth * size.width);
  shrinkToFit(lines, size);
  double height = 0;
  for (const CardLine& line : lines) height += kLineEms * line.em;
  Frame card = makeFrame(size, background);
  double upper = 0.5 * (size.height - height);
  for (const CardLine& line : lines) {
    const LabelWriter writer(std::max(1, static_cast<int>(line.em)));
    writer.draw(card, line.text, (size.width - writer.width(line.text)) / 2,
                static_cast<int>(std::lround(upper + line.em)), ink);
    upper += kLineEms * line.em;
  }
  return card;
}

}  // namespace kirireel
