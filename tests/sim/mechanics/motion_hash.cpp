/// Prints a hash of two sheets' motions, for a test that compares processes with different
/// environments.
#include <bit>
#include <cstdint>
#include <cstdio>

#include "tests/sim/mechanics/joined_bricks.h"

namespace {

using namespace kirireel;

std::uint64_t hashOf(const Motion& motion, std::uint64_t hash) {
  const auto add = [&](double value) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211U;  // FNV-1a by words
  };
  for (std::size_t i = 0; i < motion.poses.size(); ++i) {
    for (int k = 0; k < 3; ++k) add(motion.poses[i].position[k]);
    for (int k = 0; k < 4; ++k) add(motion.poses[i].rotation.coeffs()[k]);
    for (int k = 0; k < 3; ++k) add(motion.velocities[i].linear[k]);
    for (int k = 0; k < 3; ++k) add(motion.velocities[i].angular[k]);
  }
  return hash;
}

Motion motionOf(bool planar) {
  test::JoinedBricks sheet(test::openSheet(8, 0));
  test::Numbers numbers(5);
  for (Velocity& velocity : sheet.motion.velocities) velocity.linear = 1e-6 * numbers.vector();
  const run::TargetSprings springs(sheet.bricks, *sheet.model.target, {}, {});
  const auto solver = sheet.solver(planar);
  const mechanics::LoadSource loads = test::springLoads(sheet, springs, {});
  for (int step = 0; step < 60; ++step) solver->advance(sheet.motion, 1.0 / 240, loads, nullptr);
  return sheet.motion;
}

}  // namespace

int main() {
  std::uint64_t hash = 14695981039346656037U;
  for (const bool planar : {true, false}) hash = hashOf(motionOf(planar), hash);
  std::printf("%016llx\n", static_cast<unsigned long long>(hash));
}
