#include "sim/deploy/nudge.h"

#include <random>

namespace kirireel {
namespace {

constexpr double kSpeed = 1e-6;  // model sizes a second

/// Uniform in [-1, 1) with the same bits from every standard library.
double uniform(std::mt19937& generator) {
  return static_cast<double>(generator()) / 2147483648.0 - 1.0;
}

}  // namespace

std::vector<Velocity> nudge(std::size_t count, double modelSize, unsigned seed) {
  std::mt19937 generator(seed);
  const double speed = kSpeed * modelSize;
  std::vector<Velocity> velocities(count);
  for (Velocity& velocity : velocities) {
    const double x = uniform(generator);
    const double y = uniform(generator);
    const double z = uniform(generator);
    velocity.linear = speed * Vector3(x, y, z);
  }
  return velocities;
}

}  // namespace kirireel
