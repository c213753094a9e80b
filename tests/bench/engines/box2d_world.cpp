// Box2D 2.4 as a baseline: one dynamic body without a shape for each brick, one revolute joint for
// each pivot of the lower face.
//
// Box2D advances velocities by semi-implicit Euler, holds joints by sequential impulses on
// velocities, and moves the bodies at the end of a step to close joints (its position iterations;
// E. Catto, Iterative dynamics with temporal coherence, Game Developers Conference, 2005). It works
// in single precision, so gaps below about 1e-6 m are impossible. Box2D multiplies velocities by 1
// / (1 + h c) per step. For short steps, the rate c = -ln(1 - lost) loses the requested fraction
// per second.
#include <cmath>

#include <box2d/box2d.h>
#include <fmt/format.h>

#include "tests/bench/engines/other_worlds.h"

namespace kirireel::bench {
namespace {

b2Vec2 toBox2d(const Vector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y())};
}

/// The rate of a velocity that loses this fraction per second.
float dampingRate(double lost) {
  return static_cast<float>(-std::log1p(-lost));
}

class Box2dWorld : public engines::BrickWorld {
 public:
  Box2dWorld(const std::vector<brick::Brick>& bricks, const Poses& start,
             std::span<const brick::Pivot> pivots, const scene::Environment& environment,
             int iterations, int corrections)
      : start_(start),
        world_(toBox2d(environment.gravity)),
        iterations_(iterations),
        corrections_(corrections) {
    // Bodies at rest under small forces would stop to be simulated.
    world_.SetAllowSleeping(false);
    for (std::size_t k = 0; k < bricks.size(); ++k) addBrick(bricks[k], start[k], environment);
    for (const brick::Pivot& pivot : pivots) {
      if (!pivot.isUpper) addPivot(pivot);
    }
  }

  void applyLoad(int brick, const Vector3& force, const Vector3& torque) override {
    bodies_[brick]->ApplyForceToCenter(toBox2d(force), true);
    bodies_[brick]->ApplyTorque(static_cast<float>(torque.z()), true);
  }

  void advance(double step) override {
    world_.Step(static_cast<float>(step), iterations_, corrections_);
  }

  // Heights and tilts are those of the start.
  void readMotion(Motion& motion) const override {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const b2Body& body = *bodies_[k];
      const Eigen::AngleAxisd turn(body.GetAngle(), Vector3::UnitZ());
      motion.poses[k].position = {body.GetPosition().x, body.GetPosition().y,
                                  start_[k].position.z()};
      // In the plane only the rotation about z changes.
      motion.poses[k].rotation = turn * start_[k].rotation;
      const b2Vec2 speed = body.GetLinearVelocity();
      motion.velocities[k].linear = {speed.x, speed.y, 0};
      motion.velocities[k].angular = {0, 0, body.GetAngularVelocity()};
    }
  }

  // A body's angle is the rotation about z since the start.
  void writeMotion(const Motion& motion) override {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      b2Body& body = *bodies_[k];
      const Quaternion turn = motion.poses[k].rotation * start_[k].rotation.conjugate();
      body.SetTransform(toBox2d(motion.poses[k].position),
                        static_cast<float>(2 * std::atan2(turn.z(), turn.w())));
      body.SetLinearVelocity(toBox2d(motion.velocities[k].linear));
      body.SetAngularVelocity(static_cast<float>(motion.velocities[k].angular.z()));
    }
  }

 private:
  /// A body without a shape, because nothing collides. Its mass is set.
  void addBrick(const brick::Brick& brick, const Pose& start,
                const scene::Environment& environment) {
    b2BodyDef definition;
    definition.type = b2_dynamicBody;
    definition.position = toBox2d(start.position);
    definition.linearDamping = dampingRate(environment.linearDamping);
    definition.angularDamping = dampingRate(environment.angularDamping);
    bodies_.push_back(world_.CreateBody(&definition));
    b2MassData mass;
    mass.mass = static_cast<float>(brick.mass);
    // The origin of a brick is its centre of mass.
    mass.center.SetZero();
    mass.I = static_cast<float>(brick.inertia(2, 2));
    bodies_.back()->SetMassData(&mass);
  }

  /// A body's angle is 0 at the start, so its axes are the world's axes of the start.
  void addPivot(const brick::Pivot& pivot) {
    b2RevoluteJointDef definition;
    definition.bodyA = bodies_[pivot.brickA];
    definition.bodyB = bodies_[pivot.brickB];
    definition.localAnchorA = toBox2d(start_[pivot.brickA].rotation * pivot.pointA);
    definition.localAnchorB = toBox2d(start_[pivot.brickB].rotation * pivot.pointB);
    world_.CreateJoint(&definition);
  }

  Poses start_;
  b2World world_;
  std::vector<b2Body*> bodies_;  // one per brick, in order; the world's
  int iterations_;
  int corrections_;
};

}  // namespace

std::unique_ptr<engines::BrickWorld> makeBox2dWorld(const std::vector<brick::Brick>& bricks,
                                                    const Poses& start,
                                                    std::span<const brick::Pivot> pivots,
                                                    const scene::Environment& environment,
                                                    int iterations, int corrections) {
  return std::make_unique<Box2dWorld>(bricks, start, pivots, environment, iterations, corrections);
}

std::string box2dVersion() {
  return fmt::format("{}.{}.{}", b2_version.major, b2_version.minor, b2_version.revision);
}

}  // namespace kirireel::bench
