// Bullet's world of multibodies as a baseline, without collisions. Each brick is a base without
// links, so that nothing is gained from joint coordinates; it is here because PyBullet, and so
// PyKirigami, runs its bodies in this world. Joints are held by projected Gauss-Seidel sweeps over
// all point joints.
#include "sim/world/multi_body_world.h"

#include <optional>

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <btBulletDynamicsCommon.h>

#include "sim/world/bullet_values.h"

namespace kirireel {
namespace {

// The impulse that a joint may take in a step is limited by default; ours is not.
constexpr double kLargestImpulse = 1e12;

/// Bullet finds what belongs together by colliders, so there are some; they need not collide.
class UntouchedWorld : public btMultiBodyDynamicsWorld {
 public:
  using btMultiBodyDynamicsWorld::btMultiBodyDynamicsWorld;
  void performDiscreteCollisionDetection() override {}
};

}  // namespace

// The world comes last, because it must go first.
struct MultiBodyWorld::Internals {
  std::vector<PrincipalAxes> axes;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  btSphereShape shape{1e-3};
  std::vector<std::unique_ptr<btMultiBody>> bodies;  // one a brick, in order
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders;
  std::vector<std::unique_ptr<btMultiBodyPoint2Point>> joints;
  std::optional<UntouchedWorld> world;

  void addBrick(const Brick& brick, const Environment& environment);
  void addPivot(const Pivot& pivot);
};

void MultiBodyWorld::Internals::addBrick(const Brick& brick, const Environment& environment) {
  const PrincipalAxes& principal = axes.emplace_back(principalAxes(brick));
  btMultiBody& body = *bodies.emplace_back(
      // No links, the mass and principal inertia, no fixed base, no sleeping.
      std::make_unique<btMultiBody>(0, brick.mass, toBullet(principal.inertia), false, false));
  body.setLinearDamping(environment.linearDamping);
  body.setAngularDamping(environment.angularDamping);
  body.finalizeMultiDof();
  world->addMultiBody(&body);
  btMultiBodyLinkCollider& collider =
      *colliders.emplace_back(std::make_unique<btMultiBodyLinkCollider>(&body, -1));
  collider.setCollisionShape(&shape);
  collider.setActivationState(DISABLE_DEACTIVATION);
  body.setBaseCollider(&collider);
  // Group and mask 0: it meets nothing.
  world->addCollisionObject(&collider, 0, 0);
}

void MultiBodyWorld::Internals::addPivot(const Pivot& pivot) {
  const Vector3 pointA = axes[pivot.brickA].rotation.conjugate() * pivot.pointA;
  const Vector3 pointB = axes[pivot.brickB].rotation.conjugate() * pivot.pointB;
  btMultiBodyPoint2Point& joint = *joints.emplace_back(std::make_unique<btMultiBodyPoint2Point>(
      bodies[pivot.brickA].get(), -1, bodies[pivot.brickB].get(), -1, toBullet(pointA),
      toBullet(pointB)));
  joint.setMaxAppliedImpulse(kLargestImpulse);
  world->addMultiBodyConstraint(&joint);
}

MultiBodyWorld::MultiBodyWorld(const std::vector<Brick>& bricks, const Poses& start,
                               std::span<const Pivot> pivots, const Environment& environment,
                               int iterations)
    : internals_(std::make_unique<Internals>()) {
  Internals& in = *internals_;
  in.world.emplace(&in.dispatcher, &in.broadphase, &in.solver, &in.configuration);
  in.world->setGravity(toBullet(environment.gravity));
  in.world->getSolverInfo().m_numIterations = iterations;
  for (const Brick& brick : bricks) in.addBrick(brick, environment);
  writeMotion({start, std::vector<Velocity>(bricks.size())});
  for (const Pivot& pivot : pivots) in.addPivot(pivot);
}

MultiBodyWorld::~MultiBodyWorld() {
  // A world does not let go of multibodies and their joints by itself.
  for (const auto& joint : internals_->joints) {
    internals_->world->removeMultiBodyConstraint(joint.get());
  }
  for (const auto& body : internals_->bodies) internals_->world->removeMultiBody(body.get());
}

void MultiBodyWorld::applyLoad(int brick, const Vector3& force, const Vector3& torque) {
  internals_->bodies[brick]->addBaseForce(toBullet(force));
  internals_->bodies[brick]->addBaseTorque(toBullet(torque));
}

void MultiBodyWorld::advance(double step) {
  internals_->world->stepSimulation(step, 0);
}

void MultiBodyWorld::readMotion(Motion& motion) const {
  const Internals& in = *internals_;
  for (std::size_t k = 0; k < in.bodies.size(); ++k) {
    const btMultiBody& body = *in.bodies[k];
    motion.poses[k].position = fromBullet(body.getBasePos());
    motion.poses[k].rotation =
        fromBullet(body.getWorldToBaseRot().inverse()) * in.axes[k].rotation.conjugate();
    motion.velocities[k] = {fromBullet(body.getBaseVel()), fromBullet(body.getBaseOmega())};
  }
}

void MultiBodyWorld::writeMotion(const Motion& motion) {
  const Internals& in = *internals_;
  for (std::size_t k = 0; k < in.bodies.size(); ++k) {
    btMultiBody& body = *in.bodies[k];
    body.setBasePos(toBullet(motion.poses[k].position));
    body.setWorldToBaseRot(toBullet(motion.poses[k].rotation * in.axes[k].rotation).inverse());
    body.setBaseVel(toBullet(motion.velocities[k].linear));
    body.setBaseOmega(toBullet(motion.velocities[k].angular));
  }
}

}  // namespace kirireel
