#include "sim/run/mechanism_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kirireel::run {
namespace {

constexpr int kSettlingMoves = 4;  // maximum in settle()

}  // namespace

Poses MechanismPath::at(double share) const {
  if (states.size() == 1) return states.front();
  const double place = share * length();
  const auto last = static_cast<std::ptrdiff_t>(states.size()) - 1;
  const auto end = lengths.begin() + last;
  const auto next =
      static_cast<std::size_t>(std::lower_bound(lengths.begin() + 1, end, place) - lengths.begin());
  const double part = lengths[next] - lengths[next - 1];
  return interpolate(states[next - 1], states[next],
                     part > 0 ? std::clamp((place - lengths[next - 1]) / part, 0.0, 1.0) : 1);
}

double gyrationRadius(const brick::Brick& brick) {
  double sum = 0;
  for (const Vector3& point : brick.bottom) sum += point.squaredNorm();
  return std::sqrt(sum / static_cast<double>(brick.bottom.size()));
}

trajectory::PenetrationMeter overlapMeter(const scene::Environment& environment,
                                          const std::vector<brick::Brick>& bricks,
                                          std::span<const brick::Pivot> pivots,
                                          const Poses& start) {
  const bool countsJoined = environment.contacts != scene::ContactFilter::Unjoined;
  return {bricks, pivots, environment.pivotZone, start, 0, countsJoined};
}

bool closeInPlace(Poses& poses, Dynamics& dynamics) {
  const Vector3 centre = meanPosition(poses);
  if (!dynamics.assemble(poses)) return false;
  const Vector3 drift = meanPosition(poses) - centre;
  for (Pose& pose : poses) pose.position -= drift;
  return true;
}

double pathDistance(const std::vector<brick::Brick>& bricks, const Poses& from, const Poses& to,
                    double turnWeight) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const double radius = gyrationRadius(bricks[i]);
    sum +=
        (to[i].position - from[i].position).squaredNorm() +
        turnWeight * radius * radius * turnBetween(from[i].rotation, to[i].rotation).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(bricks.size()));
}

Eigen::VectorXd displacement(const std::vector<brick::Brick>& bricks, const Poses& from,
                             const Poses& to) {
  Eigen::VectorXd found(6 * from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    found.segment<3>(6 * i) = to[i].position - from[i].position;
    found.segment<3>(6 * i + 3) =
        gyrationRadius(bricks[i]) * turnBetween(from[i].rotation, to[i].rotation);
  }
  return found;
}

Poses polynomialAt(double place, std::span<const double> nodes, std::span<const Poses> states,
                   const Poses& origin) {
  Poses poses = origin;
  std::vector<Vector3> turns(poses.size(), Vector3::Zero());
  for (std::size_t k = 0; k < states.size(); ++k) {
    double weight = 1;
    for (std::size_t m = 0; m < states.size(); ++m) {
      if (m != k) weight *= (place - nodes[m]) / (nodes[k] - nodes[m]);
    }
    for (std::size_t i = 0; i < poses.size(); ++i) {
      poses[i].position += weight * (states[k][i].position - origin[i].position);
      turns[i] += weight * turnBetween(origin[i].rotation, states[k][i].rotation);
    }
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].rotation = (rotationFromVector(turns[i]) * poses[i].rotation).normalized();
  }
  return poses;
}

std::vector<brick::Brick> metricBricks(const scene::Scene& scene, double turnWeight) {
  std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  for (brick::Brick& brick : bricks) {
    const double radius = gyrationRadius(brick);
    brick.mass = 1;
    brick.inertia = turnWeight * radius * radius * Matrix3::Identity();
  }
  return bricks;
}

void withoutForces(const Poses& /*poses*/, std::vector<brick::Load>& loads) {
  std::ranges::fill(loads, brick::Load{});
}

double settle(const std::vector<brick::Brick>& bricks, double least, Dynamics& dynamics,
              Poses& poses) {
  double work = 0;
  for (int i = 0; i < kSettlingMoves; ++i) {
    Motion motion{poses, std::vector<Velocity>(poses.size())};
    work += dynamics.advance(motion, 1, withoutForces).work;
    const double moved = pathDistance(bricks, poses, motion.poses);
    poses = std::move(motion.poses);
    if (moved <= least) break;
  }
  return work;
}

std::vector<double> pathLengths(const std::vector<brick::Brick>& bricks,
                                const std::vector<Poses>& states) {
  std::vector<double> lengths = {0};
  for (std::size_t k = 1; k < states.size(); ++k) {
    lengths.push_back(lengths.back() + pathDistance(bricks, states[k - 1], states[k]));
  }
  return lengths;
}

}  // namespace kirireel::run
