// Cairo (cairographics.org) draws a page once, on a PDF or on an image surface; both share all of
// the drawing. Units are the pixels of the settings, scaled to points (1/72 inch) in a PDF. Strokes
// have round joins and end where their lines do.
//
// Antialiasing leaves hairlines between polygons side by side, because each covers a part of the
// pixel and the background shines through; polygons are therefore also stroked in their own colour,
// by 0.3 pixels or more.
//
// A PDF holds a date; a fixed one is set, so that the same page gives the same bytes. Cairo's own
// version stands in the file all the same.
#include "render/vector/cairo_canvas.h"

#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include <cairo-pdf.h>
#include <fmt/format.h>

#include "render/png/png.h"
#include "render/vector/svg.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr double kPointsPerInch = 72;

/// Called by Cairo with each piece of the file.
cairo_status_t appendBytes(void* file, const unsigned char* bytes, unsigned count) {
  static_cast<std::string*>(file)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

/// Cairo keeps the first error of a surface and draws nothing afterwards, so it is enough to ask at
/// the end.
void requireDrawn(cairo_surface_t* surface, const char* what) {
  const cairo_status_t status = cairo_surface_status(surface);
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw OutputError(
      fmt::format("error: Cairo cannot write the {} ({})", what, cairo_status_to_string(status)));
}

/// A pixel of Cairo's without the factor of its alpha.
Colour straightColour(std::uint32_t pixel) {
  const std::uint32_t alpha = pixel >> 24;
  const auto channel = [&](int shift) {
    const std::uint32_t value = pixel >> shift & 255;
    return static_cast<std::uint8_t>(alpha == 0 ? 0 : (255 * value + alpha / 2) / alpha);
  };
  return {channel(16), channel(8), channel(0), static_cast<std::uint8_t>(alpha)};
}

/// What both have in common: how Cairo draws.
class CairoCanvas : public Canvas {
 public:
  ~CairoCanvas() override;
  CairoCanvas(const CairoCanvas&) = delete;
  CairoCanvas& operator=(const CairoCanvas&) = delete;

  void begin(const std::string& name, double opacity = 1) override;
  void beginWithin(const std::string& name, double left, double upper, double width,
                   double height) override;
  void end() override;
  void polygon(const Points& corners, Colour colour) override;
  void seams(const std::vector<Points>& lines, Colour colour) override;
  void outlines(const std::vector<Points>& lines, bool pale) override;
  void lines(const std::vector<Points>& lines, double width, Colour colour) override;
  void box(double left, double upper, double width, double height, Colour colour) override;
  void text(const std::string& line, double left, double baseline, int em, Colour colour) override;

 protected:
  struct Internals;
  CairoCanvas();

  std::unique_ptr<Internals> internals_;  ///< made by the constructors below
};

/// Destroyed before the bytes that the surface writes into.
struct CairoCanvas::Internals {
  cairo_surface_t* surface = nullptr;
  cairo_t* pen = nullptr;
  Colour outline;
  Colour paleOutline;
  double outlineWidth = 1;
  double seam = 0;
  double cutSeam = 0;
  std::vector<double> opacities;  ///< of the parts that are open

  /// Takes the surface, on which `scale` units are a pixel of the settings.
  Internals(cairo_surface_t* made, double scale, const PageSettings& settings)
      : surface(made),
        pen(cairo_create(made)),
        outline(settings.outline),
        paleOutline(settings.paleOutline),
        outlineWidth(settings.outlineWidth),
        seam(seamWidth(settings)),
        cutSeam(cutSeamWidth(settings)) {
    cairo_scale(pen, scale, scale);
    cairo_set_line_join(pen, CAIRO_LINE_JOIN_ROUND);
    cairo_select_font_face(pen, settings.fontFamily.c_str(), CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_NORMAL);
    if (settings.background.alpha == 0) return;
    choose(settings.background);
    cairo_rectangle(pen, 0, 0, settings.size.width, settings.size.height);
    cairo_fill(pen);
  }
  Internals(const Internals&) = delete;
  Internals& operator=(const Internals&) = delete;
  ~Internals() {
    cairo_destroy(pen);
    cairo_surface_destroy(surface);
  }

  void choose(Colour colour) const {
    cairo_set_source_rgba(pen, colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0,
                          colour.alpha / 255.0);
  }

  void trace(const Points& points) const {
    cairo_new_sub_path(pen);
    for (const Eigen::Vector2d& point : points) cairo_line_to(pen, point.x(), point.y());
  }

  void stroke(const std::vector<Points>& lines, double width) const {
    cairo_set_line_width(pen, width);
    for (const Points& line : lines) {
      trace(line);
      if (line.size() > 2 && line.front() == line.back()) cairo_close_path(pen);
    }
    cairo_stroke(pen);
  }
};

CairoCanvas::CairoCanvas() = default;

CairoCanvas::~CairoCanvas() = default;

/// A part with opacity is drawn aside as a group and painted at once, so that what overlaps in it
/// is not darker.
void CairoCanvas::begin(const std::string&, double opacity) {
  cairo_save(internals_->pen);
  if (opacity < 1) cairo_push_group(internals_->pen);
  internals_->opacities.push_back(opacity);
}

/// The clip ends with the part, by cairo_restore.
void CairoCanvas::beginWithin(const std::string& name, double left, double upper, double width,
                              double height) {
  begin(name);
  cairo_rectangle(internals_->pen, left, upper, width, height);
  cairo_clip(internals_->pen);
}

void CairoCanvas::end() {
  const double opacity = internals_->opacities.back();
  internals_->opacities.pop_back();
  if (opacity < 1) {
    cairo_pop_group_to_source(internals_->pen);
    cairo_paint_with_alpha(internals_->pen, opacity);
  }
  cairo_restore(internals_->pen);
}

/// Filled and stroked in one colour: the stroke covers the hairline to its neighbours.
void CairoCanvas::polygon(const Points& corners, Colour colour) {
  cairo_t* pen = internals_->pen;
  internals_->choose(colour);
  internals_->trace(corners);
  cairo_close_path(pen);
  cairo_fill_preserve(pen);
  cairo_set_line_width(pen, internals_->seam);
  cairo_stroke(pen);
}

void CairoCanvas::seams(const std::vector<Points>& lines, Colour colour) {
  internals_->choose(colour);
  internals_->stroke(lines, internals_->cutSeam);
}

void CairoCanvas::outlines(const std::vector<Points>& lines, bool pale) {
  internals_->choose(pale ? internals_->paleOutline : internals_->outline);
  internals_->stroke(lines, internals_->outlineWidth);
}

void CairoCanvas::lines(const std::vector<Points>& lines, double width, Colour colour) {
  internals_->choose(colour);
  internals_->stroke(lines, width);
}

void CairoCanvas::box(double left, double upper, double width, double height, Colour colour) {
  internals_->choose(colour);
  cairo_rectangle(internals_->pen, left, upper, width, height);
  cairo_fill(internals_->pen);
}

/// Cairo's simple interface for text: no shaping beyond single glyphs.
void CairoCanvas::text(const std::string& line, double left, double baseline, int em,
                       Colour colour) {
  internals_->choose(colour);
  cairo_set_font_size(internals_->pen, em);
  cairo_move_to(internals_->pen, left, baseline);
  cairo_show_text(internals_->pen, line.c_str());
}

/// One page of width x height pixels at the settings' resolution.
class PdfCanvas : public CairoCanvas {
 public:
  explicit PdfCanvas(const PageSettings& settings);
  ~PdfCanvas() override;

  std::string finish() override;

 private:
  std::unique_ptr<std::string> file_;  ///< that Cairo writes into
};

PdfCanvas::PdfCanvas(const PageSettings& settings) : file_(std::make_unique<std::string>()) {
  const double points = kPointsPerInch / settings.pixelsPerInch;
  cairo_surface_t* surface = cairo_pdf_surface_create_for_stream(
      appendBytes, file_.get(), settings.size.width * points, settings.size.height * points);
  // Dates would make each run's bytes different.
  cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
  cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_SUBJECT, settings.description.c_str());
  internals_ = std::make_unique<Internals>(surface, points, settings);
}

PdfCanvas::~PdfCanvas() {
  // Cairo writes its last bytes when the surface goes.
  internals_.reset();
}

std::string PdfCanvas::finish() {
  cairo_surface_finish(internals_->surface);
  requireDrawn(internals_->surface, "PDF");
  return std::move(*file_);
}

/// Cairo's pixels are 32-bit words with premultiplied alpha.
class PngCanvas : public CairoCanvas {
 public:
  explicit PngCanvas(const PageSettings& settings);

  std::string finish() override;

 private:
  PageSettings settings_;
};

PngCanvas::PngCanvas(const PageSettings& settings) : settings_(settings) {
  cairo_surface_t* surface =
      cairo_image_surface_create(CAIRO_FORMAT_ARGB32, settings.size.width, settings.size.height);
  internals_ = std::make_unique<Internals>(surface, 1, settings);
}

std::string PngCanvas::finish() {
  cairo_surface_flush(internals_->surface);
  requireDrawn(internals_->surface, "picture");
  const std::uint8_t* rows = cairo_image_surface_get_data(internals_->surface);
  const int stride = cairo_image_surface_get_stride(internals_->surface);
  Frame frame = makeFrame(settings_.size, settings_.background);
  for (int y = 0; y < settings_.size.height; ++y) {
    for (int x = 0; x < settings_.size.width; ++x) {
      std::uint32_t pixel = 0;  // alpha, red, green, blue from the highest byte on; premultiplied
      std::memcpy(&pixel, rows + y * stride + 4 * x, sizeof pixel);
      frame.set(x, y, straightColour(pixel));
    }
  }
  return pngBytes(frame,
                  {.dotsPerInch = settings_.pixelsPerInch, .description = settings_.description});
}

}  // namespace

std::unique_ptr<Canvas> makePdfCanvas(const PageSettings& settings) {
  return std::make_unique<PdfCanvas>(settings);
}

std::unique_ptr<Canvas> makePngCanvas(const PageSettings& settings) {
  return std::make_unique<PngCanvas>(settings);
}

std::unique_ptr<Canvas> makeCanvas(PageFormat format, const PageSettings& settings) {
  switch (format) {
    case PageFormat::Svg:
      return makeSvgCanvas(settings);
    case PageFormat::Pdf:
      return makePdfCanvas(settings);
    case PageFormat::Png:
      break;
  }
  return makePngCanvas(settings);
}

}  // namespace kirireel
