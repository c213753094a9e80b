// Pair forces for tests.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "sim/brick/hinge.h"
#include "sim/brick/pair_force.h"

namespace kirireel::test {

/// Hinge springs and ligaments, as in a scene.
inline brick::PairForces pairForces(std::vector<brick::HingeSpring> springs,
                                    std::vector<brick::Ligament> ligaments = {}) {
  brick::PairForces forces;
  forces.add(std::make_shared<brick::HingeSprings>(std::move(springs)));
  forces.add(std::make_shared<brick::Ligaments>(std::move(ligaments)));
  return forces;
}

}  // namespace kirireel::test
