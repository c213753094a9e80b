// Chipmunk 7 as a baseline, as the quasicrystal kirigami simulator uses it through Pymunk: a body
// for each brick and a pivot joint for each pivot of the lower face. Chipmunk solves by sequential
// impulses in double precision and corrects gaps by feeding a part of them back as velocities. Its
// damping is the fraction of a velocity that remains after a second. It is the same for linear and
// angular velocities, so the environment's angular damping has no effect.
#include <chipmunk/chipmunk.h>

#include "tests/bench/engines/other_worlds.h"

namespace kirireel::bench {
namespace {

static_assert(sizeof(cpFloat) == sizeof(double), "Chipmunk must be built in double precision");

// Chipmunk has a function to free each type.
template <auto Free>
struct Deleter {
  template <typename T>
  void operator()(T* thing) const {
    Free(thing);
  }
};
using Space = std::unique_ptr<cpSpace, Deleter<cpSpaceFree>>;
using Body = std::unique_ptr<cpBody, Deleter<cpBodyFree>>;
using JointOfBodies = std::unique_ptr<cpConstraint, Deleter<cpConstraintFree>>;

cpVect toChipmunk(const Vector3& v) {
  return cpv(v.x(), v.y());
}

class ChipmunkWorld : public engines::BrickWorld {
 public:
  ChipmunkWorld(const std::vector<brick::Brick>& bricks, const Poses& start,
                std::span<const brick::Pivot> pivots, const scene::Environment& environment,
                int iterations)
      : start_(start), space_(cpSpaceNew()) {
    cpSpaceSetIterations(space_.get(), iterations);
    cpSpaceSetGravity(space_.get(), toChipmunk(environment.gravity));
    cpSpaceSetDamping(space_.get(), 1 - environment.linearDamping);
    for (const brick::Brick& brick : bricks) addBrick(brick);
    writeMotion({start, std::vector<Velocity>(bricks.size())});
    for (const brick::Pivot& pivot : pivots) {
      if (!pivot.isUpper) addPivot(pivot);
    }
  }

  // An object must leave its space before it is freed.
  ~ChipmunkWorld() override {
    for (const JointOfBodies& joint : joints_) cpSpaceRemoveConstraint(space_.get(), joint.get());
    for (const Body& body : bodies_) cpSpaceRemoveBody(space_.get(), body.get());
  }
  ChipmunkWorld(const ChipmunkWorld&) = delete;
  ChipmunkWorld& operator=(const ChipmunkWorld&) = delete;

  void applyLoad(int brick, const Vector3& force, const Vector3& torque) override {
    // Chipmunk sets forces to zero after each step.
    cpBody* body = bodies_[brick].get();
    cpBodySetForce(body, cpvadd(cpBodyGetForce(body), toChipmunk(force)));
    cpBodySetTorque(body, cpBodyGetTorque(body) + torque.z());
  }

  void advance(double step) override { cpSpaceStep(space_.get(), step); }

  // Heights and tilts are those of the start.
  void readMotion(Motion& motion) const override {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const cpBody* body = bodies_[k].get();
      const cpVect place = cpBodyGetPosition(body);
      const Eigen::AngleAxisd turn(cpBodyGetAngle(body), Vector3::UnitZ());
      motion.poses[k].position = {place.x, place.y, start_[k].position.z()};
      motion.poses[k].rotation = turn * start_[k].rotation;
      const cpVect speed = cpBodyGetVelocity(body);
      motion.velocities[k].linear = {speed.x, speed.y, 0};
      motion.velocities[k].angular = {0, 0, cpBodyGetAngularVelocity(body)};
    }
  }

  void writeMotion(const Motion& motion) override {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      cpBody* body = bodies_[k].get();
      const Quaternion turn = motion.poses[k].rotation * start_[k].rotation.conjugate();
      cpBodySetPosition(body, toChipmunk(motion.poses[k].position));
      cpBodySetAngle(body, 2 * std::atan2(turn.z(), turn.w()));
      cpBodySetVelocity(body, toChipmunk(motion.velocities[k].linear));
      cpBodySetAngularVelocity(body, motion.velocities[k].angular.z());
    }
  }

 private:
  void addBrick(const brick::Brick& brick) {
    bodies_.emplace_back(cpBodyNew(brick.mass, brick.inertia(2, 2)));
    cpSpaceAddBody(space_.get(), bodies_.back().get());
  }

  void addPivot(const brick::Pivot& pivot) {
    joints_.emplace_back(cpPivotJointNew2(bodies_[pivot.brickA].get(), bodies_[pivot.brickB].get(),
                                          anchor(pivot.brickA, pivot.pointA),
                                          anchor(pivot.brickB, pivot.pointB)));
    cpSpaceAddConstraint(space_.get(), joints_.back().get());
  }

  /// A body's angle is 0 at the start, so its axes are the world's axes of the start.
  cpVect anchor(int brick, const Vector3& point) const {
    return toChipmunk(start_[brick].rotation * point);
  }

  Poses start_;
  Space space_;
  std::vector<Body> bodies_;  // one per brick, in order
  std::vector<JointOfBodies> joints_;
};

}  // namespace

std::unique_ptr<engines::BrickWorld> makeChipmunkWorld(const std::vector<brick::Brick>& bricks,
                                                       const Poses& start,
                                                       std::span<const brick::Pivot> pivots,
                                                       const scene::Environment& environment,
                                                       int iterations) {
  return std::make_unique<ChipmunkWorld>(bricks, start, pivots, environment, iterations);
}

std::string chipmunkVersion() {
  return cpVersionString;
}

}  // namespace kirireel::bench
