// A planar start is turned so that its tiles face +z, q n = z with n the normal of tile 0, and z is
// dropped. All heights may differ by 1e-6 of the model's size at most.
//
// A gap at a corner is the turn from the edge of one tile that arrives there, looked back along, to
// the edge of the other that leaves, anticlockwise, 0 to 2 pi. The other gap of the joint is found
// with the tiles exchanged.
#include "render/sheet/flat_sheet.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr double kFlatness = 1e-6;  ///< of the model size, that vertices may be off the plane

/// Looks at every vertex.
void requireFlat(const Model& model, const Vector3& normal) {
  const Vector3& origin = model.tiles[0].vertices[0];
  const double allowed = kFlatness * modelSize(model);
  for (std::size_t t = 0; t < model.tiles.size(); ++t) {
    if (tileNormal(model.tiles[t]).dot(normal) < 0) {
      throw InputError(
          fmt::format("error: tile {} faces the other way than tile 0; a cut pattern "
                      "needs all tiles on one side: reverse its vertices",
                      t));
    }
    for (const Vector3& vertex : model.tiles[t].vertices) {
      const double height = std::abs((vertex - origin).dot(normal));
      if (height <= allowed) continue;
      throw InputError(
          fmt::format("error: the start is not flat: tile {} reaches {:.3g} m out of "
                      "the plane of tile 0; only planar models have a cut pattern",
                      t, height));
    }
  }
}

/// A gap that is closed but for rounding may come out as slightly less than 0; it counts as 0 and
/// not as a full turn.
CornerGap gapBetween(const std::vector<FlatTile>& tiles, const Corner& a, const Corner& b) {
  const int sides = static_cast<int>(tiles[a.tile].size());
  CornerGap gap;
  gap.first = {a.tile, (a.vertex + sides - 1) % sides, false};
  gap.second = {b.tile, b.vertex, true};
  const Vector2 from = directionFrom(tiles, gap.first);
  const Vector2 to = directionFrom(tiles, gap.second);
  gap.angle = std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
  if (gap.angle < -kClosedAngle) gap.angle += 2 * std::numbers::pi;
  gap.angle = std::max(gap.angle, 0.0);
  return gap;
}

}  // namespace

FlatSheet flatSheet(const Model& model) {
  const Vector3 normal = tileNormal(model.tiles[0]);
  requireFlat(model, normal);
  FlatSheet sheet;
  sheet.turn = Quaternion::FromTwoVectors(normal, Vector3::UnitZ());
  sheet.height = (sheet.turn * model.tiles[0].vertices[0]).z();
  for (const Tile& tile : model.tiles) {
    FlatTile& flat = sheet.tiles.emplace_back();
    for (const Vector3& vertex : tile.vertices) flat.push_back((sheet.turn * vertex).head<2>());
  }
  return sheet;
}

void requirePivot(const Joint& joint, std::size_t number) {
  if (joint.kind == JointKind::Pivot) return;
  throw InputError(
      fmt::format("error: joint {} does not hold two corners together; a cut "
                  "pattern knows hinges at corners alone",
                  number));
}

CornerGap narrowGap(const std::vector<FlatTile>& tiles, const Joint& joint) {
  const CornerGap ahead = gapBetween(tiles, joint.a, joint.b);
  const CornerGap behind = gapBetween(tiles, joint.b, joint.a);
  return ahead.angle <= behind.angle ? ahead : behind;
}

Vector2 directionFrom(const std::vector<FlatTile>& tiles, const EdgeEnd& end) {
  const FlatTile& tile = tiles[end.tile];
  const Vector2 along = (tile[(end.edge + 1) % tile.size()] - tile[end.edge]).normalized();
  return end.atStart ? along : Vector2(-along);
}

}  // namespace kirireel
