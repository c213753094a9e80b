// The forces that drive bricks. Each section has one force and its equations.
#include "sim/run/forces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "sim/base/error.h"
#include "sim/model/convex_parts.h"
#include "sim/model/isometry.h"
#include "sim/model/model.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// The springs of a brick of mass m (kg) and inertia I (kg m^2) with n vertices. On n springs of k_f
// (N/m), a free brick obeys m x" + mu_v x' + n k_f x = 0. Its undamped frequency is f (Hz) and its
// damping ratio zeta if
//   k_f = m (2 pi f)^2 / n,      mu_v = 2 zeta sqrt(n k_f / m) m.
// k_tau = k_f, as for a spring at each vertex: a square then rotates at sqrt(3) times the frequency
// of its translation. Rotations are damped at the same rate,
//   mu_omega = 2 zeta sqrt(n k_tau / m) I,
// a matrix, because the inertia differs between the axes of a brick. The motion does
// not change if m and I are scaled by one factor, or I by the square of a length. A value given in
// N/m replaces its own term. Catto's Box2D (v3) uses the same parameters for its springs.

namespace {

// Weight of rotations over positions while tiles are guided.
constexpr double kTurnShare = 40;
// Frequency of guide springs over the scene's. They are twice as stiff.
constexpr double kGuideFrequency = std::numbers::sqrt2;

double squaredFrequency(const scene::TargetSpringSettings& settings) {
  const double omega = 2 * std::numbers::pi * settings.frequency;
  return omega * omega;  // 1/s^2
}

std::vector<BrickSpring> springsOf(const std::vector<brick::Brick>& bricks,
                                   const scene::TargetSpringSettings& settings) {
  std::vector<BrickSpring> springs;
  for (const brick::Brick& brick : bricks) springs.push_back(springOf(brick, settings));
  return springs;
}

/// Adds the brick's damping, in world axes.
void addDamping(const BrickSpring& spring, const Matrix3& R, brick::Load& load) {
  load.damping.diagonal().head<3>().array() += spring.forceDamping;
  load.damping.bottomRightCorner<3, 3>() += R * spring.torqueDamping * R.transpose();
}

}  // namespace

BrickSpring springOf(const brick::Brick& brick, const scene::TargetSpringSettings& settings) {
  const auto n = static_cast<double>(brick.bottom.size());
  const auto rate = [&](double stiffness) {
    return 2 * settings.dampingRatio * std::sqrt(n * stiffness / brick.mass);  // 1/s
  };
  const double stiffness = brick.mass * squaredFrequency(settings) / n;
  BrickSpring spring;
  spring.springStiffness = settings.springStiffness.value_or(stiffness);
  spring.torqueStiffness = settings.torqueStiffness.value_or(settings.turnShare * stiffness);
  spring.forceDamping = settings.forceDamping.value_or(rate(spring.springStiffness) * brick.mass);
  if (settings.torqueDamping) {
    spring.torqueDamping = *settings.torqueDamping * Matrix3::Identity();
  } else {
    spring.torqueDamping = rate(spring.torqueStiffness) * brick.inertia;
  }
  return spring;
}

double placeStiffness(const scene::TargetSpringSettings& settings,
                      const std::vector<brick::Brick>& bricks) {
  double mass = 0;
  for (const brick::Brick& brick : bricks) mass += brick.mass;
  return mass / static_cast<double>(bricks.size()) * squaredFrequency(settings);
}

// Damping is always critical: tiles must follow without oscillation.
scene::TargetSpringSettings guideSprings(const scene::Scene& scene) {
  scene::TargetSpringSettings springs;
  springs.frequency = kGuideFrequency * scene.springs.frequency;
  springs.dampingRatio = 1;
  springs.turnShare = kTurnShare;
  springs.adaptive = false;
  return springs;
}

double jointStiffnessOf(const scene::Scene& scene, const std::vector<brick::Brick>& bricks) {
  const bool isGuided = scene.path.kind == scene::PathKind::Guided;
  return scene.path.jointRatio *
         placeStiffness(isGuided ? guideSprings(scene) : scene.springs, bricks);
}

// ------------------------------------------------------------------------------------------------
// Springs from the hull's corners to an ellipse. m is the centre of the hull's corners; a (along x)
// and b (along y) are the half axes. The ray from m through a corner intersects the ellipse at
//   m + (x, y) / sqrt((x / a)^2 + (y / b)^2),      (x, y) = corner - m
// This point is the corner's anchor, at the corner's own height above the sheet's plane. b is the
// requested size times the radius of the smallest circle about m that holds all corners. a is b
// times the aspect. Anchors are fixed: the sheet grows towards them. Corners of several tiles at
// one position of the convex outline, joined or not, share its spring: the order of the tiles does
// not matter.

namespace {

/// Intersection of an ellipse with the ray from its centre through a point. Keeps the point's
/// height.
Vector3 ellipsePoint(const Vector3& middle, double halfLength, double halfWidth,
                     const Vector3& point) {
  const double x = point.x() - middle.x();
  const double y = point.y() - middle.y();
  const double reach = std::hypot(x / halfLength, y / halfWidth);
  if (!(reach > 0)) {
    throw InputError(
        "error: a corner of the hull is at the centre of the outline, so the direction of its pull "
        "is not defined. Remove it from the hull");
  }
  const double scale = 1 / reach;
  return {middle.x() + scale * x, middle.y() + scale * y, point.z()};
}

/// All corners within this distance of the position, as seen from above.
std::vector<model::Corner> cornersAt(const std::vector<model::Tile>& tiles, const Vector3& place,
                                     double same) {
  std::vector<model::Corner> found;
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    const std::vector<Vector3>& vertices = tiles[tile].vertices;
    for (std::size_t vertex = 0; vertex < vertices.size(); ++vertex) {
      if ((vertices[vertex] - place).head<2>().norm() > same) continue;
      found.push_back({static_cast<int>(tile), static_cast<int>(vertex)});
    }
  }
  return found;
}

}  // namespace

BoundarySprings::BoundarySprings(const model::Model& model, const std::vector<brick::Brick>& bricks,
                                 const scene::TargetSpringSettings& settings,
                                 const scene::BoundaryCurve& curve)
    : strengths_(springsOf(bricks, settings)), springs_(bricks.size()) {
  // The model names a hull that could not be read. Only this drive needs a hull, and only it
  // throws.
  if (!model.hullFault.empty()) {
    throw InputError(model.hullFault + ". Or remove the file to pull the convex outline");
  }
  const model::SheetFrame frame = model::viewFrame(model);
  const std::vector<model::Tile> seen = model::toFrame(frame, model.tiles);
  const std::vector<model::Corner> hull = model.hull ? *model.hull : model::outlineCorners(seen);
  std::vector<Vector3> corners;
  for (const model::Corner& corner : hull) {
    corners.push_back(seen[corner.tile].vertices[corner.vertex]);
  }
  const Vector3 middle = meanPoint(corners);
  double radius = 0;
  for (const Vector3& corner : corners) {
    radius = std::max(radius, (corner - middle).head<2>().norm());
  }
  const double halfWidth = curve.size * radius;
  const double same = std::max(model::flatTolerance(model), 2 * model.rounding);
  for (std::size_t k = 0; k < hull.size(); ++k) {
    anchors_.push_back(
        frame.toWorld(ellipsePoint(middle, curve.aspect * halfWidth, halfWidth, corners[k])));
    const std::vector<model::Corner> pulled =
        model.hull ? std::vector{hull[k]} : cornersAt(seen, corners[k], same);
    for (const model::Corner& corner : pulled) {
      // Corners above each other are pulled at their own heights.
      const double rise = seen[corner.tile].vertices[corner.vertex].z() - corners[k].z();
      const double stiffness = strengths_[corner.tile].springStiffness;
      springs_[corner.tile].push_back({bricks[corner.tile].bottom[corner.vertex],
                                       anchors_.back() + rise * frame.normal,
                                       stiffness / static_cast<double>(pulled.size()), 0});
    }
  }
}

void BoundarySprings::addLoads(const Poses& poses, std::vector<brick::Load>& loads) const {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    // Damping applies to every brick, even without a spring.
    addDamping(strengths_[i], poses[i].rotation.toRotationMatrix(), loads[i]);
    for (const PointSpring& spring : springs_[i]) addPointSpring(spring, poses[i], loads[i]);
  }
}

double BoundarySprings::energy(const Poses& poses) const {
  double sum = 0;
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    for (const PointSpring& spring : springs_[i]) sum += pointSpringEnergy(spring, poses[i]);
  }
  return sum;
}

// ------------------------------------------------------------------------------------------------
// Expansion: F = k (x - c) - mu v away from the centre of mass c of its piece (N, with k in N/m).
// Its derivative with respect to x is +k, the opposite sign of a spring's stiffness. An implicit
// step would need an indefinite matrix. The push is therefore explicit, and only its damping is
// implicit. If all masses are equal, the pushes have no resultant.

// A uniform expansion needs an acceleration that depends only on the distance, not on the tiles'
// masses and vertex counts. k is therefore m (2 pi f)^2 / 4 if a frequency is given.

Expansion::Expansion(const std::vector<brick::Brick>& bricks, std::vector<int> pieces,
                     const scene::TargetSpringSettings& settings)
    : bricks_(bricks), pieces_(std::move(pieces)), strengths_(springsOf(bricks, settings)) {
  if (settings.springStiffness) return;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    strengths_[i].springStiffness = bricks[i].mass * squaredFrequency(settings) / 4;
  }
}

void Expansion::addLoads(const Poses& poses, std::vector<brick::Load>& loads) const {
  const std::vector<Vector3> centres = centresOf(poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    loads[i].force.head<3>() +=
        strengths_[i].springStiffness * (poses[i].position - centres[pieces_[i]]);
    addDamping(strengths_[i], poses[i].rotation.toRotationMatrix(), loads[i]);
  }
}

void Expansion::addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const {
  const std::vector<Vector3> centres = centresOf(poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    forces[i] += strengths_[i].springStiffness * (poses[i].position - centres[pieces_[i]]);
  }
}

/// The centre of mass of each piece, metres.
std::vector<Vector3> Expansion::centresOf(const Poses& poses) const {
  const std::size_t count = 1 + *std::ranges::max_element(pieces_);
  std::vector<Vector3> sums(count, Vector3::Zero());
  std::vector<double> masses(count);
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    sums[pieces_[i]] += bricks_[i].mass * poses[i].position;
    masses[pieces_[i]] += bricks_[i].mass;
  }
  for (std::size_t k = 0; k < count; ++k) sums[k] /= masses[k];
  return sums;
}

// ------------------------------------------------------------------------------------------------
// A spring between a point r of a brick (brick axes) and an anchor a. With the arm s = R r, the
// force is f = k (a - x - s) and the torque s x f. A small displacement dq = (dx, dtheta) moves
// the point by G dq = dx - s x dtheta, G = [1, -[s]x]. The Gauss-Newton part k G^T G of the
// stiffness is positive semidefinite. So is the damping c G^T G, which acts on the point's
// velocity.

void addPointSpring(const PointSpring& spring, const Pose& pose, brick::Load& load) {
  const Vector3 arm = pose.rotation * spring.point;
  const Vector3 force = spring.stiffness * (spring.anchor - pose.position - arm);
  load.force.head<3>() += force;
  load.force.tail<3>() += arm.cross(force);
  // The point moves by G (dx, dtheta). The change of torque by the arm's rotation is neglected,
  // because it may be indefinite.
  Eigen::Matrix<double, 3, 6> G;
  G << Matrix3::Identity(), -crossMatrix(arm);
  const Matrix6 outer = G.transpose() * G;
  load.stiffness += spring.stiffness * outer;
  load.damping += spring.damping * outer;
}

double pointSpringEnergy(const PointSpring& spring, const Pose& pose) {
  return 0.5 * spring.stiffness * (spring.anchor - pose.apply(spring.point)).squaredNorm();
}

// ------------------------------------------------------------------------------------------------
// Gravity m g at the centre of mass, and viscous damping. A velocity that loses the fraction p per
// second obeys v(t) = v(0) (1 - p)^t, thus dv/dt = -c v with c = -ln(1 - p) (1/s). The force is -c
// m v and the torque -c I w, with the inertia I in world axes. Damping enters the implicit step as
// a matrix, which sets no limit on the step length.

void addEnvironmentLoads(const scene::Environment& environment,
                         std::span<const brick::Brick> bricks, const Poses& poses,
                         std::vector<brick::Load>& loads) {
  // exp(-rate) is the fraction of the velocity that remains after one second.
  const double linearRate = -std::log1p(-environment.linearDamping);
  const double angularRate = -std::log1p(-environment.angularDamping);
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const brick::Brick& brick = bricks[i];
    brick::Load& load = loads[i];
    load.force.head<3>() += brick.mass * environment.gravity;
    load.damping.topLeftCorner<3, 3>().diagonal().array() += linearRate * brick.mass;
    if (angularRate == 0) continue;
    // The inertia in world axes: R I R^T.
    const Matrix3 R = poses[i].rotation.toRotationMatrix();
    load.damping.bottomRightCorner<3, 3>() += angularRate * R * brick.inertia * R.transpose();
  }
}

// ------------------------------------------------------------------------------------------------
// Springs to a target, with the derivatives for an implicit step.
//
// p_k are the bottom vertices and t_k their targets in world axes, n the number of vertices. Primes
// are differences from the means. s is the arm from the centre of mass x to the mean of the p_k,
// and g = mean t - x - s:
//   F = k_f n g                                          N
//   T = k_tau sum p'_k x t'_k + s x F                    N m about x
// Both follow from the energy E = k_f n |g|^2 / 2 + k_tau / 2 sum |p'_k - t'_k|^2. A rotation
// dtheta moves p'_k by dtheta x p'_k. The second derivative of -sum p'_k . t'_k by dtheta is tr(C)
// 1 - (C + C^T) / 2 with C = sum p'_k t'_k^T. The force F on the arm s contributes the same term
// with C = k_f n s g^T. The stiffness in (dx, dtheta) is then
//   [ k_f n 1        -k_f n [s]x                      ]
//   [ k_f n [s]x      k_f n [s]x^T [s]x + tr(C) 1 - sym(C) ]
// The last term becomes indefinite if a tile is rotated by more than 90 degrees from its target.
// Only its positive semidefinite part is used (negative eigenvalues are set to 0). No step length
// diverges with it. The force itself is exact.
//
// Jiang and Choi's PyKirigami holds the same forces constant during a step, which requires many
// short steps when k is large.

namespace {

// The paper's 60 steps of 1/240 s as a time: the step length does not matter.
constexpr double kStallTime = 60.0 / 240.0;  // seconds without improvement
constexpr double kSameTime = 1e-9;           // seconds; times closer than this are equal
constexpr double kLargestFactor = 16;        // of the stiffness
constexpr double kLowerError = 1 - 0.005;    // factor on the error that counts as an improvement

bool isPositiveDefinite(const Matrix3& K) {
  // Sylvester's criterion: the leading minors are positive. Most steps then need no eigenvalues.
  return K(0, 0) > 0 && K(0, 0) * K(1, 1) - K(0, 1) * K(0, 1) > 0 && K.determinant() > 0;
}

/// The nearest positive semidefinite matrix. It removes directions in which an implicit step would
/// move away from a distant target.
Matrix3 positivePart(const Matrix3& K) {
  if (isPositiveDefinite(K)) return K;
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(K);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
         solver.eigenvectors().transpose();
}

/// Minus the second derivative of sum_k p_k . t_k with respect to a rotation of the p_k:
/// tr(C) 1 - sym(C) for C = sum_k p_k t_k^T.
Matrix3 rotationalStiffness(const Matrix3& C) {
  return C.trace() * Matrix3::Identity() - 0.5 * (C + C.transpose());
}

/// sum_k p_k x t_k for C = sum_k p_k t_k^T.
Vector3 crossSum(const Matrix3& C) {
  return {C(1, 2) - C(2, 1), C(2, 0) - C(0, 2), C(0, 1) - C(1, 0)};
}

}  // namespace

TargetSprings::TargetSprings(const std::vector<brick::Brick>& bricks,
                             const std::vector<model::Tile>& target,
                             const std::optional<std::vector<int>>& pulled,
                             const scene::TargetSpringSettings& settings)
    : bricks_(bricks), springs_(bricks.size()) {
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    springs_[i].strength = springOf(bricks[i], settings);
  }
  setTarget(target);
  if (!pulled) return;
  for (Spring& spring : springs_) spring.pulled = false;
  for (const int brick : *pulled) springs_[brick].pulled = true;
}

void TargetSprings::setTarget(const std::vector<model::Tile>& target) {
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    const std::vector<Vector3>& bottom = bricks_[i].bottom;
    Spring& spring = springs_[i];
    spring.vertexCount = static_cast<int>(bottom.size());
    spring.bottomMean = meanPoint(bottom);
    spring.targetMean = meanPoint(target[i].vertices);
    spring.moment.setZero();
    spring.spread = 0;
    for (std::size_t k = 0; k < bottom.size(); ++k) {
      const Vector3 p = bottom[k] - spring.bottomMean;
      const Vector3 t = target[i].vertices[k] - spring.targetMean;
      // The sum over the vertices is precomputed: each step needs only one product with the
      // rotation to get C.
      spring.moment += p * t.transpose();
      spring.spread += p.squaredNorm() + t.squaredNorm();
    }
  }
}

brick::Load TargetSprings::load(int brick, const Pose& pose, double stiffening) const {
  brick::Load load;
  addLoad(springs_[brick], pose, stiffening, load);
  return load;
}

void TargetSprings::addLoads(const Poses& poses, double stiffening,
                             std::vector<brick::Load>& loads) const {
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    addLoad(springs_[i], poses[i], stiffening, loads[i]);
  }
}

void TargetSprings::addLoad(const Spring& spring, const Pose& pose, double stiffening,
                            brick::Load& load) const {
  const Matrix3 R = pose.rotation.toRotationMatrix();
  addDamping(spring.strength, R, load);
  if (!spring.pulled) return;

  // The force at the mean of the bottom acts on the centre of mass through the arm s.
  const double kf = stiffening * spring.strength.springStiffness * spring.vertexCount;
  const double kt = stiffening * spring.strength.torqueStiffness;
  const Vector3 s = R * spring.bottomMean;
  const Vector3 gap = spring.targetMean - pose.position - s;
  const Matrix3 S = crossMatrix(s);

  // The torque springs and the rotating arm have second derivatives of the same form.
  const Matrix3 C = kt * R * spring.moment + kf * s * gap.transpose();
  load.force.head<3>() += kf * gap;
  load.force.tail<3>() += crossSum(C);
  load.stiffness.topLeftCorner<3, 3>().diagonal().array() += kf;
  load.stiffness.topRightCorner<3, 3>() -= kf * S;
  load.stiffness.bottomLeftCorner<3, 3>() += kf * S;
  load.stiffness.bottomRightCorner<3, 3>() +=
      kf * S.transpose() * S + positivePart(rotationalStiffness(C));
}

double TargetSprings::energy(const Poses& poses, double stiffening) const {
  double sum = 0;
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    const Spring& spring = springs_[i];
    if (!spring.pulled) continue;
    const Vector3 gap = spring.targetMean - poses[i].apply(spring.bottomMean);
    // sum |p' - t'|^2 = sum |p'|^2 + |t'|^2 - 2 sum p' . t'.
    const double turned = (poses[i].rotation.toRotationMatrix() * spring.moment).trace();
    sum += 0.5 * spring.strength.springStiffness * spring.vertexCount * gap.squaredNorm() +
           0.5 * spring.strength.torqueStiffness * (spring.spread - 2 * turned);
  }
  return stiffening * sum;
}

// An error e is an improvement on the best error b if e <= 0.995 b. A steadily falling error passes
// b 0.995^k, k = 1, 2, ... The last of these before the step's end becomes the new best. Its time
// follows from linear interpolation of log e within the step.
bool AdaptiveStiffness::observe(double targetError, double time, double step) {
  const double from = time - step;
  const bool isFirst = bestError_ < 0;
  if (isFirst) {
    bestError_ = lastError_ = targetError;
    improvedAt_ = time;
  } else {
    improvedAt_ += from - lastTime_;
  }
  if (targetError > 0 && targetError < kLowerError * bestError_) {
    const double passed = std::floor(std::log(targetError / bestError_) / std::log(kLowerError));
    bestError_ *= std::pow(kLowerError, passed);
    const double share = std::log(bestError_ / targetError) / std::log(lastError_ / targetError);
    improvedAt_ = time - std::clamp(share, 0.0, 1.0) * step;
  }
  lastError_ = targetError;
  lastTime_ = time;
  if (time < nextMoment() - kSameTime) return false;
  stiffen();
  return true;
}

double AdaptiveStiffness::nextMoment() const {
  if (exhausted() || bestError_ < 0) return std::numeric_limits<double>::infinity();
  return improvedAt_ + kStallTime;
}

bool AdaptiveStiffness::exhausted() const {
  return !enabled_ || factor_ >= kLargestFactor;
}

void AdaptiveStiffness::stiffen() {
  improvedAt_ = lastTime_;
  if (!exhausted()) factor_ *= 2;
}

// ------------------------------------------------------------------------------------------------
// Rigid motion of each tile from start to target. Its mean moves straight. Its rotation is exp(s
// theta), with theta the rotation vector of the best fit (isometry.cpp) and s the progress. The
// residual of the fit, in the axes of the start, is added in proportion to s. At s = 1 every vertex
// is exactly at its target.

namespace {

Vector3 rotationVector(const Matrix3& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  // The angle is at most pi. For a rotation by exactly pi there are two such motions, and rounding
  // selects one.
  return turn.angle() * turn.axis();
}

}  // namespace

TargetGuide::TargetGuide(const std::vector<model::Tile>& start,
                         const std::vector<model::Tile>& target) {
  for (std::size_t i = 0; i < start.size(); ++i) {
    const std::vector<Vector3>& from = start[i].vertices;
    const std::vector<Vector3>& to = target[i].vertices;
    const Matrix3 R = model::bestRigidMotion(from, to).rotation;
    GuideMotion tileMotion{meanPoint(from), meanPoint(to), rotationVector(R), {}, {}};
    for (std::size_t k = 0; k < from.size(); ++k) {
      tileMotion.vertices.push_back(from[k] - tileMotion.startMean);
      tileMotion.misfit.push_back(R.transpose() * (to[k] - tileMotion.targetMean) -
                                  tileMotion.vertices.back());
    }
    motions_.push_back(std::move(tileMotion));
  }
}

std::vector<model::Tile> TargetGuide::at(double progress) const {
  std::vector<model::Tile> tiles(motions_.size());
  for (std::size_t i = 0; i < motions_.size(); ++i) {
    const GuideMotion& tileMotion = motions_[i];
    const Quaternion turn = rotationFromVector(progress * tileMotion.turn);
    const Vector3 middle =
        tileMotion.startMean + progress * (tileMotion.targetMean - tileMotion.startMean);
    for (std::size_t k = 0; k < tileMotion.vertices.size(); ++k) {
      tiles[i].vertices.push_back(
          middle + turn * (tileMotion.vertices[k] + progress * tileMotion.misfit[k]));
    }
  }
  return tiles;
}

Poses bestFitPoses(const std::vector<brick::Brick>& bricks,
                   const std::vector<model::Tile>& target) {
  Poses poses(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const model::RigidMotion motion = model::bestRigidMotion(bricks[i].bottom, target[i].vertices);
    poses[i] = {motion.translation, Quaternion(motion.rotation)};
    // The path is unknown. The shorter rotation from the start, at most pi, is assumed.
    if (poses[i].rotation.w() < 0) poses[i].rotation.coeffs() *= -1;
  }
  return poses;
}

}  // namespace kirireel::run
