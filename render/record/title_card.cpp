#include "render/record/title_card.h"

#include <algorithm>

#include <fmt/format.h>

#include "render/grid/label.h"
#include "sim/base/error.h"
#include "sim/base/spelling.h"

namespace kirireel {
namespace {

constexpr double kTextHeight = 0.07;  // em, in heights of the picture
constexpr double kTextWidth = 0.9;    // at most, in widths of the picture
constexpr double kCapital = 0.7;      // height of capital letters, em

}  // namespace

void requireTitle(const std::string& title) {
  const std::optional<std::u32string> letters = codePoints(title);
  if (!letters) {
    throw InputError(
        fmt::format("error: --title: '{}' is not UTF-8; give the title in that encoding, which "
                    "terminals use",
                    shown(title)));
  }
  const std::optional<char32_t> missing = LabelWriter(1).missingGlyph(*letters);
  if (!missing) return;
  throw InputError(fmt::format(
      "error: --title: the font has no U+{:04X}, character {} of '{}'; leave it out, or "
      "set KIRIREEL_FONT to a TrueType file that has it",
      static_cast<std::uint32_t>(*missing), letters->find(*missing) + 1, oneLine(title)));
}

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
