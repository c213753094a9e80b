// Planar designs: finds the constants F of a turning field (lattice.h) for a sheet with given
// outlines in two states.
//
// A corner's position v(theta) = F_odd e^(-i theta/2) + F_even e^(i theta/2) is linear in the
// constants. A void is closed at theta = 0 and pi if F11 - F00 = s lambda (F10 - F01). With
// lambda = 1 (rhombic voids) all equations are linear, and one solve gives the best sheet: fan,
// heart and irregular quads. With variable lambda, log lambda becomes an unknown, which keeps
// lambda positive, and the fit is nonlinear: square to disk, square to circle.
//
// Half voids at the sides have lambda = 1. A sheet that is closed in both states needs all of them.
// A sheet whose second state may be open needs only those that close at theta = 0.
//
// The weights of the soft equations were found by trial. They select one of many sheets, and none
// of them holds exactly. For example, a square without evenly spaced nodes loses its corner tiles.
#include "sim/generate/lattice_designs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel::generate {
namespace {

using std::numbers::pi;

TurningField unitField(const Lattice& lattice) {
  return regularField(lattice, 1, Complex(0, 1));
}

// A fit that fulfils its exact equations; throws InputError otherwise.
Fit fitted(const std::string& family, const DesignSource& source, Eigen::VectorXd start,
           const FitSettings& settings) {
  Fit fit = fitDesign(source, std::move(start), settings);
  if (fit.violation <= kExactFit) return fit;
  throw InputError(
      fmt::format("{}: error: no sheet of this shape was found (residual {:.2g}). Use parameters "
                  "nearer to the defaults",
                  family, fit.violation));
}

std::vector<TileBlock> allBlocks(const Lattice& lattice) {
  std::vector<TileBlock> blocks = innerBlocks(lattice);
  for (const auto& more : {sideBlocksClosedAtStart(lattice), sideBlocksClosedAtEnd(lattice)}) {
    blocks.insert(blocks.end(), more.begin(), more.end());
  }
  return blocks;
}

void addRhombicBlocks(EquationRows& rows, const LatticeUnknowns& unknowns,
                      const TurningField& field, const std::vector<TileBlock>& blocks,
                      const Eigen::VectorXd& values) {
  for (const TileBlock& block : blocks) unknowns.addBlock(rows, field, block, values, -1);
}

// Both coordinates of a corner in the state at `angle`.
void addDesiredPoint(EquationRows& rows, const LatticeUnknowns& unknowns, const TurningField& field,
                     const LatticeCorner& corner, double angle, Complex point) {
  unknowns.addPosition(rows, field, corner, angle, 1, point.real());
  unknowns.addPosition(rows, field, corner, angle, Complex(0, 1), point.imag());
}

/// A corner and its desired position.
struct DesiredPoint {
  LatticeCorner corner;
  Complex point;
};

/// The sheet with rhombic voids, closed at both ends, whose corners at `angle` are nearest to the
/// desired points. All equations are linear, so the fit is one step.
TurningField rhombicField(const std::string& family, const Lattice& lattice, double angle,
                          const std::vector<DesiredPoint>& desired) {
  const LatticeUnknowns unknowns(lattice);
  const TurningField zero(lattice);
  const auto source = [&](const Eigen::VectorXd& values, DesignEquations& equations) {
    const TurningField field = unknowns.field(values);
    addRhombicBlocks(equations.exact, unknowns, field, allBlocks(lattice), values);
    for (const DesiredPoint& point : desired) {
      addDesiredPoint(equations.desired, unknowns, field, point.corner, angle, point.point);
    }
    // Constants that the corners do not determine stay small.
    unknowns.addConstants(equations.desired, field, zero, 1e-2);
  };
  FitSettings settings;
  // Linear equations need no damping.
  settings.damping = 1e-9;
  settings.rounds = 10;
  const Eigen::VectorXd start = unknowns.pack(unitField(lattice), 0);
  return unknowns.field(fitted(family, source, start, settings).unknowns);
}

/// A point of the heart curve x = 16 sin a |sin a|, y = 13 cos a - 5 cos 2a - 2 cos 3a (divided by
/// 8), anticlockwise from the lower tip for t in [0, 1].
Complex heartPoint(double t) {
  const double a = pi - 2 * pi * t;
  const double x = 16 * std::sin(a) * std::abs(std::sin(a));
  const double y = 13 * std::cos(a) - 5 * std::cos(2 * a) - 2 * std::cos(3 * a);
  return Complex(x, y) / 8.0;
}

/// Equidistant points along a closed curve given over [0, 1].
std::vector<Complex> evenPoints(const std::function<Complex(double)>& curve, int count) {
  // This number of chords measures the curve to about 1e-8 of its length.
  constexpr int kPieces = 20000;
  std::vector<double> lengths{0};
  for (int k = 0; k < kPieces; ++k) {
    const double step = std::abs(curve((k + 1.0) / kPieces) - curve(double(k) / kPieces));
    lengths.push_back(lengths.back() + step);
  }
  std::vector<Complex> points;
  for (int k = 0; k < count; ++k) {
    const double desired = lengths.back() * k / count;
    // Linear interpolation, which is accurate enough with this number of pieces.
    const auto above = std::upper_bound(lengths.begin(), lengths.end(), desired);
    const double piece = static_cast<double>(above - lengths.begin() - 1);
    const double share = (desired - *(above - 1)) / (*above - *(above - 1));
    points.push_back(curve((piece + share) / kPieces));
  }
  return points;
}

/// Round sheets with voids of any ratio: the exact conditions of two designs.
class RoundDesign {
 public:
  RoundDesign(std::string family, int size, double angle, std::vector<TileBlock> sideBlocks)
      : family_(std::move(family)),
        lattice_{size, size},
        unknowns_(lattice_),
        blocks_(innerBlocks(lattice_)),
        sideBlocks_(std::move(sideBlocks)),
        tips_(tips(lattice_)),
        angle_(angle) {}

  int logarithm(std::size_t block) const {
    return unknowns_.firstFurther() + static_cast<int>(block);
  }
  int radius() const { return logarithm(blocks_.size()); }
  const LatticeUnknowns& unknowns() const { return unknowns_; }
  const std::vector<TileBlock>& blocks() const { return blocks_; }
  const std::vector<LatticeCorner>& tipCorners() const { return tips_; }
  const Lattice& lattice() const { return lattice_; }

  /// Closed voids, and tips on the circle.
  void addExact(EquationRows& rows, const TurningField& field,
                const Eigen::VectorXd& values) const {
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
      unknowns_.addBlock(rows, field, blocks_[k], values, logarithm(k));
    }
    addRhombicBlocks(rows, unknowns_, field, sideBlocks_, values);
    // A tip on the circle: its component along its current direction is the radius. Each round
    // updates the direction, so it finally is the position's own.
    for (const LatticeCorner& tip : tips_) {
      const Complex position = field.corner(tip.cell, tip.corner, angle_);
      const Complex outwards = position / std::abs(position);
      unknowns_.addPosition(rows, field, tip, angle_, outwards, values[radius()]);
      rows.slope(radius(), -1);
    }
  }

  // `firstRadius`: initial radius of the tips' circle, metres.
  TurningField fit(const DesignSource& source, double firstRadius, double damping) const {
    const int further = static_cast<int>(blocks_.size()) + 1;
    Eigen::VectorXd start = unknowns_.pack(unitField(lattice_), further);
    start[radius()] = firstRadius;
    FitSettings settings;
    settings.damping = damping;
    return unknowns_.field(fitted(family_, source, start, settings).unknowns);
  }

 private:
  std::string family_;
  Lattice lattice_;
  LatticeUnknowns unknowns_;
  std::vector<TileBlock> blocks_;
  std::vector<TileBlock> sideBlocks_;
  std::vector<LatticeCorner> tips_;
  double angle_;
};

/// The position of node k of the closed boundary on a square of half side h about the origin.
Complex squarePoint(const Lattice& lattice, int node) {
  const int size = lattice.columns;
  const double half = 0.5 * size;
  const int side = node / size;
  // Each further side is the bottom, rotated by a quarter turn.
  const Complex onBottom(node % size - half, -half);
  return onBottom * std::pow(Complex(0, 1), side);
}

/// Appends weight * (unknown - value).
void addValue(EquationRows& rows, int unknown, double found, double desired, double weight) {
  rows.begin(weight * (found - desired));
  rows.slope(unknown, weight);
}

std::vector<TileBlock> allSideBlocks(const Lattice& lattice) {
  std::vector<TileBlock> blocks = sideBlocksClosedAtStart(lattice);
  const std::vector<TileBlock> more = sideBlocksClosedAtEnd(lattice);
  blocks.insert(blocks.end(), more.begin(), more.end());
  return blocks;
}

}  // namespace

TurningField fanField(const FanShape& shape) {
  const TurningField regular = unitField(shape.lattice);
  const Vector3 half = halfExtent(regular.tiles(pi));
  std::vector<DesiredPoint> desired;
  for (int tile = 0; tile < shape.lattice.tileCount(); ++tile) {
    for (int k = 0; k < 4; ++k) {
      const Cell cell = shape.lattice.cellOf(tile);
      const Complex position = regular.corner(cell, k, pi);
      const double x = position.real() / half.x();
      const double y = position.imag() / half.y();
      // Only corners on the outline of the open sheet have desired positions. The inside follows
      // from the exact equations.
      if (std::max(std::abs(x), std::abs(y)) < 1 - 1e-9) continue;
      // y goes from the inner to the outer radius, x over the sector's angle from left to right.
      const double distance =
          shape.innerRadius + 0.5 * (1 + y) * (shape.outerRadius - shape.innerRadius);
      desired.push_back({{cell, k}, std::polar(distance, pi / 2 - shape.halfAngle * x)});
    }
  }
  return rhombicField("fan", shape.lattice, pi, desired);
}

TurningField heartField(const Lattice& lattice) {
  const std::vector<LatticeCorner> nodes = closedBoundary(lattice);
  const int count = static_cast<int>(nodes.size());
  const std::vector<Complex> points = evenPoints(heartPoint, count);
  // The lower tip is in the middle of the left side. Nodes count from the bottom left. The left
  // side comes after bottom, right and top, and goes down.
  const int tip = 2 * lattice.columns + lattice.rows + lattice.rows / 2;
  std::vector<DesiredPoint> desired;
  for (int k = 0; k < count; ++k) {
    desired.push_back({nodes[std::size_t(k)], points[std::size_t((k - tip + count) % count)]});
  }
  return rhombicField("heart", lattice, 0, desired);
}

TurningField squareToDiskField(int size) {
  const Lattice lattice{size, size};
  const RoundDesign design("square-to-disk", size, pi, allSideBlocks(lattice));
  const LatticeUnknowns& unknowns = design.unknowns();
  const TurningField regular = unitField(lattice);
  const std::vector<LatticeCorner> nodes = closedBoundary(lattice);
  const auto source = [&](const Eigen::VectorXd& values, DesignEquations& equations) {
    const TurningField field = unknowns.field(values);
    design.addExact(equations.exact, field, values);
    // Evenly spaced nodes: otherwise the tiles at the square's corners collapse.
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      addDesiredPoint(equations.exact, unknowns, field, nodes[k], 0,
                      squarePoint(lattice, static_cast<int>(k)));
    }
    unknowns.addConstants(equations.desired, field, regular, 0.1);
    for (std::size_t k = 0; k < design.blocks().size(); ++k) {
      const int logarithm = design.logarithm(k);
      // Voids alternate between narrow and wide, about e^-0.8 and e^0.8.
      const double desired = isEven(design.blocks()[k].lowerLeft) ? -0.8 : 0.8;
      addValue(equations.desired, logarithm, values[logarithm], desired, 0.3);
    }
  };
  // The disk has the square's area: R = size / sqrt(pi) = 0.56 size, plus a little because it is a
  // polygon.
  return design.fit(source, 0.58 * size, 0.1);
}

TurningField squareToCircleField(int size) {
  const Lattice lattice{size, size};
  const RoundDesign design("square-to-circle", size, pi / 2, sideBlocksClosedAtStart(lattice));
  const LatticeUnknowns& unknowns = design.unknowns();
  const TurningField regular = unitField(lattice);
  const std::vector<LatticeCorner> nodes = closedBoundary(lattice);
  const Vector3 half = halfExtent(regular.tiles(pi / 2));
  const double radius = 1.15 * half.x();
  const auto source = [&](const Eigen::VectorXd& values, DesignEquations& equations) {
    const TurningField field = unknowns.field(values);
    design.addExact(equations.exact, field, values);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const int node = static_cast<int>(k);
      const Complex point = squarePoint(lattice, node);
      const Complex along = std::pow(Complex(0, 1), node / size);
      const Complex across = along * Complex(0, -1);
      const auto onSide = [&](Complex direction) {
        unknowns.addPosition(equations.exact, field, nodes[k], 0, direction, 0.5 * size);
      };
      onSide(across);
      // A node at a square's corner lies on two sides.
      if (node % size == 0) onSide(-along);
      unknowns.addPosition(equations.desired, field, nodes[k], 0, along,
                           (std::conj(along) * point).real(), 0.2);
    }
    // Tips are distributed around the circle by the map from square to disk.
    for (const LatticeCorner& tip : design.tipCorners()) {
      const Complex box = regular.corner(tip.cell, tip.corner, pi / 2) / half.x();
      const double u = box.real(), v = box.imag();
      // The square [-1, 1]^2 is mapped to the unit disk by (u sqrt(1 - v^2/2), v sqrt(1 - u^2/2)).
      const Complex onDisk =
          radius * Complex(u * std::sqrt(1 - v * v / 2), v * std::sqrt(1 - u * u / 2));
      const Complex tangent = Complex(0, 1) * onDisk / std::abs(onDisk);
      unknowns.addPosition(equations.desired, field, tip, pi / 2, tangent, 0, 0.3);
    }
    unknowns.addConstants(equations.desired, field, regular, 0.05);
    for (std::size_t k = 0; k < design.blocks().size(); ++k) {
      const int logarithm = design.logarithm(k);
      addValue(equations.desired, logarithm, values[logarithm], 0, 0.3);
    }
  };
  return design.fit(source, radius, 1e-2);
}

TurningField irregularField(const Lattice& lattice, double irregularity, unsigned seed) {
  const TurningField regular = unitField(lattice);
  std::mt19937 generator(seed);
  // The generator's integers are the same on every machine, unlike those of a distribution.
  const auto random = [&] { return irregularity * (generator() / 2147483648.0 - 1); };
  std::vector<DesiredPoint> desired;
  for (const LatticeCorner& node : closedBoundary(lattice)) {
    // In two statements, because the evaluation order of arguments is unspecified.
    const double x = random();
    const double y = random();
    const Complex place = regular.corner(node.cell, node.corner, 0);
    desired.push_back({node, place + Complex(x, y)});
  }
  return rhombicField("quads", lattice, 0, desired);
}

// ------------------------------------------------------------------------------------------------
// Rows of equations for a turning field's constants, with their derivatives.
//
// Positions and constants are complex numbers. The unknowns are their real and imaginary parts. A
// row is the component along a direction d, d . z = Re(conj(d) z), of a sum of c F over positions.
// Its derivatives are d . c by Re F and d . (i c) by Im F. c is e^(-i theta/2) at the odd and
// e^(i theta/2) at the even position of a corner, or +-1 and +-lambda in a block.
//
// Positions just outside the sheet also have constants, which define the free corners at its sides.
// The four diagonally outside positions belong to no corner and to no used block.

namespace {

/// The inner product of two plane vectors.
double scalarProduct(Complex a, Complex b) {
  return (std::conj(a) * b).real();
}

// Diagonally outside positions, which no equation uses.
bool isGhostCorner(const Lattice& lattice, const Cell& cell) {
  const bool outsideColumns = cell.column < 0 || cell.column >= lattice.columns;
  const bool outsideRows = cell.row < 0 || cell.row >= lattice.rows;
  return outsideColumns && outsideRows;
}

/// Half blocks with even lower left positions on the left and right sides and odd ones at the
/// bottom and the top, or vice versa.
std::vector<TileBlock> sideBlocks(const Lattice& lattice, bool evenAtLeftAndRight) {
  std::vector<TileBlock> blocks;
  for (int column = 0; column + 1 < lattice.columns; ++column) {
    for (const int row : {-1, lattice.rows - 1}) {
      // A block's parity is that of its lower left position. Bottom and top use the other parity,
      // since neighbouring sides have their mouths at different nodes.
      if (isEven({column, row}) != evenAtLeftAndRight) blocks.push_back({{column, row}});
    }
  }
  for (int row = 0; row + 1 < lattice.rows; ++row) {
    for (const int column : {-1, lattice.columns - 1}) {
      if (isEven({column, row}) == evenAtLeftAndRight) blocks.push_back({{column, row}});
    }
  }
  return blocks;
}

}  // namespace

std::vector<LatticeCorner> closedBoundary(const Lattice& lattice) {
  const int right = lattice.columns - 1;
  const int top = lattice.rows - 1;
  std::vector<LatticeCorner> nodes;
  for (int i = 0; i <= right; ++i) nodes.push_back({{i, 0}, 0});
  for (int j = 0; j <= top; ++j) nodes.push_back({{right, j}, 1});
  for (int i = right; i >= 0; --i) nodes.push_back({{i, top}, 2});
  for (int j = top; j >= 0; --j) nodes.push_back({{0, j}, 3});
  return nodes;
}

// For an asymmetric sheet the larger side counts.
Vector3 halfExtent(const std::vector<model::Tile>& tiles) {
  Vector3 half = Vector3::Zero();
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) half = half.cwiseMax(vertex.cwiseAbs());
  }
  return half;
}

// In the order of closedBoundary().
std::vector<LatticeCorner> tips(const Lattice& lattice) {
  const int right = lattice.columns - 1;
  const int top = lattice.rows - 1;
  std::vector<LatticeCorner> found;
  const auto append = [&](const Cell& cell, int stepColumn, int stepRow) {
    for (int k = 0; k < 4; ++k) {
      const Cell beyond = cornerNeighbour(cell, k);
      // A corner whose neighbour is outside has no joint.
      const bool isThere =
          beyond.column == cell.column + stepColumn && beyond.row == cell.row + stepRow;
      if (isThere) found.push_back({cell, k});
    }
  };
  for (int i = 0; i <= right; ++i) append({i, 0}, 0, -1);
  for (int j = 0; j <= top; ++j) append({right, j}, 1, 0);
  for (int i = right; i >= 0; --i) append({i, top}, 0, 1);
  for (int j = top; j >= 0; --j) append({0, j}, -1, 0);
  return found;
}

std::vector<TileBlock> innerBlocks(const Lattice& lattice) {
  std::vector<TileBlock> blocks;
  for (int column = 0; column + 1 < lattice.columns; ++column) {
    for (int row = 0; row + 1 < lattice.rows; ++row) blocks.push_back({{column, row}});
  }
  return blocks;
}

std::vector<TileBlock> sideBlocksClosedAtStart(const Lattice& lattice) {
  return sideBlocks(lattice, true);
}

std::vector<TileBlock> sideBlocksClosedAtEnd(const Lattice& lattice) {
  return sideBlocks(lattice, false);
}

Eigen::VectorXd LatticeUnknowns::pack(const TurningField& field, int further) const {
  Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(firstFurther() + further);
  for (int column = -1; column <= lattice().columns; ++column) {
    for (int row = -1; row <= lattice().rows; ++row) {
      const int place = places_.placeAt({column, row});
      unknowns[2 * place] = field.at({column, row}).real();
      unknowns[2 * place + 1] = field.at({column, row}).imag();
    }
  }
  return unknowns;
}

TurningField LatticeUnknowns::field(const Eigen::VectorXd& unknowns) const {
  TurningField field(lattice());
  for (int column = -1; column <= lattice().columns; ++column) {
    for (int row = -1; row <= lattice().rows; ++row) {
      const int place = places_.placeAt({column, row});
      field.at({column, row}) = {unknowns[2 * place], unknowns[2 * place + 1]};
    }
  }
  return field;
}

// Adds the derivatives by both parts of a constant in a term factor * F, along a direction.
void LatticeUnknowns::addSlope(EquationRows& rows, const Cell& cell, Complex factor,
                               Complex direction) const {
  const int place = places_.placeAt(cell);
  rows.slope(2 * place, scalarProduct(direction, factor));
  rows.slope(2 * place + 1, scalarProduct(direction, factor * Complex(0, 1)));
}

void LatticeUnknowns::addPosition(EquationRows& rows, const TurningField& field,
                                  const LatticeCorner& corner, double angle, Complex direction,
                                  double value, double weight) const {
  const Complex halfTurn = std::polar(1.0, 0.5 * angle);
  Cell even = corner.cell;
  Cell odd = cornerNeighbour(corner.cell, corner.corner);
  if (!isEven(corner.cell)) std::swap(even, odd);
  const Complex position = field.corner(corner.cell, corner.corner, angle);
  rows.begin(weight * (scalarProduct(direction, position) - value));
  addSlope(rows, odd, std::conj(halfTurn), weight * direction);
  addSlope(rows, even, halfTurn, weight * direction);
}

void LatticeUnknowns::addBlock(EquationRows& rows, const TurningField& field,
                               const TileBlock& block, const Eigen::VectorXd& unknowns,
                               int logarithm) const {
  const double ratio = logarithm < 0 ? 1 : std::exp(unknowns[logarithm]);
  const double signedRatio = isEven(block.lowerLeft) ? ratio : -ratio;
  const Complex across = field.at(block.at(1, 0)) - field.at(block.at(0, 1));
  const Complex along = field.at(block.at(1, 1)) - field.at(block.at(0, 0));
  for (const Complex direction : {Complex(1, 0), Complex(0, 1)}) {
    rows.begin(scalarProduct(direction, along - signedRatio * across));
    addSlope(rows, block.at(1, 1), 1, direction);
    addSlope(rows, block.at(0, 0), -1, direction);
    addSlope(rows, block.at(1, 0), -signedRatio, direction);
    addSlope(rows, block.at(0, 1), signedRatio, direction);
    // d lambda / d log lambda = lambda, which signedRatio already contains.
    if (logarithm >= 0) rows.slope(logarithm, -scalarProduct(direction, signedRatio * across));
  }
}

void LatticeUnknowns::addConstants(EquationRows& rows, const TurningField& field,
                                   const TurningField& desired, double weight) const {
  for (int column = -1; column <= lattice().columns; ++column) {
    for (int row = -1; row <= lattice().rows; ++row) {
      const Cell cell{column, row};
      if (isGhostCorner(lattice(), cell)) continue;
      const Complex difference = field.at(cell) - desired.at(cell);
      const int place = places_.placeAt(cell);
      rows.begin(weight * difference.real());
      rows.slope(2 * place, weight);
      rows.begin(weight * difference.imag());
      rows.slope(2 * place + 1, weight);
    }
  }
}

}  // namespace kirireel::generate
