// Bullet's rigid-body world as a baseline, with our rules for contacts.
//
// Bullet advances velocities by the loads, solves joints and contacts together on velocities by one
// of three methods, and moves the bodies by semi-implicit Euler. A joint's gap c is fed back as a
// velocity of erp c / h (Baumgarte's stabilisation: J. Baumgarte, Stabilization of constraints and
// integrals of motion in dynamical systems, Comput. Methods Appl. Mech. Eng. 1, 1972): gaps shrink
// over many steps and never vanish.
//
// Three things differ from Bullet's defaults. Shapes are shrunk: shape and margin together are the
// brick (bullet_world.h). Friction coefficients belong to pairs, while Bullet multiplies those of
// two bodies. Contact points near a shared pivot are removed (bullet_world.h), because they would
// force the joint open.
#include "sim/engines/bullet_world.h"

#include <algorithm>
#include <optional>

#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <Eigen/Eigenvalues>
#include <btBulletDynamicsCommon.h>
#include <fmt/format.h>

#include "sim/contacts/bullet_values.h"

namespace kirireel::engines {
namespace {

using contacts::fromBullet;
using contacts::toBullet;

/// Bullet requires diagonal inertias: a body's axes are its brick's principal axes.
struct PrincipalAxes {
  Quaternion rotation;  ///< from principal axes to brick axes
  Vector3 inertia;      ///< about the principal axes
};

/// The principal axes of a brick, right-handed.
PrincipalAxes principalAxes(const brick::Brick& brick) {
  // Eigenvectors are orthonormal but may be left-handed, unlike a rotation.
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(brick.inertia);
  Matrix3 axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  return {Quaternion(axes).normalized(), solver.eigenvalues()};
}

// Collision groups.
constexpr int kBrickGroup = 1;
constexpr int kGroundGroup = 2;

// Bodies carry their brick's index; the ground carries this.
constexpr int kGroundIndex = -1;

/// A solver and its data.
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
      // If pivoting fails, Bullet falls back to sequential impulses.
      made.solver = std::make_unique<btMLCPSolver>(made.pivoting.get());
      break;
  }
  return made;
}

std::unique_ptr<btConvexHullShape> makeHull(const brick::Brick& brick, const PrincipalAxes& axes) {
  // A body's axes are the principal axes of the brick. Points are rotated to them.
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
                const scene::Environment& environment, PivotZones zones, const Poses& poses)
      : btDiscreteDynamicsWorld(&dispatcher, &broadphase, &solver, &configuration),
        brickFriction_(environment.brickFriction),
        zones_(std::move(zones)),
        poses_(poses) {
    if (environment.ground) groundFriction_ = environment.ground->friction;
    detects_ = environment.ground || environment.contacts != scene::ContactFilter::None;
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
    // In reverse, because removal of a point moves the last one to its index.
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

// The world is the last member, because it must be destroyed first.
struct BulletWorld::Internals {
  Motion motion;  ///< as last written or reached
  std::vector<PrincipalAxes> axes;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  SolverParts solver;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;  ///< one per brick, in order
  std::unique_ptr<btRigidBody> groundBody;
  std::vector<std::unique_ptr<btTypedConstraint>> joints;
  std::optional<KirigamiWorld> world;

  void addShape(const brick::Brick& brick, const PrincipalAxes& principal);
  void addBrick(const brick::Brick& brick, const scene::Environment& environment);
  void addPivot(const brick::Pivot& pivot, const scene::Environment& environment);
  void addGround(const scene::Ground& ground);
  void placeBodies();
};

/// A hull, or for a concave brick one shape of several hulls, which do not collide with each other.
void BulletWorld::Internals::addShape(const brick::Brick& brick, const PrincipalAxes& principal) {
  if (brick.parts.empty()) {
    shapes.push_back(makeHull(brick, principal));
    return;
  }
  auto whole = std::make_unique<btCompoundShape>();
  for (const brick::BrickPiece& piece : brick::convexPieces(brick)) {
    shapes.push_back(makeHull(piece.shape, principal));
    whole->addChildShape(btTransform::getIdentity(), shapes.back().get());
  }
  shapes.push_back(std::move(whole));
}

void BulletWorld::Internals::addBrick(const brick::Brick& brick,
                                      const scene::Environment& environment) {
  const PrincipalAxes& principal = axes.emplace_back(principalAxes(brick));
  addShape(brick, principal);
  btRigidBody::btRigidBodyConstructionInfo info(brick.mass, nullptr, shapes.back().get(),
                                                toBullet(principal.inertia));
  info.m_linearDamping = environment.linearDamping;
  info.m_angularDamping = environment.angularDamping;
  btRigidBody& body = *bodies.emplace_back(std::make_unique<btRigidBody>(info));
  body.setUserIndex(static_cast<int>(bodies.size()) - 1);
  // Springs do not move bodies that Bullet has put to sleep.
  body.setActivationState(DISABLE_DEACTIVATION);
  const bool touchesBricks = environment.contacts != scene::ContactFilter::None;
  world->addRigidBody(&body, kBrickGroup,
                      touchesBricks ? kBrickGroup | kGroundGroup : kGroundGroup);
}

void BulletWorld::Internals::addPivot(const brick::Pivot& pivot,
                                      const scene::Environment& environment) {
  const Vector3 pointA = axes[pivot.brickA].rotation.conjugate() * pivot.pointA;
  const Vector3 pointB = axes[pivot.brickB].rotation.conjugate() * pivot.pointB;
  joints.push_back(std::make_unique<btPoint2PointConstraint>(
      *bodies[pivot.brickA], *bodies[pivot.brickB], toBullet(pointA), toBullet(pointB)));
  const bool joinedPassThrough = environment.contacts != scene::ContactFilter::All;
  world->addConstraint(joints.back().get(), joinedPassThrough);
}

void BulletWorld::Internals::addGround(const scene::Ground& ground) {
  shapes.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), ground.height));
  groundBody = std::make_unique<btRigidBody>(0, nullptr, shapes.back().get());
  groundBody->setUserIndex(kGroundIndex);
  world->addRigidBody(groundBody.get(), kGroundGroup, kBrickGroup);
}

// Sets the poses and velocities of `motion`.
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

BulletWorld::BulletWorld(const std::vector<brick::Brick>& bricks, const Poses& start,
                         std::span<const brick::Pivot> pivots,
                         const scene::Environment& environment, const BulletSettings& settings)
    : internals_(std::make_unique<Internals>()) {
  Internals& in = *internals_;
  in.motion = {start, std::vector<Velocity>(bricks.size())};
  in.solver = makeSolver(settings.method);
  // Several contact points at once. With one, a brick flat on the ground would rock.
  in.configuration.setPlaneConvexMultipointIterations();
  in.world.emplace(in.dispatcher, in.broadphase, *in.solver.solver, in.configuration, environment,
                   PivotZones(bricks, pivots), in.motion.poses);
  in.world->setGravity(toBullet(environment.gravity));
  in.world->getSolverInfo().m_numIterations = settings.iterations;
  in.world->getSolverInfo().m_erp = settings.jointCorrection;
  in.world->getDispatchInfo().m_deterministicOverlappingPairs = true;
  for (const brick::Brick& brick : bricks) in.addBrick(brick, environment);
  in.placeBodies();
  for (const brick::Pivot& pivot : pivots) in.addPivot(pivot, environment);
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
        // From principal axes to the brick's axes.
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
  // Impulses of old contacts would change the start of the next solve.
  for (int k = 0; k < in.dispatcher.getNumManifolds(); ++k) {
    in.dispatcher.getManifoldByIndexInternal(k)->clearManifold();
  }
}

std::string bulletVersion() {
  return fmt::format("{}.{:02}", btGetVersion() / 100, btGetVersion() % 100);
}

// ------------------------------------------------------------------------------------------------
// Bullet's world of multibodies as a baseline, without collisions. Each brick is a base without
// links, so joint coordinates bring no advantage. The baseline exists because PyBullet, and so
// PyKirigami, uses this world. Projected Gauss-Seidel sweeps over all point joints hold the joints.

namespace {

// The impulse that a joint may take in a step is limited by default; ours is not.
constexpr double kLargestImpulse = 1e12;

/// Colliders, which Bullet needs to find connected bodies. They do not collide.
class UntouchedWorld : public btMultiBodyDynamicsWorld {
 public:
  using btMultiBodyDynamicsWorld::btMultiBodyDynamicsWorld;
  void performDiscreteCollisionDetection() override {}
};

class MultiBodyWorld : public BrickWorld {
 public:
  MultiBodyWorld(const std::vector<brick::Brick>& bricks, const Poses& start,
                 std::span<const brick::Pivot> pivots, const scene::Environment& environment,
                 int iterations) {
    world_.setGravity(toBullet(environment.gravity));
    world_.getSolverInfo().m_numIterations = iterations;
    for (const brick::Brick& brick : bricks) addBrick(brick, environment);
    MultiBodyWorld::writeMotion({start, std::vector<Velocity>(bricks.size())});
    for (const brick::Pivot& pivot : pivots) addPivot(pivot);
  }
  ~MultiBodyWorld() override {
    // A world does not remove multibodies and their joints itself.
    for (const auto& joint : joints_) world_.removeMultiBodyConstraint(joint.get());
    for (const auto& body : bodies_) world_.removeMultiBody(body.get());
  }
  MultiBodyWorld(const MultiBodyWorld&) = delete;
  MultiBodyWorld& operator=(const MultiBodyWorld&) = delete;

  void applyLoad(int brick, const Vector3& force, const Vector3& torque) override {
    bodies_[brick]->addBaseForce(toBullet(force));
    bodies_[brick]->addBaseTorque(toBullet(torque));
  }

  void advance(double step) override { world_.stepSimulation(step, 0); }

  void readMotion(Motion& motion) const override {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      const btMultiBody& body = *bodies_[k];
      motion.poses[k].position = fromBullet(body.getBasePos());
      motion.poses[k].rotation =
          fromBullet(body.getWorldToBaseRot().inverse()) * axes_[k].rotation.conjugate();
      motion.velocities[k] = {fromBullet(body.getBaseVel()), fromBullet(body.getBaseOmega())};
    }
  }

  void writeMotion(const Motion& motion) override {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      btMultiBody& body = *bodies_[k];
      body.setBasePos(toBullet(motion.poses[k].position));
      body.setWorldToBaseRot(toBullet(motion.poses[k].rotation * axes_[k].rotation).inverse());
      body.setBaseVel(toBullet(motion.velocities[k].linear));
      body.setBaseOmega(toBullet(motion.velocities[k].angular));
    }
  }

 private:
  void addBrick(const brick::Brick& brick, const scene::Environment& environment) {
    const PrincipalAxes& principal = axes_.emplace_back(principalAxes(brick));
    btMultiBody& body = *bodies_.emplace_back(
        // No links, the mass and principal inertia, no fixed base, no sleeping.
        std::make_unique<btMultiBody>(0, brick.mass, toBullet(principal.inertia), false, false));
    body.setLinearDamping(environment.linearDamping);
    body.setAngularDamping(environment.angularDamping);
    body.finalizeMultiDof();
    world_.addMultiBody(&body);
    btMultiBodyLinkCollider& collider =
        *colliders_.emplace_back(std::make_unique<btMultiBodyLinkCollider>(&body, -1));
    collider.setCollisionShape(&shape_);
    collider.setActivationState(DISABLE_DEACTIVATION);
    body.setBaseCollider(&collider);
    // Group and mask 0: no collisions.
    world_.addCollisionObject(&collider, 0, 0);
  }

  void addPivot(const brick::Pivot& pivot) {
    const Vector3 pointA = axes_[pivot.brickA].rotation.conjugate() * pivot.pointA;
    const Vector3 pointB = axes_[pivot.brickB].rotation.conjugate() * pivot.pointB;
    btMultiBodyPoint2Point& joint = *joints_.emplace_back(std::make_unique<btMultiBodyPoint2Point>(
        bodies_[pivot.brickA].get(), -1, bodies_[pivot.brickB].get(), -1, toBullet(pointA),
        toBullet(pointB)));
    joint.setMaxAppliedImpulse(kLargestImpulse);
    world_.addMultiBodyConstraint(&joint);
  }

  std::vector<PrincipalAxes> axes_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btSphereShape shape_{1e-3};
  std::vector<std::unique_ptr<btMultiBody>> bodies_;  // one per brick, in order
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<std::unique_ptr<btMultiBodyPoint2Point>> joints_;
  UntouchedWorld world_{&dispatcher_, &broadphase_, &solver_,
                        &configuration_};  // last: destroyed first
};

}  // namespace

std::unique_ptr<BrickWorld> makeMultiBodyWorld(const std::vector<brick::Brick>& bricks,
                                               const Poses& start,
                                               std::span<const brick::Pivot> pivots,
                                               const scene::Environment& environment,
                                               int iterations) {
  return std::make_unique<MultiBodyWorld>(bricks, start, pivots, environment, iterations);
}

// ------------------------------------------------------------------------------------------------
// A brick's hull moved inwards by a margin m (metres). Bullet's margin restores the size.
//
// Moving all faces inwards by m moves a vertex v of the bottom to v + m (d + n), with the tile's
// unit normal n and the vector d in the plane. d has the product 1 with the inward unit normals i_1
// and i_2 of both edges at v,
//   d = (i_1 + i_2) / (1 + i_1 . i_2)
// At a sharp corner |d| is large, and short edges could reverse. Their ends approach at the rate
// (d_k - d_(k+1)) . e, with the edge's unit direction e. This bounds m.

namespace {

// Half of Bullet's default margin of 0.04 m.
constexpr double kLargestMargin = 0.02;     // metres
constexpr double kMarginOfThickness = 0.2;  // three fifths of the thickness remain
constexpr double kLargestEdgeLoss = 0.5;    // of an edge's length

/// Displacement of each vertex of the bottom in the plane for a unit inset of the edges.
std::vector<Vector3> insetDirections(const brick::Brick& brick) {
  const std::size_t count = brick.bottom.size();
  std::vector<Vector3> inwards(count);
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 edge = brick.bottom[(k + 1) % count] - brick.bottom[k];
    inwards[k] = brick.normal.cross(edge).normalized();
  }
  std::vector<Vector3> directions(count);
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3& before = inwards[(k + count - 1) % count];
    // The vector in their plane that has the product 1 with both normals.
    directions[k] = (before + inwards[k]) / (1 + before.dot(inwards[k]));
  }
  return directions;
}

// The requested margin, or less if an edge would become too short.
double marginFor(const brick::Brick& brick, const std::vector<Vector3>& directions) {
  double margin = std::min(kLargestMargin, kMarginOfThickness * brick.thickness);
  const std::size_t count = brick.bottom.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t next = (k + 1) % count;
    const Vector3 edge = brick.bottom[next] - brick.bottom[k];
    const double lossRate = (directions[k] - directions[next]).dot(edge.normalized());
    // An edge between two obtuse outer corners can even grow.
    if (lossRate > 0) margin = std::min(margin, kLargestEdgeLoss * edge.norm() / lossRate);
  }
  return margin;
}

}  // namespace

double contactMargin(const brick::Brick& brick) {
  double margin = 0;
  for (const brick::BrickPiece& piece : brick::convexPieces(brick)) {
    margin = std::max(margin, insetHull(piece.shape).margin);
  }
  return margin;
}

InsetHull insetHull(const brick::Brick& brick) {
  const std::vector<Vector3> directions = insetDirections(brick);
  InsetHull hull;
  hull.margin = marginFor(brick, directions);
  for (std::size_t k = 0; k < brick.bottom.size(); ++k) {
    hull.points.emplace_back(brick.bottom[k] + hull.margin * (directions[k] + brick.normal));
  }
  for (std::size_t k = 0; k < brick.top.size(); ++k) {
    hull.points.emplace_back(brick.top[k] + hull.margin * (directions[k] - brick.normal));
  }
  return hull;
}

// ------------------------------------------------------------------------------------------------
// Zones around shared pivots in which Bullet's contact points are removed: balls around single
// pivots, capsules around hinge lines. They are in the axes of the pair's first brick, which moves
// with the pivot.

namespace {

// Rounded hulls touch up to a few margins away from a common corner.
constexpr double kMargins = 4;
// A twentieth of an edge is small against a tile.
constexpr double kEdges = 0.05;

// The larger of the two limits, metres.
double zoneRadius(const brick::Brick& a, const brick::Brick& b) {
  const double margin = std::max(contactMargin(a), contactMargin(b));
  return std::max(kMargins * margin, kEdges * 0.5 * (brick::meanEdge(a) + brick::meanEdge(b)));
}

}  // namespace

PivotZones::PivotZones(const std::vector<brick::Brick>& bricks,
                       std::span<const brick::Pivot> pivots) {
  for (const brick::Pivot& pivot : pivots) {
    if (pivot.joinsPoints()) add(bricks, pivot);
  }
}

void PivotZones::add(const std::vector<brick::Brick>& bricks, const brick::Pivot& pivot) {
  const bool swapped = pivot.brickB < pivot.brickA;
  const std::pair<int, int> pair = std::minmax(pivot.brickA, pivot.brickB);
  const Vector3& point = swapped ? pivot.pointB : pivot.pointA;
  std::vector<Zone>& zones = zones_[pair];
  // Both pivots of a hinge are adjacent in the list. The second extends the first to a line.
  if (!zones.empty() && zones.back().joint == pivot.joint) {
    zones.back().to = point;
    return;
  }
  zones.push_back({point, point, zoneRadius(bricks[pair.first], bricks[pair.second]), pivot.joint});
}

bool PivotZones::contains(int brickA, int brickB, const Poses& poses, const Vector3& point) const {
  const std::pair<int, int> pair = std::minmax(brickA, brickB);
  const auto found = zones_.find(pair);
  if (found == zones_.end()) return false;
  const Pose& pose = poses[pair.first];
  const Vector3 local = pose.rotation.conjugate() * (point - pose.position);
  return std::ranges::any_of(found->second, [&](const Zone& zone) {
    return (nearestOnSegment(local, zone.from, zone.to) - local).norm() <= zone.radius;
  });
}

}  // namespace kirireel::engines
