// Joints of necks: which joint is exact, which one a ligament.
//
// A neck at a joint of two tiles has, where the slit beside it is shut at the start, an axis that
// lies beside the corner along the slit (neckAxis()). With a length, and where ligaments are asked
// for, it becomes a straight ligament whose middle is the joint and which runs from tile A to tile
// B. Without a length it is the end of the slit: a pin that parts across the slit and slides along
// it. All other joints stay exact.
#include "sim/deploy/neck_ties.h"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/model/neck_stiffness.h"
#include "sim/scene/hinge_springs.h"

namespace kirireel {
namespace {

/// The directions of both edges from a corner, unit.
/// The corner's next and last neighbour give them, in the order of the tile's corners.
std::array<Vector3, 2> edgesAt(const Brick& brick, int corner) {
  const std::size_t count = brick.bottom.size();
  const auto k = static_cast<std::size_t>(corner);
  return {(brick.bottom[(k + 1) % count] - brick.bottom[k]).normalized(),
          (brick.bottom[(k + count - 1) % count] - brick.bottom[k]).normalized()};
}

/// The direction from a corner into its tile.
/// The sum of two unit edges bisects the corner's angle; its length is no measure.
Vector3 inwardAt(const Brick& brick, int corner) {
  const auto [next, last] = edgesAt(brick, corner);
  return next + last;
}

/// The edge of both tiles that starts at their joint, unit, where a shut slit lies along one.
std::optional<Vector3> slitAt(const Pivot& pivot, const std::vector<Brick>& bricks) {
  constexpr double kFlush = 1e-6;  // of the cosine
  const Brick& brickA = bricks[static_cast<std::size_t>(pivot.brickA)];
  const Brick& brickB = bricks[static_cast<std::size_t>(pivot.brickB)];
  for (const Vector3& a : edgesAt(brickA, pivot.cornerA)) {
    for (const Vector3& b : edgesAt(brickB, pivot.cornerB)) {
      if (a.dot(b) > 1 - kFlush) return a;
    }
  }
  return std::nullopt;
}

/// The neck at a joint as a ligament: its middle is the joint, and it runs from one tile to the
/// other.
Ligament ligamentAt(const Pivot& pivot, const std::vector<Brick>& bricks, const Scene& scene) {
  const HingeNeck& neck = *scene.hinges.neck;
  const Vector3 across =
      inwardAt(bricks[static_cast<std::size_t>(pivot.brickB)], pivot.cornerB).normalized() -
      inwardAt(bricks[static_cast<std::size_t>(pivot.brickA)], pivot.cornerA).normalized();
  Ligament ligament{pivot.brickA, pivot.brickB, pivot.joint};
  // The ligament runs along the difference of the two inward directions: from tile A to tile B
  // across the slit.
  ligament.start = neck.length * across.normalized();
  ligament.pointA = pivot.pointA - 0.5 * ligament.start;
  ligament.pointB = pivot.pointB + 0.5 * ligament.start;
  setNeckStiffness(neck.youngs, neck.poisson, scene.brick.thickness, neck.width, neck.length,
                   ligament);
  return ligament;
}

/// A neck without a length at the end of a shut slit, as the pin that its tiles make of it.
Ligament pinAt(const Pivot& pivot, const std::vector<Brick>& bricks, const Vector3& slit,
               const Scene& scene) {
  const CornerNeck neck =
      cornerNeck(scene.hinges.neck->youngs, scene.brick.thickness, scene.hinges.neck->width,
                 neckSide(bricks, pivot.brickA, pivot.brickB));
  Ligament pin{pivot.brickA, pivot.brickB, pivot.joint,
               pivot.pointA, pivot.pointB, Vector3::Zero()};
  pin.across = slit.cross(Vector3::UnitZ());
  pin.stretchStiffness = neck.stretch;
  pin.shearStiffness = neck.shear;
  // B turns by z as the slit opens where it lies on that side of it.
  const Brick& brickB = bricks[static_cast<std::size_t>(pivot.brickB)];
  const double sign = inwardAt(brickB, pivot.cornerB).dot(pin.across) < 0 ? 1 : -1;
  pin.opening = {sign * neck.bending * neck.opening[0], neck.bending * neck.opening[1]};
  return pin;
}

/// Adds what a neck at a hinge is: under grips one that is no more than the end of a slit always
/// gives as its tiles do, and others where ligaments are asked for.
void addNeck(Pivot pivot, const std::vector<Brick>& bricks, const Scene& scene, Ties& ties) {
  const HingeNeck& neck = *scene.hinges.neck;
  const std::optional<Vector3> slit = slitAt(pivot, bricks);
  if (slit) {
    // Its axis is beside the corner.
    const double axis =
        neckAxis(neck.width, neck.length, neckSide(bricks, pivot.brickA, pivot.brickB));
    pivot.pointA += axis * *slit;
    pivot.pointB += axis * *slit;
  }
  if (slit && neck.length == 0) {
    ties.ligaments.push_back(pinAt(pivot, bricks, *slit, scene));
  } else if (scene.hinges.areLigaments) {
    if (neck.length == 0) {
      throw InputError(
          "error: --ligaments needs necks with a length where no slit is shut, for a neck without "
          "one neither stretches nor shears there; give one in --hinge-neck, or leave --ligaments "
          "away");
    }
    ties.ligaments.push_back(ligamentAt(pivot, bricks, scene));
  } else {
    ties.pivots.push_back(pivot);
  }
}

}  // namespace

// A joint is a neck where its two bricks share a hinge that has a spring. Upper pivots coincide
// with lower ones in the plane and are left out.
Ties tiesOf(const Scene& scene, const std::vector<Brick>& bricks,
            const std::vector<HingeSpring>& springs) {
  std::set<std::pair<int, int>> hinges;
  for (const HingeSpring& spring : springs) {
    hinges.insert(std::minmax(spring.hinge.brickA, spring.hinge.brickB));
  }
  Ties ties;
  for (const Pivot& pivot : makePivots(scene.model.joints, bricks)) {
    if (pivot.isUpper) continue;
    const bool isNeck =
        scene.hinges.neck && hinges.contains(std::minmax(pivot.brickA, pivot.brickB));
    if (isNeck) {
      addNeck(pivot, bricks, scene, ties);
    } else {
      ties.pivots.push_back(pivot);
    }
  }
  return ties;
}

// Without ligaments all pivots are exact, upper ones too, since the scene may be in space.
Ties dynamicTies(const Scene& scene, const std::vector<Brick>& bricks,
                 const std::vector<HingeSpring>& springs) {
  if (!scene.hinges.areLigaments) return {makePivots(scene.model.joints, bricks), {}};
  if (const Need planar = sceneNeeds(scene).planar; !planar.on) {
    throw InputError(fmt::format(
        "error: --ligaments gives necks in the plane alone, but {}; leave it away", planar.reason));
  }
  return tiesOf(scene, bricks, springs);
}

}  // namespace kirireel
