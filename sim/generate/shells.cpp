// Sheets that deploy to a cylinder, a twisted band, a saddle.
//
// *Cylinder*: exact without a fit. The regular field of rectangles l x w is closed at theta = 0
// with the width M l, and at pi with the width M w (M columns, even). Each closed state is wrapped
// around the regular prism of M sides whose edge distance is the column width: every tile lies flat
// on a side. Tiles across the seam are joined as within the sheet, since the pattern repeats after
// two columns.
//
// *Band*: the same fit with another open state. The start bends the open sheet to the band
//   p(t, s) = ((R - s cos w) cos 2 pi t, (R - s cos w) sin 2 pi t, s sin w),   w = pi n t
// t in [0, 1] along the strip, s across it (m), n half twists, R the radius (m). Tips at both ends
// are made to coincide, crosswise for odd n, without joints.
//
// *Sphere to saddle*: both states are curved and closed. Each node should be on its surface, with
// the distance f(p) / |grad f| to first order. Curved surfaces are too far from the flat start. The
// curvature is therefore increased in four stages. Each starts from the previous stage's sheet,
// lifted to its own surfaces. The sphere is below the origin, z = sqrt(R^2 - x^2 - y^2) - R; the
// saddle is z = c (x^2 - y^2).
#include "sim/generate/shells.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"

namespace kirireel::generate {
namespace {

using std::numbers::pi;

/// Wraps a flat sheet around a regular prism with sides of width `side`. x >= 0 is the direction
/// around it.
std::vector<model::Tile> wrapped(std::vector<model::Tile> flat, int sides, double side) {
  // The circumscribed circle of a regular polygon with that side.
  const double radius = 0.5 * side / std::sin(pi / sides);
  const auto edge = [&](int k) {
    return Vector3(radius * std::cos(2 * pi * k / sides), radius * std::sin(2 * pi * k / sides), 0);
  };
  return mapped(std::move(flat), [&](const Vector3& point) {
    // x runs from -M side / 2 to M side / 2.
    const double around = point.x() / side + 0.5 * sides;
    // Vertices are at the prism's edges or between two of them, up to rounding.
    const int before = static_cast<int>(std::floor(around + 1e-9));
    const double share = around - before;
    const int next = (before + 1) % sides;
    Vector3 place = (1 - share) * edge(before % sides) + share * edge(next);
    // The tube's axis is z.
    place.z() = point.y();
    return place;
  });
}

/// Places a strip around a circle with half twists, its middle line on the circle. Without twists
/// it faces up.
Vector3 onBand(const BandShape& shape, double around, double across) {
  const double twist = pi * shape.halfTwists * around;
  const double turn = 2 * pi * around;
  const double radius = shape.radius - across * std::cos(twist);
  return {radius * std::cos(turn), radius * std::sin(turn), across * std::sin(twist)};
}

/// The sphere's cap and the saddle at the fraction f of their curvature.
class SaddleDesign {
 public:
  SaddleDesign(const SaddleShape& shape, double share)
      : lattice_{shape.columns, shape.rows},
        radius_(shape.radius / share),
        curvature_(shape.curvature * share) {
    sphere_ = {nodesClosedAtStart(lattice_), 3, 0};
    saddle_ = {nodesClosedAtEnd(lattice_), 3, sphere_.count()};
  }

  Eigen::VectorXd packed(const std::vector<model::Tile>& start,
                         const std::vector<model::Tile>& target) const {
    Eigen::VectorXd unknowns(sphere_.count() + saddle_.count());
    sphere_.pack(start, unknowns);
    saddle_.pack(target, unknowns);
    return unknowns;
  }

  /// The design nearest to the given one, with its nodes lifted to the surfaces.
  Eigen::VectorXd solve(const Eigen::VectorXd& previous) const {
    const Eigen::VectorXd start = lifted(previous);
    const auto source = [&](const Eigen::VectorXd& values, DesignEquations& equations) {
      addCongruence(equations.exact, sphere_, saddle_, values);
      addPlanarity(equations.exact, sphere_, values);
      addPlanarity(equations.exact, saddle_, values);
      for (const StateUnknowns* state : {&sphere_, &saddle_}) {
        for (int node = 0; node < state->nodes.nodeCount; ++node) {
          const UnknownPoint point = state->point(values, node);
          addOnSurface(equations.desired, point, state == &sphere_);
          addNear(equations.desired, point, state->point(start, node).value, 0.05);
        }
      }
    };
    return fitFamily("sphere-to-saddle", source, start, {1e-3, 200});
  }

  model::Model model(const Eigen::VectorXd& unknowns) const {
    model::Model model;
    model.name = "sphere-to-saddle";
    model.tiles = sphere_.tiles(unknowns);
    model.target = saddle_.tiles(unknowns);
    model.joints = latticeJoints(lattice_, model::JointFace::Bottom);
    return model;
  }

 private:
  // Height of the surface over a point of the plane, metres.
  double heightAt(double x, double y, bool onSphere) const {
    if (!onSphere) return curvature_ * (x * x - y * y);
    return std::sqrt(radius_ * radius_ - x * x - y * y) - radius_;
  }

  // The nodes with heights on the surfaces.
  Eigen::VectorXd lifted(Eigen::VectorXd unknowns) const {
    for (const StateUnknowns* state : {&sphere_, &saddle_}) {
      for (int node = 0; node < state->nodes.nodeCount; ++node) {
        const UnknownPoint point = state->point(unknowns, node);
        // Only heights change; x and y are those of the previous stage.
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

model::Model makeCylinder(const CylinderShape& shape) {
  const Lattice lattice{shape.columns, shape.rows};
  const TurningField field = regularField(lattice, shape.length, Complex(0, shape.width));
  model::Model model;
  model.name = "cylinder";
  model.tiles = wrapped(field.tiles(0), shape.columns, shape.length);
  model.target = wrapped(field.tiles(pi), shape.columns, shape.width);
  model.joints = latticeJoints(lattice, model::JointFace::Bottom);
  const int last = shape.columns - 1;
  for (int row = 0; row < shape.rows; ++row) {
    const bool even = isEven({last, row});
    model.joints.push_back({{lattice.tileAt({last, row}), even ? 2 : 1},
                            {lattice.tileAt({0, row}), even ? 3 : 0},
                            model::JointFace::Bottom});
  }
  return model;
}

model::Model makeMoebiusBand(const BandShape& shape) {
  const Lattice lattice{shape.columns, shape.rows};
  StateUnknowns strip{nodesClosedAtStart(lattice), 2, 0};
  StateUnknowns band{openNodes(lattice), 3, strip.count()};
  const int halfLength = strip.count() + band.count();
  const int halfWidth = halfLength + 1;
  const FlatRectangle rectangle(lattice, strip, halfLength, halfWidth);

  const std::vector<model::Tile> open = unitTiles(lattice, shape.angle);
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
      addNear(equations.desired, band.point(values, node), band.point(start, node).value, 0.1);
    }
    rectangle.addEvenGrid(equations.desired, values, 0.1);
  };
  const Eigen::VectorXd found = fitFamily("moebius", source, start, {1e-2, 200});
  model::Model model;
  model.name = "moebius";
  model.tiles = strip.tiles(found);
  model.target = band.tiles(found);
  model.joints = latticeJoints(lattice, model::JointFace::Bottom);
  return model;
}

// The curvature grows in stages. Each starts from the previous sheet.
model::Model makeSphereToSaddle(const SaddleShape& shape) {
  // Four stages are enough for the default curvature.
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

// ------------------------------------------------------------------------------------------------
// Flat squares that become caps of a sphere, and six of them as a cube that becomes a sphere.
//
// The design is a least squares problem with exact equations (constrained_fit.h). The unknowns are
// the nodes of the flat, closed square (x, y; m), the nodes of the open cap (x, y, z; m) and half
// the square's side h (m). Joints need no equations, since joined corners are one node. Exact
// equations: every quad has the same shape in both states and is planar in the cap; the square's
// boundary lies on |x| = h or |y| = h; each tip t of the cap (a corner without joint) lies on the
// sphere and on the plane of its side,
//   |t| = R,     t . (o - tan(a) e_z) = 0
// with the radius R, the angle a between pole and side, and the outward direction o of the side.
// Tips and boundary nodes mirror each other across x = 0 and y = 0. Soft equations: all other nodes
// are near the sphere (weight 0.3) and near their start (0.05), and the square has an even grid
// (0.05). The weights were found by trial. They only select among sheets that satisfy the exact
// equations.
//
// The start is the regular sheet opened to 0.4 pi. Central projection maps its bounding box to the
// cap: u, v in [-1, 1] become R (tan(a u), tan(a v), 1) / |.|, which maps the sides of the box to
// the planes of the sides.
//
// Fitting both states at once is the idea of G. P. T. Choi, L. H. Dudte, L. Mahadevan, Programming
// shape using kirigami tessellations, Nature Materials 18, 2019, with other equations and a general
// optimiser.

namespace {

using std::numbers::pi;

/// Adds the equation that two points mirror each other in the plane through the origin across an
/// axis.
void addMirror(EquationRows& rows, const UnknownPoint& a, const UnknownPoint& b, int axis) {
  for (int k = 0; k < std::min(a.dimension, b.dimension); ++k) {
    // The mirror changes the sign of one coordinate and keeps the others.
    const double sign = k == axis ? -1 : 1;
    rows.begin(a.value[k] - sign * b.value[k]);
    rows.slope(a.first + k, 1);
    rows.slope(b.first + k, -sign);
  }
}

/// The flat square and its cap.
struct CapPair {
  std::vector<model::Tile> square;  ///< in the plane z = 0
  std::vector<model::Tile> cap;
  double half = 0;  ///< half the square's side
};

/// The equations of a square of tiles that becomes a spherical cap. Every side of the cap lies in a
/// plane through the sphere's centre.
class CapDesign {
 public:
  CapDesign(std::string family, const CapShape& shape)
      : family_(std::move(family)),
        shape_(shape),
        lattice_{shape.size, shape.size},
        tips_(tips(lattice_)) {
    square_ = {nodesClosedAtStart(lattice_), 2, 0};
    cap_ = {openNodes(lattice_), 3, square_.count()};
    half_ = square_.count() + cap_.count();
  }

  // Solves for both states from the start.
  CapPair solve() const {
    const std::vector<model::Tile> start = startCap();
    // The square gets the mean edge length of the initial cap.
    const double half = 0.5 * shape_.size * meanEdge(start);
    Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(half_ + 1);
    cap_.pack(start, unknowns);
    square_.pack(mapped(unitTiles(lattice_, 0),
                        [&](const Vector3& v) { return Vector3(2 * half / shape_.size * v); }),
                 unknowns);
    unknowns[half_] = half;
    const FlatRectangle rectangle(lattice_, square_, half_, half_);
    const Eigen::VectorXd desiredCap = unknowns;
    const auto source = [&](const Eigen::VectorXd& values, DesignEquations& equations) {
      addExact(equations.exact, rectangle, values);
      addDesired(equations.desired, rectangle, desiredCap, values);
    };
    const Eigen::VectorXd found = fitFamily(family_, source, unknowns, {1e-3, 200});
    return {square_.tiles(found), cap_.tiles(found), found[half_]};
  }

 private:
  /// The regular open sheet, with its box mapped to the cap's.
  std::vector<model::Tile> startCap() const {
    const std::vector<model::Tile> flat = unitTiles(lattice_, 0.4 * pi);
    const Vector3 half = generate::halfExtent(flat);
    return mapped(flat, [&](const Vector3& vertex) {
      const double u = std::tan(shape_.halfAngle * vertex.x() / half.x());
      const double v = std::tan(shape_.halfAngle * vertex.y() / half.y());
      return Vector3(shape_.radius * Vector3(u, v, 1).normalized());
    });
  }

  // A free corner of the cap, numbered around the sheet.
  UnknownPoint tip(const Eigen::VectorXd& values, int number) const {
    const LatticeCorner& corner = tips_[std::size_t(number)];
    return cap_.point(values, lattice_.tileAt(corner.cell), corner.corner);
  }

  // Exact equations of both states.
  void addExact(EquationRows& rows, const FlatRectangle& rectangle,
                const Eigen::VectorXd& values) const {
    addCongruence(rows, square_, cap_, values);
    addPlanarity(rows, cap_, values);
    rectangle.addExact(rows, values);
    const double tangent = std::tan(shape_.halfAngle);
    for (int k = 0; k < 4 * shape_.size; ++k) {
      const Vector3 normal = outwards(sideOf(lattice_, k)) - tangent * Vector3::UnitZ();
      addPosition(rows, tip(values, k), normal, 0);
      addOnSphere(rows, tip(values, k), shape_.radius);
    }
    addMirrors(rows, rectangle, values);
  }

  /// The number of the mirror image of a tip or boundary node across x = 0 or y = 0. They are
  /// numbered around the square, tips from 1/2.
  int mirrored(int number, int axis, bool isTip) const {
    const int count = 4 * shape_.size;
    // Mirror images have numbers with a constant sum: across x = 0 the middle of the bottom is
    // fixed, across y = 0 the middle of the left side.
    const int sum = (axis == 0 ? shape_.size : 3 * shape_.size) - (isTip ? 1 : 0);
    return ((sum - number) % count + count) % count;
  }

  /// Mirrors tips and boundary nodes, because caps are adjacent on a cube.
  void addMirrors(EquationRows& rows, const FlatRectangle& rectangle,
                  const Eigen::VectorXd& values) const {
    for (int k = 0; k < 4 * shape_.size; ++k) {
      for (const int axis : {0, 1}) {
        addMirror(rows, tip(values, k), tip(values, mirrored(k, axis, true)), axis);
        addMirror(rows, rectangle.boundaryPoint(values, k),
                  rectangle.boundaryPoint(values, mirrored(k, axis, false)), axis);
      }
    }
  }

  // Soft equations, which select among the possible sheets.
  void addDesired(EquationRows& rows, const FlatRectangle& rectangle, const Eigen::VectorXd& start,
                  const Eigen::VectorXd& values) const {
    for (int node = 0; node < cap_.nodes.nodeCount; ++node) {
      const UnknownPoint point = cap_.point(values, node);
      addOnSphere(rows, point, shape_.radius, 0.3);
      addNear(rows, point, cap_.point(start, node).value, 0.05);
    }
    rectangle.addEvenGrid(rows, values, 0.05);
  }

  std::string family_;
  CapShape shape_;
  Lattice lattice_;
  std::vector<LatticeCorner> tips_;
  StateUnknowns square_;
  StateUnknowns cap_;
  int half_ = 0;
};

/// The rotations of a cap about +z to all six faces of a cube. Those to the sides maximise the
/// number of tips that coincide in both states.
std::array<Matrix3, 6> cubeFaces() {
  const auto halfTurn = [](double x, double y, double z) {
    return Matrix3(Eigen::AngleAxisd(pi, Vector3(x, y, z).normalized()).toRotationMatrix());
  };
  // A half turn about the bisector of two axes exchanges them.
  const Matrix3 toY = halfTurn(0, 1, 1);
  return {Matrix3::Identity(), halfTurn(1, 0, 0),       toY,
          halfTurn(0, -1, 1),  halfTurn(1, 1, 0) * toY, halfTurn(-1, 1, 0) * toY};
}

/// A corner's position at the start and at the target, in units in which coinciding corners round
/// to the same integers.
std::array<long, 6> placeOf(const model::Model& model, const model::Corner& corner, double unit) {
  std::array<long, 6> place{};
  const std::size_t tile = std::size_t(corner.tile), vertex = std::size_t(corner.vertex);
  for (int axis = 0; axis < 3; ++axis) {
    place[std::size_t(axis)] = std::lround(model.tiles[tile].vertices[vertex][axis] / unit);
    place[std::size_t(axis + 3)] = std::lround((*model.target)[tile].vertices[vertex][axis] / unit);
  }
  return place;
}

/// Joins the tips of different caps that coincide at the start and at the target.
void joinCaps(model::Model& model, const Lattice& lattice) {
  const double unit = 1e-6 * model::modelSize(model);
  std::map<std::array<long, 6>, model::Corner> known;
  for (int face = 0; face < 6; ++face) {
    for (const LatticeCorner& tip : tips(lattice)) {
      const model::Corner corner{face * lattice.tileCount() + lattice.tileAt(tip.cell), tip.corner};
      // A third tip at the same position would also be joined to the first.
      const auto [entry, isNew] = known.try_emplace(placeOf(model, corner, unit), corner);
      if (!isNew) model.joints.push_back({entry->second, corner, model::JointFace::Bottom});
    }
  }
}

}  // namespace

model::Model makeSphericalCap(const CapShape& shape) {
  const CapPair pair = CapDesign("cap", shape).solve();
  model::Model model;
  model.name = "cap";
  model.tiles = pair.square;
  model.target = pair.cap;
  model.joints = latticeJoints({shape.size, shape.size}, model::JointFace::Bottom);
  return model;
}

model::Model makeCubeToSphere(const CapShape& shape) {
  CapShape face = shape;
  face.halfAngle = pi / 4;
  const CapPair pair = CapDesign("cube-to-sphere", face).solve();
  const Lattice lattice{shape.size, shape.size};
  model::Model model;
  model.name = "cube-to-sphere";
  model.target.emplace();
  for (const Matrix3& turn : cubeFaces()) {
    const int first = static_cast<int>(model.tiles.size());
    for (model::Joint joint : latticeJoints(lattice, model::JointFace::Bottom)) {
      joint.a.tile += first;
      joint.b.tile += first;
      model.joints.push_back(joint);
    }
    // Moves the flat square to the face z = h of the cube. The cap is already centred on the
    // origin.
    const Vector3 lift(0, 0, pair.half);
    const auto place = [&](const Vector3& v) { return Vector3(turn * (v + lift)); };
    for (const model::Tile& tile : mapped(pair.square, place)) model.tiles.push_back(tile);
    const auto rotate = [&](const Vector3& v) { return Vector3(turn * v); };
    for (const model::Tile& tile : mapped(pair.cap, rotate)) model.target->push_back(tile);
  }
  joinCaps(model, lattice);
  return model;
}

// ------------------------------------------------------------------------------------------------
// Common parts of the fits of shells: a start of unit squares, the exact rectangle of a flat state,
// and the message of a failed fit.
//
// The rectangle is |x| = a, |y| = b with unknown half sides a and b (m), since the curved state
// determines the sheet's size. Every boundary node of side s satisfies o_s . p = a or b, with the
// outward direction o_s of the side. A corner node satisfies both.

Eigen::VectorXd fitFamily(const std::string& family, const DesignSource& source,
                          Eigen::VectorXd start, const FitSettings& settings) {
  const Fit fit = fitDesign(source, std::move(start), settings);
  if (fit.violation <= kExactFit) return fit.unknowns;
  throw InputError(
      fmt::format("{}: error: no sheet of this shape was found (residual {:.2g}). Use sizes and "
                  "parameters nearer to the defaults",
                  family, fit.violation));
}

std::vector<model::Tile> unitTiles(const Lattice& lattice, double angle) {
  return regularField(lattice, 1, Complex(0, 1)).tiles(angle);
}

double meanEdge(const std::vector<model::Tile>& tiles) {
  model::Model model;
  model.tiles = tiles;
  return model::tileSize(model);
}

int sideOf(const Lattice& lattice, int number) {
  // Numbers at the ends of the bottom, the right and the top side.
  const int ends[] = {lattice.columns, lattice.columns + lattice.rows,
                      2 * lattice.columns + lattice.rows};
  return static_cast<int>(std::upper_bound(std::begin(ends), std::end(ends), number) -
                          std::begin(ends));
}

Vector3 outwards(int side) {
  const Vector3 directions[] = {-Vector3::UnitY(), Vector3::UnitX(), Vector3::UnitY(),
                                -Vector3::UnitX()};
  return directions[side];
}

FlatRectangle::FlatRectangle(const Lattice& lattice, StateUnknowns state, int halfColumns,
                             int halfRows)
    : lattice_(lattice),
      state_(std::move(state)),
      halves_{halfColumns, halfRows},
      boundary_(closedBoundary(lattice)) {}

void FlatRectangle::addExact(EquationRows& rows, const Eigen::VectorXd& unknowns) const {
  const int count = static_cast<int>(boundary_.size());
  for (int number = 0; number < count; ++number) {
    const int side = sideOf(lattice_, number);
    addOnSide(rows, unknowns, number, side);
    // A node at a corner also lies on the previous side.
    const int before = sideOf(lattice_, (number + count - 1) % count);
    if (before != side) addOnSide(rows, unknowns, number, before);
  }
}

void FlatRectangle::addEvenGrid(EquationRows& rows, const Eigen::VectorXd& unknowns,
                                double weight) const {
  for (int column = 0; column <= lattice_.columns; ++column) {
    for (int row = 0; row <= lattice_.rows; ++row) {
      const double shares[] = {2.0 * column / lattice_.columns - 1, 2.0 * row / lattice_.rows - 1};
      const UnknownPoint point = state_.point(unknowns, column * (lattice_.rows + 1) + row);
      for (int axis = 0; axis < 2; ++axis) {
        const int half = halves_[std::size_t(axis)];
        addPosition(rows, point, Vector3::Unit(axis), shares[axis] * unknowns[half], weight);
        // The desired position moves with the half side.
        rows.slope(half, -weight * shares[axis]);
      }
    }
  }
}

UnknownPoint FlatRectangle::boundaryPoint(const Eigen::VectorXd& unknowns, int number) const {
  const LatticeCorner& corner = boundary_[std::size_t(number)];
  return state_.point(unknowns, lattice_.tileAt(corner.cell), corner.corner);
}

void FlatRectangle::addOnSide(EquationRows& rows, const Eigen::VectorXd& unknowns, int number,
                              int side) const {
  // Bottom and top are at y = -+ the half side of the rows.
  const int half = halves_[side % 2 == 0 ? 1 : 0];
  addPosition(rows, boundaryPoint(unknowns, number), outwards(side), unknowns[half]);
  rows.slope(half, -1);
}

// ------------------------------------------------------------------------------------------------
// Unknown nodes of two states of one sheet, and the equations that make the states congruent.
//
// With a = p_1 - p_0, b = p_2 - p_0, c = p_3 - p_0 for the corners p_k of a quad (m), five inner
// products define the shape of a planar quad,
//   a . a,   a . c,   c . c,   b . a,   b . c                  m^2
// The first three define the triangle p_0 p_1 p_3, the other two the components of b in its plane.
// Each is equal in both states. Edge lengths and one diagonal would also be five equations, but
// they allow the quad to fold about its diagonal, which occurred in fits. A quad in space is planar
// if a . (b x c) = 0 (m^3). Derivatives follow from the product rule: d(u . w) = w . du + u . dw.

namespace {

/// A quad's edges and diagonal from its corner 0.
struct QuadVectors {
  std::array<UnknownPoint, 4> corners;

  Vector3 from0(int corner) const { return corners[std::size_t(corner)].value - corners[0].value; }
};

// The four corners of a tile as unknowns.
QuadVectors quadOf(const StateUnknowns& state, const Eigen::VectorXd& unknowns, int tile) {
  QuadVectors quad;
  for (int k = 0; k < 4; ++k) quad.corners[std::size_t(k)] = state.point(unknowns, tile, k);
  return quad;
}

/// Slopes of the inner product of the vectors to two corners, times a sign.
void addProductSlopes(EquationRows& rows, const QuadVectors& quad, int i, int j, double sign) {
  const Vector3 toI = quad.from0(i);
  const Vector3 toJ = quad.from0(j);
  addSlope(rows, quad.corners[std::size_t(i)], sign * toJ);
  addSlope(rows, quad.corners[std::size_t(j)], sign * toI);
  addSlope(rows, quad.corners[0], -sign * (toI + toJ));
}

}  // namespace

NodeMap openNodes(const Lattice& lattice) {
  DisjointSets corners(std::size_t(4 * lattice.tileCount()));
  for (const model::Joint& joint : latticeJoints(lattice, model::JointFace::Bottom)) {
    corners.unite(4 * joint.a.tile + joint.a.vertex, 4 * joint.b.tile + joint.b.vertex);
  }
  const std::vector<int> numbers = corners.numbers();
  NodeMap map;
  for (auto first = numbers.begin(); first != numbers.end(); first += 4) {
    map.nodeOf.emplace_back(first, first + 4);
  }
  map.nodeCount = 1 + std::ranges::max(numbers);
  return map;
}

NodeMap nodesClosedAtStart(const Lattice& lattice) {
  NodeMap map;
  map.nodeCount = (lattice.columns + 1) * (lattice.rows + 1);
  for (int tile = 0; tile < lattice.tileCount(); ++tile) {
    const Cell cell = lattice.cellOf(tile);
    const int corner = cell.column * (lattice.rows + 1) + cell.row;
    const int next = corner + lattice.rows + 1;
    map.nodeOf.push_back({corner, next, next + 1, corner + 1});
  }
  return map;
}

NodeMap nodesClosedAtEnd(const Lattice& lattice) {
  const std::vector<model::Tile> closed =
      regularField(lattice, 1, Complex(0, 1)).tiles(std::numbers::pi);
  // Corners of unit squares coincide or are 1 apart.
  std::map<std::pair<long, long>, int> numbers;
  NodeMap map;
  for (const model::Tile& tile : closed) {
    std::vector<int>& nodes = map.nodeOf.emplace_back();
    for (const Vector3& vertex : tile.vertices) {
      // Sheets with an even or odd number of tiles have corners at integers or at half-integers.
      const std::pair place{std::lround(2 * vertex.x()), std::lround(2 * vertex.y())};
      const auto [entry, isNew] = numbers.try_emplace(place, map.nodeCount);
      map.nodeCount += isNew ? 1 : 0;
      nodes.push_back(entry->second);
    }
  }
  return map;
}

UnknownPoint StateUnknowns::point(const Eigen::VectorXd& unknowns, int node) const {
  UnknownPoint point;
  point.first = first + dimension * node;
  point.dimension = dimension;
  point.value.head(dimension) = unknowns.segment(point.first, dimension);
  return point;
}

void StateUnknowns::pack(const std::vector<model::Tile>& tiles, Eigen::VectorXd& unknowns) const {
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    for (std::size_t k = 0; k < 4; ++k) {
      unknowns.segment(first + dimension * nodes.nodeOf[tile][k], dimension) =
          tiles[tile].vertices[k].head(dimension);
    }
  }
}

std::vector<model::Tile> StateUnknowns::tiles(const Eigen::VectorXd& unknowns) const {
  std::vector<model::Tile> tiles(nodes.nodeOf.size());
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    for (const int node : nodes.nodeOf[tile]) {
      tiles[tile].vertices.push_back(point(unknowns, node).value);
    }
  }
  return tiles;
}

void addSlope(EquationRows& rows, const UnknownPoint& point, const Vector3& slope) {
  for (int axis = 0; axis < point.dimension; ++axis) rows.slope(point.first + axis, slope[axis]);
}

void addPosition(EquationRows& rows, const UnknownPoint& point, const Vector3& direction,
                 double value, double weight) {
  rows.begin(weight * (direction.dot(point.value) - value));
  addSlope(rows, point, weight * direction);
}

void addOnSphere(EquationRows& rows, const UnknownPoint& point, double radius, double weight) {
  const double distance = point.value.norm();
  rows.begin(weight * (distance - radius));
  addSlope(rows, point, weight / distance * point.value);
}

void addNear(EquationRows& rows, const UnknownPoint& point, const Vector3& desired, double weight) {
  for (int axis = 0; axis < point.dimension; ++axis) {
    addPosition(rows, point, Vector3::Unit(axis), desired[axis], weight);
  }
}

void addCongruence(EquationRows& rows, const StateUnknowns& a, const StateUnknowns& b,
                   const Eigen::VectorXd& unknowns) {
  constexpr std::pair<int, int> kProducts[] = {{1, 1}, {1, 3}, {3, 3}, {2, 1}, {2, 3}};
  for (int tile = 0; tile < std::ssize(a.nodes.nodeOf); ++tile) {
    const QuadVectors inA = quadOf(a, unknowns, tile);
    const QuadVectors inB = quadOf(b, unknowns, tile);
    for (const auto& [i, j] : kProducts) {
      rows.begin(inA.from0(i).dot(inA.from0(j)) - inB.from0(i).dot(inB.from0(j)));
      addProductSlopes(rows, inA, i, j, 1);
      addProductSlopes(rows, inB, i, j, -1);
    }
  }
}

void addPlanarity(EquationRows& rows, const StateUnknowns& state, const Eigen::VectorXd& unknowns) {
  for (int tile = 0; tile < std::ssize(state.nodes.nodeOf); ++tile) {
    const QuadVectors quad = quadOf(state, unknowns, tile);
    const Vector3 a = quad.from0(1), b = quad.from0(2), c = quad.from0(3);
    rows.begin(a.dot(b.cross(c)));
    addSlope(rows, quad.corners[1], b.cross(c));
    addSlope(rows, quad.corners[2], c.cross(a));
    addSlope(rows, quad.corners[3], a.cross(b));
    addSlope(rows, quad.corners[0], -(b.cross(c) + c.cross(a) + a.cross(b)));
  }
}

}  // namespace kirireel::generate
