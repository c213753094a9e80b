/// What holds the tiles of a sheet together where its joints are necks of material.
#pragma once

#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/brick/ligament.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Joints that are exact, and ligaments in the place of the others. In the plane.
struct Ties {
  std::vector<Pivot> pivots;
  std::vector<Ligament> ligaments;
};

/// The ties of a planar scene with these springs, which are at its hinges: a joint at a hinge is a
/// neck where the scene has necks. Throws InputError for ligaments that could neither stretch nor
/// shear.
Ties tiesOf(const Scene& scene, const std::vector<Brick>& bricks,
            const std::vector<HingeSpring>& springs);

/// The ties of a scene that moves masses: as tiesOf() where it asks for ligaments, which needs a
/// planar one; else its joints are exact, and turn about the tiles' corners. Throws InputError.
Ties dynamicTies(const Scene& scene, const std::vector<Brick>& bricks,
                 const std::vector<HingeSpring>& springs);

}  // namespace kirireel
