// SVG 1.1 (W3C Recommendation) as text: the root with its size, <desc>, one <style> with classes
// for faces, seams, outlines and text, then groups. A top-level group is a layer in Inkscape
// (inkscape:groupmode="layer"), which other programs ignore. Coordinates have two decimals of a
// pixel, which at 300 dots per inch is a micrometre in print.
//
// Shapes are paths "M x y L x y ... Z" with the fill of their face. Only the style sheet has the
// line style, so an editor can change all outlines at once. Text stays text in the font of that
// name; a reader without the font uses Arial or Helvetica. Programs shape text themselves, so a
// line has its characters in reading order.
#include "render/picture/canvas.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include <cairo-ft.h>
#include <cairo-pdf.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/picture/picture_geometry.h"
#include "render/picture/png.h"
#include "sim/base/error.h"
#include "sim/base/interruption.h"

namespace kirireel::picture {
namespace {

/// Alpha is written separately, as an opacity.
std::string hex(Colour colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
}

/// A length on the page: pixels for screens, else millimetres.
std::string lengthOf(int pixels, const PageSettings& settings) {
  if (settings.pixelsPerInch == PageSettings().pixelsPerInch) return fmt::format("{}", pixels);
  return fmt::format("{:.6g}mm", pixels * 25.4 / settings.pixelsPerInch);
}

/// Empty for opaque colours, the most frequent case.
std::string opacityText(double opacity) {
  return opacity < 1 ? fmt::format(" opacity=\"{:.4g}\"", opacity) : std::string();
}

std::string opacityText(Colour colour) {
  return opacityText(colour.alpha / 255.0);
}

/// A text between tags.
std::string escaped(const std::string& text) {
  std::string safe;
  for (const char letter : text) {
    if (letter == '&')
      safe += "&amp;";
    else if (letter == '<')
      safe += "&lt;";
    else if (letter == '>')
      safe += "&gt;";
    else
      safe += letter;
  }
  return safe;
}

/// "M" for the first point, "L" for the others; not closed.
std::string pathOf(const Canvas::Points& points) {
  std::string path;
  for (const Eigen::Vector2d& point : points) {
    path += fmt::format("{}{:.2f} {:.2f}", path.empty() ? "M" : "L", point.x(), point.y());
  }
  return path;
}

/// Whether its last point equals its first.
bool isClosed(const Canvas::Points& line) {
  return line.size() > 2 && line.front() == line.back();
}

std::string pathOf(const std::vector<Canvas::Points>& lines) {
  std::string path;
  for (const Canvas::Points& line : lines) {
    path +=
        isClosed(line) ? pathOf(Canvas::Points(line.begin(), line.end() - 1)) + "Z" : pathOf(line);
  }
  return path;
}

/// Size at which text for pages is shaped, pixels per em: at this size hinting moves glyphs by less
/// than a thousandth of the em.
constexpr int kShapingSize = 2048;

/// Lengths are for kShapingSize.
ShapedLine shapeForPage(const std::string& line, Weight weight) {
  return LabelWriter(kShapingSize, findFont(weight)).shape(line);
}

/// The families of a line with fallback fonts; empty for the main font only.
std::string fallbackStyle(const ShapedLine& line, const std::string& family) {
  std::vector<std::string> families = {family};
  for (const TextRun& run : line.runs) {
    if (std::ranges::find(families, run.family) == families.end()) families.push_back(run.family);
  }
  if (families.size() == 1) return {};
  return fmt::format(" style=\"font-family: '{}', sans-serif\"", fmt::join(families, "', '"));
}

class SvgCanvas : public Canvas {
 public:
  explicit SvgCanvas(const PageSettings& settings);

  void begin(const std::string& name, double opacity = 1) override;
  void beginWithin(const std::string& name, double left, double upper, double width,
                   double height) override;
  void end() override;
  void setOutlines(const OutlineStyle& style) override;
  void polygon(const Points& corners, Colour colour) override;
  void seams(const std::vector<Points>& lines, Colour colour) override;
  void outlines(const std::vector<Points>& lines, Line kind, double opacity) override;
  void lines(const std::vector<Points>& lines, double width, Colour colour) override;
  void box(double left, double upper, double width, double height, Colour colour) override;
  void text(const std::string& line, double left, double baseline, int em, Colour colour,
            Weight weight) override;

  double silhouetteWidth() const override { return parts_.back().silhouetteWidth; }
  std::string finish() override;

 private:
  template <typename... Arguments>
  void append(fmt::format_string<Arguments...> form, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(file_), form, std::forward<Arguments>(arguments)...);
  }

  /// Rules of a style sheet for the elements in `scope`, a selector with a space after it.
  void appendRules(const OutlineStyle& style, const std::string& scope);
  void open(const std::string& name);

  /// An open group; the first one is the page.
  struct SvgGroup {
    std::string name;
    double silhouetteWidth;
  };

  std::string file_;
  std::string fontFamily_;
  std::vector<SvgGroup> parts_;
  int clips_ = 0;
};

SvgCanvas::SvgCanvas(const PageSettings& settings)
    : fontFamily_(settings.fontFamily), parts_{{"", settings.outlines.silhouetteWidth}} {
  append(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" width=\"{}\" height=\"{}\" "
      "viewBox=\"0 0 {} {}\">\n",
      lengthOf(settings.size.width, settings), lengthOf(settings.size.height, settings),
      settings.size.width, settings.size.height);
  if (!settings.description.empty()) append("<desc>{}</desc>\n", escaped(settings.description));
  append("<style>\n");
  appendRules(settings.outlines, "");
  append(
      "text {{ font-family: \"{}\", \"Arial\", \"Helvetica\", sans-serif }}\n"
      "</style>\n",
      settings.fontFamily);
  if (settings.background.alpha == 0) return;
  begin("page");
  box(0, 0, settings.size.width, settings.size.height, settings.background);
  end();
}

void SvgCanvas::appendRules(const OutlineStyle& style, const std::string& scope) {
  append(
      "{0}.face {{ stroke-width: {1:.3g}; stroke-linejoin: round }}\n"
      "{0}.seam {{ fill: none; stroke-width: {2:.3g} }}\n"
      "{0}.outline {{ fill: none; stroke: {3}; stroke-width: {4:.4g}; stroke-linejoin: round; "
      "stroke-linecap: round }}\n"
      "{0}.silhouette {{ stroke-width: {5:.4g} }}\n",
      scope, seamWidth(style), cutSeamWidth(style), hex(style.colour), style.slitWidth,
      style.silhouetteWidth);
}

void SvgCanvas::setOutlines(const OutlineStyle& style) {
  append("<style>\n");
  appendRules(style, '#' + parts_.back().name + ' ');
  append("</style>\n");
  parts_.back().silhouetteWidth = style.silhouetteWidth;
}

void SvgCanvas::open(const std::string& name) {
  parts_.push_back({name, silhouetteWidth()});
}

void SvgCanvas::begin(const std::string& name, double opacity) {
  append("<g id=\"{0}\" inkscape:label=\"{0}\"{1}{2}>\n", name,
         parts_.size() == 1 ? " inkscape:groupmode=\"layer\"" : "", opacityText(opacity));
  open(name);
}

void SvgCanvas::beginWithin(const std::string& name, double left, double upper, double width,
                            double height) {
  append(
      "<clipPath id=\"clip_{0}\"><rect x=\"{1:.2f}\" y=\"{2:.2f}\" width=\"{3:.2f}\" "
      "height=\"{4:.2f}\"/></clipPath>\n<g id=\"{5}\" inkscape:label=\"{5}\" "
      "clip-path=\"url(#clip_{0})\">\n",
      ++clips_, left, upper, width, height, name);
  open(name);
}

void SvgCanvas::end() {
  append("</g>\n");
  parts_.pop_back();
}

void SvgCanvas::polygon(const Points& corners, Colour colour) {
  append("<path class=\"face\" fill=\"{0}\" stroke=\"{0}\"{1} d=\"{2}Z\"/>\n", hex(colour),
         opacityText(colour), pathOf(corners));
}

void SvgCanvas::seams(const std::vector<Points>& lines, Colour colour) {
  const std::string path = pathOf(lines);
  if (path.empty()) return;
  append("<path class=\"seam\" stroke=\"{}\" d=\"{}\"/>\n", hex(colour), path);
}

void SvgCanvas::outlines(const std::vector<Points>& lines, Line kind, double opacity) {
  const std::string path = pathOf(lines);
  if (path.empty()) return;
  append("<path class=\"outline{}\"{} d=\"{}\"/>\n", kind == Line::Silhouette ? " silhouette" : "",
         opacityText(opacity), path);
}

void SvgCanvas::lines(const std::vector<Points>& lines, double width, Colour colour) {
  const std::string path = pathOf(lines);
  if (path.empty()) return;
  append(
      "<path fill=\"none\" stroke=\"{}\" stroke-width=\"{:.3g}\" stroke-linejoin=\"round\" "
      "d=\"{}\"/>\n",
      hex(colour), width, path);
}

void SvgCanvas::box(double left, double upper, double width, double height, Colour colour) {
  append("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"{}/>\n",
         left, upper, width, height, hex(colour), opacityText(colour));
}

void SvgCanvas::text(const std::string& line, double left, double baseline, int em, Colour colour,
                     Weight weight) {
  if (line.empty()) return;
  const ShapedLine shaped = shapeForPage(line, weight);
  // From right to left, a line ends at its left end.
  append("<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{}\"{}{}{} fill=\"{}\">{}</text>\n", left,
         baseline, em, weight == Weight::Bold ? " font-weight=\"bold\"" : "",
         shaped.isRightToLeft ? " direction=\"rtl\" text-anchor=\"end\"" : "",
         fallbackStyle(shaped, fontFamily_), hex(colour), escaped(line));
}

std::string SvgCanvas::finish() {
  return file_ + "</svg>\n";
}

}  // namespace

int pixelsOf(double millimetres, double dotsPerInch) {
  return static_cast<int>(std::ceil(millimetres / kMillimetresPerInch * dotsPerInch - 1e-6));
}

int emOf(double points, double dotsPerInch) {
  return std::max(1, static_cast<int>(std::lround(points / kPointsPerInch * dotsPerInch)));
}

std::unique_ptr<Canvas> makeSvgCanvas(const PageSettings& settings) {
  return std::make_unique<SvgCanvas>(settings);
}

// ------------------------------------------------------------------------------------------------
// Cairo (cairographics.org) draws a page to a PDF or an image surface with the same code. Units are
// the pixels of the settings, scaled to points (1/72 inch) in a PDF. Strokes have round joins and
// end at the ends of their lines.
//
// Antialiasing leaves hairlines between adjacent polygons, because each covers a part of the pixel
// and the background is visible. Polygons are therefore also stroked in their own colour with a
// width of at least 0.3 pixels.
//
// A PDF contains a date. A fixed date makes equal pages have equal bytes. The file still contains
// Cairo's version.

namespace {

/// Called by Cairo with each piece of the file.
cairo_status_t appendBytes(void* file, const unsigned char* bytes, unsigned count) {
  static_cast<std::string*>(file)->append(reinterpret_cast<const char*>(bytes), count);
  return CAIRO_STATUS_SUCCESS;
}

/// Cairo keeps the first error of a surface and draws nothing afterwards, so one check at the end
/// is sufficient.
void requireDrawn(cairo_surface_t* surface, const char* what) {
  const cairo_status_t status = cairo_surface_status(surface);
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw OutputError(
      fmt::format("error: Cairo cannot write the {} ({})", what, cairo_status_to_string(status)));
}

/// Converts a pixel of Cairo from premultiplied alpha.
Colour straightColour(std::uint32_t pixel) {
  const std::uint32_t alpha = pixel >> 24;
  const auto channel = [&](int shift) {
    const std::uint32_t value = pixel >> shift & 255;
    return static_cast<std::uint8_t>(alpha == 0 ? 0 : (255 * value + alpha / 2) / alpha);
  };
  return {channel(16), channel(8), channel(0), static_cast<std::uint8_t>(alpha)};
}

/// Common drawing code with Cairo.
class CairoCanvas : public Canvas {
 public:
  ~CairoCanvas() override;
  CairoCanvas(const CairoCanvas&) = delete;
  CairoCanvas& operator=(const CairoCanvas&) = delete;

  void begin(const std::string& name, double opacity = 1) override;
  void beginWithin(const std::string& name, double left, double upper, double width,
                   double height) override;
  void end() override;
  void setOutlines(const OutlineStyle& style) override;
  void polygon(const Points& corners, Colour colour) override;
  void seams(const std::vector<Points>& lines, Colour colour) override;
  void outlines(const std::vector<Points>& lines, Line kind, double opacity) override;
  void lines(const std::vector<Points>& lines, double width, Colour colour) override;
  void box(double left, double upper, double width, double height, Colour colour) override;
  void text(const std::string& line, double left, double baseline, int em, Colour colour,
            Weight weight) override;
  double silhouetteWidth() const override;

 protected:
  struct Internals;
  CairoCanvas();

  std::unique_ptr<Internals> internals_;  ///< made by the constructors below
};

/// Destroyed before the bytes that the surface writes to.
struct CairoCanvas::Internals {
  cairo_surface_t* surface = nullptr;
  cairo_t* pen = nullptr;
  /// An open part; the first one is the page.
  struct CairoPart {
    double opacity;
    OutlineStyle outlines;
  };
  std::vector<CairoPart> parts;
  std::string fontFamily;
  std::map<FontFile, cairo_font_face_t*> fonts;  ///< of shaped text

  /// Owns the surface, on which `scale` units are a pixel of the settings.
  Internals(cairo_surface_t* made, double scale, const PageSettings& settings)
      : surface(made),
        pen(cairo_create(made)),
        parts{{1, settings.outlines}},
        fontFamily(settings.fontFamily) {
    cairo_scale(pen, scale, scale);
    cairo_set_line_join(pen, CAIRO_LINE_JOIN_ROUND);
    if (settings.background.alpha == 0) return;
    choose(settings.background);
    cairo_rectangle(pen, 0, 0, settings.size.width, settings.size.height);
    cairo_fill(pen);
  }
  Internals(const Internals&) = delete;
  Internals& operator=(const Internals&) = delete;
  ~Internals() {
    for (const auto& [file, font] : fonts) cairo_font_face_destroy(font);
    cairo_destroy(pen);
    cairo_surface_destroy(surface);
  }

  const OutlineStyle& outlines() const { return parts.back().outlines; }

  void choose(Colour colour) const {
    cairo_set_source_rgba(pen, colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0,
                          colour.alpha / 255.0);
  }

  cairo_font_face_t* fontOf(const FontFile& file) {
    cairo_font_face_t*& font = fonts[file];
    if (font == nullptr) {
      font =
          cairo_ft_font_face_create_for_pattern(static_cast<FcPattern*>(fontPattern(file).get()));
    }
    return font;
  }

  /// A run's glyphs with their characters, which a PDF stores for searches and copies. They are
  /// from left to right, as readers of PDF expect, which restore the reading order.
  void show(const TextRun& run, double left, double baseline, int em) {
    const double scale = static_cast<double>(em) / kShapingSize;
    std::vector<cairo_glyph_t> glyphs;
    for (const PlacedGlyph& glyph : run.glyphs) {
      glyphs.push_back({glyph.number, left + scale * glyph.x, baseline + scale * glyph.y});
    }
    std::string text;
    std::vector<cairo_text_cluster_t> clusters;
    for (const GlyphCluster& cluster : run.clusters) {
      text += cluster.text;
      clusters.push_back({static_cast<int>(cluster.text.size()), cluster.glyphs});
    }
    cairo_set_font_face(pen, fontOf(run.font));
    cairo_set_font_size(pen, em);
    cairo_show_text_glyphs(pen, text.data(), static_cast<int>(text.size()), glyphs.data(),
                           static_cast<int>(glyphs.size()), clusters.data(),
                           static_cast<int>(clusters.size()),
                           static_cast<cairo_text_cluster_flags_t>(0));
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

/// A part with opacity is drawn separately as a group and painted at once, so its overlaps are not
/// darker.
void CairoCanvas::begin(const std::string&, double opacity) {
  cairo_save(internals_->pen);
  if (opacity < 1) cairo_push_group(internals_->pen);
  internals_->parts.push_back({opacity, internals_->outlines()});
}

/// The clip ends with the part, by cairo_restore.
void CairoCanvas::beginWithin(const std::string& name, double left, double upper, double width,
                              double height) {
  begin(name);
  cairo_rectangle(internals_->pen, left, upper, width, height);
  cairo_clip(internals_->pen);
}

void CairoCanvas::end() {
  const double opacity = internals_->parts.back().opacity;
  internals_->parts.pop_back();
  if (opacity < 1) {
    cairo_pop_group_to_source(internals_->pen);
    cairo_paint_with_alpha(internals_->pen, opacity);
  }
  cairo_restore(internals_->pen);
}

/// Filled and stroked in one colour: the stroke covers the hairline to its neighbours. The combined
/// opacity is that of the colour.
void CairoCanvas::polygon(const Points& corners, Colour colour) {
  if (colour.alpha < 255) {
    begin({}, colour.alpha / 255.0);
    polygon(corners, {colour.red, colour.green, colour.blue});
    end();
    return;
  }
  cairo_t* pen = internals_->pen;
  internals_->choose(colour);
  internals_->trace(corners);
  cairo_close_path(pen);
  cairo_fill_preserve(pen);
  cairo_set_line_width(pen, seamWidth(internals_->outlines()));
  cairo_stroke(pen);
}

void CairoCanvas::seams(const std::vector<Points>& lines, Colour colour) {
  internals_->choose(colour);
  internals_->stroke(lines, cutSeamWidth(internals_->outlines()));
}

void CairoCanvas::setOutlines(const OutlineStyle& style) {
  internals_->parts.back().outlines = style;
}

double CairoCanvas::silhouetteWidth() const {
  return internals_->outlines().silhouetteWidth;
}

void CairoCanvas::outlines(const std::vector<Points>& lines, Line kind, double opacity) {
  const OutlineStyle& style = internals_->outlines();
  Colour colour = style.colour;
  colour.alpha = static_cast<std::uint8_t>(std::lround(opacity * colour.alpha));
  internals_->choose(colour);
  cairo_set_line_cap(internals_->pen, CAIRO_LINE_CAP_ROUND);
  internals_->stroke(lines, kind == Line::Slit ? style.slitWidth : style.silhouetteWidth);
  cairo_set_line_cap(internals_->pen, CAIRO_LINE_CAP_BUTT);
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

/// Cairo's simple text interface has no shaping, so it draws plain lines only.
void CairoCanvas::text(const std::string& line, double left, double baseline, int em, Colour colour,
                       Weight weight) {
  internals_->choose(colour);
  const ShapedLine shaped = shapeForPage(line, weight);
  if (!shaped.isPlain) {
    for (const TextRun& run : shaped.runs) internals_->show(run, left, baseline, em);
    return;
  }
  cairo_select_font_face(
      internals_->pen, internals_->fontFamily.c_str(), CAIRO_FONT_SLANT_NORMAL,
      weight == Weight::Bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
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
  std::unique_ptr<std::string> file_;  ///< output of Cairo
};

PdfCanvas::PdfCanvas(const PageSettings& settings) : file_(std::make_unique<std::string>()) {
  const double points = kPointsPerInch / settings.pixelsPerInch;
  cairo_surface_t* surface = cairo_pdf_surface_create_for_stream(
      appendBytes, file_.get(), settings.size.width * points, settings.size.height * points);
  // Real dates would make the bytes of each run different.
  cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
  cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_SUBJECT, settings.description.c_str());
  internals_ = std::make_unique<Internals>(surface, points, settings);
}

PdfCanvas::~PdfCanvas() {
  // Cairo writes its last bytes when the surface is destroyed.
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
  /// The pixels drawn so far. Throws OutputError.
  Frame frame() const;

 private:
  PageSettings settings_;
};

PngCanvas::PngCanvas(const PageSettings& settings) : settings_(settings) {
  cairo_surface_t* surface =
      cairo_image_surface_create(CAIRO_FORMAT_ARGB32, settings.size.width, settings.size.height);
  internals_ = std::make_unique<Internals>(surface, 1, settings);
}

std::string PngCanvas::finish() {
  return pngBytes(frame(),
                  {.dotsPerInch = settings_.pixelsPerInch, .description = settings_.description});
}

Frame PngCanvas::frame() const {
  cairo_surface_flush(internals_->surface);
  requireDrawn(internals_->surface, "picture");
  const std::uint8_t* rows = cairo_image_surface_get_data(internals_->surface);
  const int stride = cairo_image_surface_get_stride(internals_->surface);
  Frame frame = makeFrame(settings_.size, settings_.background);
  for (int y = 0; y < settings_.size.height; ++y) {
    for (int x = 0; x < settings_.size.width; ++x) {
      std::uint32_t pixel = 0;  // alpha, red, green, blue from the highest byte; premultiplied
      std::memcpy(&pixel, rows + y * stride + 4 * x, sizeof pixel);
      frame.set(x, y, straightColour(pixel));
    }
  }
  return frame;
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

Frame drawnPage(const PageSettings& settings, const std::function<void(Canvas&)>& draw) {
  PngCanvas canvas(settings);
  draw(canvas);
  return canvas.frame();
}

// ------------------------------------------------------------------------------------------------
// Faces are painted in the order of farthestFirst(), each filled completely and closed along its
// cuts. The visible parts of their own sides (visibleOutlines()) are drawn over all of them as
// lines of constant width. Sides that come from cutting are not drawn.

namespace {

/// Projects points of space to the picture.
class Projector {
 public:
  Projector(const Camera& camera, FrameSize size, const Eigen::Vector2d& corner)
      : clipFromWorld_(clipFromWorld(camera, size.aspect())), size_(size), corner_(corner) {}

  Canvas::Points operator()(const std::vector<Vector3>& points) const {
    Canvas::Points projected;
    for (const Vector3& point : points) projected.push_back((*this)(point));
    return projected;
  }

 private:
  Eigen::Vector2d operator()(const Vector3& point) const {
    const Eigen::Vector4d clip = clipFromWorld_ * point.homogeneous();
    return corner_ + Eigen::Vector2d(0.5 * (1 + clip.x() / clip.w()) * size_.width,
                                     0.5 * (1 - clip.y() / clip.w()) * size_.height);
  }

  Eigen::Matrix4d clipFromWorld_;
  FrameSize size_;
  Eigen::Vector2d corner_;
};

/// The sides that come from cutting; consecutive sides are one line.
std::vector<Canvas::Points> cutSides(const CutPolygon& polygon, const Canvas::Points& corners) {
  const std::size_t count = corners.size();
  const auto isCut = [&](std::size_t side) { return polygon.isCut[side] != 0; };
  std::size_t first = 0;  // a corner after an uncut side, which begins a line
  while (first < count && isCut((first + count - 1) % count)) ++first;
  if (first == count) first = 0;
  std::vector<Canvas::Points> lines;
  bool isContinued = false;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t side = (first + k) % count;
    if (isCut(side)) {
      if (!isContinued) lines.push_back({corners[side]});
      lines.back().push_back(corners[(side + 1) % count]);
    }
    isContinued = isCut(side);
  }
  return lines;
}

/// In their order, each over the previous ones.
void drawPieces(const std::vector<Piece>& pieces, const Projector& project, Canvas& canvas) {
  for (const Piece& piece : pieces) {
    checkInterruption();
    const Canvas::Points corners = project(piece.outer.corners);
    canvas.polygon(corners, piece.colour);
    // A line over two translucent parts would be darker than they are.
    if (piece.colour.alpha == 255) canvas.seams(cutSides(piece.outer, corners), piece.colour);
  }
}

/// Groups of consecutive pieces of one colour.
std::vector<std::vector<Piece>> byColour(std::vector<Piece> pieces) {
  std::vector<std::vector<Piece>> groups;
  for (Piece& piece : pieces) {
    if (groups.empty() || !(groups.back().back().colour == piece.colour)) groups.emplace_back();
    groups.back().push_back(std::move(piece));
  }
  return groups;
}

/// The steps of a shadow from the palest on. Each is transparent as a whole, so overlaps in it are
/// as dark as one. Steps with opacities o1, o2, ... hide 1 - (1 - o1)(1 - o2) ... together. A
/// piece's alpha is this value up to its own step.
void drawShadow(std::vector<Piece> pieces, const Projector& project, const std::string& name,
                Canvas& canvas) {
  canvas.begin(name);
  double below = 0;
  int count = 0;
  for (std::vector<Piece>& step : byColour(std::move(pieces))) {
    const double hidden = step.front().colour.alpha / 255.0;
    for (Piece& piece : step) piece.colour.alpha = 255;
    canvas.begin(fmt::format("{}_{}", name, ++count),
                 hidden < 1 ? (hidden - below) / (1 - below) : 1);
    drawPieces(step, project, canvas);
    canvas.end();
    below = hidden;
  }
  canvas.end();
}

void drawOutlines(const std::vector<VisibleOutline>& outlines, const Projector& project,
                  Canvas& canvas) {
  for (const auto& [lines, opacity] : outlines) {
    std::vector<Canvas::Points> slits, silhouettes;
    for (const auto& [points, isSilhouette] : lines) {
      (isSilhouette ? silhouettes : slits).push_back(project(points));
    }
    canvas.outlines(slits, Canvas::Line::Slit, opacity);
    canvas.outlines(silhouettes, Canvas::Line::Silhouette, opacity);
  }
}

}  // namespace

void drawGeometry(const PictureGeometry& geometry, const Camera& camera, FrameSize size,
                  const Eigen::Vector2d& corner, const std::string& name, Canvas& canvas) {
  const Projector project(camera, size, corner);
  const auto layerName = [&name](const char* part) {
    return name.empty() ? std::string(part) : name + '_' + part;
  };
  const auto layer = [&](const char* part, const std::vector<Piece>& pieces) {
    if (pieces.empty()) return;
    canvas.begin(layerName(part));
    drawPieces(pieces, project, canvas);
    canvas.end();
  };
  layer("ground", makePieces(geometry, geometry.ground, camera));
  if (!geometry.shadow.empty()) {
    drawShadow(makePieces(geometry, geometry.shadow, camera), project, layerName("shadow"), canvas);
  }
  const std::vector<Piece> bricks = drawnPieces(geometry, camera);
  layer("bricks", farthestFirst(bricks));
  if (!geometry.outlines.empty()) {
    canvas.begin(layerName("outlines"));
    drawOutlines(visibleOutlines(geometry, bricks, camera, canvas.silhouetteWidth() / size.height),
                 project, canvas);
    canvas.end();
  }
  layer("overlay", makePieces(geometry, geometry.overlay, camera));
}

}  // namespace kirireel::picture
