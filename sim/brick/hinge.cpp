// Finds hinges from the common points of two bricks. A hinge's angle is that of the start plus the
// twist since then. The rotation q from brick A to brick B, identity at the start, has the twist
//   turn = 2 atan2(axis . Im q, Re q)
// about the axis. A quaternion and its negative are the same rotation but differ by one full turn.
// Quaternions of a run do not change sign abruptly, so the turn is continuous and defined up to 4
// pi. The value nearest to the middle of the reachable angles is used. Bricks may therefore overlap
// by up to a full turn.
#include "sim/brick/hinge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "sim/model/sheet_frame.h"

namespace kirireel::brick {
namespace {

constexpr double kPi = std::numbers::pi;
// Points closer than this fraction of a brick's edge are one.
constexpr double kSameHingePoint = 1e-6;
// Angles closer than this are equal, radians.
constexpr double kSameAngle = 1e-6;

/// The common points of two bricks, in the axes of the first.
struct PivotPoints {
  const Pivot* first = nullptr;
  std::vector<Vector3> points;
  bool isTied = false;  // fixed, or held by a link too
};

/// The common points of all pairs of bricks, in the order of their first pivots.
std::vector<PivotPoints> sharedPoints(std::span<const Pivot> pivots, bool planar) {
  std::vector<PivotPoints> pairs;
  std::map<std::pair<int, int>, std::size_t> known;
  for (const Pivot& pivot : pivots) {
    if (planar && pivot.isUpper) continue;
    const std::pair<int, int> key = std::minmax(pivot.brickA, pivot.brickB);
    const auto [place, isNew] = known.try_emplace(key, pairs.size());
    if (isNew) pairs.push_back({&pivot, {}, false});
    PivotPoints& shared = pairs[place->second];
    // All points of a pair are in the axes of its first brick.
    const bool isSwapped = pivot.brickA != shared.first->brickA;
    shared.points.push_back(isSwapped ? pivot.pointB : pivot.pointA);
    shared.isTied = shared.isTied || pivot.cornerA == kNoCorner;
  }
  return pairs;
}

/// The unit direction of the line through all points; zero if they coincide or are not collinear.
struct CommonLine {
  Vector3 direction = Vector3::Zero();
  bool isPoint = false;
};

CommonLine commonLine(const std::vector<Vector3>& points, double same) {
  const auto fromFirst = [&](const Vector3& point) { return (point - points[0]).norm(); };
  const Vector3 farthest = *std::ranges::max_element(points, {}, fromFirst);
  // All points are one: a corner.
  if (fromFirst(farthest) <= same) return {Vector3::Zero(), true};
  const Vector3 along = (farthest - points[0]).normalized();
  const bool isLine = std::ranges::all_of(
      points, [&](const Vector3& point) { return along.cross(point - points[0]).norm() <= same; });
  return {isLine ? along : Vector3::Zero(), false};
}

/// Angular range of a brick at a corner on the axis.
struct Sector {
  double begin = 0;  // radians from a common direction
  double width = 0;
};

Sector sectorAt(const Brick& brick, int corner, const Vector3& axis, const Vector3& zero) {
  const std::size_t count = brick.bottom.size();
  const auto k = static_cast<std::size_t>(corner);
  const auto angleOf = [&](const Vector3& edge) {
    return std::atan2(axis.dot(zero.cross(edge)), zero.dot(edge));
  };
  double begin = angleOf(brick.bottom[(k + 1) % count] - brick.bottom[k]);
  double end = angleOf(brick.bottom[(k + count - 1) % count] - brick.bottom[k]);
  // A tile is clockwise if seen against its normal.
  if (brick.normal.dot(axis) < 0) std::swap(begin, end);
  return {begin, end > begin ? end - begin : end - begin + 2 * kPi};
}

/// The angle nearest to `middle` among those that differ by multiples of `period`.
double nearest(double angle, double middle, double period = 2 * kPi) {
  return middle + std::remainder(angle - middle, period);
}

Hinge cornerHinge(const std::vector<Brick>& bricks, const Pivot& pivot) {
  const Brick& brickA = bricks[static_cast<std::size_t>(pivot.brickA)];
  const Brick& brickB = bricks[static_cast<std::size_t>(pivot.brickB)];
  const Vector3 axis = brickA.normal;
  const Vector3 zero = axis.unitOrthogonal();
  const Sector a = sectorAt(brickA, pivot.cornerA, axis, zero);
  const Sector b = sectorAt(brickB, pivot.cornerB, axis, zero);
  // The free part of the full turn about the corner is divided between the gaps on both sides.
  const double free = std::max(0.0, 2 * kPi - a.width - b.width);
  const double left = nearest(b.begin - a.begin - a.width, 0.5 * free);
  // The gap on the other side is smaller: the angle is measured there, with a reversed axis.
  if (free - left < left - kSameAngle) {
    return {pivot.brickA, pivot.brickB, -axis, free - left, 0, free, pivot.cornerA, pivot.cornerB};
  }
  return {pivot.brickA, pivot.brickB, axis, left, 0, free, pivot.cornerA, pivot.cornerB};
}

/// The direction from an axis through a point into the brick, along its tile.
Vector3 inward(const Brick& brick, const Vector3& point, const Vector3& axis) {
  Vector3 direction = meanPoint(brick.bottom) - point;
  // Only the component across the axis and in the tile shows the tile's side of the axis.
  direction -= brick.normal.dot(direction) * brick.normal;
  direction -= axis.dot(direction) * axis;
  return direction.normalized();
}

Hinge foldHinge(const std::vector<Brick>& bricks, const Pivot& pivot, const Vector3& line) {
  const Brick& brickA = bricks[static_cast<std::size_t>(pivot.brickA)];
  const Brick& brickB = bricks[static_cast<std::size_t>(pivot.brickB)];
  const Vector3 a = inward(brickA, pivot.pointA, line);
  const Vector3 b = inward(brickB, pivot.pointB, line);
  // The first tile is on the right of the axis. A positive turn lifts B to A's upper side.
  const Vector3 axis = line.dot(brickA.normal.cross(a)) < 0 ? Vector3(-line) : line;
  const double start = std::atan2(axis.dot(b.cross(a)), -a.dot(b));
  return {pivot.brickA, pivot.brickB, axis, start, -kPi, kPi};
}

}  // namespace

FoundHinges findHinges(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
                       bool planar) {
  FoundHinges found;
  for (PivotPoints& shared : sharedPoints(pivots, planar)) {
    if (shared.isTied) continue;
    const Pivot& pivot = *shared.first;
    const Brick& brick = bricks[static_cast<std::size_t>(pivot.brickA)];
    const CommonLine line = commonLine(shared.points, kSameHingePoint * meanEdge(brick));
    // A line along the thickness is a corner with both faces joined, a line in the tile an edge.
    const bool isAcross = std::abs(line.direction.dot(brick.normal)) > std::sqrt(0.5);
    if (isAcross || (planar && line.isPoint)) {
      found.hinges.push_back(cornerHinge(bricks, pivot));
    } else if (line.isPoint) {
      found.ballJoints.emplace_back(pivot.brickA, pivot.brickB);
    } else if (!planar && !line.direction.isZero()) {
      found.hinges.push_back(foldHinge(bricks, pivot, line.direction));
    }
  }
  return found;
}

double hingeAngle(const Hinge& hinge, const Poses& poses) {
  const Quaternion& a = poses[static_cast<std::size_t>(hinge.brickA)].rotation;
  const Quaternion& b = poses[static_cast<std::size_t>(hinge.brickB)].rotation;
  // The twist about the axis, as above. Re and Im of the quaternion are w and vec().
  const Quaternion between = a.conjugate() * b;
  const double turn = 2 * std::atan2(hinge.axis.dot(between.vec()), between.w());
  return nearest(hinge.start + turn, 0.5 * (hinge.least + hinge.most), 4 * kPi);
}

double hingeRate(const Hinge& hinge, const Motion& motion) {
  const auto a = static_cast<std::size_t>(hinge.brickA), b = static_cast<std::size_t>(hinge.brickB);
  const Vector3 axis = motion.poses[a].rotation * hinge.axis;
  return axis.dot(motion.velocities[b].angular - motion.velocities[a].angular);
}

std::vector<double> hingeMoments(std::span<const HingeSpring> springs, const Poses& poses) {
  std::vector<double> moments;
  for (const HingeSpring& spring : springs) {
    moments.push_back(spring.stiffness * (spring.rest - hingeAngle(spring.hinge, poses)));
  }
  return moments;
}

double elasticEnergy(std::span<const HingeSpring> springs, const Poses& poses) {
  double sum = 0;
  for (const HingeSpring& spring : springs) {
    const double turn = hingeAngle(spring.hinge, poses) - spring.rest;
    sum += 0.5 * spring.stiffness * turn * turn;
  }
  return sum;
}

namespace {

constexpr std::array kSpringFields = {
    PairField<HingeSpring>{"axis", "1", 3, [](HingeSpring& s) { return s.hinge.axis.data(); }},
    PairField<HingeSpring>{"start", "rad", 1, [](HingeSpring& s) { return &s.hinge.start; }},
    PairField<HingeSpring>{"least", "rad", 1, [](HingeSpring& s) { return &s.hinge.least; }},
    PairField<HingeSpring>{"most", "rad", 1, [](HingeSpring& s) { return &s.hinge.most; }},
    PairField<HingeSpring>{"stiffness", "N m/rad", 1, [](HingeSpring& s) { return &s.stiffness; }},
    PairField<HingeSpring>{"rest", "rad", 1, [](HingeSpring& s) { return &s.rest; }},
    PairField<HingeSpring>{"damping", "N m s/rad", 1, [](HingeSpring& s) { return &s.damping; }}};

}  // namespace

std::shared_ptr<const PairForce> HingeSprings::read(const PairReader& file) {
  std::vector<HingeSpring> springs;
  for (const auto& [brickA, brickB] : file.bricks()) {
    springs.emplace_back().hinge.brickA = brickA;
    springs.back().hinge.brickB = brickB;
  }
  readFields(file, kSpringFields, springs);
  return std::make_shared<HingeSprings>(std::move(springs));
}

std::pair<int, int> HingeSprings::bricks(std::size_t pair) const {
  return {springs_[pair].hinge.brickA, springs_[pair].hinge.brickB};
}

double HingeSprings::energy(std::size_t pair, const Poses& poses) const {
  return elasticEnergy({&springs_[pair], 1}, poses);
}

// The gradient of the angle by rotations is the axis for brick B and its opposite for brick A.
PairEnergy HingeSprings::derivatives(std::size_t pair, const Poses& poses) const {
  const HingeSpring& spring = springs_[pair];
  const Hinge& hinge = spring.hinge;
  Vector12 slope = Vector12::Zero();
  slope.tail<3>() = poses[static_cast<std::size_t>(hinge.brickA)].rotation * hinge.axis;
  slope.segment<3>(3) = -slope.tail<3>();
  return {energy(pair, poses), -hingeMoments({&spring, 1}, poses).front() * slope,
          spring.stiffness * slope * slope.transpose()};
}

void HingeSprings::addForces(const Motion& motion, std::vector<Vector6>& forces) const {
  const std::vector<double> moments = hingeMoments(springs_, motion.poses);
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const Hinge& hinge = springs_[s].hinge;
    const double moment = moments[s] - springs_[s].damping * hingeRate(hinge, motion);
    const auto a = static_cast<std::size_t>(hinge.brickA);
    const Vector3 onB = moment * (motion.poses[a].rotation * hinge.axis);
    forces[a].tail<3>() -= onB;
    forces[static_cast<std::size_t>(hinge.brickB)].tail<3>() += onB;
  }
}

std::optional<std::pair<int, int>> HingeSprings::findJump(const Poses& from,
                                                          const Poses& to) const {
  for (const auto& [hinge, stiffness, rest, damping] : springs_) {
    if (std::abs(hingeAngle(hinge, to) - hingeAngle(hinge, from)) > 2 * kPi) {
      return std::pair(hinge.brickA, hinge.brickB);
    }
  }
  return std::nullopt;
}

std::vector<PairColumn> HingeSprings::columns() const {
  return columnsOf(springs_, kSpringFields);
}

const std::vector<HingeSpring>& hingeSpringsOf(const PairForces& forces) {
  static const std::vector<HingeSpring> none;
  for (const std::shared_ptr<const PairForce>& force : forces) {
    if (force->hingeSprings()) return *force->hingeSprings();
  }
  return none;
}

// ------------------------------------------------------------------------------------------------
// Let l be the vector from point A to point B, l0 its value at the start and phi the turns of the
// bricks:
//   E = k_l (|l| - |l0|)^2 / 2 + k_s gamma^2 / 2,   gamma = angle(l0, l) - (phi_A + phi_B) / 2.
// This is exact for large turns: a rotation of the whole changes neither term. Together with a
// torsional spring on phi_B - phi_A this is the rigid unit's ligament of Deng, Raney, Tournat and
// Bertoldi, Elastic vector solitons in soft architected materials, Phys. Rev. Lett. 118, 2017. The
// strains are those of Bordiga, Medina, Jafarzadeh et al., Automated discovery of reprogrammable
// nonlinear dynamic metamaterials, Nat. Mater. 23, 2024. A beam whose ends turn by a and b relative
// to its chord has the energy
//   E I / L (2 a^2 + 2 a b + 2 b^2) = 12 E I / L gamma^2 / 2 + E I / L (b - a)^2 / 2.
//
// The points of a pin separate by d from point A to point B. The directions n across and t along
// its slit turn by the mean m of both bricks' turns since the start: dn/dm = t, dt/dm = -n. Then
//   E = k_l (n . d)^2 / 2 + k_s (t . d)^2 / 2,
//   d(n . d) = n . dd + (t . d) dm,   d(t . d) = t . dd - (n . d) dm,
// Opening adds b a^3 / 3 + c a^4 / 4 to the energy of the linear spring, with a = phi_B - phi_A.

namespace {

using Row2 = Eigen::Matrix<double, 2, 6>;

/// The derivative of l by the six coordinates.
Row2 slopeOf(const Vector3& armA, const Vector3& armB) {
  Row2 slope;
  slope << -1, 0, armA.y(), 1, 0, -armB.y(), 0, -1, -armA.x(), 0, 1, armB.x();
  return slope;
}

/// The second derivative of the component of l along a direction. It depends only on the turns.
Matrix6 bendOf(const Vector3& armA, const Vector3& armB, const Eigen::Vector2d& direction) {
  Matrix6 bend = Matrix6::Zero();
  bend(2, 2) = direction.dot(armA.head<2>());
  bend(5, 5) = -direction.dot(armB.head<2>());
  return bend;
}

/// A component of d and its derivatives by the coordinates of both bricks.
struct PinComponent {
  double value = 0;
  Vector6 slope = Vector6::Zero();
  Matrix6 bend = Matrix6::Zero();
};

/// The component along a direction that turns with m. `turned`: derivative of the direction by m.
PinComponent componentAlong(const Eigen::Vector2d& d, const Eigen::Vector2d& direction,
                            const Eigen::Vector2d& turned, const Eigen::Vector2d& armA,
                            const Eigen::Vector2d& armB) {
  const auto slopeAlong = [&](const Eigen::Vector2d& along) {
    Vector6 slope;
    slope << -along, crossZ(along, armA), along, crossZ(armB, along);
    return slope;
  };
  Vector6 mean = Vector6::Zero();
  mean[2] = mean[5] = 0.5;
  PinComponent found{direction.dot(d), slopeAlong(direction) + turned.dot(d) * mean};
  const Matrix6 mixed = slopeAlong(turned) * mean.transpose();
  found.bend = mixed + mixed.transpose() - found.value * mean * mean.transpose();
  found.bend(2, 2) += direction.dot(armA);
  found.bend(5, 5) -= direction.dot(armB);
  return found;
}

void addPinSpring(double stiffness, const PinComponent& of, PlanarEnergy& sum) {
  sum.energy += 0.5 * stiffness * of.value * of.value;
  sum.gradient += stiffness * of.value * of.slope;
  sum.hessian += stiffness * (of.slope * of.slope.transpose() + of.value * of.bend);
}

PlanarEnergy pinEnergy(const Ligament& pin, const Vector3& between, const Vector3& armA,
                       const Vector3& armB, double turnA, double turnB) {
  const Eigen::Vector2d d = (between + armB - armA).head<2>();
  const Vector3 across = rotationFromVector(Vector3(0, 0, 0.5 * (turnA + turnB))) * pin.across;
  const Eigen::Vector2d n = across.head<2>(), t(-n.y(), n.x());
  PlanarEnergy sum;
  addPinSpring(pin.stretchStiffness, componentAlong(d, n, t, armA.head<2>(), armB.head<2>()), sum);
  addPinSpring(pin.shearStiffness, componentAlong(d, t, -n, armA.head<2>(), armB.head<2>()), sum);
  const double a = turnB - turnA;
  const auto [square, cube] = pin.opening;
  Vector6 turning = Vector6::Zero();
  turning[2] = -1;
  turning[5] = 1;
  // The moment square a^2 + cube a^3, integrated over a.
  sum.energy += a * a * a * (square / 3 + cube * a / 4);
  sum.gradient += a * a * (square + cube * a) * turning;
  sum.hessian += a * (2 * square + 3 * cube * a) * turning * turning.transpose();
  return sum;
}

}  // namespace

void setNeckStiffness(double youngs, double poisson, double thickness, double width, double length,
                      Ligament& ligament) {
  // S. P. Timoshenko's shear coefficient of a rectangle, the common approximation.
  constexpr double kShearFactor = 5.0 / 6;
  const double area = width * thickness;
  const double bending = youngs * thickness * width * width * width / 12;
  const double shearing = kShearFactor * youngs / (2 * (1 + poisson)) * area;
  ligament.stretchStiffness = youngs * area / length;
  ligament.shearStiffness = 1 / (length / (12 * bending) + 1 / (shearing * length));
}

PlanarEnergy ligamentEnergy(const Ligament& ligament, const Vector3& between, const Vector3& armA,
                            const Vector3& armB, double turnA, double turnB) {
  if (ligament.isPin()) return pinEnergy(ligament, between, armA, armB, turnA, turnB);
  const Eigen::Vector2d l = (between + armB - armA).head<2>();
  const Eigen::Vector2d l0 = ligament.start.head<2>();
  // The ligament's current length and direction, and the direction across it.
  const double length = l.norm();
  const Eigen::Vector2d n = l / length, t(-n.y(), n.x());
  const double stretch = length - l0.norm();
  const double turn = std::atan2(crossZ(l0, l), l0.dot(l));
  const double shear = std::remainder(turn - 0.5 * (turnA + turnB), 2 * std::numbers::pi);

  // d|l| = n . dl, and the angle of l changes by t . dl / |l|.
  const Row2 slope = slopeOf(armA, armB);
  const Vector6 ofStretch = slope.transpose() * n;
  Vector6 ofShear = slope.transpose() * t / length;
  ofShear[2] -= 0.5;
  ofShear[5] -= 0.5;
  const Vector6 across = slope.transpose() * t;
  // The second derivative of |l| by l, plus n . d2l, and that of the angle, plus t . d2l / |l|:
  //   t t^T / |l|,    -(n t^T + t n^T) / |l|^2
  const Matrix6 stretchBend = across * across.transpose() / length + bendOf(armA, armB, n);
  const Matrix6 mixed = ofStretch * across.transpose();
  const Matrix6 shearBend =
      -(mixed + mixed.transpose()) / (length * length) + bendOf(armA, armB, t) / length;

  const double kl = ligament.stretchStiffness, ks = ligament.shearStiffness;
  return {0.5 * kl * stretch * stretch + 0.5 * ks * shear * shear,
          kl * stretch * ofStretch + ks * shear * ofShear,
          kl * (ofStretch * ofStretch.transpose() + stretch * stretchBend) +
              ks * (ofShear * ofShear.transpose() + shear * shearBend)};
}

namespace {

/// The turns of both bricks about the normal since the start. Quaternions give each up to two full
/// turns. B's turn is therefore chosen near A's.
std::array<double, 2> turnsOf(const Ligament& ligament, const Poses& poses) {
  const auto turnOf = [&](int brick) {
    const Quaternion& rotation = poses[static_cast<std::size_t>(brick)].rotation;
    return 2 * std::atan2(rotation.vec().dot(ligament.normal), rotation.w());
  };
  const double turnA = turnOf(ligament.brickA), turnB = turnOf(ligament.brickB);
  return {turnA, turnA + std::remainder(turnB - turnA, 4 * kPi)};
}

Matrix3 axesOf(const Ligament& ligament) {
  return model::frameAlong(ligament.normal, Vector3::Zero()).axes();
}

/// The energy with the arms and the vector between the centres in world axes.
PlanarEnergy energyInWorld(Ligament ligament, const Vector3& between, const Vector3& armA,
                           const Vector3& armB, const std::array<double, 2>& turns) {
  const Matrix3 toPlane = axesOf(ligament).transpose();
  ligament.start = toPlane * ligament.start;
  ligament.across = toPlane * ligament.across;
  return ligamentEnergy(ligament, toPlane * between, toPlane * armA, toPlane * armB, turns[0],
                        turns[1]);
}

}  // namespace

PlanarEnergy ligamentEnergy(const Ligament& ligament, const Poses& poses) {
  const Pose& a = poses[static_cast<std::size_t>(ligament.brickA)];
  const Pose& b = poses[static_cast<std::size_t>(ligament.brickB)];
  return energyInWorld(ligament, b.position - a.position, a.rotation * ligament.pointA,
                       b.rotation * ligament.pointB, turnsOf(ligament, poses));
}

double elasticEnergy(std::span<const Ligament> ligaments, const Poses& poses) {
  double sum = 0;
  for (const Ligament& ligament : ligaments) sum += ligamentEnergy(ligament, poses).energy;
  return sum;
}

namespace {

constexpr const char* kAcross = "across";

constexpr std::array kLigamentFields = {
    PairField<Ligament>{"point_a", "m", 3, [](Ligament& l) { return l.pointA.data(); }},
    PairField<Ligament>{"point_b", "m", 3, [](Ligament& l) { return l.pointB.data(); }},
    PairField<Ligament>{"start", "m", 3, [](Ligament& l) { return l.start.data(); }},
    PairField<Ligament>{kAcross, "1", 3, [](Ligament& l) { return l.across.data(); }},
    PairField<Ligament>{"stretch", "N/m", 1, [](Ligament& l) { return &l.stretchStiffness; }},
    PairField<Ligament>{"shear", "N m/rad, of pins N/m", 1,
                        [](Ligament& l) { return &l.shearStiffness; }},
    PairField<Ligament>{"opening_2", "N m/rad^2", 1, [](Ligament& l) { return &l.opening[0]; }},
    PairField<Ligament>{"opening_3", "N m/rad^3", 1, [](Ligament& l) { return &l.opening[1]; }}};

/// Reads the model's joint that each ligament replaces.
void readJoints(const PairReader& file, std::vector<Ligament>& ligaments) {
  const std::vector<int> numbers = file.wholeNumbers("joint");
  const bool areThere = std::ranges::all_of(numbers, [&](int number) {
    return number >= 0 && static_cast<std::size_t>(number) < file.joints();
  });
  if (numbers.size() != ligaments.size() || !areThere) {
    file.refuse("ligaments/joint does not name a joint of the model for each ligament");
  }
  for (std::size_t k = 0; k < ligaments.size(); ++k) ligaments[k].joint = numbers[k];
}

}  // namespace

std::shared_ptr<const PairForce> Ligaments::read(const PairReader& file) {
  std::vector<Ligament> ligaments;
  for (const auto& [brickA, brickB] : file.bricks()) ligaments.push_back({brickA, brickB});
  readJoints(file, ligaments);
  readFields(file, kLigamentFields, ligaments);
  for (Ligament& ligament : ligaments) ligament.normal = file.normal();
  for (std::size_t k = 0; k < ligaments.size(); ++k) {
    if (std::abs(ligaments[k].across.norm() - 1) <= kUnitTolerance) continue;
    file.refuse(fmt::format("the direction of ligament {} in ligaments/{} is not a unit vector", k,
                            kAcross));
  }
  return std::make_shared<Ligaments>(std::move(ligaments));
}

std::pair<int, int> Ligaments::bricks(std::size_t pair) const {
  return {ligaments_[pair].brickA, ligaments_[pair].brickB};
}

double Ligaments::energy(std::size_t pair, const Poses& poses) const {
  return ligamentEnergy(ligaments_[pair], poses).energy;
}

PairEnergy Ligaments::derivatives(std::size_t pair, const Poses& poses) const {
  PairEnergy found = inSpace(ligamentEnergy(ligaments_[pair], poses));
  if (ligaments_[pair].normal == Vector3::UnitZ()) return found;
  Matrix12 axes = Matrix12::Zero();
  for (int k = 0; k < 12; k += 3) axes.block<3, 3>(k, k) = axesOf(ligaments_[pair]);
  found.gradient = axes * found.gradient;
  found.hessian = axes * found.hessian * axes.transpose();
  return found;
}

std::vector<PairColumn> Ligaments::columns() const {
  std::vector<PairColumn> columns = columnsOf(ligaments_, kLigamentFields);
  PairColumn joints{"joint", "", 1, {}, true};
  for (const Ligament& ligament : ligaments_) joints.numbers.push_back(ligament.joint);
  columns.insert(columns.begin(), std::move(joints));
  return columns;
}

const std::vector<Ligament>& ligamentsOf(const PairForces& forces) {
  static const std::vector<Ligament> none;
  for (const std::shared_ptr<const PairForce>& force : forces) {
    if (force->ligaments()) return *force->ligaments();
  }
  return none;
}

// ------------------------------------------------------------------------------------------------
// Springs and ligaments together.

namespace {

/// A ligament's moment on a brick about its own end, N m about its normal. With the ends as
/// centres, the energy depends on the turns without lever arms.
double endMoment(const Ligament& ligament, int brick, const Poses& poses) {
  const Vector3 between = poses[static_cast<std::size_t>(ligament.brickB)].apply(ligament.pointB) -
                          poses[static_cast<std::size_t>(ligament.brickA)].apply(ligament.pointA);
  const Vector6 slope =
      energyInWorld(ligament, between, Vector3::Zero(), Vector3::Zero(), turnsOf(ligament, poses))
          .gradient;
  return brick == ligament.brickA ? -slope[2] : -slope[5];
}

}  // namespace

std::vector<EndMoments> endMoments(const PairForces& forces, const Poses& poses) {
  std::map<std::pair<int, int>, const Ligament*> byBricks;
  for (const Ligament& one : ligamentsOf(forces)) {
    byBricks[std::minmax(one.brickA, one.brickB)] = &one;
  }
  std::vector<EndMoments> moments;
  for (const HingeSpring& spring : hingeSpringsOf(forces)) {
    const Hinge& hinge = spring.hinge;
    const double own = hingeMoments({&spring, 1}, poses).front();
    EndMoments& both = moments.emplace_back(EndMoments{hinge.brickA, hinge.brickB, -own, own});
    const auto found = byBricks.find(std::minmax(hinge.brickA, hinge.brickB));
    if (found == byBricks.end()) continue;
    // In the plane the hinge's axis is the normal or its opposite at every pose.
    const double sign = hinge.axis.dot(found->second->normal);
    both.onA += sign * endMoment(*found->second, hinge.brickA, poses);
    both.onB += sign * endMoment(*found->second, hinge.brickB, poses);
  }
  return moments;
}

int Elasticity::count(const std::string& name) const {
  const auto found = std::ranges::find(counts, name, &std::pair<std::string, int>::first);
  return found == counts.end() ? 0 : found->second;
}

Elasticity elasticityOf(const PairForces& forces, const Poses& start, const Poses& end) {
  Elasticity found{{}, forces.energy(start), forces.energy(end)};
  for (const std::shared_ptr<const PairForce>& force : forces) {
    found.counts.emplace_back(force->name().counted, static_cast<int>(force->size()));
  }
  for (const EndMoments& moments : endMoments(forces, end)) {
    found.momentEnd = std::max({found.momentEnd, std::abs(moments.onA), std::abs(moments.onB)});
  }
  return found;
}

}  // namespace kirireel::brick
