// Formats what all decks share: numbers, lists, and the lines that say where a deck comes from.
//
// Numbers. CalculiX reads 20 characters of a field and drops the rest without a word, so that
// 1.2345678901234567e-05 (22 characters) loses its exponent. The shortest decimal that reads back
// to the same double (fmt's "{}") usually fits; 14 digits with sign, point and exponent always do:
// 1 + 1 + 1 + 13 + 4 = 20. Exponents of three digits would need 21, so magnitudes below 1e-90 are
// written as zero.
//
// Units. A deck has no units; consistent ones are the user's task. With lengths in mm and forces in
// N, stress is N/mm^2 = MPa (1 Pa = 1e-6 MPa) and mass is the tonne, because 1 N = 1 t mm/s^2; so 1
// kg/m^3 = 1e-3 t / 1e9 mm^3 = 1e-12 t/mm^3.
#include "render/fea/deck_text.h"

#include <cmath>
#include <iterator>

namespace kirireel {
namespace {

constexpr std::size_t kLongestNumber = 20;  ///< characters that CalculiX reads of a number
constexpr std::size_t kLongestLine = 200;   ///< Abaqus and CalculiX read 256 characters
/// Abaqus keeps the first 80 characters of a heading.
constexpr std::size_t kLongestHeading = 80;
constexpr int kNumbersInLine = 16;  ///< that CalculiX and Abaqus read of a line
/// Smaller coordinates are rounding; their exponents would take a third digit.
constexpr double kSmallest = 1e-90;
/// Of the thickness: less is what contacts tolerate.
constexpr double kOverlapToTell = 1e-4;

/// One line of printable characters, whatever a name holds. Control characters, line breaks above
/// all, would end the comment and begin a card.
std::string oneLine(std::string text, std::size_t longest) {
  for (char& letter : text) {
    if (static_cast<unsigned char>(letter) < ' ') letter = ' ';
  }
  if (text.size() > longest) text.resize(longest);
  return text;
}

}  // namespace

UnitScale unitScale(DeckUnit unit) {
  if (unit == DeckUnit::Model) return {};
  return {1e3, 1e-6, 1e-12, "mm, N, t, s, MPa"};
}

bool isOverlapToTell(double overlap, double thickness) {
  return overlap > kOverlapToTell * thickness;
}

std::string deckNumber(double value) {
  // CalculiX wants a real number, so the point stays.
  if (std::abs(value) < kSmallest) return "0.";
  const std::string exact = fmt::format("{}", value);
  return exact.size() <= kLongestNumber ? exact : fmt::format("{:.14g}", value);
}

void appendNumbers(std::string& text, const int* numbers, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) {
    const bool endsLine = (k + 1) % kNumbersInLine == 0 || k + 1 == count;
    // Decks count from 1, meshes here from 0.
    append(text, "{}{}", numbers[k] + 1, endsLine ? "\n" : ", ");
  }
}

void appendNodeSet(std::string& text, const std::string& name, const std::vector<int>& nodes) {
  if (nodes.empty()) return;
  append(text, "*NSET, NSET={}\n", name);
  appendNumbers(text, nodes.data(), nodes.size());
}

void appendOrigin(std::string& text, const DeckOrigin& origin, DeckUnit unit) {
  append(
      text, "** {}\n",
      oneLine(fmt::format("Model {}, state {}, at {} s.", origin.model, origin.state, origin.time),
              kLongestLine));
  append(text, "** Written by {}. Units: {}; bricks {} m thick.\n", origin.writer,
         unitScale(unit).words, deckNumber(origin.thickness));
  append(text, "** {}\n", oneLine("Run: " + origin.run, kLongestLine));
  append(text, "** Deepest overlap of two bricks in this state: {} m.\n",
         deckNumber(origin.overlap));
  if (!isOverlapToTell(origin.overlap, origin.thickness)) return;
  append(text,
         "** WARNING: bricks overlap by {:.2g} of their thickness: with contact between tiles,\n"
         "** an analysis starts overclosed. A run with --contacts keeps bricks apart.\n",
         origin.overlap / origin.thickness);
}

std::string heading(const DeckOrigin& origin, const std::string& subject) {
  const std::string line =
      fmt::format("{}, state {}, {}, {}", origin.model, origin.state, subject, origin.writer);
  return "*HEADING\n" + oneLine(line, kLongestHeading) + "\n";
}

}  // namespace kirireel
