// SVG 1.1 (W3C Recommendation) as text. In this order: the root with its size, <desc>, one <style>
// with classes for faces, seams, outlines and text, then groups. A group at the top is a layer to
// Inkscape (inkscape:groupmode="layer"), which other programs ignore. Coordinates have two decimals
// of a pixel, which at 300 dots an inch is a micrometre of print.
//
// Shapes are paths "M x y L x y ... Z" with the fill of their face. The look of lines stands in the
// style sheet alone, so that an editor changes all outlines at once. Text stays text in the font of
// that name; a reader without it takes Arial or Helvetica.
#include "render/vector/svg.h"

#include <iterator>
#include <string>

#include <fmt/format.h>

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

}  // namespace kirireel
