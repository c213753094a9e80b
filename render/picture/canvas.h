/// Vector graphics: pages as SVG, PDF and PNG, and geometries drawn on them with hidden surfaces
/// removed. No Cairo header is needed to make them.
#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/picture/camera.h"
#include "render/picture/label.h"
#include "render/picture/picture_geometry.h"
#include "sim/base/geometry.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// Pages of vector graphics.

/// Units of lengths on paper.
inline constexpr double kMillimetresPerInch = 25.4;
inline constexpr double kPointsPerInch = 72;

/// A length in print as pixels, never fewer than requested.
int pixelsOf(double millimetres, double dotsPerInch);

/// The em of text with a size in points, pixels.
int emOf(double points, double dotsPerInch);

/// Lines around polygons on a page. Widths in pixels.
struct OutlineStyle {
  Colour colour;
  double slitWidth = 1;          ///< of lines between tiles
  double silhouetteWidth = 1.5;  ///< of lines without a neighbour
};

/// Settings of a page. Its unit is a pixel; at 96 pixels per inch a page has its natural size in a
/// browser.
struct PageSettings {
  FrameSize size;             ///< in its own unit, the pixels of a picture of the same layout
  double pixelsPerInch = 96;  ///< > 0
  Colour background = {255, 255, 255};  ///< of the whole page, opaque in files
  OutlineStyle outlines;                ///< of parts without their own
  std::string fontFamily;               ///< of all text
  std::string description;              ///< author and source, one line
};

/// Width of the lines in a polygon's own colour that close the antialiasing gaps between adjacent
/// polygons, pixels.
inline double seamWidth(const OutlineStyle& style) {
  return std::max(0.3, 0.4 * style.slitWidth);
}

/// The same for the cut of one face.
inline double cutSeamWidth(const OutlineStyle& style) {
  return 3 * seamWidth(style);
}

/// A rectangle of a page, pixels from the upper left.
struct PageBox {
  double left = 0;
  double upper = 0;
  double width = 0;
  double height = 0;

  /// Its right side.
  double right() const { return left + width; }
  /// Its lower side.
  double lower() const { return upper + height; }
};

/// A page for painting from back to front. Lengths are pixels of PageSettings::size. Later calls
/// cover earlier ones.
class Canvas : public Surface {
 public:
  /// A polygon or a line on the page, pixels from the upper left.
  using Points = std::vector<Eigen::Vector2d>;

  /// Following calls belong to a named part of the page, up to the matching end(). Parts may be
  /// nested. opacity: of the part as a whole, [0, 1]. Every begin() needs its end() before
  /// finish().
  virtual void begin(const std::string& name, double opacity = 1) = 0;
  /// The same, clipped to a rectangle.
  virtual void beginWithin(const std::string& name, double left, double upper, double width,
                           double height) = 0;
  /// Closes the innermost part.
  virtual void end() = 0;

  /// Sets the outlines of the innermost open part. A part is open.
  virtual void setOutlines(const OutlineStyle& style) = 0;

  /// A filled polygon, its sides closed against those of its neighbours. Three corners or more;
  /// alpha counts.
  virtual void polygon(const Points& corners, Colour colour) = 0;

  /// Lines in a polygon's own colour along its cuts.
  virtual void seams(const std::vector<Points>& lines, Colour colour) = 0;

  /// Kind of a line of an outline.
  enum class Line { Slit, Silhouette };

  /// Lines in the colour of outlines and of their width, each through two points or more, opacity
  /// 0 to 1. A line whose first and last points are the same is closed without a gap.
  virtual void outlines(const std::vector<Points>& lines, Line kind, double opacity = 1) = 0;
  /// Width of silhouettes in the innermost open part, pixels.
  virtual double silhouetteWidth() const = 0;

  /// Lines of a width in pixels, each through two points or more.
  virtual void lines(const std::vector<Points>& lines, double width, Colour colour) = 0;

  /// The whole file; call it once, when everything is drawn. Throws OutputError.
  virtual std::string finish() = 0;
};

/// Format of a page. SVG 1.1: filled paths, lines and text, named groups that editors show as
/// layers, and one style sheet with the appearance of faces, outlines and text. PDF: one page with
/// the size of the settings' pixels at their resolution, shapes and text as vector graphics, the
/// font embedded. PNG: the settings' pixels and their resolution.
enum class PageFormat { Svg, Pdf, Png };

/// The words of options for the formats, which are the endings of files.
inline constexpr std::array<std::pair<const char*, PageFormat>, 3> kPageFormats{
    {{"png", PageFormat::Png}, {"svg", PageFormat::Svg}, {"pdf", PageFormat::Pdf}}};

/// A text between the tags of SVG or HTML, or an attribute in double quotation marks.
std::string markupText(const std::string& text);

/// "curves.svg" for the stem "curves".
std::string pageFile(const char* stem, PageFormat format);

/// A page of any format. Equal pages give equal bytes. The settings' size must be valid, see
/// requireValidSize(). Throws OutputError if there is too little memory.
std::unique_ptr<Canvas> makeCanvas(PageFormat format, const PageSettings& settings);

/// The pixels of a page that `draw` draws on. Its background may be transparent. Throws OutputError
/// if there is too little memory.
Frame drawnPage(const PageSettings& settings, const std::function<void(Canvas&)>& draw);

// ------------------------------------------------------------------------------------------------
// Sketches on pages, hidden surfaces removed.

/// Draws what the camera sees of the geometry, from back to front, in parts called `name`_ground,
/// _shadow, _bricks, _outlines and _overlay as far as there are such (without `name`_ when that is
/// empty). size: of the picture, pixels; its upper left corner is at `corner` of the canvas. Names
/// must be unique on a page: they become ids in SVG.
void drawGeometry(const PictureGeometry& geometry, const Camera& camera, FrameSize size,
                  const Eigen::Vector2d& corner, const std::string& name, Canvas& canvas);

}  // namespace kirireel::picture
