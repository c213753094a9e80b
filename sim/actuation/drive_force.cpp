// The choice of a drive. Springs to a target are not made here: a run moves their target on,
// stiffens them and switches them, so that it keeps them itself.
#include "sim/actuation/drive_force.h"

#include "sim/actuation/boundary_springs.h"
#include "sim/actuation/expansion.h"

namespace kirireel {

std::unique_ptr<DriveForce> makeDriveForce(const Scene& scene, const std::vector<Brick>& bricks) {
  const TargetSpringSettings strength = springsOf(scene);
  switch (scene.actuation.drive) {
    case Drive::Expansion:
      return std::make_unique<Expansion>(bricks, strength);
    case Drive::Boundary:
      return std::make_unique<BoundarySprings>(scene.model, bricks, strength,
                                               scene.actuation.boundary);
    case Drive::Auto:
    case Drive::Target:
    case Drive::None:
      break;
  }
  return nullptr;
}

}  // namespace kirireel
