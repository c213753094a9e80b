/// Pages of vector graphics.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "render/grid/surface.h"
#include "sim/base/geometry.h"

namespace kirireel {

/// How a page is made. The page's unit is a pixel; at 96 of them an inch a page is as large as a
/// browser shows it.
struct PageSettings {
  FrameSize size;  ///< in its own unit, the pixels of a picture of the same layout
  double pixelsPerInch = 96;
  Colour background = {255, 255, 255};
  Colour outline;           ///< of bricks
  Colour paleOutline;       ///< of dark bricks
  double outlineWidth = 1;  ///< pixels
  std::string fontFamily;   ///< of all text
  std::string description;  ///< who made it from what, one line
};

/// Width of the lines in a polygon's own colour that close the gaps which antialiasing leaves
/// between polygons side by side, pixels.
inline double seamWidth(const PageSettings& settings) {
  return std::max(0.3, 0.4 * settings.outlineWidth);
}

/// The same where one face was cut in two.
inline double cutSeamWidth(const PageSettings& settings) {
  return 3 * seamWidth(settings);
}

/// A page that is drawn on from back to front. Lengths are pixels of PageSettings::size. Calls come
/// in painting order: what is drawn later covers what is there.
class Canvas : public Surface {
 public:
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

  /// Lines in the settings' outline, or the pale one, each through two points or more. A line whose
  /// first and last points are the same is closed without a gap.
  virtual void outlines(const std::vector<Points>& lines, bool pale = false) = 0;

  /// Lines of a width in pixels, each through two points or more.
  virtual void lines(const std::vector<Points>& lines, double width, Colour colour) = 0;

  /// The whole file; call it once, when everything is drawn. Throws OutputError.
  virtual std::string finish() = 0;
};

/// What pages are written as.
enum class PageFormat { Svg, Pdf, Png };

}  // namespace kirireel
