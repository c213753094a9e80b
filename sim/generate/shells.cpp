// Sheets that deploy to a cylinder, a twisted band, a saddle.
//
// *Cylinder*: exact without a fit. The regular field of rectangles l x w is closed at theta = 0, M
// l wide, and at pi, M w wide (M columns, even). Each closed state is wrapped round the regular
// prism of M sides whose edges are as far apart as columns are wide, so that every tile lies flat
// on a side of it. Tiles that are joined across the seam are joined as within the sheet, as the
// pattern repeats after two columns.
//
// *Band*: the fit of cap.cpp with another open state. The start bends the open sheet onto the band
//   p(t, s) = ((R - s cos w) cos 2 pi t, (R - s cos w) sin 2 pi t, s sin w),   w = pi n t
// t in [0, 1] along the strip, s across it (m), n the number of half twists, R the radius (m). Tips
// at both ends are made to coincide, crosswise for odd n; no joints hold them.
//
// *Sphere to saddle*: both states are curved and closed. Each node is wanted on its surface, at the
// distance f(p) / |grad f|, to first order. Curved surfaces are too far from the flat start, so
// that their curvature is raised in four stages, each begun with the last stage's sheet lifted onto
// the surfaces of the next. The sphere lies below the origin, z = sqrt(R^2 - x^2 - y^2) - R; the
// saddle is z = c (x^2 - y^2).
#include "sim/generate/shells.h"

#include <cmath>
#include <numbers>

#include "sim/generate/shell_parts.h"

namespace kirireel {
namespace {

using std::numbers::pi;

/// Wraps a flat sheet round a regular prism whose sides are `side` wide: x, from 0, runs round it.
std::vector<Tile> wrapped(std::vector<Tile> flat, int sides, double side) {
  // The circumscribed circle of a regular polygon with that side.
  const double radius = 0.5 * side / std::sin(pi / sides);
  const auto edge = [&](int k) {
    return Vector3(radius * std::cos(2 * pi * k / sides), radius * std::sin(2 * pi * k / sides), 0);
  };
  return mapped(std::move(flat), [&](const Vector3& point) {
    // x runs from -M side / 2 to M side / 2.
    const double around = point.x() / side + 0.5 * sides;
    // Vertices stand at the prism's edges or between two of them, to rounding.
    const int before = static_cast<int>(std::floor(around + 1e-9));
    const double share = around - before;
    const int next = (before + 1) % sides;
    Vector3 place = (1 - share) * edge(before % sides) + share * edge(next);
    // The tube stands along z.
    place.z() = point.y();
    return place;
  });
}

/// Places a strip round a circle with half twists, its middle line on the circle; without twists it
/// faces up.
Vector3 onBand(const BandShape& shape, double around, double across) {
  const double twist = pi * shape.halfTwists * around;
  const double turn = 2 * pi * around;
  const double radius = shape.radius - across * std::cos(twist);
  return {radius * std::cos(turn), radius * std::sin(turn), across * std::sin(twist)};
}

/// A surface that the nodes of a state should lie on: a function that is zero there, and its
/// gradient.
struct SurfacePoint {
  double value = 0;
  Vector3 gradient;
};

/// The sphere's cap and the saddle at share f of their curvature.
class SaddleDesign {
 public:
  SaddleDesign(const SaddleShape& shape, double share)
      : lattice_{shape.columns, shape.rows},
        radius_(shape.radius / share),
        curvature_(shape.curvature * share) {
    sphere_ = {nodesClosedAtStart(lattice_), 3, 0};
    saddle_ = {nodesClosedAtEnd(lattice_), 3, sphere_.count()};
  }

  Eigen::VectorXd packed(const std::vector<Tile>& start, const std::vector<Tile>& target) const {
    Eigen::VectorXd unknowns(sphere_.count() + saddle_.count());
    sphere_.pack(start, unknowns);
    saddle_.pack(target, unknowns);
    return unknowns;
  }

  /// The design nearest to the given one with its nodes lifted onto the surfaces.
  Eigen::VectorXd solve(const Eigen::VectorXd& previous) const {
    const Eigen::VectorXd start = lifted(previous);
    const auto source = [&](const Eigen::VectorXd& values, DesignEquations& equations) {
      addCongruence(equations.exact, sphere_, saddle_, values);
      addPlanarity(equations.exact, sphere_, values);
      addPlanarity(equations.exact, saddle_, values);
      for (const StateUnknowns* state : {&sphere_, &saddle_}) {
        for (int node = 0; node < state->nodes.nodeCount; ++node) {
          const UnknownPoint point = state->point(values, node);
          addOnSurface(equations.wanted, point, state == &sphere_);
          addNear(equations.wanted, point, state->point(start, node).value, 0.05);
        }
      }
    };
    return fitFamily("sphere-to-saddle", source, start, {1e-3, 200});
  }

  Model model(const Eigen::VectorXd& unknowns) const {
    Model model;
    model.name = "sphere-to-saddle";
    model.tiles = sphere_.tiles(unknowns);
    model.target = saddle_.tiles(unknowns);
    model.joints = latticeJoints(lattice_, JointFace::Bottom);
    return model;
  }

 private:
  // Of the surface over a point of the plane, metres.
  double heightAt(double x, double y, bool onSphere) const {
    if (!onSphere) return curvature_ * (x * x - y * y);
    return std::sqrt(radius_ * radius_ - x * x - y * y) - radius_;
  }

  // The nodes with their heights set onto the surfaces.
  Eigen::VectorXd lifted(Eigen::VectorXd unknowns) const {
    for (const StateUnknowns* state : {&sphere_, &saddle_}) {
      for (int node = 0; node < state->nodes.nodeCount; ++node) {
        const UnknownPoint point = state->point(unknowns, node);
        // Only heights are set; x and y stay as the last stage left them.
        unknowns[point.first + 2] = heightAt(point.value.x(), point.value.y(), state == &sphere_);
      }
    }
    return unknowns;
  }

  /// The sphere passes through the origin and lies below it.
  void addOnSurface(EquationRows& rows, const UnknownPoint& point, bool onSphere) const {
    const Vector3& p = point.value;
    if (onSphere) {
      const Vector3 fromCentre = p + Vector3(0, 0, radius_);
      rows.begin(fromCentre.norm() - radius_);
      addSlope(rows, point, fromCentre.normalized());
      return;
    }
    const Vector3 gradient(-2 * curvature_ * p.x(), 2 * curvature_ * p.y(), 1);
    rows.begin((p.z() - heightAt(p.x(), p.y(), false)) / gradient.norm());
    addSlope(rows, point, gradient.normalized());
  }

  Lattice lattice_;
  double radius_;
  double curvature_;
  StateUnknowns sphere_;
  StateUnknowns saddle_;
};

}  // namespace

Model makeCylinder(const CylinderShape& shape) {
  const Lattice lattice{shape.columns, shape.rows};
  const TurningField field = regularField(lattice, shape.length, Complex(0, shape.width));
  Model model;
  model.name = "cylinder";
  model.tiles = wrapped(field.tiles(0), shape.columns, shape.length);
  model.target = wrapped(field.tiles(pi), shape.columns, shape.width);
  model.joints = latticeJoints(lattice, JointFace::Bottom);
  const int last = shape.columns - 1;
  for (int row = 0; row < shape.rows; ++row) {
    const bool even = isEven({last, row});
    model.joints.push_back({{lattice.tileAt({last, row}), even ? 2 : 1},
                            {lattice.tileAt({0, row}), even ? 3 : 0},
                            JointFace::Bottom});
  }
  return model;
}

Model makeMoebiusBand(const BandShape& shape) {
  const Lattice lattice{shape.columns, shape.rows};
  StateUnknowns strip{nodesClosedAtStart(lattice), 2, 0};
  StateUnknowns band{openNodes(lattice), 3, strip.count()};
  const int halfLength = strip.count() + band.count();
  const int halfWidth = halfLength + 1;
  const FlatRectangle rectangle(lattice, strip, halfLength, halfWidth);

  const std::vector<Tile> open = unitTiles(lattice, shape.angle);
  const Vector3 half = halfExtent(open);
  // The open sheet is as long as the circle: 2 half.x() scale = 2 pi R.
  const double scale = pi * shape.radius / half.x();
  const auto bend = [&](const Vector3& v) {
    return onBand(shape, 0.5 + 0.5 * v.x() / half.x(), scale * v.y());
  };
  Eigen::VectorXd start(halfLength + 2);
  strip.pack(mapped(unitTiles(lattice, 0), [&](const Vector3& v) { return Vector3(scale * v); }),
             start);
  band.pack(mapped(open, bend), start);
  start[halfLength] = 0.5 * scale * shape.columns;
  start[halfWidth] = 0.5 * scale * shape.rows;

  const std::vector<LatticeCorner> corners = tips(lattice);
  const auto tip = [&](const Eigen::VectorXd& values, int number) {
    const LatticeCorner& corner = corners[std::size_t(number)];
    return band.point(values, lattice.tileAt(corner.cell), corner.corner);
  };
  const auto source = [&](const Eigen::VectorXd& values, DesignEquations& equations) {
    addCongruence(equations.exact, strip, band, values);
    addPlanarity(equations.exact, band, values);
    rectangle.addExact(equations.exact, values);
    // The ends meet, upside down after an odd number of half twists.
    for (int row = 0; row < shape.rows; ++row) {
      const int right = shape.columns + row;
      const int met = shape.halfTwists % 2 == 0 ? row : shape.rows - 1 - row;
      const int left = 2 * shape.columns + 2 * shape.rows - 1 - met;
      for (int axis = 0; axis < 3; ++axis) {
        const UnknownPoint a = tip(values, right), b = tip(values, left);
        addPosition(equations.exact, a, Vector3::Unit(axis), b.value[axis]);
        addSlope(equations.exact, b, -Vector3::Unit(axis));
      }
    }
    for (int node = 0; node < band.nodes.nodeCount; ++node) {
      addNear(equations.wanted, band.point(values, node), band.point(start, node).value, 0.1);
    }
    rectangle.addEvenGrid(equations.wanted, values, 0.1);
  };
  const Eigen::VectorXd found = fitFamily("moebius", source, start, {1e-2, 200});
  Model model;
  model.name = "moebius";
  model.tiles = strip.tiles(found);
  model.target = band.tiles(found);
  model.joints = latticeJoints(lattice, JointFace::Bottom);
  return model;
}

// The curvature grows in stages, each begun from the sheet before.
Model makeSphereToSaddle(const SaddleShape& shape) {
  // Four stages are enough for the usual curvature.
  constexpr int kStages = 4;
  const Lattice lattice{shape.columns, shape.rows};
  const double scale = shape.width / std::max(shape.columns, shape.rows);
  const auto scaled = [&](double angle) {
    return mapped(unitTiles(lattice, angle), [&](const Vector3& v) { return Vector3(scale * v); });
  };
  Eigen::VectorXd unknowns = SaddleDesign(shape, 1).packed(scaled(0), scaled(pi));
  for (int stage = 1; stage < kStages; ++stage) {
    unknowns = SaddleDesign(shape, double(stage) / kStages).solve(unknowns);
  }
  const SaddleDesign design(shape, 1);
  return design.model(design.solve(unknowns));
}

}  // namespace kirireel
