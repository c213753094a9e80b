/// Vector graphics: pages as SVG, PDF and PNG, and geometries drawn on them with hidden surfaces
/// removed. No Cairo header is needed to make them.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/picture/camera.h"
#include "render/picture/label.h"
#include "render/picture/picture_geometry.h"
#include "sim/base/geometry.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// Pages of vector graphics.

/// Of lengths on paper.
inline constexpr double kMillimetresPerInch = 25.4;
inline constexpr double kPointsPerInch = 72;

/// How a page is made. The page's unit is a pixel; at 96 of them an inch a page is as large as a
/// browser shows it.
struct PageSettings {
  FrameSize size;             ///< in its own unit, the pixels of a picture of the same layout
  double pixelsPerInch = 96;  ///< above 0
  Colour background = {255, 255, 255};  ///< of the whole page, opaque
  Colour outline;                       ///< of bricks
  Colour paleOutline;                   ///< of dark bricks
  double slitWidth = 1;                 ///< of lines between tiles, pixels
  double silhouetteWidth = 1.5;         ///< of lines with nothing beyond, pixels
  std::string fontFamily;               ///< of all text
  std::string description;              ///< who made it from what, one line
};

/// Width of the lines in a polygon's own colour that close the gaps which antialiasing leaves
/// between polygons side by side, pixels.
inline double seamWidth(const PageSettings& settings) {
  return std::max(0.3, 0.4 * settings.slitWidth);
}

/// The same where one face was cut in two.
inline double cutSeamWidth(const PageSettings& settings) {
  return 3 * seamWidth(settings);
}

/// A page that is drawn on from back to front. Lengths are pixels of PageSettings::size. Calls come
/// in painting order: what is drawn later covers what is there.
class Canvas : public Surface {
 public:
  /// A polygon or a line on the page, pixels from the upper left.
  using Points = std::vector<Eigen::Vector2d>;

  /// What follows belongs to a named part of the page, up to the matching end(); parts may hold
  /// others. opacity: of the part as a whole, 0 to 1. Every begin() needs its end() before
  /// finish().
  virtual void begin(const std::string& name, double opacity = 1) = 0;
  /// The same, cut off at a rectangle.
  virtual void beginWithin(const std::string& name, double left, double upper, double width,
                           double height) = 0;
  /// Closes the part that was begun last.
  virtual void end() = 0;

  /// A filled polygon, its sides closed against those of its neighbours. Three corners or more;
  /// alpha counts.
  virtual void polygon(const Points& corners, Colour colour) = 0;

  /// Lines in a polygon's own colour where it was cut from another.
  virtual void seams(const std::vector<Points>& lines, Colour colour) = 0;

  /// What a line of an outline is.
  enum class Line { Slit, Silhouette };

  /// Lines in the settings' outline, or the pale one, and of the settings' width, each through two
  /// points or more, opacity 0 to 1. A line whose first and last points are the same is closed
  /// without a gap.
  virtual void outlines(const std::vector<Points>& lines, Line kind, bool pale = false,
                        double opacity = 1) = 0;
  /// As in the settings, pixels.
  virtual double silhouetteWidth() const = 0;

  /// Lines of a width in pixels, each through two points or more.
  virtual void lines(const std::vector<Points>& lines, double width, Colour colour) = 0;

  /// The whole file; call it once, when everything is drawn. Throws OutputError.
  virtual std::string finish() = 0;
};

/// What pages are written as.
enum class PageFormat { Svg, Pdf, Png };

// ------------------------------------------------------------------------------------------------
// Pages as SVG, for print and for editing.

/// Writes SVG 1.1 that every program reads: filled paths, lines and text, named groups that editors
/// show as layers, and one style sheet that says how faces, outlines and text look. The same page
/// gives the same bytes. The text grows in memory.
std::unique_ptr<Canvas> makeSvgCanvas(const PageSettings& settings);

// ------------------------------------------------------------------------------------------------
// Pages as PDF and as PNG, by Cairo. No Cairo header is needed to make them.

/// Writes a PDF of one page, as large as the settings' pixels are at their resolution: shapes are
/// shapes, text is text, and its font is embedded. The same page gives the same bytes. finish()
/// throws OutputError.
std::unique_ptr<Canvas> makePdfCanvas(const PageSettings& settings);

/// Writes a PNG with as many pixels as the settings say, and notes their resolution. The same page
/// gives the same bytes. Throws OutputError when there is too little memory.
std::unique_ptr<Canvas> makePngCanvas(const PageSettings& settings);

/// A page of any format. The settings' size must be valid, see requireValidSize().
std::unique_ptr<Canvas> makeCanvas(PageFormat format, const PageSettings& settings);

// ------------------------------------------------------------------------------------------------
// Sketches on pages, hidden surfaces removed.

/// Draws what the camera sees of the geometry, from back to front, in parts called `name`_ground,
/// _shadow, _bricks, _outlines and _overlay as far as there are such (without `name`_ when that is
/// empty). size: of the picture, pixels; its upper left corner is at `corner` of the canvas.
/// Names must be unique on a page: they become ids in SVG.
void drawGeometry(const PictureGeometry& geometry, const Camera& camera, FrameSize size,
                  const Eigen::Vector2d& corner, const std::string& name, Canvas& canvas);

}  // namespace kirireel::picture
