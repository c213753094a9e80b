/// Scenes of generated models.
#pragma once

#include <string>

#include "sim/scene/scene.h"

namespace kirireel {

/// The model of a family with its usual values, its start turned into the target's axes; no
/// contacts.
Scene familyScene(const std::string& family);

}  // namespace kirireel
