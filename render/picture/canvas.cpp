// SVG 1.1 (W3C Recommendation) as text. In this order: the root with its size, <desc>, one <style>
// with classes for faces, seams, outlines and text, then groups. A group at the top is a layer to
// Inkscape (inkscape:groupmode="layer"), which other programs ignore. Coordinates have two decimals
// of a pixel, which at 300 dots an inch is a micrometre of print.
//
// Shapes are paths "M x y L x y ... Z" with the fill of their face. The look of lines stands in the
// style sheet alone, so that an editor changes all outlines at once. Text stays text in the font of
// that name; a reader without it takes Arial or Helvetica.
#include "render/picture/canvas.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include <cairo-pdf.h>
#include <fmt/format.h>

#include "render/picture/png.h"
#include "sim/base/error.h"
#include "sim/base/interruption.h"

namespace kirireel {
namespace {

/// Alpha is written apart, as an opacity.
std::string hex(Colour colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
}

/// A length on the page: pixels where they are those of the screen, else millimetres.
std::string lengthOf(int pixels, const PageSettings& settings) {
  if (settings.pixelsPerInch == PageSettings().pixelsPerInch) return fmt::format("{}", pixels);
  return fmt::format("{:.6g}mm", pixels * 25.4 / settings.pixelsPerInch);
}

/// Nothing for opaque colours, which most are.
std::string opacityText(Colour colour) {
  return colour.alpha == 255 ? std::string()
                             : fmt::format(" fill-opacity=\"{:.4g}\"", colour.alpha / 255.0);
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

/// Its last point is its first.
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

class SvgCanvas : public Canvas {
 public:
  explicit SvgCanvas(const PageSettings& settings);

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

  std::string finish() override;

 private:
  template <typename... Arguments>
  void append(fmt::format_string<Arguments...> form, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(file_), form, std::forward<Arguments>(arguments)...);
  }

  std::string file_;
  int depth_ = 0;  ///< of groups
  int clips_ = 0;
};

SvgCanvas::SvgCanvas(const PageSettings& settings) {
  append(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" width=\"{}\" height=\"{}\" "
      "viewBox=\"0 0 {} {}\">\n",
      lengthOf(settings.size.width, settings), lengthOf(settings.size.height, settings),
      settings.size.width, settings.size.height);
  if (!settings.description.empty()) append("<desc>{}</desc>\n", escaped(settings.description));
  append(
      "<style>\n"
      ".face {{ stroke-width: {:.3g}; stroke-linejoin: round }}\n"
      ".seam {{ fill: none; stroke-width: {:.3g} }}\n"
      ".outline {{ fill: none; stroke: {}; stroke-width: {:.3g}; stroke-linejoin: round }}\n"
      ".pale {{ stroke: {} }}\n"
      "text {{ font-family: \"{}\", \"Arial\", \"Helvetica\", sans-serif }}\n"
      "</style>\n",
      seamWidth(settings), cutSeamWidth(settings), hex(settings.outline), settings.outlineWidth,
      hex(settings.paleOutline), settings.fontFamily);
  if (settings.background.alpha == 0) return;
  begin("page");
  box(0, 0, settings.size.width, settings.size.height, settings.background);
  end();
}

void SvgCanvas::begin(const std::string& name, double opacity) {
  append("<g id=\"{0}\" inkscape:label=\"{0}\"{1}{2}>\n", name,
         depth_ == 0 ? " inkscape:groupmode=\"layer\"" : "",
         opacity < 1 ? fmt::format(" opacity=\"{:.4g}\"", opacity) : "");
  ++depth_;
}

void SvgCanvas::beginWithin(const std::string& name, double left, double upper, double width,
                            double height) {
  append(
      "<clipPath id=\"clip_{0}\"><rect x=\"{1:.2f}\" y=\"{2:.2f}\" width=\"{3:.2f}\" "
      "height=\"{4:.2f}\"/></clipPath>\n<g id=\"{5}\" inkscape:label=\"{5}\" "
      "clip-path=\"url(#clip_{0})\">\n",
      ++clips_, left, upper, width, height, name);
  ++depth_;
}

void SvgCanvas::end() {
  append("</g>\n");
  --depth_;
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

void SvgCanvas::outlines(const std::vector<Points>& lines, bool pale) {
  const std::string path = pathOf(lines);
  if (!path.empty()) append("<path class=\"outline{}\" d=\"{}\"/>\n", pale ? " pale" : "", path);
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

void SvgCanvas::text(const std::string& line, double left, double baseline, int em, Colour colour) {
  if (line.empty()) return;
  append("<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{}\" fill=\"{}\">{}</text>\n", left, baseline,
         em, hex(colour), escaped(line));
}

std::string SvgCanvas::finish() {
  return file_ + "</svg>\n";
}

}  // namespace

std::unique_ptr<Canvas> makeSvgCanvas(const PageSettings& settings) {
  return std::make_unique<SvgCanvas>(settings);
}

// ------------------------------------------------------------------------------------------------
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

// ------------------------------------------------------------------------------------------------
// Faces are painted over each other in the order of farthestFirst(), each filled whole and closed
// against what it was cut from. Over all of them what shows of their own sides (seenOutlines()) is
// drawn as lines of one width; sides that came from cutting a face are none of its own.

namespace {

/// Brings points of space into the picture.
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

/// The sides that came from cutting; sides in a row are one line.
std::vector<Canvas::Points> cutSides(const CutPolygon& polygon, const Canvas::Points& corners) {
  const std::size_t count = corners.size();
  const auto isCut = [&](std::size_t side) { return polygon.isCut[side] != 0; };
  std::size_t first = 0;  // a corner after a side that was not cut, where a line begins
  while (first < count && isCut((first + count - 1) % count)) ++first;
  if (first == count) first = 0;
  std::vector<Canvas::Points> lines;
  bool goesOn = false;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t side = (first + k) % count;
    if (isCut(side)) {
      if (!goesOn) lines.push_back({corners[side]});
      lines.back().push_back(corners[(side + 1) % count]);
    }
    goesOn = isCut(side);
  }
  return lines;
}

/// In their order, each over those before.
void drawPieces(const std::vector<Piece>& pieces, const Projector& project, Canvas& canvas) {
  for (const Piece& piece : pieces) {
    checkInterruption();
    const Canvas::Points corners = project(piece.outer.corners);
    canvas.polygon(corners, piece.colour);
    canvas.seams(cutSides(piece.outer, corners), piece.colour);
  }
}

/// Pieces of one colour that follow each other, together.
std::vector<std::vector<Piece>> byColour(std::vector<Piece> pieces) {
  std::vector<std::vector<Piece>> groups;
  for (Piece& piece : pieces) {
    if (groups.empty() || !(groups.back().back().colour == piece.colour)) groups.emplace_back();
    groups.back().push_back(std::move(piece));
  }
  return groups;
}

/// The steps of a shadow from the palest on, each transparent as a whole so that what overlaps in
/// it is as dark as one. Steps with opacities o1, o2, ... hide 1 - (1 - o1)(1 - o2) ... together; a
/// piece's alpha says how much that is up to its own step.
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

void drawOutlines(const std::vector<SeenOutline>& outlines, const Projector& project,
                  Canvas& canvas) {
  for (const auto& [lines, pale] : outlines) {
    std::vector<Canvas::Points> projected;
    for (const std::vector<Vector3>& line : lines) projected.push_back(project(line));
    canvas.outlines(projected, pale);
  }
}

}  // namespace

void drawSketch(const Sketch& sketch, const Camera& camera, FrameSize size,
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
  layer("ground", makePieces(sketch, sketch.ground, camera));
  if (!sketch.shadow.empty()) {
    drawShadow(makePieces(sketch, sketch.shadow, camera), project, layerName("shadow"), canvas);
  }
  const std::vector<Piece> solid = makePieces(sketch, sketch.solid, camera);
  layer("bricks", farthestFirst(solid));
  if (std::ranges::any_of(solid, &Piece::outlined)) {
    canvas.begin(layerName("outlines"));
    drawOutlines(seenOutlines(solid, camera), project, canvas);
    canvas.end();
  }
  layer("overlay", makePieces(sketch, sketch.overlay, camera));
}

// ------------------------------------------------------------------------------------------------
// Binary space partition (H. Fuchs, Z. M. Kedem, B. F. Naylor, "On Visible Surface Generation by A
// Priori Tree Structures", SIGGRAPH 1980). One piece is chosen as splitter; its plane n . p = o
// divides the others:
//
//     back (n . p < o)    on (within the tolerance)    front (n . p > o)
//
// A piece on both sides is cut in two. Back and front are sorted in the same way, and the order
// back, on, front is right for the painter's algorithm, because every splitter looks at the camera:
// nothing behind its plane can hide what is on it or in front of it.
//
// The splitter is the best of twelve candidates, by the cost 8 cuts + |front - back|: few cuts keep
// the file small, balance keeps the recursion shallow. With n pieces that takes about 12 n log n
// tests when planes divide well.
//
// A sort by distance would be simpler and wrong for faces that cross or hide each other in turn.

namespace {

/// Points nearer to a plane than this part of the model count as on it.
constexpr double kOnPlane = 1e-7;

/// Planes that are tried at each cut.
constexpr std::size_t kCandidates = 12;

/// One cut polygon more costs as much as this many polygons of imbalance.
constexpr int kCostOfCut = 8;

/// A facet hides nothing so near to its own sides, in heights of the picture: those of neighbours
/// lie there. Far less than the width of an outline, whose own line covers what is left.
constexpr double kSideMargin = 2e-4;

struct Plane {
  Vector3 normal;
  double offset;
  double tolerance;

  double distance(const Vector3& point) const { return normal.dot(point) - offset; }
};

/// The part of a polygon in front of the plane. A side along the plane is marked as cut. Sutherland
/// and Hodgman's clipping. Empty where less than a triangle is left.
CutPolygon frontPart(const CutPolygon& polygon, const Plane& plane) {
  CutPolygon part;
  const std::size_t count = polygon.corners.size();
  const auto add = [&part](const Vector3& point, bool isCut) {
    part.corners.push_back(point);
    part.isCut.push_back(isCut ? 1 : 0);
  };
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3& from = polygon.corners[k];
    const Vector3& to = polygon.corners[(k + 1) % count];
    const double before = plane.distance(from), after = plane.distance(to);
    const bool isCut = polygon.isCut[k] != 0;
    if (before >= 0) add(from, isCut);
    if ((before >= 0) == (after >= 0)) continue;
    // What follows the point where the polygon leaves the front is the cut.
    add(from + before / (before - after) * (to - from), before >= 0 || isCut);
  }
  if (part.corners.size() < 3) return {};
  return part;
}

Piece frontPart(const Piece& piece, const Plane& plane) {
  Piece part = piece;
  part.outer = frontPart(piece.outer, plane);
  part.inner = frontPart(piece.inner, plane);
  return part;
}

struct Sides {
  bool front = false;
  bool back = false;
};

/// By the corners of the outer polygon; the inner one lies within.
Sides sidesOf(const Piece& piece, const Plane& plane) {
  Sides sides;
  for (const Vector3& corner : piece.outer.corners) {
    const double distance = plane.distance(corner);
    sides.front |= distance > plane.tolerance;
    sides.back |= distance < -plane.tolerance;
  }
  return sides;
}

/// Recursion over ever smaller parts of space.
class Sorter {
 public:
  explicit Sorter(double tolerance) : tolerance_(tolerance) {}

  void sort(std::vector<Piece> pieces) {
    if (pieces.empty()) return;
    const std::size_t splitter = bestSplitter(pieces);
    const Plane plane = planeOf(pieces[splitter]);
    std::vector<Piece> back, on, front;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      Piece& piece = pieces[k];
      // Tiles need not be exactly flat: the splitter is on its own plane by definition, so that
      // every step takes one piece away.
      const Sides sides = k == splitter ? Sides{} : sidesOf(piece, plane);
      if (sides.front && sides.back) {
        keep(frontPart(piece, {-plane.normal, -plane.offset, plane.tolerance}), back);
        keep(frontPart(piece, plane), front);
      } else {
        (sides.front ? front : sides.back ? back : on).push_back(std::move(piece));
      }
    }
    pieces = {};  // gives the memory back before going deeper
    sort(std::move(back));
    std::move(on.begin(), on.end(), std::back_inserter(sorted));
    sort(std::move(front));
  }

  std::vector<Piece> sorted;

 private:
  static void keep(Piece piece, std::vector<Piece>& pieces) {
    if (!piece.outer.corners.empty()) pieces.push_back(std::move(piece));
  }

  Plane planeOf(const Piece& piece) const { return {piece.normal, piece.offset, tolerance_}; }

  std::size_t bestSplitter(const std::vector<Piece>& pieces) const {
    const std::size_t stride = 1 + (pieces.size() - 1) / kCandidates;
    std::size_t best = 0;
    int least = std::numeric_limits<int>::max();
    for (std::size_t candidate = 0; candidate < pieces.size(); candidate += stride) {
      checkInterruption();
      const int cost = costOf(planeOf(pieces[candidate]), pieces);
      if (cost >= least) continue;
      least = cost;
      best = candidate;
    }
    return best;
  }

  /// Looks at all pieces.
  static int costOf(const Plane& plane, const std::vector<Piece>& pieces) {
    int front = 0, back = 0, cut = 0;
    for (const Piece& piece : pieces) {
      const Sides sides = sidesOf(piece, plane);
      front += sides.front ? 1 : 0;
      back += sides.back ? 1 : 0;
      cut += sides.front && sides.back ? 1 : 0;
    }
    return kCostOfCut * cut + std::abs(front - back);
  }

  double tolerance_;
};

/// Diagonal of a box around all of them, metres.
double sizeOf(const std::vector<Piece>& pieces) {
  Eigen::AlignedBox3d box;
  for (const Piece& piece : pieces) {
    for (const Vector3& corner : piece.outer.corners) box.extend(corner);
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

CutPolygon uncut(std::span<const Vector3> corners) {
  return {{corners.begin(), corners.end()}, std::vector<char>(corners.size(), 0)};
}

/// The normal is that of the outer corners.
Piece makePiece(const Sketch& sketch, const Facet& facet) {
  Piece piece{uncut(sketch.corners(facet)), uncut(sketch.inner(facet)), facet.outlined, facet.pale,
              facet.colour};
  const std::vector<Vector3>& corners = piece.outer.corners;
  piece.normal = Vector3::Zero();
  for (std::size_t k = 2; k < corners.size(); ++k) {
    piece.normal += (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]);
  }
  piece.normal.normalize();
  piece.offset = piece.normal.dot(corners[0]);
  return piece;
}

/// Where a camera sees points: right and up in the picture, in heights of the picture at the
/// camera's centre.
class View {
 public:
  explicit View(const Camera& camera)
      : camera_(camera),
        forward_((camera.centre - camera.eye).normalized()),
        right_(forward_.cross(camera.up).normalized()),
        up_(right_.cross(forward_)),
        height_(heightAtCentre(camera)) {}

  Eigen::Vector2d operator()(const Vector3& point) const {
    const Vector3 seen = point - camera_.eye;
    return scaleAt(seen) * Eigen::Vector2d(right_.dot(seen), up_.dot(seen));
  }

  /// The half-space of points x with normal . x >= offset that the side of a polygon bounds in the
  /// picture, on the side of `inside` and `margin` heights of the picture away from it: a plane
  /// through the eye, or along the view.
  std::pair<Vector3, double> within(const Vector3& from, const Vector3& to, const Vector3& inside,
                                    double margin) const {
    const Vector3 along = camera_.orthographic ? forward_ : Vector3(from - camera_.eye);
    Vector3 normal = along.cross(to - from);
    const double length = normal.norm();
    if (length <= 0) return {Vector3::Zero(), 0};
    normal /= normal.dot(inside - from) < 0 ? -length : length;
    const double width = margin * height_;
    if (camera_.orthographic) return {normal, normal.dot(from) + width};
    // A margin of the picture is as much wider as it is farther away.
    normal -= width / (camera_.centre - camera_.eye).norm() * forward_;
    return {normal, normal.dot(camera_.eye)};
  }

 private:
  double scaleAt(const Vector3& seen) const {
    if (camera_.orthographic) return 1 / height_;
    return (camera_.centre - camera_.eye).norm() / (forward_.dot(seen) * height_);
  }

  const Camera& camera_;
  Vector3 forward_, right_, up_;
  double height_;
};

/// The pieces that may hide what lies in a part of the picture: a grid of square cells, each with
/// the pieces whose boxes reach into it.
class PictureGrid {
 public:
  using Box = Eigen::AlignedBox2d;

  PictureGrid(const std::vector<Piece>& pieces, const View& view) {
    for (const Piece& piece : pieces) {
      Box& box = boxes_.emplace_back();
      for (const Vector3& corner : piece.outer.corners) box.extend(view(corner));
      all_.extend(box);
    }
    sides_ = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(pieces.size()))));
    cells_.resize(static_cast<std::size_t>(sides_) * sides_);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      forCells(boxes_[k], [&](std::vector<std::size_t>& cell) { cell.push_back(k); });
    }
  }

  /// In rising order, each once.
  std::vector<std::size_t> near(const Box& box) {
    std::vector<std::size_t> found;
    forCells(box, [&](const std::vector<std::size_t>& cell) {
      for (const std::size_t k : cell) {
        if (boxes_[k].intersects(box)) found.push_back(k);
      }
    });
    std::ranges::sort(found);
    found.erase(std::ranges::unique(found).begin(), found.end());
    return found;
  }

 private:
  template <typename Action>
  void forCells(const Box& box, const Action& action) {
    const auto cellOf = [this](const Eigen::Vector2d& point) -> Eigen::Array2i {
      const Eigen::Array2d share =
          (point - all_.min()).array() / all_.sizes().array().max(1e-300) * sides_;
      return share.max(0).min(sides_ - 1).cast<int>();
    };
    const Eigen::Array2i least = cellOf(box.min()), most = cellOf(box.max());
    for (int y = least.y(); y <= most.y(); ++y) {
      for (int x = least.x(); x <= most.x(); ++x) action(cells_[y * sides_ + x]);
    }
  }

  Box all_;
  int sides_ = 1;
  std::vector<Box> boxes_;
  std::vector<std::vector<std::size_t>> cells_;
};

/// A part of a line, from 0 at its first point to 1 at its last.
using Interval = std::pair<double, double>;

/// The part of a line that a piece hides: from one bound to the other, as both are convex. Empty
/// (first not before second) where it hides nothing.
Interval hiddenBy(const Piece& piece, const Vector3& from, const Vector3& to, const View& view,
                  double tolerance) {
  Interval hidden(0, 1);
  const auto keepWhere = [&](const Vector3& normal, double offset) {
    const double before = normal.dot(from) - offset, after = normal.dot(to) - offset;
    if (before < 0 && after < 0) {
      hidden = {1, 0};
    } else if (before < 0) {
      hidden.first = std::max(hidden.first, before / (before - after));
    } else if (after < 0) {
      hidden.second = std::min(hidden.second, before / (before - after));
    }
  };
  keepWhere(-piece.normal, -piece.offset + tolerance);
  const std::vector<Vector3>& corners = piece.outer.corners;
  Vector3 middle = Vector3::Zero();
  for (const Vector3& corner : corners) middle += corner / static_cast<double>(corners.size());
  for (std::size_t k = 0; k < corners.size() && hidden.first < hidden.second; ++k) {
    const auto [normal, offset] =
        view.within(corners[k], corners[(k + 1) % corners.size()], middle, kSideMargin);
    keepWhere(normal, offset);
  }
  return hidden;
}

/// What intervals leave over of a whole line; between two of them no less than `least`.
std::vector<Interval> restOf(std::vector<Interval> hidden, double least) {
  std::ranges::sort(hidden);
  std::vector<Interval> rest;
  double end = 0;
  for (const auto& [first, second] : hidden) {
    if (first > end && (end == 0 || first - end > least)) rest.emplace_back(end, first);
    end = std::max(end, second);
  }
  if (end < 1) rest.emplace_back(end, 1);
  return rest;
}

/// Lines from what shows of the sides of a polygon, one after the other from a corner on.
class OutlineChain {
 public:
  /// A part of the next side that shows; it goes on with the line that ends where it begins.
  void add(const Vector3& from, const Vector3& to, const Interval& part) {
    const auto at = [&](double share) -> Vector3 {
      return share == 0 ? from : share == 1 ? to : from + share * (to - from);
    };
    if (lines_.empty() || part.first > 0 || lines_.back().back() != from)
      lines_.push_back({at(part.first)});
    lines_.back().push_back(at(part.second));
  }

  /// What ends at the corner where the first line begins is one with it.
  std::vector<std::vector<Vector3>> finish() {
    if (lines_.size() > 1 && lines_.back().back() == lines_.front().front()) {
      lines_.back().insert(lines_.back().end(), lines_.front().begin() + 1, lines_.front().end());
      lines_.erase(lines_.begin());
    }
    return std::move(lines_);
  }

 private:
  std::vector<std::vector<Vector3>> lines_;
};

}  // namespace

std::vector<Piece> makePieces(const Sketch& sketch, const std::vector<Facet>& facets,
                              const Camera& camera) {
  const Vector3 forward = (camera.centre - camera.eye).normalized();
  const Plane nearPlane{forward, forward.dot(camera.eye) + camera.near, 0};
  std::vector<Piece> pieces;
  for (const Facet& facet : facets) {
    Piece piece = makePiece(sketch, facet);
    if (sidesOf(piece, nearPlane).back) piece = frontPart(piece, nearPlane);
    if (!piece.outer.corners.empty()) pieces.push_back(std::move(piece));
  }
  return pieces;
}

std::vector<SeenOutline> seenOutlines(const std::vector<Piece>& pieces, const Camera& camera) {
  const View view(camera);
  PictureGrid grid(pieces, view);
  const double tolerance = kOnPlane * sizeOf(pieces);
  std::vector<SeenOutline> outlines;
  for (std::size_t own = 0; own < pieces.size(); ++own) {
    checkInterruption();
    if (!pieces[own].outlined) continue;
    const auto& [corners, isCut] = pieces[own].outer;
    OutlineChain chain;
    for (std::size_t side = 0; side < corners.size(); ++side) {
      if (isCut[side] != 0) continue;
      const Vector3 &from = corners[side], &to = corners[(side + 1) % corners.size()];
      const Eigen::Vector2d begin = view(from), end = view(to);
      std::vector<Interval> hidden;
      for (const std::size_t k : grid.near(Eigen::AlignedBox2d(begin).extend(end))) {
        if (k == own) continue;
        const Interval part = hiddenBy(pieces[k], from, to, view, tolerance);
        if (part.first < part.second) hidden.push_back(part);
      }
      // Between two facets side by side their margins show, under the line between them.
      const double least = 3 * kSideMargin / std::max((end - begin).norm(), kSideMargin);
      for (const Interval& part : restOf(std::move(hidden), least)) chain.add(from, to, part);
    }
    outlines.push_back({chain.finish(), pieces[own].pale});
  }
  return outlines;
}

std::vector<Piece> farthestFirst(std::vector<Piece> pieces) {
  if (pieces.empty()) return {};
  Sorter sorter(kOnPlane * sizeOf(pieces));
  sorter.sort(std::move(pieces));
  return std::move(sorter.sorted);
}

}  // namespace kirireel
