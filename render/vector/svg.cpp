#include "render/vector/svg.h"

#include <iterator>

#include <fmt/format.h>

#include "render/vector/depth_order.h"

namespace kirireel {
namespace {

/// Width of the lines in a polygon's own colour that close the gaps which antialiasing leaves
/// between polygons side by side, pixels.
constexpr double kSeam = 0.3;
/// The same where one face was cut in two.
constexpr double kCutSeam = 1.5;

std::string hex(Colour colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.red, colour.green, colour.blue);
}

std::string opacity(Colour colour, const char* property) {
  if (colour.alpha == 255) return {};
  return fmt::format(" {}=\"{:.4g}\"", property, colour.alpha / 255.0);
}

/// Writes polygons in space as paths in the picture.
class PathWriter {
 public:
  PathWriter(const Camera& camera, FrameSize size)
      : clipFromWorld_(clipFromWorld(camera, size.aspect())), size_(size) {}

  void rectangle(Colour colour) {
    append("<rect width=\"{}\" height=\"{}\" fill=\"{}\"{}/>\n", size_.width, size_.height,
           hex(colour), opacity(colour, "fill-opacity"));
  }

  void openGroup(const std::string& attributes) { append("<g {}>\n", attributes); }
  void closeGroup() { append("</g>\n"); }

  /// A polygon in one colour, with lines of that colour on all its sides.
  void sealed(const CutPolygon& polygon, const std::string& colour) {
    append("<path fill=\"{0}\" stroke=\"{0}\" d=\"{1}\"/>\n", colour, outline(polygon));
  }

  void piece(const Piece& piece, const std::string& edge) {
    const std::string colour = hex(piece.colour);
    if (!piece.outlined) return sealed(piece.outer, colour);
    // Where a face was cut, its two parts must join without a line of the outline's colour.
    filled(piece.outer, edge);
    lines(piece.outer, Sides::Whole, edge, kSeam);
    if (piece.inner.corners.empty()) return;
    filled(piece.inner, colour);
    lines(piece.inner, Sides::Cut, colour, kCutSeam);
  }

  std::string text;

 private:
  template <typename... Arguments>
  void append(fmt::format_string<Arguments...> form, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text), form, std::forward<Arguments>(arguments)...);
  }

  /// "12.34 56.78", pixels from the upper left corner.
  std::string place(const Vector3& point) const {
    const Eigen::Vector4d clip = clipFromWorld_ * point.homogeneous();
    return fmt::format("{:.2f} {:.2f}", 0.5 * (1 + clip.x() / clip.w()) * size_.width,
                       0.5 * (1 - clip.y() / clip.w()) * size_.height);
  }

  std::string outline(const CutPolygon& polygon) const {
    std::string path;
    for (const Vector3& corner : polygon.corners) {
      path += (path.empty() ? "M" : "L") + place(corner);
    }
    return path + "Z";
  }

  enum class Sides { Whole, Cut };

  void filled(const CutPolygon& polygon, const std::string& colour) {
    append("<path fill=\"{}\" d=\"{}\"/>\n", colour, outline(polygon));
  }

  /// Lines along those sides of the polygon that came from cutting, or along the others.
  void lines(const CutPolygon& polygon, Sides sides, const std::string& colour, double width) {
    std::string path;
    for (std::size_t k = 0; k < polygon.corners.size(); ++k) {
      if ((polygon.isCut[k] != 0) != (sides == Sides::Cut)) continue;
      path += fmt::format("M{}L{}", place(polygon.corners[k]),
                          place(polygon.corners[(k + 1) % polygon.corners.size()]));
    }
    if (path.empty()) return;
    append("<path fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" d=\"{}\"/>\n", colour, width,
           path);
  }

  Eigen::Matrix4d clipFromWorld_;
  FrameSize size_;
};

/// Shadows that overlap are as dark as one: transparent as a group, not each by itself.
void writeShadow(PathWriter& writer, const std::vector<Piece>& shadow) {
  if (shadow.empty()) return;
  const Colour colour = shadow.front().colour;
  writer.openGroup("id=\"shadow\"" + opacity(colour, "opacity"));
  for (const Piece& piece : shadow) writer.sealed(piece.outer, hex(colour));
  writer.closeGroup();
}

void writeLayer(PathWriter& writer, const char* name, const std::vector<Piece>& pieces,
                Colour edge) {
  if (pieces.empty()) return;
  writer.openGroup(fmt::format("id=\"{}\"", name));
  for (const Piece& piece : pieces) writer.piece(piece, hex(edge));
  writer.closeGroup();
}

}  // namespace

std::string svgText(const Sketch& sketch, const Camera& camera, FrameSize size, Colour background) {
  requireValidSize(size);
  PathWriter writer(camera, size);
  writer.text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
      "viewBox=\"0 0 {0} {1}\">\n",
      size.width, size.height);
  if (background.alpha > 0) writer.rectangle(background);
  writer.openGroup(fmt::format("stroke-width=\"{}\" stroke-linejoin=\"round\"", kSeam));
  writeLayer(writer, "ground", makePieces(sketch, sketch.ground, camera), sketch.edge);
  writeShadow(writer, makePieces(sketch, sketch.shadow, camera));
  writeLayer(writer, "bricks", farthestFirst(makePieces(sketch, sketch.solid, camera)),
             sketch.edge);
  writeLayer(writer, "overlay", makePieces(sketch, sketch.overlay, camera), sketch.edge);
  writer.closeGroup();
  return writer.text + "</svg>\n";
}

}  // namespace kirireel
