// The bricks are painted first by the usual painter, then numbers are drawn over the pixels at the
// places where the camera shows the middles and corners. A number is left out where another tile
// hides its place. Its size follows the tile's: with s the side of a square of as many pixels,
// tiles' numbers are 0.28 s high (7 to 40 pixels), corners' 0.14 s (6 to 20), and corners of tiles
// below 40 pixels have none.
//
// A corner's number stands at 22% of the way from it into its tile, so that the numbers of tiles
// that meet in a corner stand apart.
#include "render/inspect/numbered_picture.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "render/grid/grid.h"
#include "render/grid/label.h"
#include "render/inspect/line_of_sight.h"
#include "render/picture/painter.h"
#include "sim/model/convex_parts.h"

namespace kirireel {
namespace {

constexpr Colour kTileNumber = {20, 30, 44};
constexpr Colour kVertexNumber = {150, 30, 30};

std::vector<Vector3> allVertices(const std::vector<Tile>& tiles) {
  std::vector<Vector3> points;
  for (const Tile& tile : tiles) {
    points.insert(points.end(), tile.vertices.begin(), tile.vertices.end());
  }
  return points;
}

/// A place within the tile for its number: the centroid, or that of the largest part of a concave
/// tile, whose own may lie outside.
Vector3 middleOf(const Tile& tile) {
  Tile largest;
  for (const PolygonPart& part : convexParts(tile.vertices, tileNormal(tile))) {
    Tile piece;
    for (const int corner : part) piece.vertices.push_back(tile.vertices[corner]);
    if (largest.vertices.empty() || tileArea(piece) > tileArea(largest)) largest = piece;
  }
  return tileCentroid(largest);
}

/// The middle of a convex part that has this vertex: towards it the way leads into the tile.
Vector3 middleBy(const Tile& tile, int vertex) {
  for (const PolygonPart& part : convexParts(tile.vertices, tileNormal(tile))) {
    if (std::find(part.begin(), part.end(), vertex) == part.end()) continue;
    Tile piece;
    for (const int corner : part) piece.vertices.push_back(tile.vertices[corner]);
    return tileCentroid(piece);
  }
  return tileCentroid(tile);
}

/// One state: picture and numbers from one camera.
class StatePicture {
 public:
  StatePicture(const std::vector<Tile>& tiles, const Model& model, const BrickRule& rule,
               FrameSize size)
      : tiles_(tiles), order_(model.fileOrder), size_(size) {
    const std::vector<Vector3> points = allVertices(tiles);
    CameraFit fit;
    fit.view = defaultView(points);
    fit.aspect = size.aspect();
    // Parallel, so that equal tiles have numbers of equal size.
    fit.orthographic = true;
    camera_ = fitCamera(points, fit);
    const std::vector<Brick> bricks = makeBricks(tiles, rule);
    Shot shot;
    shot.poses = startPoses(tiles, bricks);
    for (const Mend& mend : model.mends) {
      for (const Corner& corner : mend.corners) {
        shot.marks.push_back(tiles[corner.tile].vertices[corner.vertex]);
      }
    }
    frame_ = Painter(size, bricks, Style{}).paint(shot, camera_);
  }

  /// To be called once: it gives the frame away.
  Frame numbered() {
    const Vector3 towardsEye = (camera_.eye - camera_.centre).normalized();
    const LineOfSight sight(tiles_, towardsEye);
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      const Vector3 middle = middleOf(tiles_[i]);
      const double pixels = apparentSize(tiles_[i], towardsEye);
      if (sight.isClear(middle, i)) {
        write(fmt::format("{}", order_.countsFrom + i), middle,
              std::clamp(0.28 * pixels, 7.0, 40.0), kTileNumber);
      }
      if (pixels < 40) continue;  // vertices' numbers could not be read
      for (std::size_t k = 0; k < tiles_[i].vertices.size(); ++k) {
        const Vector3& vertex = tiles_[i].vertices[k];
        const Vector3 inside = vertex + 0.22 * (middleBy(tiles_[i], static_cast<int>(k)) - vertex);
        if (!sight.isClear(inside, i)) continue;
        // The reader may have turned a tile's order round; the number is the file's.
        const int inFile = order_.across({static_cast<int>(i), static_cast<int>(k)}, tiles_).vertex;
        write(fmt::format("{}", order_.countsFrom + inFile), inside,
              std::clamp(0.14 * pixels, 6.0, 20.0), kVertexNumber);
      }
    }
    return std::move(frame_);
  }

 private:
  /// The side of a square that fills as many pixels as the tile. Pixels: the area as the camera
  /// sees it, |n . e| times the true one.
  double apparentSize(const Tile& tile, const Vector3& towardsEye) const {
    const double area = tileArea(tile) * std::abs(tileNormal(tile).dot(towardsEye));
    return size_.height / heightAtCentre(camera_) * std::sqrt(area);
  }

  void write(const std::string& text, const Vector3& place, double pixels, Colour colour) {
    const int em = static_cast<int>(pixels);
    // Writers load a font, so there is one for each size.
    const LabelWriter& writer = writers_.try_emplace(em, em).first->second;
    const Eigen::Vector4d clip = clipFromWorld(camera_, size_.aspect()) * place.homogeneous();
    // From clip coordinates, -1 to 1 with y up, to pixels with y down.
    const double x = 0.5 * (1 + clip.x() / clip.w()) * size_.width;
    const double y = 0.5 * (1 - clip.y() / clip.w()) * size_.height;
    const int width = writer.width(text);
    // Digits are about 0.7 of the em high, and 0.6 wide.
    const double height = 1.2 * width / static_cast<double>(text.size());
    writer.draw(frame_, text, static_cast<int>(std::lround(x - 0.5 * width)),
                static_cast<int>(std::lround(y + 0.5 * height)), colour);
  }

  const std::vector<Tile>& tiles_;
  const FileOrder& order_;  ///< numbers are the file's
  FrameSize size_;
  Camera camera_;
  Frame frame_;
  std::map<int, LabelWriter> writers_;  ///< by their size, pixels
};

}  // namespace

Frame numberedPicture(const Scene& scene, FrameSize stateSize) {
  std::vector<GridPicture> pictures;
  pictures.push_back(
      {StatePicture(scene.model.tiles, scene.model, scene.brick, stateSize).numbered(), "start"});
  if (scene.model.target) {
    pictures.push_back(
        {StatePicture(*scene.model.target, scene.model, scene.brick, stateSize).numbered(),
         "target"});
  }
  return composeGrid(pictures, {1, static_cast<int>(pictures.size())});
}

Frame crossingPicture(const Tile& tile, const Vector3& place, FrameSize size) {
  CameraFit fit;
  fit.view = defaultView(tile.vertices);
  fit.aspect = size.aspect();
  fit.orthographic = true;
  Style style;
  style.markSize = 0.03;
  Shot shot;
  shot.overlay = {tile};
  shot.marks = {place};
  return Painter(size, {}, style).paint(shot, fitCamera(tile.vertices, fit));
}

}  // namespace kirireel
