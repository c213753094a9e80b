// Forces between pairs of bricks, as tests make them.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "sim/model/hinge.h"
#include "sim/model/pair_force.h"

namespace kirireel::test {

/// Hinge springs and ligaments, as in a scene.
inline model::PairForces pairForces(std::vector<model::HingeSpring> springs,
                                    std::vector<model::Ligament> ligaments = {}) {
  model::PairForces forces;
  forces.add(std::make_shared<model::HingeSprings>(std::move(springs)));
  forces.add(std::make_shared<model::Ligaments>(std::move(ligaments)));
  return forces;
}

}  // namespace kirireel::test
