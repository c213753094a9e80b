// Text by FreeType (freetype.org). Each letter is loaded, rendered with 256 levels of coverage and
// blended over the frame,
//
//     c = (under (255 - cover) + colour cover) / 255, rounded.
//
// Pens count in 64ths of a pixel; glyphs are at whole pixels. There is no kerning and no shaping,
// which some scripts need: captions are short and mostly figures.
#include "render/picture/label.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <sstream>

#include <fmt/format.h>
#include <fontconfig/fontconfig.h>
#include <ft2build.h>

#include "sim/base/error.h"

#include FT_FREETYPE_H

namespace kirireel::picture {
namespace {

/// Replaces invalid text.
constexpr const char32_t* kUnknown = U"\ufffd";

/// FreeType counts in 64ths of a pixel.
constexpr int kPixelUnits = 64;

std::filesystem::path chosenFont;  // of setFont(); empty: none

OutputError fontError(const std::filesystem::path& font) {
  return OutputError(
      fmt::format("{}: error: cannot be used as a font; install Debian's fonts-dejavu-core or set "
                  "KIRIREEL_FONT to a TrueType file",
                  font.string()));
}

std::uint8_t mix(std::uint8_t under, std::uint8_t over, int cover) {
  return static_cast<std::uint8_t>((under * (255 - cover) + over * cover + 127) / 255);
}

/// Does nothing outside the frame.
void blend(Frame& frame, int x, int y, Colour colour, int cover) {
  if (x < 0 || y < 0 || x >= frame.size.width || y >= frame.size.height) return;
  const Colour under = frame.at(x, y);
  frame.set(x, y,
            {mix(under.red, colour.red, cover), mix(under.green, colour.green, cover),
             mix(under.blue, colour.blue, cover), mix(under.alpha, 255, cover)});
}

/// `bitmap_top` counts up from the baseline, rows of the bitmap down.
void drawGlyph(Frame& frame, const FT_GlyphSlot glyph, int penX, int baseline, Colour colour) {
  const FT_Bitmap& bitmap = glyph->bitmap;
  for (int row = 0; row < static_cast<int>(bitmap.rows); ++row) {
    for (int column = 0; column < static_cast<int>(bitmap.width); ++column) {
      const int cover = bitmap.buffer[row * bitmap.pitch + column];
      blend(frame, penX + glyph->bitmap_left + column, baseline - glyph->bitmap_top + row, colour,
            cover);
    }
  }
}

}  // namespace

void setFont(const std::string& family) {
  chosenFont = family.empty() ? std::filesystem::path() : fontFile(family);
}

std::filesystem::path findFont() {
  if (!chosenFont.empty()) return chosenFont;
  if (const char* chosen = std::getenv("KIRIREEL_FONT")) return chosen;
  constexpr std::array<const char*, 3> kKnownPlaces = {
      "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
      "/usr/share/fonts/dejavu-sans-fonts/DejaVuSans.ttf",
      "/usr/share/fonts/TTF/DejaVuSans.ttf",
  };
  for (const char* place : kKnownPlaces) {
    if (std::filesystem::exists(place)) return place;
  }
  throw fontError(kKnownPlaces.front());
}

struct LabelWriter::Face {
  FT_Library library = nullptr;
  FT_Face face = nullptr;

  ~Face() {
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }

  /// The glyph of a letter, drawn on request; the font's box if it lacks the letter.
  FT_GlyphSlot load(char32_t letter, bool drawn) const {
    FT_Load_Char(face, letter, drawn ? FT_LOAD_RENDER : FT_LOAD_DEFAULT);
    return face->glyph;
  }
};

LabelWriter::LabelWriter(int pixelsPerEm, const std::filesystem::path& font)
    : face_(std::make_unique<Face>()) {
  if (FT_Init_FreeType(&face_->library) != 0 ||
      FT_New_Face(face_->library, font.c_str(), 0, &face_->face) != 0 ||
      FT_Set_Pixel_Sizes(face_->face, 0, pixelsPerEm) != 0) {
    throw fontError(font);
  }
}

LabelWriter::~LabelWriter() = default;

std::string fontFamily() {
  return LabelWriter(1).family();
}

std::string LabelWriter::family() const {
  const char* name = face_->face->family_name;
  return name == nullptr ? "sans-serif" : name;
}

int LabelWriter::width(const std::string& text) const {
  long units = 0;
  for (const char32_t letter : codePoints(text).value_or(kUnknown)) {
    units += face_->load(letter, false)->advance.x;
  }
  return static_cast<int>((units + kPixelUnits - 1) / kPixelUnits);
}

std::optional<char32_t> LabelWriter::missingGlyph(const std::u32string& text) const {
  for (const char32_t letter : text) {
    if (FT_Get_Char_Index(face_->face, letter) == 0) return letter;
  }
  return std::nullopt;
}

void LabelWriter::draw(Frame& frame, const std::string& text, int x, int baseline,
                       Colour colour) const {
  long units = static_cast<long>(x) * kPixelUnits;
  for (const char32_t letter : codePoints(text).value_or(kUnknown)) {
    const FT_GlyphSlot glyph = face_->load(letter, true);
    drawGlyph(frame, glyph, static_cast<int>(units / kPixelUnits), baseline, colour);
    units += glyph->advance.x;
  }
}

void requireDrawable(const char* option, const std::string& text) {
  const std::optional<std::u32string> letters = codePoints(text);
  if (!letters) {
    throw InputError(
        fmt::format("error: {}: '{}' is not UTF-8; give the text in that encoding, which "
                    "terminals use",
                    option, shown(text)));
  }
  std::u32string drawn = *letters;
  std::erase(drawn, U'\n');
  const std::optional<char32_t> missing = LabelWriter(1).missingGlyph(drawn);
  if (!missing) return;
  throw InputError(fmt::format(
      "error: {}: the font has no U+{:04X}, character {} of '{}'; remove it, or set KIRIREEL_FONT "
      "to a TrueType file that has it",
      option, static_cast<std::uint32_t>(*missing), letters->find(*missing) + 1, oneLine(text)));
}

// ------------------------------------------------------------------------------------------------
// Asks fontconfig (fontconfig.org, Developers Reference) for the best match of a family, and
// accepts it only if it has that name. fontconfig always finds some font, and nobody would notice a
// figure in another font than requested.

namespace {

struct FreePattern {
  void operator()(FcPattern* pattern) const { FcPatternDestroy(pattern); }
};
using OwnedPattern = std::unique_ptr<FcPattern, FreePattern>;

/// "" if there is none.
std::string textOf(FcPattern* pattern, const char* property, int number = 0) {
  FcChar8* text = nullptr;
  if (FcPatternGetString(pattern, property, number, &text) != FcResultMatch) return "";
  return reinterpret_cast<const char*>(text);
}

/// A font may have several names, in several languages.
bool hasFamily(FcPattern* font, const FcChar8* family) {
  FcChar8* name = nullptr;
  for (int k = 0; FcPatternGetString(font, FC_FAMILY, k, &name) == FcResultMatch; ++k) {
    if (FcStrCmpIgnoreCase(name, family) == 0) return true;
  }
  return false;
}

}  // namespace

namespace {

/// The match of fontconfig for a family and a weight.
OwnedPattern matchFont(const std::string& family, Weight weight) {
  const auto* name = reinterpret_cast<const FcChar8*>(family.c_str());
  const OwnedPattern request(FcPatternCreate());
  FcPatternAddString(request.get(), FC_FAMILY, name);
  FcPatternAddBool(request.get(), FC_SCALABLE, FcTrue);
  if (weight == Weight::Bold) FcPatternAddInteger(request.get(), FC_WEIGHT, FC_WEIGHT_BOLD);
  FcConfigSubstitute(nullptr, request.get(), FcMatchPattern);
  FcDefaultSubstitute(request.get());
  FcResult result = FcResultNoMatch;
  return OwnedPattern(FcFontMatch(nullptr, request.get(), &result));
}

}  // namespace

std::filesystem::path findFont(Weight weight) {
  if (weight == Weight::Regular) return findFont();
  const std::string family = fontFamily();
  const OwnedPattern font = matchFont(family, Weight::Bold);
  const bool isFound =
      font && hasFamily(font.get(), reinterpret_cast<const FcChar8*>(family.c_str()));
  return isFound ? std::filesystem::path(textOf(font.get(), FC_FILE)) : findFont();
}

std::filesystem::path fontFile(const std::string& family) {
  const auto* name = reinterpret_cast<const FcChar8*>(family.c_str());
  const OwnedPattern font = matchFont(family, Weight::Regular);
  if (font && hasFamily(font.get(), name)) return textOf(font.get(), FC_FILE);
  const std::string nearest = font ? textOf(font.get(), FC_FAMILY) : "";
  throw InputError(fmt::format(
      "error: this machine has no font \"{}\"; install it, or give a family from fc-list{}", family,
      nearest.empty() ? "" : fmt::format(", the nearest is \"{}\"", nearest)));
}

// ------------------------------------------------------------------------------------------------
// Greedy: words are added to a line while it fits. Other methods give nothing better for captions
// of a few words.

namespace {

/// Breaks a text without line feeds and appends its lines.
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

// ------------------------------------------------------------------------------------------------
// A box spans from the pixel nearest to its upper left corner to the pixel nearest to its lower
// right corner. Each is rounded separately, so adjacent boxes have no overlap and no gap. A font is
// loaded for each text, because captions are few.

namespace {

int nearestPixel(double length) {
  return static_cast<int>(std::lround(length));
}

}  // namespace

void FrameSurface::box(double left, double upper, double width, double height, Colour colour) {
  const int right = std::min(nearestPixel(left + width), frame_.size.width);
  const int lower = std::min(nearestPixel(upper + height), frame_.size.height);
  for (int y = std::max(nearestPixel(upper), 0); y < lower; ++y) {
    for (int x = std::max(nearestPixel(left), 0); x < right; ++x) frame_.set(x, y, colour);
  }
}

void FrameSurface::text(const std::string& line, double left, double baseline, int em,
                        Colour colour, Weight weight) {
  LabelWriter(em, findFont(weight))
      .draw(frame_, line, nearestPixel(left), nearestPixel(baseline), colour);
}

// ------------------------------------------------------------------------------------------------
// A colour bar from the left: title, gap, bar, with ticks of round values below it. The bar is at
// most 14 em long, shorter in a narrow sheet. It has at most six ticks, fewer if their numbers do
// not fit.
//
// A bar of length shows 1, 2 or 5 times a power of ten metres. With L the longest allowed length,
// p = 10^floor(log10 L) and q = L / p, it is 5 p for q >= 5, 2 p for q >= 2, else p.
//
// A legend that does not fit has smaller letters and squares, all by one factor.

namespace {

/// Height of a bar of colours, and of a bar of length, in ems of the text next to it.
constexpr double kColourBarEms = 0.9;
constexpr double kScaleBarEms = 0.25;
/// Gap between a bar and its text, ems.
constexpr double kSpaceEms = 0.5;
/// Half the height of a capital letter, ems.
constexpr double kHalfCapital = 0.36;
/// Length of a tick below a bar of colours, and distance from its end to the baseline of its value,
/// ems.
constexpr double kTickEms = 0.22;
constexpr double kTickWidthEms = 0.07;
constexpr int kMostTicks = 6;
constexpr double kTickValueEms = 0.95;
/// Length of a colour bar, ems, if there is space.
constexpr double kColourBarLengthEms = 14;

int pixels(double length) {
  return static_cast<int>(std::lround(length));
}

}  // namespace

Colour colourAt(const ColourScale& scale, double share) {
  return scale.background ? mapColour(scale.map, share, *scale.background)
                          : mapColour(scale.map, share);
}

double shareOf(const ColourScale& scale, double value) {
  const double range = scale.most - scale.least;
  return range > 0 ? (value - scale.least) / range : 0;
}

ScaleLength roundLength(double longest) {
  const double power = std::pow(10.0, std::floor(std::log10(longest) + 1e-9));
  const double ratio = longest / power * (1 + 1e-9);
  const double metres = power * (ratio >= 5 ? 5 : ratio >= 2 ? 2 : 1);
  if (metres >= 0.1 && metres < 1000) return {metres, fmt::format("{:g} m", metres)};
  if (metres >= 1000) return {metres, fmt::format("{:g} km", metres / 1000)};
  if (metres >= 1e-3) return {metres, fmt::format("{:g} mm", metres * 1e3)};
  if (metres >= 1e-6) return {metres, fmt::format("{:g} um", metres * 1e6)};
  return {metres, fmt::format("{:g} nm", metres * 1e9)};
}

int ScaleDrawer::baseline(int y) const {
  return y + pixels(kHalfCapital * em_);
}

void ScaleDrawer::drawColourBar(Surface& surface, const ColourScale& scale, int x, int y,
                                int width) const {
  const int gap = pixels(2 * kSpaceEms * em_);
  const int title = writer_.width(scale.title);
  // A tick's value may extend by half its width; a margin stays free at each end.
  const int length = std::clamp(width - title - 3 * gap, em_, pixels(kColourBarLengthEms * em_));
  const int left = x - (title + gap + length) / 2;
  const int height = std::max(3, pixels(kColourBarEms * em_));
  const int upper = y - pixels(0.5 * kColourBarHeight * em_) + pixels(0.1 * em_);
  surface.text(scale.title, left, baseline(upper + height / 2), em_, text_);
  const int bar = left + title + gap;
  for (int k = 0; k < length; ++k) {
    const double share = length > 1 ? static_cast<double>(k) / (length - 1) : 0;
    // Each colour extends to the end of the bar, so there is no gap between two.
    surface.box(bar + k, upper, length - k, height, colourAt(scale, share));
  }
  drawTicks(surface, scale, bar, upper + height, length);
}

/// With as many ticks as values fit.
Axis ScaleDrawer::axisThatFits(const ColourScale& scale, int length) const {
  Axis axis;
  for (int most = kMostTicks; most >= 2; --most) {
    axis = makeAxisWithin(scale.least, scale.most, most);
    int widest = 0;
    for (const std::string& text : axis.texts) widest = std::max(widest, writer_.width(text));
    if (axis.ticks.size() < 2) break;
    const double step = (axis.ticks[1] - axis.ticks[0]) / (scale.most - scale.least);
    if (widest + kSpaceEms * em_ <= step * length) break;
  }
  return axis;
}

void ScaleDrawer::drawTicks(Surface& surface, const ColourScale& scale, int left, int upper,
                            int length) const {
  const Axis axis = axisThatFits(scale, length);
  const int height = std::max(2, pixels(kTickEms * em_));
  const int width = std::max(1, pixels(kTickWidthEms * em_));
  for (std::size_t k = 0; k < axis.ticks.size(); ++k) {
    const int place = left + pixels(shareOf(scale, axis.ticks[k]) * (length - 1));
    surface.box(place - width / 2, upper, width, height, text_);
    surface.text(axis.texts[k], place - writer_.width(axis.texts[k]) / 2,
                 upper + height + pixels(kTickValueEms * em_), em_, text_);
  }
}

void ScaleDrawer::drawLegend(Surface& surface, const std::vector<LegendEntry>& entries, int x,
                             int y, int width) const {
  // In ems of the text: a square, a space, the text, and two spaces before the next.
  double needed = -2 * kSpaceEms * em_;
  for (const auto& [colour, text] : entries) {
    needed += (kColourBarEms + 3 * kSpaceEms) * em_ + writer_.width(text);
  }
  const double share = std::min(1.0, width / needed);
  const int em = std::max(1, static_cast<int>(share * em_));
  const double square = kColourBarEms * em, space = kSpaceEms * em;
  double pen = x - 0.5 * share * needed;
  for (const auto& [colour, text] : entries) {
    surface.box(std::round(pen), std::round(y - 0.5 * square), std::round(square),
                std::round(square), colour);
    pen += square + space;
    surface.text(text, std::round(pen), std::round(y + kHalfCapital * em), em, text_);
    pen += share * writer_.width(text) + 2 * space;
  }
}

void ScaleDrawer::drawScaleBar(Surface& surface, const std::string& text, int length, int x,
                               int y) const {
  const int space = pixels(kSpaceEms * em_);
  const int left = x - (length + space + writer_.width(text)) / 2;
  const int height = std::max(2, pixels(kScaleBarEms * em_));
  surface.box(left, y - height / 2, length, height, text_);
  surface.text(text, left + length + space, baseline(y), em_, text_);
}

// ------------------------------------------------------------------------------------------------
// Steps are 1, 2 or 5 times a power of ten: the least with at most `mostTicks` ticks in the range.
// Ticks are multiples k s of the step s, computed from k each time, so errors do not accumulate.
// Numbers have as many decimals as the step.
//
// A range below 1e-5 of its values would give ticks with equal numbers. It is drawn as a constant
// in the middle of an axis as wide as the value.

namespace {

/// Differences below this fraction of the values are rounding.
constexpr double kConstant = 1e-9;
/// A range below this fraction of its values is drawn as a constant: its numbers would be equal.
constexpr double kUnreadable = 1e-5;
/// Margin above and below the curves, as a fraction of the range.
constexpr double kRoom = 0.05;

/// The least of 1, 2 and 5 times a power of ten that is >= the step.
double roundStep(double step) {
  const double power = std::pow(10, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= step * (1 - kConstant)) return factor * power;
  }
  return 10 * power;
}

/// With a true minus sign.
std::string numberText(double value, int decimals) {
  const std::string text = decimals <= 6 && std::abs(value) < 1e6
                               ? fmt::format("{:.{}f}", std::abs(value), std::max(0, decimals))
                               : fmt::format("{:.3g}", std::abs(value));
  return value < 0 ? "\u2212" + text : text;
}

}  // namespace

double Axis::shareOf(double value) const {
  if (isLogarithmic) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

Axis makeAxis(const std::vector<double>& values, int mostTicks) {
  const auto [least, largest] = std::ranges::minmax_element(values);
  Axis axis{*least, *largest, false, {}, {}};
  const double size = std::max(std::abs(axis.low), std::abs(axis.high));
  if (axis.high - axis.low <= kUnreadable * size) {
    const double room = size > 0 ? 0.5 * size : 1;
    axis.low -= room;
    axis.high += room;
  } else {
    const double room = kRoom * (axis.high - axis.low);
    axis.low -= room;
    axis.high += room;
  }
  return makeAxisWithin(axis.low, axis.high, mostTicks);
}

Axis makeAxisWithin(double low, double high, int mostTicks) {
  Axis axis{low, high, false, {}, {}};
  if (high <= low) return axis;
  const double step = roundStep((high - low) / mostTicks);
  const int decimals = static_cast<int>(std::ceil(-std::log10(step) - kConstant));
  for (double k = std::ceil(low / step - kConstant); k * step <= high * (1 + kConstant); ++k) {
    axis.ticks.push_back(k * step);
    axis.texts.push_back(numberText(k == 0 ? 0 : k * step, decimals));
  }
  return axis;
}

Axis makeLogarithmicAxis(const std::vector<double>& values, int mostTicks) {
  double least = INFINITY, largest = 0;
  for (const double value : values) {
    if (value > 0) least = std::min(least, value);
    largest = std::max(largest, value);
  }
  if (largest == 0) least = largest = 1;
  Axis axis{std::pow(10, std::floor(std::log10(least))),
            std::pow(10, std::ceil(std::log10(largest))),
            true,
            {},
            {}};
  if (axis.low == axis.high) {
    axis.low /= 10;
    axis.high *= 10;
  }
  const int decades = static_cast<int>(std::lround(std::log10(axis.high / axis.low)));
  const int stride = (decades + mostTicks - 1) / mostTicks;
  const int lowest = static_cast<int>(std::lround(std::log10(axis.low)));
  for (int k = 0; k <= decades; k += stride) {
    axis.ticks.push_back(axis.low * std::pow(10, k));
    axis.texts.push_back(fmt::format("1e{}", lowest + k));
  }
  return axis;
}

}  // namespace kirireel::picture
