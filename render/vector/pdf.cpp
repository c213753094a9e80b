#include "render/vector/pdf.h"

#include <cairo-pdf.h>
#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr double kPointsPerInch = 72;

cairo_status_t appendBytes(void* file, const unsigned char* bytes, unsigned count) {
  static_cast<std::string*>(file)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

struct PdfCanvas::Internals {
  std::string file;
  cairo_surface_t* surface = nullptr;
  cairo_t* pen = nullptr;
  Colour outline;
  double outlineWidth = 1;
  double seam = 0;
  double cutSeam = 0;
  std::vector<double> opacities;  ///< of the parts that are open

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

PdfCanvas::PdfCanvas(const PageSettings& settings) : internals_(std::make_unique<Internals>()) {
  Internals& page = *internals_;
  const double points = kPointsPerInch / settings.pixelsPerInch;
  page.surface = cairo_pdf_surface_create_for_stream(
      appendBytes, &page.file, settings.size.width * points, settings.size.height * points);
  // Dates would make each run's bytes different.
  cairo_pdf_surface_set_metadata(page.surface, CAIRO_PDF_METADATA_CREATE_DATE,
                                 "2000-01-01T00:00:00Z");
  cairo_pdf_surface_set_metadata(page.surface, CAIRO_PDF_METADATA_SUBJECT,
                                 settings.description.c_str());
  page.pen = cairo_create(page.surface);
  cairo_scale(page.pen, points, points);
  cairo_set_line_join(page.pen, CAIRO_LINE_JOIN_ROUND);
  cairo_select_font_face(page.pen, settings.fontFamily.c_str(), CAIRO_FONT_SLANT_NORMAL,
                         CAIRO_FONT_WEIGHT_NORMAL);
  page.outline = settings.outline;
  page.outlineWidth = settings.outlineWidth;
  page.seam = seamWidth(settings);
  page.cutSeam = cutSeamWidth(settings);
  if (settings.background.alpha == 0) return;
  box(0, 0, settings.size.width, settings.size.height, settings.background);
}

PdfCanvas::~PdfCanvas() = default;

void PdfCanvas::begin(const std::string&, double opacity) {
  cairo_save(internals_->pen);
  if (opacity < 1) cairo_push_group(internals_->pen);
  internals_->opacities.push_back(opacity);
}

void PdfCanvas::beginWithin(const std::string& name, double left, double upper, double width,
                            double height) {
  begin(name);
  cairo_rectangle(internals_->pen, left, upper, width, height);
  cairo_clip(internals_->pen);
}

void PdfCanvas::end() {
  const double opacity = internals_->opacities.back();
  internals_->opacities.pop_back();
  if (opacity < 1) {
    cairo_pop_group_to_source(internals_->pen);
    cairo_paint_with_alpha(internals_->pen, opacity);
  }
  cairo_restore(internals_->pen);
}

void PdfCanvas::polygon(const Points& corners, Colour colour) {
  cairo_t* pen = internals_->pen;
  internals_->choose(colour);
  internals_->trace(corners);
  cairo_close_path(pen);
  cairo_fill_preserve(pen);
  cairo_set_line_width(pen, internals_->seam);
  cairo_stroke(pen);
}

void PdfCanvas::seams(const std::vector<Points>& lines, Colour colour) {
  internals_->choose(colour);
  internals_->stroke(lines, internals_->cutSeam);
}

void PdfCanvas::outlines(const std::vector<Points>& lines) {
  internals_->choose(internals_->outline);
  internals_->stroke(lines, internals_->outlineWidth);
}

void PdfCanvas::box(double left, double upper, double width, double height, Colour colour) {
  internals_->choose(colour);
  cairo_rectangle(internals_->pen, left, upper, width, height);
  cairo_fill(internals_->pen);
}

void PdfCanvas::text(const std::string& line, double left, double baseline, int em, Colour colour) {
  internals_->choose(colour);
  cairo_set_font_size(internals_->pen, em);
  cairo_move_to(internals_->pen, left, baseline);
  cairo_show_text(internals_->pen, line.c_str());
}

std::string PdfCanvas::finish() {
  cairo_surface_finish(internals_->surface);
  const cairo_status_t status = cairo_surface_status(internals_->surface);
  if (status != CAIRO_STATUS_SUCCESS) {
    throw OutputError(
        fmt::format("error: Cairo cannot write the PDF ({})", cairo_status_to_string(status)));
  }
  return std::move(internals_->file);
}

}  // namespace kirireel
