// Speeds at the start: a group of tiles begins to move as one rigid body. With the common centre of
// mass c (m), the velocity v of c (m/s) and the angular velocity w (rad/s), the tile at x has
//   v_x = v + w x (x - c),     w_x = w
// Velocities of several entries for one tile add up. What joints do not allow is taken away by the
// first projection of the run, which keeps momentum.
#include "sim/scene/initial_velocity.h"

#include <numeric>

#include "sim/scene/tile_numbers.h"

namespace kirireel {
namespace {

// No tiles named means all.
std::vector<int> tilesOf(const InitialVelocity& velocity, std::size_t count) {
  if (!velocity.tiles.empty()) return velocity.tiles;
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace

// From the file's numbers to the model's. Throws InputError for a tile that the model does not
// have.
void numberAsModel(std::vector<InitialVelocity>& velocities, const Model& model) {
  for (InitialVelocity& velocity : velocities) {
    for (int& tile : velocity.tiles) tile = tileOfModel(tile, model, velocity.where);
  }
}

// Tiles must be numbered as the model's. One velocity a brick, zero where no entry names it.
std::vector<Velocity> initialVelocities(const std::vector<InitialVelocity>& given,
                                        const std::vector<Brick>& bricks, const Poses& poses) {
  std::vector<Velocity> velocities(bricks.size());
  for (const InitialVelocity& velocity : given) {
    const std::vector<int> tiles = tilesOf(velocity, bricks.size());
    double mass = 0;
    Vector3 centre = Vector3::Zero();
    for (const int tile : tiles) {
      mass += bricks[tile].mass;
      centre += bricks[tile].mass * poses[tile].position;
    }
    // Masses are positive, and a group has one tile at least.
    centre /= mass;
    for (const int tile : tiles) {
      const Vector3 arm = poses[tile].position - centre;
      velocities[tile].linear += velocity.linear + velocity.angular.cross(arm);
      velocities[tile].angular += velocity.angular;
    }
  }
  return velocities;
}

}  // namespace kirireel
