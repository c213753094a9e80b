// Faces are painted over each other in the order of farthestFirst(), each filled whole and closed
// against what it was cut from. Over all of them what shows of their own sides (seenOutlines()) is
// drawn as lines of one width; sides that came from cutting a face are none of its own.
#include "render/vector/drawing.h"

#include <algorithm>

#include "render/vector/depth_order.h"
#include "sim/base/interruption.h"

namespace kirireel {
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
  const auto layer = [&](const char* part, std::vector<Piece> pieces, double opacity = 1) {
    if (pieces.empty()) return;
    canvas.begin(name.empty() ? part : name + '_' + part, opacity);
    drawPieces(pieces, project, canvas);
    canvas.end();
  };
  layer("ground", makePieces(sketch, sketch.ground, camera));
  // Shadows that overlap are as dark as one: transparent together, not each by itself.
  std::vector<Piece> shadow = makePieces(sketch, sketch.shadow, camera);
  const double opacity = shadow.empty() ? 1 : shadow.front().colour.alpha / 255.0;
  for (Piece& piece : shadow) piece.colour.alpha = 255;
  layer("shadow", std::move(shadow), opacity);
  const std::vector<Piece> solid = makePieces(sketch, sketch.solid, camera);
  layer("bricks", farthestFirst(solid));
  if (std::ranges::any_of(solid, &Piece::outlined)) {
    canvas.begin(name.empty() ? "outlines" : name + "_outlines");
    drawOutlines(seenOutlines(solid, camera), project, canvas);
    canvas.end();
  }
  layer("overlay", makePieces(sketch, sketch.overlay, camera));
}

}  // namespace kirireel
