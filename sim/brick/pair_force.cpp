// Forces between pairs of bricks. A kind of force defines its energy E at poses q. The force on the
// bricks is -dE/dq.
#include "sim/brick/pair_force.h"

namespace kirireel::brick {
namespace {

/// Indices of the coordinates in the plane (x, y, rotation of A, then of B) among the 12 in space.
constexpr std::array kPlanar = {0, 1, 5, 6, 7, 11};

}  // namespace

PlanarEnergy inPlane(const PairEnergy& energy) {
  return {energy.energy, energy.gradient(kPlanar), energy.hessian(kPlanar, kPlanar)};
}

PairEnergy inSpace(const PlanarEnergy& energy) {
  PairEnergy found{energy.energy};
  found.gradient(kPlanar) = energy.gradient;
  found.hessian(kPlanar, kPlanar) = energy.hessian;
  return found;
}

void PairForce::addForces(const Motion& motion, std::vector<Vector6>& forces) const {
  for (std::size_t pair = 0; pair < size(); ++pair) {
    const auto [brickA, brickB] = bricks(pair);
    const Vector12 slope = derivatives(pair, motion.poses).gradient;
    forces[static_cast<std::size_t>(brickA)] -= slope.head<6>();
    forces[static_cast<std::size_t>(brickB)] -= slope.tail<6>();
  }
}

double PairForce::energy(const Poses& poses) const {
  double sum = 0;
  for (std::size_t pair = 0; pair < size(); ++pair) sum += energy(pair, poses);
  return sum;
}

void PairForces::add(std::shared_ptr<const PairForce> force) {
  if (force && force->size() > 0) forces_.push_back(std::move(force));
}

double PairForces::energy(const Poses& poses) const {
  double sum = 0;
  for (const std::shared_ptr<const PairForce>& force : forces_) sum += force->energy(poses);
  return sum;
}

bool PairForces::replaceJoints() const {
  for (const std::shared_ptr<const PairForce>& force : forces_) {
    for (std::size_t pair = 0; pair < force->size(); ++pair) {
      if (force->joint(pair) != PairForce::kNoJoint) return true;
    }
  }
  return false;
}

std::optional<std::pair<int, int>> PairForces::findJump(const Poses& from, const Poses& to) const {
  for (const std::shared_ptr<const PairForce>& force : forces_) {
    if (const auto bricks = force->findJump(from, to)) return bricks;
  }
  return std::nullopt;
}

}  // namespace kirireel::brick
