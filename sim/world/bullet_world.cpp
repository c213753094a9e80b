// Bullet's rigid-body world as a baseline, with our rules for contacts.
//
// Bullet advances velocities by the loads, solves joints and contacts together on velocities by one
// of three methods, and moves the bodies by semi-implicit Euler. A joint's gap c is fed back as a
// velocity of erp c / h (Baumgarte's stabilisation: J. Baumgarte, Stabilization of constraints and
// integrals of motion in dynamical systems, Comput. Methods Appl. Mech. Eng. 1, 1972), so that gaps
// shrink over many steps and never vanish.
//
// Three things differ from Bullet's defaults. Shapes are shrunk so that shape and margin together
// are the brick (inset_hull.h). Friction coefficients belong to pairs, where Bullet multiplies
// those of two bodies. Contact points near a shared pivot are removed (pivot_zones.h), as they
// would pry the joint open.
#include "sim/world/bullet_world.h"

#include <optional>

#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>
#include <fmt/format.h>

#include "sim/world/bullet_values.h"
#include "sim/world/inset_hull.h"
#include "sim/world/pivot_zones.h"

namespace kirireel {
namespace {

// Collision groups: what may be in a pair with what.
constexpr int kBrickGroup = 1;
constexpr int kGroundGroup = 2;

// Bodies carry their brick's index; the ground carries this.
constexpr int kGroundIndex = -1;

/// A solver, and what it works with.
struct SolverParts {
  std::unique_ptr<btDantzigSolver> pivoting;
  std::unique_ptr<btConstraintSolver> solver;
};

SolverParts makeSolver(BulletMethod method) {
  SolverParts made;
  switch (method) {
    case BulletMethod::SequentialImpulse:
      made.solver = std::make_unique<btSequentialImpulseConstraintSolver>();
      break;
    case BulletMethod::Nncg:
      made.solver = std::make_unique<btNNCGConstraintSolver>();
      break;
    case BulletMethod::Dantzig:
      made.pivoting = std::make_unique<btDantzigSolver>();
      // Where pivoting fails, Bullet falls back to sequential impulses by itself.
      made.solver = std::make_unique<btMLCPSolver>(made.pivoting.get());
      break;
  }
  return made;
}

std::unique_ptr<btConvexHullShape> makeHull(const Brick& brick, const PrincipalAxes& axes) {
  // A body's axes are the principal axes of the brick, so that points are turned into them.
  const InsetHull hull = insetHull(brick);
  auto shape = std::make_unique<btConvexHullShape>();
  for (const Vector3& point : hull.points) {
    shape->addPoint(toBullet(axes.rotation.conjugate() * point), false);
  }
  shape->setMargin(hull.margin);
  shape->recalcLocalAabb();
  return shape;
}

/// Bullet's world with our rules between detecting contacts and solving them. Its global contact
/// callbacks would be shared by all worlds of a program.
class KirigamiWorld : public btDiscreteDynamicsWorld {
 public:
  KirigamiWorld(btDispatcher& dispatcher, btBroadphaseInterface& broadphase,
                btConstraintSolver& solver, btCollisionConfiguration& configuration,
                const Environment& environment, PivotZones zones, const Poses& poses)
      : btDiscreteDynamicsWorld(&dispatcher, &broadphase, &solver, &configuration),
        brickFriction_(environment.brickFriction),
        zones_(std::move(zones)),
        poses_(poses) {
    if (environment.ground) groundFriction_ = environment.ground->friction;
    detects_ = environment.ground || environment.contacts != ContactFilter::None;
  }

  void performDiscreteCollisionDetection() override {
    if (!detects_) return;
    btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
    for (int k = 0; k < getDispatcher()->getNumManifolds(); ++k) {
      amend(*getDispatcher()->getManifoldByIndexInternal(k));
    }
  }

 private:
  // Sets friction, and removes points near shared pivots.
  void amend(btPersistentManifold& manifold) const {
    const int brickA = manifold.getBody0()->getUserIndex();
    const int brickB = manifold.getBody1()->getUserIndex();
    const bool onGround = brickA == kGroundIndex || brickB == kGroundIndex;
    // From the last point, because removing one moves the last into its place.
    for (int k = manifold.getNumContacts() - 1; k >= 0; --k) {
      btManifoldPoint& point = manifold.getContactPoint(k);
      // Bullet multiplies two bodies' coefficients; ours belong to the pair.
      point.m_combinedFriction = onGround ? groundFriction_ : brickFriction_;
      if (onGround) continue;
      const Vector3 place = fromBullet(point.getPositionWorldOnA());
      if (zones_.contains(brickA, brickB, poses_, place)) manifold.removeContactPoint(k);
    }
  }

  double brickFriction_;
  double groundFriction_ = 0;
  bool detects_ = true;
  PivotZones zones_;
  const Poses& poses_;  // at the start of the step
};

}  // namespace

// The world comes last, because it must go first.
struct BulletWorld::Internals {
  Motion motion;  ///< as last written or reached
  std::vector<PrincipalAxes> axes;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  SolverParts solver;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;  ///< one a brick, in order
  std::unique_ptr<btRigidBody> groundBody;
  std::vector<std::unique_ptr<btTypedConstraint>> joints;
  std::optional<KirigamiWorld> world;

  void addShape(const Brick& brick, const PrincipalAxes& principal);
  void addBrick(const Brick& brick, const Environment& environment);
  void addPivot(const Pivot& pivot, const Environment& environment);
  void addGround(const Ground& ground);
  void placeBodies();
};

/// A hull, or for a concave brick one shape of several hulls, which do not meet each other.
void BulletWorld::Internals::addShape(const Brick& brick, const PrincipalAxes& principal) {
  if (brick.parts.empty()) {
    shapes.push_back(makeHull(brick, principal));
    return;
  }
  auto whole = std::make_unique<btCompoundShape>();
  for (const BrickPiece& piece : convexPieces(brick)) {
    shapes.push_back(makeHull(piece.shape, principal));
    whole->addChildShape(btTransform::getIdentity(), shapes.back().get());
  }
  shapes.push_back(std::move(whole));
}

void BulletWorld::Internals::addBrick(const Brick& brick, const Environment& environment) {
  const PrincipalAxes& principal = axes.emplace_back(principalAxes(brick));
  addShape(brick, principal);
  btRigidBody::btRigidBodyConstructionInfo info(brick.mass, nullptr, shapes.back().get(),
                                                toBullet(principal.inertia));
  info.m_linearDamping = environment.linearDamping;
  info.m_angularDamping = environment.angularDamping;
  btRigidBody& body = *bodies.emplace_back(std::make_unique<btRigidBody>(info));
  body.setUserIndex(static_cast<int>(bodies.size()) - 1);
  // Bodies that Bullet takes for resting are no longer moved by springs.
  body.setActivationState(DISABLE_DEACTIVATION);
  const bool touchesBricks = environment.contacts != ContactFilter::None;
  world->addRigidBody(&body, kBrickGroup,
                      touchesBricks ? kBrickGroup | kGroundGroup : kGroundGroup);
}

void BulletWorld::Internals::addPivot(const Pivot& pivot, const Environment& environment) {
  const Vector3 pointA = axes[pivot.brickA].rotation.conjugate() * pivot.pointA;
  const Vector3 pointB = axes[pivot.brickB].rotation.conjugate() * pivot.pointB;
  joints.push_back(std::make_unique<btPoint2PointConstraint>(
      *bodies[pivot.brickA], *bodies[pivot.brickB], toBullet(pointA), toBullet(pointB)));
  const bool joinedPassThrough = environment.contacts != ContactFilter::All;
  world->addConstraint(joints.back().get(), joinedPassThrough);
}

void BulletWorld::Internals::addGround(const Ground& ground) {
  shapes.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), ground.height));
  groundBody = std::make_unique<btRigidBody>(0, nullptr, shapes.back().get());
  groundBody->setUserIndex(kGroundIndex);
  world->addRigidBody(groundBody.get(), kGroundGroup, kBrickGroup);
}

// To the poses and velocities of `motion`.
void BulletWorld::Internals::placeBodies() {
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const Pose& pose = motion.poses[k];
    // Velocities first: placing the body copies them to its interpolation state.
    bodies[k]->setLinearVelocity(toBullet(motion.velocities[k].linear));
    bodies[k]->setAngularVelocity(toBullet(motion.velocities[k].angular));
    bodies[k]->setCenterOfMassTransform(
        btTransform(toBullet(pose.rotation * axes[k].rotation), toBullet(pose.position)));
  }
}

BulletWorld::BulletWorld(const std::vector<Brick>& bricks, const Poses& start,
                         std::span<const Pivot> pivots, const Environment& environment,
                         const BulletSettings& settings)
    : internals_(std::make_unique<Internals>()) {
  Internals& in = *internals_;
  in.motion = {start, std::vector<Velocity>(bricks.size())};
  in.solver = makeSolver(settings.method);
  // Several contact points at once, else a brick laid flat on the ground rocks on one.
  in.configuration.setPlaneConvexMultipointIterations();
  in.world.emplace(in.dispatcher, in.broadphase, *in.solver.solver, in.configuration, environment,
                   PivotZones(bricks, pivots), in.motion.poses);
  in.world->setGravity(toBullet(environment.gravity));
  in.world->getSolverInfo().m_numIterations = settings.iterations;
  in.world->getSolverInfo().m_erp = settings.jointCorrection;
  in.world->getDispatchInfo().m_deterministicOverlappingPairs = true;
  for (const Brick& brick : bricks) in.addBrick(brick, environment);
  in.placeBodies();
  for (const Pivot& pivot : pivots) in.addPivot(pivot, environment);
  if (environment.ground) in.addGround(*environment.ground);
}

BulletWorld::~BulletWorld() = default;

void BulletWorld::applyLoad(int brick, const Vector3& force, const Vector3& torque) {
  internals_->bodies[brick]->applyCentralForce(toBullet(force));
  internals_->bodies[brick]->applyTorque(toBullet(torque));
}

void BulletWorld::advance(double step) {
  Internals& in = *internals_;
  // No substeps: one call is one step of exactly this length.
  in.world->stepSimulation(step, 0);
  for (std::size_t k = 0; k < in.bodies.size(); ++k) {
    const btRigidBody& body = *in.bodies[k];
    in.motion.poses[k].position = fromBullet(body.getCenterOfMassPosition());
    in.motion.poses[k].rotation =
        // From principal axes back to the brick's.
        fromBullet(body.getOrientation()) * in.axes[k].rotation.conjugate();
    in.motion.velocities[k] = {fromBullet(body.getLinearVelocity()),
                               fromBullet(body.getAngularVelocity())};
  }
}

void BulletWorld::readMotion(Motion& motion) const {
  motion = internals_->motion;
}

void BulletWorld::writeMotion(const Motion& motion) {
  Internals& in = *internals_;
  in.motion = motion;
  in.placeBodies();
  // Impulses of the contacts that were would start the next solve from another place.
  for (int k = 0; k < in.dispatcher.getNumManifolds(); ++k) {
    in.dispatcher.getManifoldByIndexInternal(k)->clearManifold();
  }
}

std::string bulletVersion() {
  return fmt::format("{}.{:02}", btGetVersion() / 100, btGetVersion() % 100);
}

}  // namespace kirireel
