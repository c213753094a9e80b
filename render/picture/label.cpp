// Text by FreeType (freetype.org). Each glyph is loaded, rendered with 256 levels of coverage and
// blended over the frame,
//
//     c = (under (255 - cover) + colour cover) / 255, rounded.
//
// Glyphs are at whole pixels. FriBidi orders mixed directions (Unicode Standard Annex 9); the first
// letter with a direction sets that of the line. A run has one font, script and direction, and
// HarfBuzz shapes it (harfbuzz.github.io). Latin, Greek and Cyrillic have no kerning and no
// ligatures: pictures look the same as in vector graphics, where Cairo has neither.
#include "render/picture/label.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <mutex>
#include <new>
#include <sstream>
#include <tuple>

#include <fmt/format.h>
#include <fontconfig/fontconfig.h>
#include <fribidi.h>
#include <ft2build.h>
#include <hb-ft.h>
#include <hb.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"

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
    if (isPresent(place)) return place;
  }
  throw fontError(kKnownPlaces.front());
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
bool hasFamily(FcPattern* font, const std::string& family) {
  FcChar8* name = nullptr;
  for (int k = 0; FcPatternGetString(font, FC_FAMILY, k, &name) == FcResultMatch; ++k) {
    if (FcStrCmpIgnoreCase(name, reinterpret_cast<const FcChar8*>(family.c_str())) == 0)
      return true;
  }
  return false;
}

/// A request for scalable fonts of a family and a weight, before fontconfig's substitutions.
OwnedPattern requestFor(const std::string& family, Weight weight) {
  OwnedPattern request(FcPatternCreate());
  FcPatternAddString(request.get(), FC_FAMILY, reinterpret_cast<const FcChar8*>(family.c_str()));
  FcPatternAddBool(request.get(), FC_SCALABLE, FcTrue);
  if (weight == Weight::Bold) FcPatternAddInteger(request.get(), FC_WEIGHT, FC_WEIGHT_BOLD);
  return request;
}

/// The match of fontconfig for a family and a weight.
OwnedPattern matchFont(const std::string& family, Weight weight) {
  const OwnedPattern request = requestFor(family, weight);
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
  return font && hasFamily(font.get(), family) ? std::filesystem::path(textOf(font.get(), FC_FILE))
                                               : findFont();
}

std::filesystem::path fontFile(const std::string& family) {
  const OwnedPattern font = matchFont(family, Weight::Regular);
  if (font && hasFamily(font.get(), family)) return textOf(font.get(), FC_FILE);
  const std::string nearest = font ? textOf(font.get(), FC_FAMILY) : "";
  throw InputError(fmt::format(
      "error: this machine has no font \"{}\"; install it, or give a family from fc-list{}", family,
      nearest.empty() ? "" : fmt::format(", the nearest is \"{}\"", nearest)));
}

std::shared_ptr<void> fontPattern(const FontFile& font) {
  FcPattern* pattern = FcPatternCreate();
  FcPatternAddString(pattern, FC_FILE, reinterpret_cast<const FcChar8*>(font.path.c_str()));
  FcPatternAddInteger(pattern, FC_INDEX, font.number);
  return {pattern, FreePattern()};
}

// ------------------------------------------------------------------------------------------------
// Fallback fonts. fontconfig sorts the fonts of the machine by the number of missing characters
// that they have, then by similarity. A character is drawn with the first font that has it. Fonts
// of bitmaps or of colours have no outlines for vector graphics, so they are skipped.

namespace {

struct FreeFontSet {
  void operator()(FcFontSet* set) const { FcFontSetDestroy(set); }
};

/// Whether a font has a property. Fonts without the property have `absent`.
bool hasProperty(FcPattern* font, const char* property, bool absent) {
  FcBool value = absent ? FcTrue : FcFalse;
  FcPatternGetBool(font, property, 0, &value);
  return value == FcTrue;
}

/// The language of the script; Chinese characters have other forms in Japanese and Korean.
const char* languageOf(const std::u32string& letters) {
  for (const char32_t letter : letters) {
    if (letter >= 0x3040 && letter < 0x3100) return "ja";
    if (letter >= 0xac00 && letter < 0xd7b0) return "ko";
  }
  return nullptr;
}

/// The font of each missing character; empty path: none has it.
std::vector<FontFile> findFallback(const std::string& family, Weight weight,
                                   const std::u32string& missing) {
  FcCharSet* letters = FcCharSetCreate();
  for (const char32_t letter : missing) FcCharSetAddChar(letters, letter);
  const OwnedPattern request = requestFor(family, weight);
  FcPatternAddCharSet(request.get(), FC_CHARSET, letters);
  FcCharSetDestroy(letters);  // the pattern has its own reference
  FcPatternAddBool(request.get(), FC_COLOR, FcFalse);
  if (const char* language = languageOf(missing)) {
    FcPatternAddString(request.get(), FC_LANG, reinterpret_cast<const FcChar8*>(language));
  }
  FcConfigSubstitute(nullptr, request.get(), FcMatchPattern);
  FcDefaultSubstitute(request.get());
  FcResult result = FcResultNoMatch;
  const std::unique_ptr<FcFontSet, FreeFontSet> fonts(
      FcFontSort(nullptr, request.get(), FcFalse, nullptr, &result));
  std::vector<FontFile> found(missing.size());
  if (!fonts) return found;
  for (int k = 0; k < fonts->nfont; ++k) {
    FcPattern* font = fonts->fonts[k];
    FcCharSet* has = nullptr;
    if (!(hasProperty(font, FC_OUTLINE, true) && !hasProperty(font, FC_COLOR, false) &&
          !hasProperty(font, FC_VARIABLE, false)) ||
        FcPatternGetCharSet(font, FC_CHARSET, 0, &has) != FcResultMatch) {
      continue;
    }
    FontFile file{textOf(font, FC_FILE)};
    FcPatternGetInteger(font, FC_INDEX, 0, &file.number);
    for (std::size_t i = 0; i < missing.size(); ++i) {
      if (found[i].path.empty() && FcCharSetHasChar(has, missing[i])) found[i] = file;
    }
  }
  return found;
}

/// The same, remembered after the first search: each frame of a video has the same texts.
std::vector<FontFile> fallbackFonts(const std::string& family, Weight weight,
                                    const std::u32string& missing) {
  static std::mutex mutex;
  static std::map<std::tuple<std::string, Weight, std::u32string>, std::vector<FontFile>> known;
  const std::lock_guard lock(mutex);
  const auto [entry, isNew] = known.try_emplace({family, weight, missing});
  if (isNew) entry->second = findFallback(family, weight, missing);
  return entry->second;
}

// ------------------------------------------------------------------------------------------------
// Shaping.

hb_unicode_general_category_t categoryOf(char32_t letter) {
  return hb_unicode_general_category(hb_unicode_funcs_get_default(), letter);
}

hb_script_t scriptOf(char32_t letter) {
  return hb_unicode_script(hb_unicode_funcs_get_default(), letter);
}

/// Part of the character before it.
bool isMark(char32_t letter) {
  const hb_unicode_general_category_t category = categoryOf(letter);
  return category == HB_UNICODE_GENERAL_CATEGORY_NON_SPACING_MARK ||
         category == HB_UNICODE_GENERAL_CATEGORY_ENCLOSING_MARK ||
         category == HB_UNICODE_GENERAL_CATEGORY_SPACING_MARK;
}

/// Joiners, directions and selectors of variants, which need no glyph.
bool isInvisible(char32_t letter) {
  return letter == 0xad || categoryOf(letter) == HB_UNICODE_GENERAL_CATEGORY_FORMAT ||
         (letter >= 0xfe00 && letter <= 0xfe0f) || (letter >= 0xe0100 && letter <= 0xe01ef);
}

/// The script of each character. Spaces, digits and marks get the script of the text before them.
std::vector<hb_script_t> scriptsOf(const std::u32string& letters) {
  std::vector<hb_script_t> scripts;
  hb_script_t last = HB_SCRIPT_COMMON;
  for (const char32_t letter : letters) {
    const hb_script_t script = scriptOf(letter);
    if (script != HB_SCRIPT_COMMON && script != HB_SCRIPT_INHERITED) last = script;
    scripts.push_back(last);
  }
  return scripts;
}

/// Embedding levels of Unicode Standard Annex 9; odd: right to left.
struct Directions {
  std::vector<FriBidiLevel> levels;  ///< one per character
  bool isRightToLeft = false;        ///< the line
};

Directions directionsOf(const std::u32string& letters) {
  const std::vector<FriBidiChar> text(letters.begin(), letters.end());
  const auto count = static_cast<FriBidiStrIndex>(text.size());
  std::vector<FriBidiCharType> types(text.size());
  std::vector<FriBidiBracketType> brackets(text.size());
  Directions directions{std::vector<FriBidiLevel>(text.size())};
  fribidi_get_bidi_types(text.data(), count, types.data());
  fribidi_get_bracket_types(text.data(), count, types.data(), brackets.data());
  FriBidiParType line = FRIBIDI_PAR_ON;
  if (fribidi_get_par_embedding_levels_ex(types.data(), brackets.data(), count, &line,
                                          directions.levels.data()) == 0) {
    throw std::bad_alloc();  // its only failure
  }
  directions.isRightToLeft = FRIBIDI_IS_RTL(line);
  return directions;
}

/// Characters in one font, script and direction.
struct Span {
  std::size_t first = 0;
  std::size_t end = 0;
  std::size_t font = 0;
  hb_script_t script = HB_SCRIPT_COMMON;
  FriBidiLevel level = 0;
};

/// Rule L2 of the annex: reverses each sequence of spans at or above each level, from the highest.
void orderOnPage(std::vector<Span>& spans) {
  FriBidiLevel highest = 0;
  for (const Span& span : spans) highest = std::max(highest, span.level);
  for (int level = highest; level > 0; --level) {
    const auto isBelow = [level](const Span& span) { return span.level < level; };
    for (auto first = spans.begin(); first != spans.end();) {
      const auto end = std::find_if(first, spans.end(), isBelow);
      std::reverse(first, end);
      first = end == spans.end() ? end : end + 1;
    }
  }
}

/// Scripts without joined letters.
bool isSimple(hb_script_t script) {
  return script == HB_SCRIPT_LATIN || script == HB_SCRIPT_GREEK || script == HB_SCRIPT_CYRILLIC ||
         script == HB_SCRIPT_COMMON;
}

struct FreeBuffer {
  void operator()(hb_buffer_t* buffer) const { hb_buffer_destroy(buffer); }
};
using OwnedBuffer = std::unique_ptr<hb_buffer_t, FreeBuffer>;

/// Glyphs of a span; their clusters are numbers of characters.
OwnedBuffer shapeSpan(const std::u32string& letters, const Span& span, hb_font_t* font) {
  OwnedBuffer buffer(hb_buffer_create());
  hb_buffer_add_utf32(buffer.get(), reinterpret_cast<const std::uint32_t*>(letters.data()),
                      static_cast<int>(letters.size()), static_cast<unsigned>(span.first),
                      static_cast<int>(span.end - span.first));
  hb_buffer_set_direction(buffer.get(), span.level % 2 == 1 ? HB_DIRECTION_RTL : HB_DIRECTION_LTR);
  hb_buffer_set_script(buffer.get(), span.script);
  // Else HarfBuzz takes it from the locale.
  hb_buffer_set_language(buffer.get(), hb_language_from_string("und", -1));
  std::vector<hb_feature_t> features;
  if (isSimple(span.script)) {
    for (const char* off : {"-kern", "-liga", "-clig"}) {
      hb_feature_from_string(off, -1, &features.emplace_back());
    }
  }
  hb_shape(font, buffer.get(), features.data(), static_cast<unsigned>(features.size()));
  return buffer;
}

int bytesOf(char32_t letter) {
  return letter < 0x80 ? 1 : letter < 0x800 ? 2 : letter < 0x10000 ? 3 : 4;
}

/// Bytes in UTF-8 of the characters from `first` to before `end`.
int bytesOf(const std::u32string& letters, std::size_t first, std::size_t end) {
  int bytes = 0;
  for (std::size_t k = first; k < end; ++k) bytes += bytesOf(letters[k]);
  return bytes;
}

/// The characters from `first` to before `end`, of a text in UTF-8.
std::string partOf(const std::string& text, const std::u32string& letters, std::size_t first,
                   std::size_t end) {
  return text.substr(bytesOf(letters, 0, first), bytesOf(letters, first, end));
}

/// The clusters from left to right. `starts`: the first character of each glyph's cluster.
std::vector<GlyphCluster> clustersOf(const std::vector<std::size_t>& starts, const Span& span,
                                     const std::string& text, const std::u32string& letters) {
  std::vector<GlyphCluster> clusters;
  std::size_t left = span.end;  // start of the cluster on the left
  for (std::size_t k = 0; k < starts.size();) {
    std::size_t next = k;
    while (next < starts.size() && starts[next] == starts[k]) ++next;
    const std::size_t right = next < starts.size() ? starts[next] : span.end;
    const std::size_t end = span.level % 2 == 1 ? left : right;
    clusters.push_back({partOf(text, letters, starts[k], end), static_cast<int>(next - k)});
    left = starts[k];
    k = next;
  }
  return clusters;
}

}  // namespace

/// The main font, then the fallback fonts that were needed.
struct LabelWriter::Fonts {
  struct Font {
    FontFile file;
    FT_Face face = nullptr;
    hb_font_t* shaper = nullptr;
  };

  int pixelsPerEm;
  FT_Library library = nullptr;
  std::vector<Font> fonts;

  explicit Fonts(int pixels) : pixelsPerEm(pixels) {}
  Fonts(const Fonts&) = delete;
  Fonts& operator=(const Fonts&) = delete;
  ~Fonts() {
    for (const Font& font : fonts) {
      if (font.shaper != nullptr) hb_font_destroy(font.shaper);
      if (font.face != nullptr) FT_Done_Face(font.face);
    }
    if (library != nullptr) FT_Done_FreeType(library);
  }

  /// The number of a font, which it opens on first use.
  std::size_t open(const FontFile& file) {
    const auto known = std::ranges::find(fonts, file, &Font::file);
    if (known != fonts.end()) return static_cast<std::size_t>(known - fonts.begin());
    Font& font = fonts.emplace_back(Font{file});
    if (FT_New_Face(library, file.path.c_str(), file.number, &font.face) != 0 ||
        FT_Set_Pixel_Sizes(font.face, 0, pixelsPerEm) != 0) {
      throw fontError(file.path);
    }
    font.shaper = hb_ft_font_create_referenced(font.face);
    hb_ft_font_set_load_flags(font.shaper, FT_LOAD_DEFAULT);
    return fonts.size() - 1;
  }

  std::string familyOf(std::size_t font) const {
    const char* name = fonts[font].face->family_name;
    return name == nullptr ? "sans-serif" : name;
  }

  bool has(std::size_t font, char32_t letter) const {
    return FT_Get_Char_Index(fonts[font].face, letter) != 0;
  }

  /// The characters that need a fallback font, each once, ascending.
  std::u32string missingOf(const std::u32string& letters) const {
    std::u32string missing;
    for (const char32_t letter : letters) {
      if (!has(0, letter) && !isInvisible(letter)) missing += letter;
    }
    std::ranges::sort(missing);
    missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
    return missing;
  }

  std::vector<FontFile> fallbackFor(const std::u32string& missing) const {
    if (missing.empty()) return {};
    const bool isBold = (fonts[0].face->style_flags & FT_STYLE_FLAG_BOLD) != 0;
    return fallbackFonts(familyOf(0), isBold ? Weight::Bold : Weight::Regular, missing);
  }

  /// The font of each character. A mark gets the font of its base if that has the mark.
  std::vector<std::size_t> fontsFor(const std::u32string& letters) {
    const std::u32string missing = missingOf(letters);
    const std::vector<FontFile> fallback = fallbackFor(missing);
    std::vector<std::size_t> result;
    for (const char32_t letter : letters) {
      std::size_t font = 0;
      if (!result.empty() &&
          (isInvisible(letter) || (isMark(letter) && has(result.back(), letter)))) {
        font = result.back();
      } else if (const std::size_t k = missing.find(letter);
                 k != std::u32string::npos && !fallback[k].path.empty()) {
        font = open(fallback[k]);
      }
      result.push_back(font);
    }
    return result;
  }

  /// The spans in reading order.
  std::vector<Span> spansOf(const std::u32string& letters,
                            const std::vector<FriBidiLevel>& levels) {
    const std::vector<hb_script_t> scripts = scriptsOf(letters);
    const std::vector<std::size_t> fontOf = fontsFor(letters);
    std::vector<Span> spans;
    for (std::size_t k = 0; k < letters.size(); ++k) {
      const Span next{k, k + 1, fontOf[k], scripts[k], levels[k]};
      if (!spans.empty() && spans.back().font == next.font && spans.back().level == next.level &&
          spans.back().script == next.script) {
        spans.back().end = next.end;
      } else {
        spans.push_back(next);
      }
    }
    return spans;
  }

  bool isPlain(const Span& span, const std::vector<PlacedGlyph>& glyphs,
               const std::u32string& letters) const {
    if (span.font != 0 || span.level != 0 || glyphs.size() != span.end - span.first) return false;
    for (std::size_t k = 0; k < glyphs.size(); ++k) {
      if (glyphs[k].y != 0 ||
          glyphs[k].number != FT_Get_Char_Index(fonts[0].face, letters[span.first + k]))
        return false;
    }
    return true;
  }
};

LabelWriter::LabelWriter(int pixelsPerEm, const std::filesystem::path& font)
    : fonts_(std::make_unique<Fonts>(pixelsPerEm)) {
  if (FT_Init_FreeType(&fonts_->library) != 0) throw fontError(font);
  fonts_->open({font});
}

LabelWriter::~LabelWriter() = default;

std::string fontFamily() {
  return LabelWriter(1).family();
}

std::string LabelWriter::family() const {
  return fonts_->familyOf(0);
}

ShapedLine LabelWriter::shape(const std::string& text) const {
  const std::optional<std::u32string> characters = codePoints(text);
  const std::u32string letters = characters.value_or(kUnknown);
  const Directions directions = directionsOf(letters);
  std::vector<Span> spans = fonts_->spansOf(letters, directions.levels);
  orderOnPage(spans);
  ShapedLine line{.isRightToLeft = directions.isRightToLeft};
  long pen = 0;  // in FreeType's units
  for (const Span& span : spans) {
    const OwnedBuffer buffer = shapeSpan(letters, span, fonts_->fonts[span.font].shaper);
    unsigned count = 0;
    const hb_glyph_info_t* glyphs = hb_buffer_get_glyph_infos(buffer.get(), &count);
    const hb_glyph_position_t* places = hb_buffer_get_glyph_positions(buffer.get(), &count);
    TextRun run{.font = fonts_->fonts[span.font].file, .family = fonts_->familyOf(span.font)};
    std::vector<std::size_t> starts;
    for (unsigned k = 0; k < count; ++k) {
      run.glyphs.push_back({glyphs[k].codepoint,
                            static_cast<double>(pen + places[k].x_offset) / kPixelUnits,
                            -static_cast<double>(places[k].y_offset) / kPixelUnits});
      starts.push_back(glyphs[k].cluster);
      pen += places[k].x_advance;
    }
    run.clusters = clustersOf(starts, span, characters ? text : "\ufffd", letters);
    line.isPlain = line.isPlain && fonts_->isPlain(span, run.glyphs, letters);
    line.runs.push_back(std::move(run));
  }
  line.width = static_cast<double>(pen) / kPixelUnits;
  return line;
}

int LabelWriter::width(const std::string& text) const {
  return static_cast<int>(std::ceil(shape(text).width));
}

int LabelWriter::widest(const std::vector<std::string>& lines) const {
  int widest = 0;
  for (const std::string& line : lines) widest = std::max(widest, width(line));
  return widest;
}

std::optional<char32_t> LabelWriter::missingGlyph(const std::u32string& text) const {
  const std::u32string missing = fonts_->missingOf(text);
  const std::vector<FontFile> fallback = fonts_->fallbackFor(missing);
  for (const char32_t letter : text) {
    const std::size_t k = missing.find(letter);
    if (k != std::u32string::npos && fallback[k].path.empty()) return letter;
  }
  return std::nullopt;
}

void LabelWriter::draw(Frame& frame, const std::string& text, int x, int baseline,
                       Colour colour) const {
  for (const TextRun& run : shape(text).runs) {
    const FT_Face face = fonts_->fonts[fonts_->open(run.font)].face;
    for (const PlacedGlyph& glyph : run.glyphs) {
      if (FT_Load_Glyph(face, glyph.number, FT_LOAD_RENDER) != 0) continue;
      drawGlyph(frame, face->glyph, static_cast<int>(x + glyph.x), baseline + wholePixels(glyph.y),
                colour);
    }
  }
}

// ------------------------------------------------------------------------------------------------
// Refusal of text that no font has.

namespace {

/// Debian's package with the letters of some scripts (ISO 15924).
struct ScriptPackage {
  const char* name;
  const char* package;
  std::vector<hb_script_t> scripts;
};

const std::vector<ScriptPackage>& scriptPackages() {
  static const std::vector<ScriptPackage> table = {
      {"Chinese or Japanese", "fonts-noto-cjk", {HB_SCRIPT_HAN, HB_SCRIPT_BOPOMOFO}},
      {"Japanese", "fonts-noto-cjk", {HB_SCRIPT_HIRAGANA, HB_SCRIPT_KATAKANA}},
      {"Korean", "fonts-noto-cjk", {HB_SCRIPT_HANGUL}},
      {"Arabic", "fonts-noto-core", {HB_SCRIPT_ARABIC}},
      {"Hebrew", "fonts-noto-core", {HB_SCRIPT_HEBREW}},
      {"Devanagari", "fonts-noto-core", {HB_SCRIPT_DEVANAGARI}},
      {"Thai", "fonts-noto-core", {HB_SCRIPT_THAI}},
      {"Latin, Greek or Cyrillic",
       "fonts-dejavu-core",
       {HB_SCRIPT_LATIN, HB_SCRIPT_GREEK, HB_SCRIPT_CYRILLIC}},
      {"a symbol or emoji", "fonts-symbola", {HB_SCRIPT_COMMON, HB_SCRIPT_INHERITED}},
      {"another script", "fonts-noto-core", {}},
  };
  return table;
}

/// Null for characters that have no glyph in any font, such as control characters.
const ScriptPackage* packageFor(char32_t letter) {
  switch (categoryOf(letter)) {
    case HB_UNICODE_GENERAL_CATEGORY_CONTROL:
    case HB_UNICODE_GENERAL_CATEGORY_PRIVATE_USE:
    case HB_UNICODE_GENERAL_CATEGORY_UNASSIGNED:
      return nullptr;
    default:
      break;
  }
  const bool isWide =
      (letter >= 0x3000 && letter < 0x3400) || (letter >= 0xff00 && letter < 0xfff0);
  const hb_script_t own = scriptOf(letter);
  const hb_script_t script = own == HB_SCRIPT_COMMON && isWide ? HB_SCRIPT_HAN : own;
  for (const ScriptPackage& row : scriptPackages()) {
    if (std::ranges::find(row.scripts, script) != row.scripts.end()) return &row;
  }
  return &scriptPackages().back();
}

}  // namespace

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
  const std::size_t place = letters->find(*missing);
  const ScriptPackage* row = packageFor(*missing);
  const std::string start =
      fmt::format("error: {}: no font has U+{:04X}", option, static_cast<std::uint32_t>(*missing));
  const std::string in = fmt::format("character {} of '{}'", place + 1, oneLine(text));
  if (row == nullptr) throw InputError(fmt::format("{}, {}; remove it", start, in));
  throw InputError(fmt::format(
      "{} '{}' ({}), {}; remove it, or install a font that has it, for example from Debian's {}",
      start, partOf(text, *letters, place, place + 1), row->name, in, row->package));
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

// ------------------------------------------------------------------------------------------------
// A box spans from the pixel nearest to its upper left corner to the pixel nearest to its lower
// right corner. Each is rounded separately, so adjacent boxes have no overlap and no gap. A font is
// loaded for each text, because captions are few.

void FrameSurface::box(double left, double upper, double width, double height, Colour colour) {
  const int right = std::min(wholePixels(left + width), frame_.size.width);
  const int lower = std::min(wholePixels(upper + height), frame_.size.height);
  for (int y = std::max(wholePixels(upper), 0); y < lower; ++y) {
    for (int x = std::max(wholePixels(left), 0); x < right; ++x) frame_.set(x, y, colour);
  }
}

void FrameSurface::text(const std::string& line, double left, double baseline, int em,
                        Colour colour, Weight weight) {
  LabelWriter(em, findFont(weight))
      .draw(frame_, line, wholePixels(left), wholePixels(baseline), colour);
}

// ------------------------------------------------------------------------------------------------
// A colour bar from the left: title, gap, bar, with ticks of round values below it. The bar is at
// most 14 em long, shorter in a narrow sheet. It has at most six ticks, fewer if their numbers do
// not fit. If less than 5 em are left for the bar, all of it is drawn with smaller text.
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
constexpr int kMaxTicks = 6;
constexpr double kTickValueEms = 0.95;
/// Length of a colour bar, ems, if there is space.
constexpr double kColourBarLengthEms = 14;
/// Its smallest length, ems. With less space the text is smaller.
constexpr double kMinColourBarEms = 5;

}  // namespace

Colour colourAt(const ColourScale& scale, double share) {
  return scale.background ? mapColour(scale.map, share, *scale.background)
                          : mapColour(scale.map, share);
}

double shareOf(const ColourScale& scale, double value) {
  const double range = scale.most - scale.least;
  return range > 0 ? (value - scale.least) / range : 0;
}

std::string unitSymbol(const LengthUnit& unit) {
  return unit.name == "um" ? "\u00b5m" : unit.name;
}

ScaleLength roundLength(double longest, const LengthUnit& unit) {
  const double units = longest / unit.metres;
  const double power = std::pow(10.0, std::floor(std::log10(units) + 1e-9));
  const double ratio = units / power * (1 + 1e-9);
  const double length = power * (ratio >= 5 ? 5 : ratio >= 2 ? 2 : 1);
  return {length * unit.metres, fmt::format("{:g} {}", length, unitSymbol(unit))};
}

int ScaleDrawer::baseline(int y) const {
  return y + wholePixels(kHalfCapital * em_);
}

void ScaleDrawer::drawColourBar(Surface& surface, const ColourScale& scale, int x, int y,
                                int width) const {
  const int gap = wholePixels(2 * kSpaceEms * em_);
  const int title = writer_.width(scale.title);
  const double needed = title + 3 * gap + kMinColourBarEms * em_;
  if (width < needed && em_ > 1) {
    const ScaleDrawer smaller(std::max(1, static_cast<int>(width / needed * em_)), text_);
    return smaller.drawColourBar(surface, scale, x, y, width);
  }
  // A tick's value may extend by half its width; a margin stays free at each end.
  const int length =
      std::clamp(width - title - 3 * gap, em_, wholePixels(kColourBarLengthEms * em_));
  const int left = x - (title + gap + length) / 2;
  const int height = std::max(3, wholePixels(kColourBarEms * em_));
  const int upper = y - wholePixels(0.5 * kColourBarHeight * em_) + wholePixels(0.1 * em_);
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
  for (int most = kMaxTicks; most >= 2; --most) {
    axis = makeAxisWithin(scale.least, scale.most, most);
    if (axis.ticks.size() < 2) break;
    const double step = (axis.ticks[1] - axis.ticks[0]) / (scale.most - scale.least);
    if (writer_.widest(axis.texts) + kSpaceEms * em_ <= step * length) break;
  }
  return axis;
}

void ScaleDrawer::drawTicks(Surface& surface, const ColourScale& scale, int left, int upper,
                            int length) const {
  const Axis axis = axisThatFits(scale, length);
  const int height = std::max(2, wholePixels(kTickEms * em_));
  const int width = std::max(1, wholePixels(kTickWidthEms * em_));
  for (std::size_t k = 0; k < axis.ticks.size(); ++k) {
    const int place = left + wholePixels(shareOf(scale, axis.ticks[k]) * (length - 1));
    surface.box(place - width / 2, upper, width, height, text_);
    surface.text(axis.texts[k], place - writer_.width(axis.texts[k]) / 2,
                 upper + height + wholePixels(kTickValueEms * em_), em_, text_);
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
  const int space = wholePixels(kSpaceEms * em_);
  const int left = x - (length + space + writer_.width(text)) / 2;
  const int height = std::max(2, wholePixels(kScaleBarEms * em_));
  surface.box(left, y - height / 2, length, height, text_);
  surface.text(text, left + length + space, baseline(y), em_, text_);
}

// ------------------------------------------------------------------------------------------------
// Steps are 1, 2 or 5 times a power of ten: the smallest with at most `maxTicks` ticks in the
// range. Ticks are multiples k s of the step s, computed from k each time, so errors do not
// accumulate. Numbers have as many decimals as the step. Ends below a thousandth, or of a million
// and more, give numbers such as 5e-6, with as many digits as the step needs.
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

/// The smallest of 1, 2 and 5 times a power of ten that is >= the step.
double roundStep(double step) {
  const double power = std::pow(10, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= step * (1 - kConstant)) return factor * power;
  }
  return 10 * power;
}

/// Powers of ten between which numbers of an axis have decimals instead of an exponent.
constexpr int kMinPower = -3;
constexpr int kMaxPower = 6;

/// The power of ten of the first digit of a positive value.
int powerOf(double value) {
  return static_cast<int>(std::floor(std::log10(value) + kConstant));
}

/// A multiple of the step 10^-decimals on an axis up to the size 10^power. With a true minus sign.
std::string numberText(double value, int decimals, int power) {
  const double size = std::abs(value);
  std::string text = "0";
  if (power >= kMinPower && power < kMaxPower) {
    text = fmt::format("{:.{}f}", size, std::max(0, decimals));
  } else if (size > 0) {
    const int own = powerOf(size);
    const int digits = std::max(0, decimals + own) + 1;
    text = fmt::format("{:.{}g}e{}", size / std::pow(10, own), digits, own);
  }
  return value < 0 ? "\u2212" + text : text;
}

}  // namespace

double Axis::shareOf(double value) const {
  if (isLogarithmic) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

Axis makeAxis(const std::vector<double>& values, int maxTicks) {
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
  return makeAxisWithin(axis.low, axis.high, maxTicks);
}

Axis makeAxisWithin(double low, double high, int maxTicks) {
  Axis axis{low, high, false, {}, {}};
  if (high <= low) return axis;
  const double step = roundStep((high - low) / maxTicks);
  const int decimals = static_cast<int>(std::ceil(-std::log10(step) - kConstant));
  const int power = powerOf(std::max(std::abs(low), std::abs(high)));
  for (double k = std::ceil(low / step - kConstant); k * step <= high * (1 + kConstant); ++k) {
    axis.ticks.push_back(k * step);
    axis.texts.push_back(numberText(k == 0 ? 0 : k * step, decimals, power));
  }
  return axis;
}

Axis makeLogarithmicAxis(const std::vector<double>& values, int maxTicks) {
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
  const int stride = (decades + maxTicks - 1) / maxTicks;
  const int lowest = static_cast<int>(std::lround(std::log10(axis.low)));
  for (int k = 0; k <= decades; k += stride) {
    axis.ticks.push_back(axis.low * std::pow(10, k));
    axis.texts.push_back(fmt::format("1e{}", lowest + k));
  }
  return axis;
}

}  // namespace kirireel::picture
