// Text by FreeType (freetype.org): each letter is loaded, rendered as 256 levels of cover and
// blended over the frame,
//
//     c = (under (255 - cover) + colour cover) / 255, rounded.
//
// Pens count in 64ths of a pixel; glyphs stand at whole pixels. There is no kerning and no shaping,
// so that scripts which need them are not set right; captions are short and mostly figures.
#include "render/grid/label.h"

#include <array>
#include <cstdlib>

#include <fmt/format.h>
#include <ft2build.h>

#include FT_FREETYPE_H

#include "render/grid/font_file.h"
#include "sim/base/error.h"
#include "sim/base/spelling.h"

namespace kirireel {
namespace {

/// Stands for a text that cannot be read.
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

/// Outside the frame nothing happens.
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

  /// The glyph of a letter, drawn when asked for; the font's box when it lacks the letter.
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
      "error: {}: the font has no U+{:04X}, character {} of '{}'; leave it out, or "
      "set KIRIREEL_FONT to a TrueType file that has it",
      option, static_cast<std::uint32_t>(*missing), letters->find(*missing) + 1, oneLine(text)));
}

}  // namespace kirireel
