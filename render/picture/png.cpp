// A PNG (W3C Recommendation, "Portable Network Graphics (PNG) Specification") by libpng. It has
// these chunks:
//
//     IHDR   width, height, 8 bits per channel, RGB or RGBA
//     sRGB   the colour space
//     pHYs   pixels per metre (dots per inch / 0.0254), if a resolution was requested
//     iTXt   Description: author and source, UTF-8
//     IDAT   rows from the top, compressed by zlib
//     IEND
//
// No time is written, so the same picture gives the same bytes.
#include "render/picture/png.h"

#include <cmath>
#include <csetjmp>

#include <fmt/format.h>
#include <png.h>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/base/interruption.h"

namespace kirireel::picture {
namespace {

constexpr double kMetresPerInch = 0.0254;

/// libpng reports errors by a long jump, which must not skip a destructor. So the message is stored
/// here, and encode() has only plain values.
struct Failure {
  std::string message;
};

/// Must not return: libpng would continue as if nothing had happened.
void keepMessageAndJump(png_structp png, png_const_charp message) {
  static_cast<Failure*>(png_get_error_ptr(png))->message = message;
  png_longjmp(png, 1);
}

void appendBytes(png_structp png, png_bytep bytes, png_size_t count) {
  auto* const file = static_cast<std::string*>(png_get_io_ptr(png));
  file->append(reinterpret_cast<const char*>(bytes), count);
}

void ignoreWarning(png_structp /*png*/, png_const_charp /*message*/) {}

/// The writer of libpng, freed at the end of its scope.
class Encoder {
 public:
  explicit Encoder(Failure& failure)
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, &failure, keepMessageAndJump,
                                     ignoreWarning)),
        info_(png_ != nullptr ? png_create_info_struct(png_) : nullptr) {}
  ~Encoder() { png_destroy_write_struct(&png_, &info_); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  bool ready() const { return info_ != nullptr; }
  png_structp png() const { return png_; }
  png_infop info() const { return info_; }

 private:
  png_structp png_;
  png_infop info_;
};

/// Writes everything before the rows. For an opaque picture libpng skips the alpha bytes of the
/// frame.
void writeHeader(png_structp png, png_infop info, const Frame& frame, bool opaque,
                 const PngSettings& settings) {
  png_set_IHDR(png, info, frame.size.width, frame.size.height, 8,
               opaque ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGBA, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  if (settings.dotsPerInch.has_value()) {
    // Rounded up to whole numbers, because journals check the minimum resolution: 300 dots per inch
    // are 11812 per metre.
    constexpr double kRounding = 1e-6;
    const auto dotsPerMetre =
        static_cast<png_uint_32>(std::ceil(*settings.dotsPerInch / kMetresPerInch - kRounding));
    png_set_pHYs(png, info, dotsPerMetre, dotsPerMetre, PNG_RESOLUTION_METER);
  }
  if (!settings.description.empty()) {
    std::string key = "Description", text = settings.description;
    png_text note{};
    note.compression = PNG_ITXT_COMPRESSION_NONE;
    note.key = key.data();
    note.text = text.data();
    png_set_text(png, info, &note, 1);
  }
  png_set_compression_level(png, settings.compressionLevel);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  png_write_info(png, info);
  if (opaque) png_set_filler(png, 0, PNG_FILLER_AFTER);  // skips every alpha byte
}

/// False if libpng failed; the message is then in the encoder's failure.
bool encode(png_structp png, png_infop info, std::string& file, const Frame& frame, bool opaque,
            const PngSettings& settings) {
  // libpng returns here if anything below fails.
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &file, appendBytes, nullptr);
  writeHeader(png, info, frame, opaque, settings);
  for (int y = 0; y < frame.size.height; ++y) {
    // It may throw; the libpng structures belong to the Encoder and are still freed.
    checkInterruption();
    png_write_row(png, frame.pixels.data() + frame.rowStart(y));
  }
  png_write_end(png, info);
  return true;
}

}  // namespace

void writePng(const Frame& frame, const std::filesystem::path& path, const PngSettings& settings) {
  writeTextFile(path, pngBytes(frame, settings));
}

std::string pngBytes(const Frame& frame, const PngSettings& settings) {
  std::string file;
  Failure failure;
  const Encoder encoder(failure);
  if (!encoder.ready() ||
      !encode(encoder.png(), encoder.info(), file, frame, isOpaque(frame), settings)) {
    throw OutputError(fmt::format("error: a picture cannot be encoded ({}); free some memory",
                                  encoder.ready() ? failure.message : "out of memory"));
  }
  return file;
}

std::string pngLibraryVersion() {
  return png_get_libpng_ver(nullptr);
}

}  // namespace kirireel::picture
