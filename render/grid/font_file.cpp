// Asks fontconfig (fontconfig.org, Developers Reference) for the best match of a family, and takes
// it only when the match bears that name: fontconfig always finds something, and a figure in
// another font than the one that was asked for would go unnoticed.
#include "render/grid/font_file.h"

#include <memory>

#include <fmt/format.h>
#include <fontconfig/fontconfig.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

struct FreePattern {
  void operator()(FcPattern* pattern) const { FcPatternDestroy(pattern); }
};
using OwnedPattern = std::unique_ptr<FcPattern, FreePattern>;

/// "" where there is none.
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

std::filesystem::path fontFile(const std::string& family) {
  const auto* name = reinterpret_cast<const FcChar8*>(family.c_str());
  const OwnedPattern wanted(FcPatternCreate());
  FcPatternAddString(wanted.get(), FC_FAMILY, name);
  FcPatternAddBool(wanted.get(), FC_SCALABLE, FcTrue);
  FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
  FcDefaultSubstitute(wanted.get());
  FcResult result = FcResultNoMatch;
  const OwnedPattern font(FcFontMatch(nullptr, wanted.get(), &result));
  if (font && hasFamily(font.get(), name)) return textOf(font.get(), FC_FILE);
  const std::string nearest = font ? textOf(font.get(), FC_FAMILY) : "";
  throw InputError(fmt::format(
      "error: this machine has no font \"{}\"; install it, or give a family that fc-list names{}",
      family, nearest.empty() ? "" : fmt::format(", the nearest is \"{}\"", nearest)));
}

}  // namespace kirireel
