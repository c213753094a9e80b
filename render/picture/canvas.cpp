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

#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <map>
#include <utility>

#include <cairo-ft.h>
#include <cairo-pdf.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

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
  explicit SvgCanvas(const PageSettings& settings)
      : fontFamily_(settings.fontFamily), parts_{{"", settings.outlines.silhouetteWidth}} {
    append(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" "
        "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" width=\"{}\" height=\"{}\" "
        "viewBox=\"0 0 {} {}\">\n",
        lengthOf(settings.size.width, settings), lengthOf(settings.size.height, settings),
        settings.size.width, settings.size.height);
    if (!settings.description.empty())
      append("<desc>{}</desc>\n", markupText(settings.description));
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

  void begin(const std::string& name, double opacity = 1) override {
    append("<g id=\"{0}\" inkscape:label=\"{0}\"{1}{2}>\n", name,
           parts_.size() == 1 ? " inkscape:groupmode=\"layer\"" : "", opacityText(opacity));
    open(name);
  }

  void beginWithin(const std::string& name, double left, double upper, double width,
                   double height) override {
    append(
        "<clipPath id=\"clip_{0}\"><rect x=\"{1:.2f}\" y=\"{2:.2f}\" width=\"{3:.2f}\" "
        "height=\"{4:.2f}\"/></clipPath>\n<g id=\"{5}\" inkscape:label=\"{5}\" "
        "clip-path=\"url(#clip_{0})\">\n",
        ++clips_, left, upper, width, height, name);
    open(name);
  }

  void end() override {
    append("</g>\n");
    parts_.pop_back();
  }

  void setOutlines(const OutlineStyle& style) override {
    append("<style>\n");
    appendRules(style, '#' + parts_.back().name + ' ');
    append("</style>\n");
    parts_.back().silhouetteWidth = style.silhouetteWidth;
  }

  void polygon(const Points& corners, Colour colour) override {
    append("<path class=\"face\" fill=\"{0}\" stroke=\"{0}\"{1} d=\"{2}Z\"/>\n", hex(colour),
           opacityText(colour), pathOf(corners));
  }

  void seams(const std::vector<Points>& lines, Colour colour) override {
    const std::string path = pathOf(lines);
    if (path.empty()) return;
    append("<path class=\"seam\" stroke=\"{}\" d=\"{}\"/>\n", hex(colour), path);
  }

  void outlines(const std::vector<Points>& lines, Line kind, double opacity) override {
    const std::string path = pathOf(lines);
    if (path.empty()) return;
    append("<path class=\"outline{}\"{} d=\"{}\"/>\n",
           kind == Line::Silhouette ? " silhouette" : "", opacityText(opacity), path);
  }

  void lines(const std::vector<Points>& lines, double width, Colour colour) override {
    const std::string path = pathOf(lines);
    if (path.empty()) return;
    append(
        "<path fill=\"none\" stroke=\"{}\" stroke-width=\"{:.3g}\" stroke-linejoin=\"round\" "
        "d=\"{}\"/>\n",
        hex(colour), width, path);
  }

  void box(double left, double upper, double width, double height, Colour colour) override {
    append("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"{}/>\n",
           left, upper, width, height, hex(colour), opacityText(colour));
  }

  void text(const std::string& line, double left, double baseline, int em, Colour colour,
            Weight weight) override {
    if (line.empty()) return;
    const ShapedLine shaped = shapeForPage(line, weight);
    // From right to left, a line ends at its left end.
    append("<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{}\"{}{}{} fill=\"{}\">{}</text>\n", left,
           baseline, em, weight == Weight::Bold ? " font-weight=\"bold\"" : "",
           shaped.isRightToLeft ? " direction=\"rtl\" text-anchor=\"end\"" : "",
           fallbackStyle(shaped, fontFamily_), hex(colour), markupText(line));
  }

  double silhouetteWidth() const override { return parts_.back().silhouetteWidth; }
  std::string finish() override { return file_ + "</svg>\n"; }

 private:
  template <typename... Arguments>
  void append(fmt::format_string<Arguments...> form, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(file_), form, std::forward<Arguments>(arguments)...);
  }

  /// Rules of a style sheet for the elements in `scope`, a selector with a space after it.
  void appendRules(const OutlineStyle& style, const std::string& scope) {
    append(
        "{0}.face {{ stroke-width: {1:.3g}; stroke-linejoin: round }}\n"
        "{0}.seam {{ fill: none; stroke-width: {2:.3g} }}\n"
        "{0}.outline {{ fill: none; stroke: {3}; stroke-width: {4:.4g}; stroke-linejoin: round; "
        "stroke-linecap: round }}\n"
        "{0}.silhouette {{ stroke-width: {5:.4g} }}\n",
        scope, seamWidth(style), cutSeamWidth(style), hex(style.colour), style.slitWidth,
        style.silhouetteWidth);
  }

  void open(const std::string& name) { parts_.push_back({name, silhouetteWidth()}); }

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

}  // namespace

std::string markupText(const std::string& text) {
  const std::map<char, const char*> entities = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string safe;
  for (const char letter : text) {
    const auto entity = entities.find(letter);
    safe += entity == entities.end() ? std::string(1, letter) : entity->second;
  }
  return safe;
}

std::string pageFile(const char* stem, PageFormat format) {
  const auto row =
      std::ranges::find(kPageFormats, format, &std::pair<const char*, PageFormat>::second);
  return fmt::format("{}.{}", stem, row->first);
}

int pixelsOf(double millimetres, double dotsPerInch) {
  return static_cast<int>(std::ceil(millimetres / kMillimetresPerInch * dotsPerInch - 1e-6));
}

int emOf(double points, double dotsPerInch) {
  return std::max(1, wholePixels(points / kPointsPerInch * dotsPerInch));
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
  /// Owns the surface, on which `scale` units are a pixel of the settings.
  CairoCanvas(cairo_surface_t* surface, double scale, const PageSettings& settings)
      : surface_(surface),
        pen_(cairo_create(surface)),
        parts_{{1, settings.outlines}},
        fontFamily_(settings.fontFamily) {
    cairo_scale(pen_, scale, scale);
    cairo_set_line_join(pen_, CAIRO_LINE_JOIN_ROUND);
    if (settings.background.alpha > 0) {
      box(0, 0, settings.size.width, settings.size.height, settings.background);
    }
  }
  ~CairoCanvas() override {
    for (const auto& [file, font] : fonts_) cairo_font_face_destroy(font);
    cairo_destroy(pen_);
    cairo_surface_destroy(surface_);
  }
  CairoCanvas(const CairoCanvas&) = delete;
  CairoCanvas& operator=(const CairoCanvas&) = delete;

  /// A part with opacity is drawn separately as a group and painted at once, so its overlaps are
  /// not darker.
  void begin(const std::string&, double opacity = 1) override {
    cairo_save(pen_);
    if (opacity < 1) cairo_push_group(pen_);
    parts_.push_back({opacity, parts_.back().outlines});
  }

  /// The clip ends with the part, by cairo_restore.
  void beginWithin(const std::string& name, double left, double upper, double width,
                   double height) override {
    begin(name);
    cairo_rectangle(pen_, left, upper, width, height);
    cairo_clip(pen_);
  }

  void end() override {
    const double opacity = parts_.back().opacity;
    parts_.pop_back();
    if (opacity < 1) {
      cairo_pop_group_to_source(pen_);
      cairo_paint_with_alpha(pen_, opacity);
    }
    cairo_restore(pen_);
  }

  void setOutlines(const OutlineStyle& style) override { parts_.back().outlines = style; }
  double silhouetteWidth() const override { return parts_.back().outlines.silhouetteWidth; }

  /// Filled and stroked in one colour: the stroke covers the hairline to its neighbours. The
  /// combined opacity is that of the colour.
  void polygon(const Points& corners, Colour colour) override {
    if (colour.alpha < 255) {
      begin({}, colour.alpha / 255.0);
      polygon(corners, {colour.red, colour.green, colour.blue});
      end();
      return;
    }
    choose(colour);
    trace(corners);
    cairo_close_path(pen_);
    cairo_fill_preserve(pen_);
    cairo_set_line_width(pen_, seamWidth(parts_.back().outlines));
    cairo_stroke(pen_);
  }

  void seams(const std::vector<Points>& lines, Colour colour) override {
    this->lines(lines, cutSeamWidth(parts_.back().outlines), colour);
  }

  void outlines(const std::vector<Points>& lines, Line kind, double opacity) override {
    const OutlineStyle& style = parts_.back().outlines;
    Colour colour = style.colour;
    colour.alpha = static_cast<std::uint8_t>(std::lround(opacity * colour.alpha));
    cairo_set_line_cap(pen_, CAIRO_LINE_CAP_ROUND);
    this->lines(lines, kind == Line::Slit ? style.slitWidth : style.silhouetteWidth, colour);
    cairo_set_line_cap(pen_, CAIRO_LINE_CAP_BUTT);
  }

  void lines(const std::vector<Points>& lines, double width, Colour colour) override {
    choose(colour);
    cairo_set_line_width(pen_, width);
    for (const Points& line : lines) {
      trace(line);
      if (isClosed(line)) cairo_close_path(pen_);
    }
    cairo_stroke(pen_);
  }

  void box(double left, double upper, double width, double height, Colour colour) override {
    choose(colour);
    cairo_rectangle(pen_, left, upper, width, height);
    cairo_fill(pen_);
  }

  /// Cairo's simple text interface has no shaping, so it draws plain lines only.
  void text(const std::string& line, double left, double baseline, int em, Colour colour,
            Weight weight) override {
    choose(colour);
    const ShapedLine shaped = shapeForPage(line, weight);
    if (!shaped.isPlain) {
      for (const TextRun& run : shaped.runs) show(run, left, baseline, em);
      return;
    }
    cairo_select_font_face(
        pen_, fontFamily_.c_str(), CAIRO_FONT_SLANT_NORMAL,
        weight == Weight::Bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(pen_, em);
    cairo_move_to(pen_, left, baseline);
    cairo_show_text(pen_, line.c_str());
  }

 protected:
  cairo_surface_t* surface() const { return surface_; }

 private:
  /// An open part; the first one is the page.
  struct CairoPart {
    double opacity;
    OutlineStyle outlines;
  };

  void choose(Colour colour) const {
    cairo_set_source_rgba(pen_, colour.red / 255.0, colour.green / 255.0, colour.blue / 255.0,
                          colour.alpha / 255.0);
  }

  void trace(const Points& points) const {
    cairo_new_sub_path(pen_);
    for (const Eigen::Vector2d& point : points) cairo_line_to(pen_, point.x(), point.y());
  }

  cairo_font_face_t* fontOf(const FontFile& file) {
    cairo_font_face_t*& font = fonts_[file];
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
    cairo_set_font_face(pen_, fontOf(run.font));
    cairo_set_font_size(pen_, em);
    cairo_show_text_glyphs(pen_, text.data(), static_cast<int>(text.size()), glyphs.data(),
                           static_cast<int>(glyphs.size()), clusters.data(),
                           static_cast<int>(clusters.size()),
                           static_cast<cairo_text_cluster_flags_t>(0));
  }

  cairo_surface_t* surface_;
  cairo_t* pen_;
  std::vector<CairoPart> parts_;
  std::string fontFamily_;
  std::map<FontFile, cairo_font_face_t*> fonts_;  // of shaped text
};

/// The bytes of a PDF. They are a base of PdfCanvas, because they must outlive the surface.
struct PdfBytes {
  std::string file;
};

/// One page of width x height pixels at the settings' resolution.
class PdfCanvas : private PdfBytes, public CairoCanvas {
 public:
  explicit PdfCanvas(const PageSettings& settings)
      : CairoCanvas(surfaceOf(settings, file), pointsPerPixel(settings), settings) {}

  std::string finish() override {
    cairo_surface_finish(surface());
    requireDrawn(surface(), "PDF");
    return std::move(file);
  }

 private:
  static double pointsPerPixel(const PageSettings& settings) {
    return kPointsPerInch / settings.pixelsPerInch;
  }

  static cairo_surface_t* surfaceOf(const PageSettings& settings, std::string& file) {
    const double points = pointsPerPixel(settings);
    cairo_surface_t* surface = cairo_pdf_surface_create_for_stream(
        appendBytes, &file, settings.size.width * points, settings.size.height * points);
    // Real dates would make the bytes of each run different.
    cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, "2000-01-01T00:00:00Z");
    cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_SUBJECT,
                                   settings.description.c_str());
    return surface;
  }
};

/// Cairo's pixels are 32-bit words with premultiplied alpha.
class PngCanvas : public CairoCanvas {
 public:
  explicit PngCanvas(const PageSettings& settings)
      : CairoCanvas(cairo_image_surface_create(CAIRO_FORMAT_ARGB32, settings.size.width,
                                               settings.size.height),
                    1, settings),
        settings_(settings) {}

  std::string finish() override {
    return pngBytes(frame(),
                    {.dotsPerInch = settings_.pixelsPerInch, .description = settings_.description});
  }

  /// The pixels drawn so far. Throws OutputError.
  Frame frame() const {
    cairo_surface_flush(surface());
    requireDrawn(surface(), "picture");
    const std::uint8_t* rows = cairo_image_surface_get_data(surface());
    const int stride = cairo_image_surface_get_stride(surface());
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

 private:
  PageSettings settings_;
};

}  // namespace

std::unique_ptr<Canvas> makeCanvas(PageFormat format, const PageSettings& settings) {
  switch (format) {
    case PageFormat::Svg:
      return std::make_unique<SvgCanvas>(settings);
    case PageFormat::Pdf:
      return std::make_unique<PdfCanvas>(settings);
    case PageFormat::Png:
      break;
  }
  return std::make_unique<PngCanvas>(settings);
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
