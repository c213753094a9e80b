// The plane as complex numbers. At the opening t since the start, a point p of a tile with sign s
// is at
//
//     x = exp(i s t/2) p + 2 i sin(t/2) c,
//
// with one number c per tile. A joint at p, between a tile a with s = 1 and a tile b with s = -1,
// stays closed if
//
//     exp(i t/2) p + 2 i sin(t/2) c_a = exp(-i t/2) p + 2 i sin(t/2) c_b,   so   c_b - c_a = p.
//
// The motion exists for all t if the joints give both signs and numbers without contradiction: the
// joints between tiles form no odd loop, and in each loop the sums of p over the joints in both
// directions are equal.
#include "sim/trajectory/exact_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/model/isometry.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::trajectory {
namespace {

/// Largest contradiction, as a fraction of the sheet.
constexpr double kExact = 1e-9;

/// An opening at which the degrees of freedom are counted, radians: closed states have more.
constexpr double kGeneric = 0.7;

double sizeOf(const std::vector<model::Tile>& tiles) {
  return model::boxOf(tiles).diagonal().norm();
}

}  // namespace

std::optional<ExactMotion> ExactMotion::find(const model::Model& model) {
  const std::optional<model::SheetFrame> frame = model::sheetFrame(model);
  if (!frame || model.joints.empty()) return std::nullopt;
  ExactMotion motion;
  motion.frame_ = *frame;
  motion.start_ = model::toFrame(*frame, model.tiles);
  motion.signs_.assign(model.tiles.size(), 0);
  motion.positions_.assign(model.tiles.size(), Eigen::Vector2d::Zero());
  const double tolerance = kExact * sizeOf(motion.start_);
  const auto at = [&](const model::Corner& corner) -> Eigen::Vector2d {
    return motion.start_[corner.tile].vertices[corner.vertex].head<2>();
  };
  // Each tile is reached through joints from tile 0.
  motion.signs_[0] = 1;
  bool isGrowing = true;
  while (isGrowing) {
    isGrowing = false;
    for (const model::Joint& joint : model.joints) {
      if (joint.kind != model::JointKind::Pivot) return std::nullopt;
      for (const auto& [known, next] : {std::pair(joint.a, joint.b), std::pair(joint.b, joint.a)}) {
        const int sign = motion.signs_[known.tile];
        if (sign == 0 || motion.signs_[next.tile] != 0) continue;
        motion.signs_[next.tile] = -sign;
        motion.positions_[next.tile] = motion.positions_[known.tile] + sign * at(joint.a);
        isGrowing = true;
      }
    }
  }
  if (std::ranges::find(motion.signs_, 0) != motion.signs_.end()) return std::nullopt;
  for (const model::Joint& joint : model.joints) {
    const int sign = motion.signs_[joint.a.tile];
    const Eigen::Vector2d missed =
        motion.positions_[joint.b.tile] - motion.positions_[joint.a.tile] - sign * at(joint.a);
    if (motion.signs_[joint.b.tile] == sign || missed.norm() > tolerance ||
        (at(joint.a) - at(joint.b)).norm() > tolerance) {
      return std::nullopt;
    }
  }
  const Mobility mobility =
      trajectory::mobility(model, motion.tilesAt(kGeneric), Freedom::Plane, sizeOf(model.tiles));
  if (mobility.freedoms != 1) return std::nullopt;
  return motion;
}

std::vector<model::Tile> ExactMotion::tilesAt(double opening) const {
  std::vector<model::Tile> tiles = start_;
  const double shift = 2 * std::sin(opening / 2);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const Eigen::Rotation2Dd turn(signs_[i] * opening / 2);
    const Eigen::Vector2d moved = shift * Eigen::Vector2d(-positions_[i].y(), positions_[i].x());
    for (Vector3& vertex : tiles[i].vertices) {
      vertex.head<2>() = turn * vertex.head<2>() + moved;
      vertex = frame_.toWorld(vertex);
    }
  }
  return tiles;
}

std::vector<model::Tile> ExactMotion::nearest(double opening,
                                              const std::vector<model::Tile>& state) const {
  std::vector<model::Tile> best;
  double least = 0;
  for (const double signedOpening : {opening, -opening}) {
    std::vector<model::Tile> tiles = model::bestFitted(tilesAt(signedOpening), state);
    const double distance = vertexDistance(tiles, state).mean;
    if (!best.empty() && !(distance < least)) continue;
    least = distance;
    best = std::move(tiles);
  }
  return best;
}

VertexDistance vertexDistance(const std::vector<model::Tile>& a,
                              const std::vector<model::Tile>& b) {
  VertexDistance result;
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < a[i].vertices.size(); ++k, ++count) {
      const double distance = (a[i].vertices[k] - b[i].vertices[k]).norm();
      result.largest = std::max(result.largest, distance);
      result.mean += distance;
    }
  }
  if (count > 0) result.mean /= static_cast<double>(count);
  return result;
}

double largestRadius(const std::vector<model::Tile>& tiles) {
  Vector3 mean = Vector3::Zero();
  double count = 0, radius = 0;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) mean += vertex;
    count += static_cast<double>(tile.vertices.size());
  }
  mean /= count;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) radius = std::max(radius, (vertex - mean).norm());
  }
  return radius;
}

}  // namespace kirireel::trajectory
