// A family's model with default parameters as a scene, its start moved onto its target by the best
// rigid motion, so that springs pull the tiles no farther than the deployment needs.
#include "sim/study/family_scene.h"

#include "sim/generate/families.h"
#include "sim/model/alignment.h"

namespace kirireel {

Scene familyScene(const std::string& family) {
  Scene scene;
  scene.model = generateModel(familyNamed(family), {});
  alignStartToTarget(scene.model);
  return scene;
}

}  // namespace kirireel
