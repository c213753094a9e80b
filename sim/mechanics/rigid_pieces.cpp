// Rigid pieces. A piece P of bricks i with masses m_i, inertias I_i and positions r_i from its
// centre of mass has the mass sum m_i and the inertia
//   I = sum R_i I_i R_i^T - m_i [r_i]x [r_i]x .
// It moves with the momentum of its bricks, P = sum m_i v_i and L = sum m_i r_i x v_i + I_i w_i, so
// that v = P / m and w = I^-1 L. A load on brick i with the map G_i = [1, -[r_i]x; 0, 1] from the
// velocity of the piece to that of the brick counts as G_i^T f, G_i^T K G_i and G_i^T D G_i.
#include "sim/mechanics/rigid_pieces.h"

#include <algorithm>

#include "sim/base/disjoint_sets.h"

namespace kirireel::mechanics {
namespace {

/// The piece of each brick, numbered by the first brick of each.
std::vector<int> connectedPieces(std::size_t bricks,
                                 const std::vector<std::pair<int, int>>& pairs) {
  DisjointSets pieces(bricks);
  for (const auto& [a, b] : pairs) pieces.unite(a, b);
  return pieces.numbers();
}

}  // namespace

RigidPieces::RigidPieces(const std::vector<brick::Brick>& bricks, const Poses& poses,
                         const std::vector<std::pair<int, int>>& pairs)
    : bricks_(bricks), pieces_(connectedPieces(bricks.size(), pairs)), places_(poses) {
  const int count = pieces_.empty() ? 0 : 1 + *std::ranges::max_element(pieces_);
  bodies_.resize(count);
  start_.resize(count);
  for (brick::Brick& body : bodies_) {
    body.mass = 0;
    body.inertia.setZero();
  }
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    bodies_[pieces_[i]].mass += bricks[i].mass;
    start_[pieces_[i]].position += bricks[i].mass * poses[i].position;
  }
  for (int p = 0; p < count; ++p) start_[p].position /= bodies_[p].mass;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    places_[i].position -= start_[pieces_[i]].position;
    const Matrix3 turn = poses[i].rotation.toRotationMatrix();
    const Matrix3 arm = crossMatrix(places_[i].position);
    bodies_[pieces_[i]].inertia +=
        turn * bricks[i].inertia * turn.transpose() - bricks[i].mass * arm * arm;
  }
}

Motion RigidPieces::motionOf(const Motion& ofBricks, bool planar) const {
  Motion motion = {start_, std::vector<Velocity>(bodies_.size())};
  std::vector<Vector3> spins(bodies_.size(), Vector3::Zero());
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const auto& [linear, angular] = ofBricks.velocities[i];
    const Quaternion& turn = ofBricks.poses[i].rotation;
    motion.velocities[pieces_[i]].linear += bricks_[i].mass * linear;
    spins[pieces_[i]] += bricks_[i].mass * places_[i].position.cross(linear) +
                         turn * (bricks_[i].inertia * (turn.conjugate() * angular));
  }
  for (std::size_t p = 0; p < bodies_.size(); ++p) {
    motion.velocities[p].linear /= bodies_[p].mass;
    motion.velocities[p].angular = planar ? Vector3(0, 0, spins[p].z() / bodies_[p].inertia(2, 2))
                                          : Vector3(bodies_[p].inertia.llt().solve(spins[p]));
  }
  return motion;
}

Poses RigidPieces::posesOfBricks(const Poses& ofPieces) const {
  Poses poses = places_;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose& piece = ofPieces[pieces_[i]];
    poses[i] = {piece.apply(places_[i].position),
                (piece.rotation * places_[i].rotation).normalized()};
  }
  return poses;
}

Motion RigidPieces::motionOfBricks(const Motion& ofPieces) const {
  Motion motion = {posesOfBricks(ofPieces.poses), std::vector<Velocity>(bricks_.size())};
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const auto& [linear, angular] = ofPieces.velocities[pieces_[i]];
    const Vector3 arm = motion.poses[i].position - ofPieces.poses[pieces_[i]].position;
    motion.velocities[i] = {linear + angular.cross(arm), angular};
  }
  return motion;
}

std::vector<brick::Load> RigidPieces::loadsOnPieces(
    const Poses& ofPieces, const std::vector<brick::Load>& onBricks) const {
  std::vector<brick::Load> loads(bodies_.size());
  for (std::size_t i = 0; i < onBricks.size(); ++i) {
    Matrix6 map = Matrix6::Identity();
    map.topRightCorner<3, 3>() = -crossMatrix(ofPieces[pieces_[i]].rotation * places_[i].position);
    brick::Load& load = loads[pieces_[i]];
    load.force += map.transpose() * onBricks[i].force;
    load.stiffness += map.transpose() * onBricks[i].stiffness * map;
    load.damping += map.transpose() * onBricks[i].damping * map;
  }
  return loads;
}

void PieceContacts::startStep(const Poses& start) {
  inStep_.clear();
  source_.startStep(pieces_.posesOfBricks(start));
}

double PieceContacts::appendViolated(const Poses& end, std::vector<brick::Contact>& contacts) {
  std::vector<brick::Contact> found;
  source_.appendViolated(pieces_.posesOfBricks(end), found);
  for (const brick::Contact& contact : found) {
    const bool isWithin = brick::isBrick(contact.brickA) && brick::isBrick(contact.brickB) &&
                          pieces_.pieceOf(contact.brickA) == pieces_.pieceOf(contact.brickB);
    if (isWithin) continue;
    inStep_.push_back(ofPieces(contact));
    given_.emplace_back(inStep_.back(), contact);
    contacts.push_back(inStep_.back());
  }
  double overlap = 0;
  for (const brick::Contact& contact : inStep_) {
    overlap = std::max(overlap, -brick::contactGap(contact, end));
  }
  return overlap;
}

bool PieceContacts::isCurrent(const brick::Contact& contact) const {
  const auto known =
      std::ranges::find_if(given_, [&](const auto& both) { return both.first == contact; });
  return known != given_.end() && source_.isCurrent(known->second);
}

void PieceContacts::appendRegion(const brick::Contact& contact,
                                 std::vector<brick::Contact>& contacts) {
  const auto known =
      std::ranges::find_if(given_, [&](const auto& both) { return both.first == contact; });
  if (known == given_.end()) return;
  std::vector<brick::Contact> found;
  source_.appendRegion(known->second, found);
  for (const brick::Contact& ofBricks : found) {
    contacts.push_back(ofPieces(ofBricks));
    given_.emplace_back(contacts.back(), ofBricks);
  }
}

/// A contact of bricks in the axes of their pieces.
brick::Contact PieceContacts::ofPieces(brick::Contact contact) const {
  if (brick::isBrick(contact.brickA)) {
    const Pose& place = pieces_.placeInPiece(contact.brickA);
    contact.pointA = place.apply(contact.pointA);
    contact.edgeA = place.rotation * contact.edgeA;
    contact.brickA = pieces_.pieceOf(contact.brickA);
  }
  if (brick::isBrick(contact.brickB)) {
    const Pose& place = pieces_.placeInPiece(contact.brickB);
    contact.pointB = place.apply(contact.pointB);
    contact.normal = place.rotation * contact.normal;
    contact.brickB = pieces_.pieceOf(contact.brickB);
  }
  return contact;
}

}  // namespace kirireel::mechanics
