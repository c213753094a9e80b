#include "sim/run/mechanism_path.h"

#include <cmath>

namespace kirireel::run {
namespace {

Vector3 commonCentre(const Poses& poses) {
  Vector3 sum = Vector3::Zero();
  for (const Pose& pose : poses) sum += pose.position;
  return sum / static_cast<double>(poses.size());
}

}  // namespace

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
  const Vector3 centre = commonCentre(poses);
  if (!dynamics.assemble(poses)) return false;
  const Vector3 drift = commonCentre(poses) - centre;
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

std::vector<double> pathLengths(const std::vector<brick::Brick>& bricks,
                                const std::vector<Poses>& states) {
  std::vector<double> lengths = {0};
  for (std::size_t k = 1; k < states.size(); ++k) {
    lengths.push_back(lengths.back() + pathDistance(bricks, states[k - 1], states[k]));
  }
  return lengths;
}

}  // namespace kirireel::run
