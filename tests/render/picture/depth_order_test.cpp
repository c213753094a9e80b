#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "render/picture/picture_geometry.h"
#include "tests/render/picture/sample_bricks.h"

namespace kirireel {
namespace {

double area(const picture::CutPolygon& polygon) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 2; k < polygon.corners.size(); ++k) {
    sum += (polygon.corners[k - 1] - polygon.corners[0])
               .cross(polygon.corners[k] - polygon.corners[0]);
  }
  return 0.5 * sum.norm();
}

double totalArea(const std::vector<picture::Piece>& pieces) {
  double sum = 0;
  for (const picture::Piece& piece : pieces) sum += area(piece.outer);
  return sum;
}

picture::Camera cameraOf(const SampleBricks& sample) {
  return picture::fitCamera(picture::brickCorners(sample.bricks, sample.poses), {});
}

picture::PictureGeometry geometryOf(const SampleBricks& sample, const picture::Camera& camera) {
  picture::PictureGeometry geometry;
  picture::GeometryBuilder(sample.bricks, {})
      .draw({sample.poses, {}, {}, {}, {}}, camera, geometry);
  return geometry;
}

std::vector<picture::Piece> piecesOf(const SampleBricks& sample, const picture::Camera& camera) {
  return picture::drawnPieces(geometryOf(sample, camera), camera);
}

/// Bricks that cross each other at all angles.
SampleBricks heap() {
  SampleBricks sample = tumbledBricks();
  for (Pose& pose : sample.poses) pose.position *= 0.4;
  return sample;
}

TEST(DepthOrder, CutsWithoutLosingAnything) {
  const SampleBricks sample = heap();
  const std::vector<picture::Piece> pieces = piecesOf(sample, cameraOf(sample));
  const std::vector<picture::Piece> sorted = picture::farthestFirst(pieces);
  EXPECT_GT(sorted.size(), pieces.size());
  EXPECT_NEAR(totalArea(sorted) / totalArea(pieces), 1, 1e-12);  // measured 2e-15
}

TEST(DepthOrder, KeepsBricksWholeThatNoPlaneCuts) {
  std::vector<model::Tile> tiles;
  for (int k = 0; k < 25; ++k) tiles.push_back(rectangleTile(k % 5, k / 5, 0.9, 0.9));
  const SampleBricks sample = sampleBricks(tiles, 0.1);
  const std::vector<picture::Piece> pieces = piecesOf(sample, cameraOf(sample));
  EXPECT_EQ(picture::farthestFirst(pieces).size(), pieces.size());
}

/// The intersection of the sight line with the piece, in units of its direction; infinity without
/// one.
double distanceTo(const picture::Piece& piece, const Vector3& eye, const Vector3& direction) {
  const double distance = (piece.offset - piece.normal.dot(eye)) / piece.normal.dot(direction);
  const Vector3 point = eye + distance * direction;
  const std::vector<Vector3>& corners = piece.outer.corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector3 side = corners[(k + 1) % corners.size()] - corners[k];
    if (piece.normal.dot(side.cross(point - corners[k])) < -1e-9) return INFINITY;
  }
  return distance;
}

TEST(DepthOrder, PaintsTheNearestLastOnEverySightLine) {
  const SampleBricks sample = heap();
  const picture::Camera camera = cameraOf(sample);
  const std::vector<picture::Piece> sorted = picture::farthestFirst(piecesOf(sample, camera));
  for (const picture::Piece& aim : sorted) {
    Vector3 middle = Vector3::Zero();
    for (const Vector3& corner : aim.outer.corners) middle += corner;
    middle /= static_cast<double>(aim.outer.corners.size());
    double nearest = INFINITY, last = INFINITY;
    for (const picture::Piece& piece : sorted) {
      const double distance = distanceTo(piece, camera.eye, middle - camera.eye);
      nearest = std::min(nearest, distance);
      if (distance < INFINITY) last = distance;
    }
    EXPECT_NEAR(last, nearest, 1e-6);  // measured 0
  }
}

TEST(DepthOrder, TakesTilesThatAreNotExactlyFlat) {
  model::Tile bent = rectangleTile(0, 0, 1, 1);
  bent.vertices[2].z() += 1e-4;
  const SampleBricks sample = sampleBricks({bent, rectangleTile(1, 0, 1, 1)}, 1e-3);
  const std::vector<picture::Piece> pieces = piecesOf(sample, cameraOf(sample));
  EXPECT_GE(picture::farthestFirst(pieces).size(), pieces.size());
}

TEST(DepthOrder, CutsPartsNearerThanTheCamerasRange) {
  SampleBricks sample = sampleBricks({rectangleTile(0, -50, 1, 100)}, 0.1);
  picture::Camera camera;
  camera.eye = Vector3(0.5, 0, 2);
  camera.centre = Vector3(0.5, 10, 0);
  camera.up = Vector3::UnitZ();
  camera.near = 0.5;
  const Vector3 forward = (camera.centre - camera.eye).normalized();
  for (const picture::Piece& piece : piecesOf(sample, camera)) {
    for (const Vector3& corner : piece.outer.corners) {
      EXPECT_GE(forward.dot(corner - camera.eye), camera.near - 1e-9);
    }
  }
}

/// Whether another piece is in front of a point of one.
bool isHidden(const std::vector<picture::Piece>& pieces, const picture::Piece& own,
              const Vector3& point, const picture::Camera& camera) {
  return std::ranges::any_of(pieces, [&](const picture::Piece& piece) {
    return &piece != &own && distanceTo(piece, camera.eye, point - camera.eye) < 1 - 1e-6;
  });
}

bool isOn(const std::vector<picture::VisibleLine>& lines, const Vector3& point) {
  for (const auto& [line, isSilhouette] : lines) {
    for (std::size_t k = 1; k < line.size(); ++k) {
      const Vector3 side = line[k] - line[k - 1];
      const double share = std::clamp((point - line[k - 1]).dot(side) / side.squaredNorm(), 0., 1.);
      if ((line[k - 1] + share * side - point).norm() < 1e-9) return true;
    }
  }
  return false;
}

TEST(SeenOutlines, AreTheLinesThatNoBrickHides) {
  const SampleBricks sample = heap();
  const picture::Camera camera = cameraOf(sample);
  const std::vector<picture::Piece> pieces = piecesOf(sample, camera);
  const std::vector<picture::VisibleOutline> seen =
      picture::visibleOutlines(geometryOf(sample, camera), pieces, camera, 0);
  ASSERT_EQ(seen.size(), pieces.size());
  int points = 0, hidden = 0, wrong = 0;
  for (std::size_t piece = 0; piece < pieces.size(); ++piece) {
    const std::vector<Vector3>& corners = pieces[piece].outer.corners;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vector3 side = corners[(k + 1) % corners.size()] - corners[k];
      for (double share = 0.005; share < 1; share += 0.01) {
        const Vector3 point = corners[k] + share * side;
        const bool isBehind = isHidden(pieces, pieces[piece], point, camera);
        ++points;
        hidden += isBehind ? 1 : 0;
        wrong += isOn(seen[piece].lines, point) == isBehind ? 1 : 0;
      }
    }
  }
  EXPECT_GT(hidden, points / 10);
  EXPECT_LT(static_cast<double>(wrong) / points, 0.004);
}

TEST(SeenOutlines, AreClosedIfNothingIsBefore) {
  std::vector<model::Tile> tiles;
  for (int k = 0; k < 25; ++k) tiles.push_back(rectangleTile(k % 5, k / 5, 1, 1));
  const SampleBricks sample = sampleBricks(tiles, 0.1);
  picture::CameraFit fit;
  fit.view = picture::kTopView;
  for (const bool parallel : {false, true}) {
    fit.orthographic = parallel;
    const picture::Camera camera =
        picture::fitCamera(picture::brickCorners(sample.bricks, sample.poses), fit);
    const std::vector<picture::Piece> pieces = piecesOf(sample, camera);
    const std::vector<picture::VisibleOutline> seen =
        picture::visibleOutlines(geometryOf(sample, camera), pieces, camera, 0);
    int closed = 0;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      if (pieces[k].normal.z() < 0.5) continue;
      ASSERT_EQ(seen[k].lines.size(), 1U);
      const std::vector<Vector3>& line = seen[k].lines[0].points;
      closed += line.size() == 5 && line.front() == line.back() ? 1 : 0;
    }
    EXPECT_EQ(closed, 25) << parallel;
  }
}

/// The lengths of silhouettes and of other lines of a sheet, metres.
std::pair<double, double> lengthsOf(const SampleBricks& sample, const picture::Camera& camera,
                                    double width) {
  std::pair<double, double> lengths;
  for (const picture::VisibleOutline& outline : picture::visibleOutlines(
           geometryOf(sample, camera), piecesOf(sample, camera), camera, width)) {
    for (const auto& [line, isSilhouette] : outline.lines) {
      for (std::size_t k = 1; k < line.size(); ++k) {
        (isSilhouette ? lengths.first : lengths.second) += (line[k] - line[k - 1]).norm();
      }
    }
  }
  return lengths;
}

/// 5 x 5 squares with gaps between them. In gaps narrower than half a line their sides are slits.
/// Otherwise all sides are silhouettes.
TEST(SeenOutlines, AreSilhouettesIfNothingIsBeyond) {
  for (const double gap : {0.0, 0.004, 0.02}) {
    std::vector<model::Tile> tiles;
    for (int k = 0; k < 25; ++k) {
      tiles.push_back(rectangleTile((k % 5) * (1 + gap), (k / 5) * (1 + gap), 1, 1));
    }
    const SampleBricks sample = sampleBricks(tiles, 0.1);
    picture::CameraFit fit;
    fit.view = picture::kTopView;
    fit.orthographic = true;
    const picture::Camera camera =
        picture::fitCamera(picture::brickCorners(sample.bricks, sample.poses), fit);
    // The picture is 5.7 m high: half a line is 0.008 m wide.
    const auto [silhouettes, slits] = lengthsOf(sample, camera, 0.0028);
    EXPECT_NEAR(silhouettes, gap < 0.01 ? 20 : 100, 0.3) << gap;
    EXPECT_NEAR(slits, gap < 0.01 ? 80 : 0, 0.3) << gap;
  }
}

}  // namespace
}  // namespace kirireel
