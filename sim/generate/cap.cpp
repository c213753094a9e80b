// Flat squares that become caps of a sphere, and six of them as a cube that becomes a sphere.
//
// The design is a least squares problem under exact equations (constrained_fit.h). The unknowns are
// the nodes of the flat, closed square (x, y; m), the nodes of the open cap (x, y, z; m) and half
// the square's side h (m). Joints need no equations, since joined corners are one node. Exact:
// every quad has the same shape in both states and is planar in the cap; the square's boundary lies
// on |x| = h or |y| = h; each tip t of the cap (a corner that no joint holds) lies on the sphere
// and on the plane of its side,
//   |t| = R,     t . (o - tan(a) e_z) = 0
// with R the radius, a the angle between pole and side, o the direction out of the side; and tips
// and boundary nodes mirror each other across x = 0 and y = 0. Wanted: all other nodes near the
// sphere (weight 0.3), near their start (0.05), and an even grid in the square (0.05). The weights
// were found by trial; they only choose among sheets that satisfy the exact equations.
//
// The start is the regular sheet opened to 0.4 pi, with its bounding box mapped to the cap by
// central projection: u, v in [-1, 1] go to R (tan(a u), tan(a v), 1) / |.|, which takes the sides
// of the box into the planes of the sides.
//
// The idea of fitting both states at once: G. P. T. Choi, L. H. Dudte, L. Mahadevan, Programming
// shape using kirigami tessellations, Nature Materials 18, 2019, who use other equations and a
// general optimiser.
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "sim/generate/shell_parts.h"
#include "sim/generate/shells.h"

namespace kirireel {
namespace {

using std::numbers::pi;

/// Adds that two points mirror each other in the plane through the origin across an axis.
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
  std::vector<Tile> square;  ///< in the plane z = 0
  std::vector<Tile> cap;
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

  // From the start to both states.
  CapPair solve() const {
    const std::vector<Tile> start = startCap();
    // The square is given the edge lengths of the cap that it starts from.
    const double half = 0.5 * shape_.size * meanEdge(start);
    Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(half_ + 1);
    cap_.pack(start, unknowns);
    square_.pack(mapped(unitTiles(lattice_, 0),
                        [&](const Vector3& v) { return Vector3(2 * half / shape_.size * v); }),
                 unknowns);
    unknowns[half_] = half;
    const FlatRectangle rectangle(lattice_, square_, half_, half_);
    const Eigen::VectorXd wantedCap = unknowns;
    const auto source = [&](const Eigen::VectorXd& values, DesignEquations& equations) {
      addExact(equations.exact, rectangle, values);
      addWanted(equations.wanted, rectangle, wantedCap, values);
    };
    const Eigen::VectorXd found = fitFamily(family_, source, unknowns, {1e-3, 200});
    return {square_.tiles(found), cap_.tiles(found), found[half_]};
  }

 private:
  /// The regular open sheet, its box mapped to the cap's.
  std::vector<Tile> startCap() const {
    const std::vector<Tile> flat = unitTiles(lattice_, 0.4 * pi);
    const Vector3 half = halfExtent(flat);
    return mapped(flat, [&](const Vector3& vertex) {
      const double u = std::tan(shape_.halfAngle * vertex.x() / half.x());
      const double v = std::tan(shape_.halfAngle * vertex.y() / half.y());
      return Vector3(shape_.radius * Vector3(u, v, 1).normalized());
    });
  }

  // A free corner of the cap, counted round the sheet.
  UnknownPoint tip(const Eigen::VectorXd& values, int number) const {
    const LatticeCorner& corner = tips_[std::size_t(number)];
    return cap_.point(values, lattice_.tileAt(corner.cell), corner.corner);
  }

  // What both states must be.
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

  /// The number of the tip or boundary node that is the mirror image across x = 0 or y = 0: they
  /// are counted round the square, tips from 1/2.
  int mirrored(int number, int axis, bool isTip) const {
    const int count = 4 * shape_.size;
    // Mirror images have numbers that add up to a constant: across x = 0 the middle of the bottom
    // stays, across y = 0 the middle of the left side.
    const int sum = (axis == 0 ? shape_.size : 3 * shape_.size) - (isTip ? 1 : 0);
    return ((sum - number) % count + count) % count;
  }

  /// Mirrored tips and boundary nodes, so that caps meet each other on a cube.
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

  // What chooses among the sheets that are possible.
  void addWanted(EquationRows& rows, const FlatRectangle& rectangle, const Eigen::VectorXd& start,
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

/// The rotations that bring a cap about +z to all six faces of a cube. The ones to the sides are
/// chosen so that the tips of as many caps as can be meet in both states.
std::array<Matrix3, 6> cubeFaces() {
  const auto halfTurn = [](double x, double y, double z) {
    return Matrix3(Eigen::AngleAxisd(pi, Vector3(x, y, z).normalized()).toRotationMatrix());
  };
  // A half turn about the bisector of two axes swaps them.
  const Matrix3 toY = halfTurn(0, 1, 1);
  return {Matrix3::Identity(), halfTurn(1, 0, 0),       toY,
          halfTurn(0, -1, 1),  halfTurn(1, 1, 0) * toY, halfTurn(-1, 1, 0) * toY};
}

/// A corner's place at the start and at the target, in units in which all corners that coincide
/// round to the same numbers.
std::array<long, 6> placeOf(const Model& model, const Corner& corner, double unit) {
  std::array<long, 6> place{};
  const std::size_t tile = std::size_t(corner.tile), vertex = std::size_t(corner.vertex);
  for (int axis = 0; axis < 3; ++axis) {
    place[std::size_t(axis)] = std::lround(model.tiles[tile].vertices[vertex][axis] / unit);
    place[std::size_t(axis + 3)] = std::lround((*model.target)[tile].vertices[vertex][axis] / unit);
  }
  return place;
}

/// Joins the tips of different caps that coincide at the start and at the target.
void joinCaps(Model& model, const Lattice& lattice) {
  const double unit = 1e-6 * modelSize(model);
  std::map<std::array<long, 6>, Corner> known;
  for (int face = 0; face < 6; ++face) {
    for (const LatticeCorner& tip : tips(lattice)) {
      const Corner corner{face * lattice.tileCount() + lattice.tileAt(tip.cell), tip.corner};
      // A third tip at the same place would be joined to the first, too.
      const auto [entry, isNew] = known.try_emplace(placeOf(model, corner, unit), corner);
      if (!isNew) model.joints.push_back({entry->second, corner, JointFace::Bottom});
    }
  }
}

}  // namespace

Model makeSphericalCap(const CapShape& shape) {
  const CapPair pair = CapDesign("cap", shape).solve();
  Model model;
  model.name = "cap";
  model.tiles = pair.square;
  model.target = pair.cap;
  model.joints = latticeJoints({shape.size, shape.size}, JointFace::Bottom);
  return model;
}

Model makeCubeToSphere(const CapShape& shape) {
  CapShape face = shape;
  face.halfAngle = pi / 4;
  const CapPair pair = CapDesign("cube-to-sphere", face).solve();
  const Lattice lattice{shape.size, shape.size};
  Model model;
  model.name = "cube-to-sphere";
  model.target.emplace();
  for (const Matrix3& turn : cubeFaces()) {
    const int first = static_cast<int>(model.tiles.size());
    for (Joint joint : latticeJoints(lattice, JointFace::Bottom)) {
      joint.a.tile += first;
      joint.b.tile += first;
      model.joints.push_back(joint);
    }
    // The flat square becomes the face z = h of the cube; the cap is centred on the origin already.
    const Vector3 lift(0, 0, pair.half);
    const auto place = [&](const Vector3& v) { return Vector3(turn * (v + lift)); };
    for (const Tile& tile : mapped(pair.square, place)) model.tiles.push_back(tile);
    const auto rotate = [&](const Vector3& v) { return Vector3(turn * v); };
    for (const Tile& tile : mapped(pair.cap, rotate)) model.target->push_back(tile);
  }
  joinCaps(model, lattice);
  return model;
}

}  // namespace kirireel
