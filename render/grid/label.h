/// Text in pictures.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "render/picture/frame.h"

namespace kirireel {

/// Chooses the family of all text from now on, for example "Liberation Sans"; empty: the program's
/// own. Throws InputError when the machine has none of this name. Call it before other threads
/// start.
void setFont(const std::string& family);

/// The font file for labels: that of setFont(), else $KIRIREEL_FONT if set, else DejaVu Sans where
/// Debian, Fedora or Arch keep it. Throws OutputError that names Debian's package when there is
/// none.
std::filesystem::path findFont();

/// The name of that font's family, for example "DejaVu Sans".
std::string fontFamily();

/// Draws lines of text in one size.
class LabelWriter {
 public:
  /// pixelsPerEm: the size of the text, at least 1. Throws OutputError when the font cannot be
  /// read.
  explicit LabelWriter(int pixelsPerEm, const std::filesystem::path& font = findFont());
  ~LabelWriter();
  LabelWriter(const LabelWriter&) = delete;
  LabelWriter& operator=(const LabelWriter&) = delete;

  /// The name of the font's family.
  std::string family() const;

  /// Width of one line of text in UTF-8, pixels. Each character that the font lacks, and any text
  /// that is not UTF-8, counts and is drawn as the font's box. Rounded up.
  int width(const std::string& text) const;

  /// The first character that the font lacks; absent when it has them all.
  std::optional<char32_t> missingGlyph(const std::u32string& text) const;

  /// Draws one line of text in UTF-8: its pen starts at x, its letters stand on row `baseline`.
  /// What falls outside the frame is left out.
  void draw(Frame& frame, const std::string& text, int x, int baseline, Colour colour) const;

 private:
  struct Face;
  std::unique_ptr<Face> face_;
};

/// Throws InputError that names the option when a text is not UTF-8 or has a character that the
/// font lacks, and OutputError when the font is missing. Line feeds are allowed.
void requireDrawable(const char* option, const std::string& text);

}  // namespace kirireel
