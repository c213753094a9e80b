// All quantities are built from positions. The position of a handle at arm r from the centre of
// mass of brick i, relative to that centre at the start, is
//   p = d . (x_i + R(phi_i) r),   dp/dphi = d . (z x R r),   d^2p/dphi^2 = -d . R r,
// and that of a rotation is p = phi_i. Far from the origin, the displacements x_i keep all their
// digits. A pivot is two rows p_a - p_b = d . (c_b - c_a) with the centres c at the start, a pin
// three rows p = p(start). A grip that moves is a row p = p(start) + load * amount for each handle.
// A dead load is the potential -load * amount * p. Springs at hinges are quadratic in the
// rotations; ligaments are in hinge.cpp, other pair forces in their own files.
//
// Symbols: x_i the displacement of the centre of mass of brick i since the start and r an arm, both
// in length scales, phi_i its rotation (rad) since the start, d a unit direction, z the vertical.
// All constraints are sums of positions, and their derivatives are sums of the three formulas
// above. Each position depends only on one brick's three coordinates, and only its rotation has a
// second derivative.
#include "sim/statics/elastic_sheet.h"

#include <algorithm>
#include <cmath>

namespace kirireel::statics {

// Builds the rows in a fixed order: two for each pivot, three for each pinned tile, one for each
// handle of a grip that moves. force() finds a grip's multipliers by that order. Pivots of the
// upper face coincide with those of the lower one in the plane and are omitted.
ElasticSheet::ElasticSheet(const std::vector<brick::Brick>& bricks, Poses start,
                           const brick::PairForces& pairForces,
                           const std::vector<brick::Pivot>& pivots, const std::vector<int>& pinned,
                           std::vector<Grip> grips)
    : start_(std::move(start)),
      springs_(brick::hingeSpringsOf(pairForces)),
      grips_(std::move(grips)),
      ligaments_(brick::ligamentsOf(pairForces)),
      scale_(bricks.empty() ? 1 : brick::meanEdge(bricks.front())),
      stiffness_(0) {
  for (const std::shared_ptr<const brick::PairForce>& force : pairForces) {
    if (!force->hingeSprings() && !force->ligaments()) others_.add(force);
  }
  stiffness_ = largestStiffness();
  const Vector q = startCoordinates();
  const Vector3 axes[] = {Vector3::UnitX(), Vector3::UnitY()};
  for (const brick::Pivot& pivot : pivots) {
    if (pivot.isUpper) continue;
    for (const Vector3& axis : axes) {
      addRow({{{pivot.brickA, pivot.pointA}, axis}, {{pivot.brickB, pivot.pointB}, axis, -1}}, 0,
             q);
      // Closed, for any start.
      rows_.back().offset = axis.dot(centreDistance(pivot.brickA, pivot.brickB)) / scale_;
    }
  }
  for (const int tile : pinned) {
    for (const Vector3& axis : axes) addRow({{{tile}, axis}}, 0, q);
    addRow({{{.brick = tile, .isTurn = true}, Vector3::UnitZ()}}, 0, q);
  }
  for (const Grip& grip : grips_) {
    firstRow_.push_back(rows());
    if (grip.isForce) continue;
    for (const GripHandle& handle : grip.handles) {
      addRow({{handle, grip.direction}}, grip.amount / (handle.isTurn ? 1 : scale_), q);
    }
  }
}

// A row is sum(factor * position) - offset - load * motion = 0. The offset is the sum at the start:
// the row holds there at load 0.
void ElasticSheet::addRow(std::vector<Term> terms, double motion, const Vector& start) {
  Row row{std::move(terms), 0, motion};
  for (const Term& term : row.terms) row.offset += term.factor * place(term, start);
  rows_.push_back(std::move(row));
}

// Three coordinates per brick: x and y of its displacement in length scales, and its rotation in
// radians, both since the start.
ElasticSheet::Vector ElasticSheet::startCoordinates() const {
  return Vector::Zero(unknowns());
}

/// From the centre of mass of brick A at the start to that of brick B, metres.
Vector3 ElasticSheet::centreDistance(int brickA, int brickB) const {
  return start_[brickB].position - start_[brickA].position;
}

// The height and the tilt of the start are kept.
Poses ElasticSheet::posesAt(const Vector& q) const {
  Poses poses = start_;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].position.head<2>() += scale_ * q.segment<2>(3 * i);
    poses[i].rotation = rotationFromVector(Vector3(0, 0, q[3 * i + 2])) * start_[i].rotation;
  }
  return poses;
}

/// Arm of a handle from its brick's centre of mass, world axes, length scales.
Vector3 ElasticSheet::arm(const GripHandle& handle, const Vector& q) const {
  const Vector3 r = start_[handle.brick].rotation * handle.point / scale_;
  return rotationFromVector(Vector3(0, 0, q[3 * handle.brick + 2])) * r;
}

// Position along the term's direction from the brick's centre at the start, in length scales, or
// the rotation of the brick in radians.
double ElasticSheet::place(const Term& term, const Vector& q) const {
  const auto& [handle, direction, factor] = term;
  if (handle.isTurn) return q[3 * handle.brick + 2];
  const Vector3 at(q[3 * handle.brick], q[3 * handle.brick + 1], 0);
  return direction.dot(at + arm(handle, q));
}

/// The derivative of a position with respect to its brick's three coordinates.
Vector3 ElasticSheet::slope(const Term& term, const Vector& q) const {
  if (term.handle.isTurn) return Vector3::UnitZ();
  const Vector3 turning = Vector3::UnitZ().cross(arm(term.handle, q));
  return {term.direction.x(), term.direction.y(), term.direction.dot(turning)};
}

/// The second derivative of a position with respect to its brick's rotation.
double ElasticSheet::bend(const Term& term, const Vector& q) const {
  return term.handle.isTurn ? 0 : -term.direction.dot(arm(term.handle, q));
}

// The largest second derivative of one part of the sheet, joules: springs by rotations (N m per
// rad), ligaments by positions (N/m times the length scale squared) and by rotations. The shear
// stiffness of a ligament that is not a pin is a moment per radian: across the ligament it acts as
// shear / length^2.
double ElasticSheet::largestStiffness() const {
  double largest = 0;
  for (const brick::HingeSpring& spring : springs_) largest = std::max(largest, spring.stiffness);
  for (const brick::Ligament& ligament : ligaments_) {
    const double area = scale_ * scale_, shear = ligament.shearStiffness;
    const double across = ligament.isPin() ? shear : shear / ligament.start.squaredNorm();
    largest = std::max(largest, area * std::max(across, ligament.stretchStiffness));
    if (!ligament.isPin()) largest = std::max(largest, shear);
  }
  const std::vector<PairPart> parts = pairParts(startCoordinates());
  for (std::size_t k = ligaments_.size(); k < parts.size(); ++k) {
    largest = std::max(largest, parts[k].energy.hessian.cwiseAbs().maxCoeff());
  }
  return largest;
}

/// Converts derivatives per metre to derivatives per length scale.
brick::PlanarEnergy ElasticSheet::inLengthScales(brick::PlanarEnergy energy) const {
  Vector6 units;
  units << scale_, scale_, 1, scale_, scale_, 1;
  energy.gradient.array() *= units.array();
  energy.hessian = units.asDiagonal() * energy.hessian * units.asDiagonal();
  return energy;
}

/// Energy of a ligament, with derivatives with respect to q.
brick::PlanarEnergy ElasticSheet::energyOf(const brick::Ligament& ligament, const Vector& q) const {
  const int a = 3 * ligament.brickA, b = 3 * ligament.brickB;
  Vector3 between = scale_ * Vector3(q[b] - q[a], q[b + 1] - q[a + 1], 0);
  between.head<2>() += centreDistance(ligament.brickA, ligament.brickB).head<2>();
  const brick::PlanarEnergy found = brick::ligamentEnergy(
      ligament, between, scale_ * arm({ligament.brickA, ligament.pointA}, q),
      scale_ * arm({ligament.brickB, ligament.pointB}, q), q[a + 2], q[b + 2]);
  return inLengthScales(found);
}

// Ligaments use the rotations, which may be large; other forces use the poses. Springs at hinges
// are handled separately.
std::vector<ElasticSheet::PairPart> ElasticSheet::pairParts(const Vector& q) const {
  std::vector<PairPart> parts;
  for (const brick::Ligament& ligament : ligaments_) {
    parts.push_back({ligament.brickA, ligament.brickB, energyOf(ligament, q)});
  }
  if (others_.empty()) return parts;
  const Poses poses = posesAt(q);
  for (const std::shared_ptr<const brick::PairForce>& force : others_) {
    for (std::size_t pair = 0; pair < force->size(); ++pair) {
      const auto [brickA, brickB] = force->bricks(pair);
      parts.push_back(
          {brickA, brickB, inLengthScales(brick::inPlane(force->derivatives(pair, poses)))});
    }
  }
  return parts;
}

// Energy of all pair forces, joules. Dead loads are only in gradient().
double ElasticSheet::energy(const Vector& q) const {
  double sum = brick::elasticEnergy(springs_, posesAt(q));
  for (const PairPart& part : pairParts(q)) sum += part.energy.energy;
  return sum;
}

/// The positions on which a dead load does work, with factors in joules.
std::vector<ElasticSheet::Term> ElasticSheet::forceTerms(const Grip& grip) const {
  std::vector<Term> terms;
  const double share = grip.amount / static_cast<double>(grip.handles.size());
  for (const GripHandle& handle : grip.handles) {
    terms.push_back({handle, grip.direction, share * (handle.isTurn ? 1 : scale_)});
  }
  return terms;
}

// The dead loads' forces on the coordinates at load 1, joules. They depend on q, because the loaded
// point rotates with its brick.
ElasticSheet::Vector ElasticSheet::pull(const Vector& q) const {
  Vector sum = Vector::Zero(unknowns());
  for (const Grip& grip : grips_) {
    if (!grip.isForce) continue;
    for (const Term& term : forceTerms(grip)) {
      sum.segment<3>(3 * term.handle.brick) += term.factor * slope(term, q);
    }
  }
  return sum;
}

// dE/dq - load * pull, joules. hingeMoments() are about the hinge's axis on brick B. Energy falls
// in the direction of the moment: B's entry gets minus and A's entry plus.
ElasticSheet::Vector ElasticSheet::gradient(const Vector& q, double load) const {
  Vector sum = -load * pull(q);
  const std::vector<double> moments = brick::hingeMoments(springs_, posesAt(q));
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const brick::Hinge& hinge = springs_[s].hinge;
    sum[3 * hinge.brickA + 2] += moments[s] * hinge.axis.z();
    sum[3 * hinge.brickB + 2] -= moments[s] * hinge.axis.z();
  }
  for (const PairPart& part : pairParts(q)) {
    sum.segment<3>(3 * part.brickA) += part.energy.gradient.head<3>();
    sum.segment<3>(3 * part.brickB) += part.energy.gradient.tail<3>();
  }
  return sum;
}

// sum(factor * position(q)) - offset - load * motion for each row.
ElasticSheet::Vector ElasticSheet::residual(const Vector& q, double load) const {
  Vector rest(rows());
  for (int k = 0; k < rows(); ++k) {
    const Row& row = rows_[static_cast<std::size_t>(k)];
    rest[k] = -row.offset - load * row.motion;
    for (const Term& term : row.terms) rest[k] += term.factor * place(term, q);
  }
  return rest;
}

// Each row has three entries for each of its terms. A pivot's row has two terms, those of pins and
// grips have one.
ElasticSheet::Matrix ElasticSheet::jacobian(const Vector& q) const {
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < rows(); ++k) {
    for (const Term& term : rows_[static_cast<std::size_t>(k)].terms) {
      const Vector3 part = term.factor * slope(term, q);
      for (int j = 0; j < 3; ++j) entries.emplace_back(k, 3 * term.handle.brick + j, part[j]);
    }
  }
  Matrix matrix(rows(), unknowns());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// The change of each row's position as the load grows by 1, length scales or radians.
ElasticSheet::Vector ElasticSheet::motion() const {
  Vector column(rows());
  for (int k = 0; k < rows(); ++k) column[k] = rows_[static_cast<std::size_t>(k)].motion;
  return column;
}

// The second derivative of E - load * work + multipliers . rows with respect to q. Positions are
// linear in x and y, and curved only in the rotation: rows and dead loads add only to its diagonal.
ElasticSheet::Matrix ElasticSheet::hessian(const Vector& q, double load,
                                           const Vector& multipliers) const {
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int brickA, int brickB, double value) {
    entries.emplace_back(3 * brickA + 2, 3 * brickB + 2, value);
  };
  for (const brick::HingeSpring& spring : springs_) {
    const auto [a, b] = std::pair(spring.hinge.brickA, spring.hinge.brickB);
    add(a, a, spring.stiffness);
    add(b, b, spring.stiffness);
    add(a, b, -spring.stiffness);
    add(b, a, -spring.stiffness);
  }
  for (const PairPart& part : pairParts(q)) {
    const auto index = [&](int k) { return 3 * (k < 3 ? part.brickA : part.brickB) + k % 3; };
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        entries.emplace_back(index(i), index(j), part.energy.hessian(i, j));
      }
    }
  }
  for (int k = 0; k < rows(); ++k) {
    for (const Term& term : rows_[static_cast<std::size_t>(k)].terms) {
      add(term.handle.brick, term.handle.brick, multipliers[k] * term.factor * bend(term, q));
    }
  }
  for (const Grip& grip : grips_) {
    if (!grip.isForce) continue;
    for (const Term& term : forceTerms(grip)) {
      add(term.handle.brick, term.handle.brick, -load * term.factor * bend(term, q));
    }
  }
  Matrix matrix(unknowns(), unknowns());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

mechanics::RowRange ElasticSheet::rowsOf(std::size_t grip) const {
  const Grip& found = grips_[grip];
  const std::size_t count = found.isForce ? 0 : found.handles.size();
  return {firstRow_[grip], static_cast<Eigen::Index>(count)};
}

// All handles of a grip have the same type: check the first.
double ElasticSheet::unit(std::size_t grip) const {
  return grips_[grip].handles.front().isTurn ? 1 : scale_;
}

// The mean displacement of the handles along the grip's direction, m or rad.
double ElasticSheet::displacement(std::size_t number, const Vector& q) const {
  const Grip& grip = grips_[number];
  const Vector start = startCoordinates();
  double sum = 0;
  for (const GripHandle& handle : grip.handles) {
    const Term term{handle, grip.direction};
    sum += (handle.isTurn ? 1 : scale_) * (place(term, q) - place(term, start));
  }
  return sum / static_cast<double>(grip.handles.size());
}

double ElasticSheet::displacementSlope(std::size_t number, const Vector& q,
                                       const Vector& along) const {
  const Grip& grip = grips_[number];
  double sum = 0;
  for (const GripHandle& handle : grip.handles) {
    const Vector3 part = slope({handle, grip.direction}, q);
    sum += (handle.isTurn ? 1 : scale_) * part.dot(along.segment<3>(3 * handle.brick));
  }
  return sum / static_cast<double>(grip.handles.size());
}

// Minus the sum of its rows' multipliers. A multiplier is in joules per unit of the row. Divided by
// the scale it is in newtons; for a rotation it is already in N m.
double ElasticSheet::multiplierForce(std::size_t grip, const Vector& multipliers) const {
  const auto [first, count] = rowsOf(grip);
  return -multipliers.segment(first, count).sum() / unit(grip);
}

// Multipliers of dependent directions hold any part that does no work. The sum removes it.
double ElasticSheet::force(std::size_t grip, double load, const Vector& multipliers) const {
  const Grip& found = grips_[grip];
  if (found.isForce) return load * found.amount;
  if (found.force.empty()) return multiplierForce(grip, multipliers);
  double sum = 0;
  for (const auto& [other, share] : found.force) sum += share * multiplierForce(other, multipliers);
  return sum;
}

}  // namespace kirireel::statics
