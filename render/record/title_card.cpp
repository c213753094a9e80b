#include "render/record/title_card.h"

#include <algorithm>

#include "render/grid/label.h"

namespace kirireel {
namespace {

constexpr double kTextHeight = 0.07;  // em, in heights of the picture
constexpr double kTextWidth = 0.9;    // at most, in widths of the picture
constexpr double kCapital = 0.7;      // height of capital letters, em

}  // namespace

Frame titleCard(const std::string& text, FrameSize size, Colour background, Colour ink) {
  Frame card = makeFrame(size, background);
  const double wanted = std::max(1.0, kTextHeight * size.height);
  const double width = LabelWriter(static_cast<int>(wanted)).width(text);
  const double shrink = std::min(1.0, kTextWidth * size.width / std::max(1.0, width));
  const int em = std::max(1, static_cast<int>(wanted * shrink));
  const LabelWriter writer(em);
  writer.draw(card, text, (size.width - writer.width(text)) / 2,
              static_cast<int>(0.5 * (size.height + kCapital * em)), ink);
  return card;
}

}  // namespace kirireel
