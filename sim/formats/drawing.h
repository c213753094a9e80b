/// Drawings of lines: SVG and DXF files from any program as geometry.
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

namespace kirireel::formats {

/// A position in the plane, metres.
using Vector2 = Eigen::Vector2d;

/// One line of a drawing; curves are chains of straight pieces.
struct DrawnPath {
  std::vector<Vector2> points;     ///< metres, y upwards; at least 2; closed paths repeat none
  bool isClosed = false;           ///< the last point is connected to the first
  std::string colour;              ///< "#ff0000"; "fill #ff0000" for a shape without stroke
  std::string layer;               ///< layer, or outermost named group; may be empty
  std::vector<std::string> names;  ///< its ids, labels and classes, and those of its groups
  bool isDashed = false;           ///< drawn with a dash pattern
};

/// A drawing. Lengths are in metres. The drawing's own coordinates are used in messages.
struct Drawing {
  std::vector<DrawnPath> paths;   ///< in the order of the file
  std::vector<DrawnPath> shapes;  ///< filled shapes without a stroke, if other lines have strokes
  std::map<std::string, int> ignored;  ///< other elements than lines, with counts: {"text", 2}
  double unit = 1;                     ///< metres per unit of the drawing's coordinates
  std::string unitName;                ///< "mm"; "px" or "units" if that is no unit of length
  bool hasUnit = false;                ///< whether the file gives its size in a unit of length
  bool isDownwards = false;            ///< the drawing's y axis points down
  Vector2 origin = Vector2::Zero();    ///< of the drawing's coordinates, metres
  double rounding = 0;                 ///< last digit of its coordinates, metres; 0: all digits
  double flattening = 0;  ///< deviation of straight pieces from their curves, metres; 0: no curves

  /// "(12.3, 4) mm": a position in the drawing's own coordinates.
  std::string place(const Vector2& point) const;
  /// "3.2 mm": a length in the unit of these coordinates.
  std::string length(double metres) const;
  /// Diagonal of the bounding box of all lines, metres; 0 without lines.
  double size() const;
};

/// Error for a drawing that is not a sheet. The caller can draw the fault.
class DrawingFault : public InputError {
 public:
  /// The drawing's lines, and the positions of the fault, metres.
  DrawingFault(const InputError& error, std::vector<DrawnPath> lines, std::vector<Vector2> places)
      : InputError(error), lines_(std::move(lines)), places_(std::move(places)) {}

  /// All lines of the drawing.
  const std::vector<DrawnPath>& lines() const { return lines_; }
  /// One or more positions, metres.
  const std::vector<Vector2>& places() const { return places_; }

 private:
  std::vector<DrawnPath> lines_;
  std::vector<Vector2> places_;
};

/// Whether a file is a drawing, by its ending.
bool isDrawing(const std::filesystem::path& file);

/// Reads an SVG or DXF file by its ending. Throws InputError for text that is neither, invalid
/// numbers, and drawings with more than 2 million points.
Drawing readDrawing(const std::filesystem::path& file);

/// Reads SVG 1.1 and the line elements of SVG 2: all shapes, transforms, nested svg, use, units,
/// viewBox, style sheets. Curves are flattened to a tolerance in metres.
Drawing readSvgDrawing(const std::filesystem::path& file, const std::string& text,
                       double flattening);

/// Reads ASCII DXF, R12 to 2018: LINE, LWPOLYLINE, POLYLINE, ARC, CIRCLE, ELLIPSE, SPLINE, and
/// INSERT of blocks, on visible layers.
Drawing readDxfDrawing(const std::filesystem::path& file, const std::string& text,
                       double flattening);

// ------------------------------------------------------------------------------------------------
// Functions of both readers.

/// The name of Drawing::shapes in Drawing::ignored.
inline constexpr const char* kShapeWithoutStroke = "shape without a stroke";

/// Maximum number of points of a drawing, a limit for nested blocks.
inline constexpr std::size_t kMaxDrawnPoints = 2'000'000;

/// Adds a path in metres. Repeated points and paths without length are dropped.
void addPath(Drawing& drawing, DrawnPath path, const std::filesystem::path& file);

/// Points of an arc after its first: centre, half axes as vectors, angles in radians.
void addArc(std::vector<Vector2>& points, const Vector2& centre, const Vector2& first,
            const Vector2& second, double from, double sweep, double flattening);

/// Lower case text, for comparisons of names and colours.
std::string lowerCase(std::string_view text);

/// "#rrggbb" for any spelling of a colour in SVG; other words in lower case.
std::string normalColour(std::string_view text);

/// Counts of decimals of a drawing's coordinates.
struct DecimalCounts {
  /// Count of coordinates with 0, 1, ... decimals, or 15 and more, without zeros at the end.
  std::array<int, 16> numbers{};

  /// The finest place that is in use: 1, 0.1, ... A few numbers may have more decimals. 0 for 7 or
  /// more decimals.
  double lastPlace() const;
};

/// A list for a message: at most `most` entries, and the number of others.
std::string listed(const std::vector<std::string>& entries, std::size_t most = 8);

/// "2 x text" for each of these counts.
std::vector<std::string> entriesOf(const std::map<std::string, int>& counts);

/// A number with '.' or ',' before its decimals, possibly with a leading '+'. Throws InputError
/// with the place.
double drawnNumber(std::string_view text, const FileLocation& place,
                   DecimalCounts* decimals = nullptr);

}  // namespace kirireel::formats
