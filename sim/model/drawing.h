/// Drawings of lines: SVG and DXF files as geometry, whatever program wrote them.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sim/base/error.h"

namespace kirireel::model {

/// A place in the plane, metres.
using Vector2 = Eigen::Vector2d;

/// One line of a drawing; curves are chains of straight pieces.
struct DrawnPath {
  std::vector<Vector2> points;     ///< metres, y upwards; at least 2, a closed one repeats none
  bool isClosed = false;           ///< the last point leads back to the first
  std::string colour;              ///< "#ff0000"; "fill #ff0000" of a shape without a stroke
  std::string layer;               ///< layer, or outermost group with a name; may be empty
  std::vector<std::string> names;  ///< ids, labels and classes of it and of its groups
  bool isDashed = false;           ///< drawn with a dash pattern
};

/// A drawing. Lengths are metres; the drawing's own coordinates are for messages.
struct Drawing {
  std::vector<DrawnPath> paths;        ///< in the order of the file
  std::map<std::string, int> ignored;  ///< what is no line, and how often: {"text", 2}
  double unit = 1;                     ///< metres of one unit of the drawing's coordinates
  std::string unitName;                ///< "mm"; "px" and "units" where the file names no length
  bool isDownwards = false;            ///< the drawing's y runs down
  Vector2 origin = Vector2::Zero();    ///< of the drawing's coordinates, metres
  double rounding = 0;  ///< the last digit of its coordinates, metres; 0 where they have all digits
  double flattening = 0;  ///< how far straight pieces are off their curves, metres; 0: no curves

  /// "(12.3, 4) mm": a place in the drawing's own coordinates.
  std::string place(const Vector2& point) const;
  /// The diagonal of the box round all lines, metres; 0 without lines.
  double size() const;
};

/// A drawing that is no sheet: a picture shows the fault better than a message.
class DrawingFault : public InputError {
 public:
  /// With the message, the drawing's lines, and where the fault is, metres.
  DrawingFault(const InputError& error, std::vector<DrawnPath> lines, std::vector<Vector2> places)
      : InputError(error), lines_(std::move(lines)), places_(std::move(places)) {}

  /// All lines of the drawing.
  const std::vector<DrawnPath>& lines() const { return lines_; }
  /// One place or more, metres.
  const std::vector<Vector2>& places() const { return places_; }

 private:
  std::vector<DrawnPath> lines_;
  std::vector<Vector2> places_;
};

/// Whether a file is a drawing by its ending.
bool isDrawing(const std::filesystem::path& file);

/// Reads an SVG or DXF file by its ending. Throws InputError for text that is neither, numbers that
/// are none, and drawings of more than 2 million points.
Drawing readDrawing(const std::filesystem::path& file);

/// Reads SVG 1.1 and what SVG 2 adds to lines: all shapes, transforms, nested svg, use, units,
/// viewBox, style sheets with simple selectors. Curves are flattened to within so many metres.
Drawing readSvgDrawing(const std::filesystem::path& file, const std::string& text,
                       double flattening);

/// Reads DXF in ASCII, R12 to 2018: LINE, LWPOLYLINE, POLYLINE, ARC, CIRCLE, ELLIPSE, SPLINE, and
/// INSERT of blocks, on layers that are on.
Drawing readDxfDrawing(const std::filesystem::path& file, const std::string& text,
                       double flattening);

// ------------------------------------------------------------------------------------------------
// What both readers use.

/// Most points of a drawing: a bound on what blocks within blocks can ask for.
inline constexpr std::size_t kMostDrawnPoints = 2'000'000;

/// Adds a path in metres. Repeated points and paths without length are dropped.
void addPath(Drawing& drawing, DrawnPath path, const std::filesystem::path& file);

/// Points of an arc after its first: centre, half axes as vectors, angles in radians.
void addArc(std::vector<Vector2>& points, const Vector2& centre, const Vector2& first,
            const Vector2& second, double from, double sweep, double flattening);

/// In lower case, for names and colours, which are compared so.
std::string lowerCase(std::string_view text);

/// "#rrggbb" of any spelling of a colour in SVG; other words in lower case.
std::string normalColour(std::string_view text);

/// How many decimals the coordinates of a drawing are written with.
struct DecimalCounts {
  std::array<int, 16> numbers{};  ///< how many have 0, 1, ... decimals, or 15 and more

  /// The last place that most of those with decimals have; 0 where they have 7 or more.
  double lastPlace() const;
};

/// A number with '.' or ',' before its decimals, leading '+' allowed. Throws InputError that names
/// the file.
double drawnNumber(std::string_view text, const std::filesystem::path& file,
                   DecimalCounts* decimals = nullptr);

}  // namespace kirireel::model
