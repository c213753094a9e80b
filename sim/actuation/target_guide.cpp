// Each tile's own way from start to target: its mean goes straight, its rotation is exp(s theta)
// with theta the rotation vector of the best fit (alignment.cpp) and s the progress, and what the
// best fit leaves over, in the axes of the start, is added in proportion to s. At s = 1 every
// vertex is exactly at its target.
#include "sim/actuation/target_guide.h"

#include "sim/model/alignment.h"

namespace kirireel {
namespace {

Vector3 rotationVector(const Matrix3& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  // The angle is at most pi. A tile that turns by exactly pi has two such ways, of which rounding
  // chooses one.
  return turn.angle() * turn.axis();
}

}  // namespace

TargetGuide::TargetGuide(const std::vector<Tile>& start, const std::vector<Tile>& target) {
  for (std::size_t i = 0; i < start.size(); ++i) {
    const std::vector<Vector3>& from = start[i].vertices;
    const std::vector<Vector3>& to = target[i].vertices;
    const Matrix3 R = bestRigidMotion(from, to).rotation;
    Way way{meanPoint(from), meanPoint(to), rotationVector(R), {}, {}};
    for (std::size_t k = 0; k < from.size(); ++k) {
      way.vertices.push_back(from[k] - way.startMean);
      way.unfit.push_back(R.transpose() * (to[k] - way.targetMean) - way.vertices.back());
    }
    ways_.push_back(std::move(way));
  }
}

std::vector<Tile> TargetGuide::at(double progress) const {
  std::vector<Tile> tiles(ways_.size());
  for (std::size_t i = 0; i < ways_.size(); ++i) {
    const Way& way = ways_[i];
    const Quaternion turn = rotationFromVector(progress * way.turn);
    const Vector3 middle = way.startMean + progress * (way.targetMean - way.startMean);
    for (std::size_t k = 0; k < way.vertices.size(); ++k) {
      tiles[i].vertices.push_back(middle + turn * (way.vertices[k] + progress * way.unfit[k]));
    }
  }
  return tiles;
}

Poses bestFitPoses(const std::vector<Brick>& bricks, const std::vector<Tile>& target) {
  Poses poses(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const RigidMotion motion = bestRigidMotion(bricks[i].bottom, target[i].vertices);
    poses[i] = {motion.translation, Quaternion(motion.rotation)};
  }
  return poses;
}

}  // namespace kirireel
