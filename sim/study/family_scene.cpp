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
