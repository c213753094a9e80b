#include "sim/world/chipmunk_world.h"

namespace kirireel {

std::unique_ptr<BrickWorld> makeChipmunkWorld(const std::vector<Brick>& /*bricks*/,
                                              const Poses& /*start*/,
                                              std::span<const Pivot> /*pivots*/,
                                              const Environment& /*environment*/,
                                              int /*iterations*/) {
  return nullptr;
}

std::string chipmunkVersion() {
  return "";
}

}  // namespace kirireel
