// Forces between pairs of bricks, as tests make them.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "sim/model/hinge.h"
#include "sim/model/pair_force.h"

namespace kirireel::test {

/// Springs at hinges and ligaments as a scene has them.
inline PairForces pairForces(std::vector<HingeSpring> springs,
                             std::vector<Ligament> ligaments = {}) {
  PairForces forces;
  forces.add(std::make_shared<HingeSprings>(std::move(springs)));
  forces.add(std::make_shared<Ligaments>(std::move(ligaments)));
  return forces;
}

}  // namespace kirireel::test
