/// The force of a drive, for all drives but the springs to a target, which a run moves on and
/// stiffens on its way (see TargetSprings).
#pragma once

#include <memory>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/load.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// What drives the bricks of a scene.
class DriveForce {
 public:
  virtual ~DriveForce() = default;

  /// Adds the drive's load on every brick at these poses, its damping included.
  /// One pose and one load a brick. The loads are added to what is there.
  virtual void addLoads(const Poses& poses, std::vector<Load>& loads) const = 0;

  /// Energy that it stores in these poses, joules; 0 where it stores none.
  virtual double energy(const Poses& poses) const = 0;

  /// Adds to every brick's force, newtons, what of the drive stores no energy.
  virtual void addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const = 0;

  /// Whether it drives bricks on however far they have come, so that nothing but joints ends it.
  virtual bool isEndless() const = 0;
};

/// The drive that a scene asks for; null where that is the target or nothing. Scene and bricks must
/// outlive it. Throws InputError where the model does not have what the drive needs.
std::unique_ptr<DriveForce> makeDriveForce(const Scene& scene, const std::vector<Brick>& bricks);

}  // namespace kirireel
