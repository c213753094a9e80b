// Let the unknowns be six displacements u_t of nodes of each tile t, which fix it as a rigid body.
// A point p of the tile then moves by R(p) B_t^-1 u_t, where R(p) = [1, -[p - c]x] maps velocity
// and spin to the point and B_t holds the rows of R that belong to u_t. A joint asks that two tiles
// move alike at its middle and, where it goes through the thickness along d, that they turn its
// line alike, s w x d with a length s of the tiles' size: J u = 0. (Two points a thickness apart
// would ask the same, but of thin bricks so softly that what they hold looks free.)
//
// What J leaves free is the first-order motions of rigid tiles. free_columns.h finds as many
// unknowns as there are of them, and holding these leaves none (compare C. Farhat, M. Geradin, On
// the general solution by a direct method of a large-scale singular system of linear equations,
// Int. J. Numer. Meth. Engng. 41, 1998).
//
// Elimination leaves of a column |J u| for a motion u with this unknown at 1. For a motion that
// strains nothing that is rounding times |u|; where corners that meet are g apart, J is wrong by
// g / s, and it is up to g / s |u|. |u| is about the root of the number of unknowns n. Free is
// hence what lies below root(n) (1e-8 + g / s), but never above 1e-3: a motion that opens joints by
// more than a thousandth of what it moves is none of a mechanism, whatever g.
#include "render/fea/supports.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "render/fea/free_columns.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// How a tile's points follow its six displacements. Spins are multiplied by `size`, so that all
/// six unknowns are lengths and rows compare.
struct TileMotion {
  std::vector<NodeDisplacement> displacements;
  Vector3 centre;
  double size = 1;  ///< metres, by which spins are scaled
  Matrix6 fromDisplacements;

  /// The rows of velocity and spin that make the motion of a point.
  Eigen::Matrix<double, 3, 6> motionOf(const Vector3& point) const {
    Eigen::Matrix<double, 3, 6> rows;
    rows << Matrix3::Identity(), -crossMatrix(point - centre) / size;
    return rows;
  }
};

/// The nodes of joints, and those that tiles share with necks or each other. A node that a second
/// part uses is one of these.
std::vector<bool> jointNodesOf(const ElementMesh& mesh) {
  std::vector<bool> isJoint(mesh.nodes.size());
  std::vector<bool> isUsed(mesh.nodes.size());
  for (const auto* parts : {&mesh.tiles, &mesh.necks}) {
    for (const TileElements& part : *parts) {
      for (const int node : part.nodes) {
        if (isUsed[node]) isJoint[node] = true;
        isUsed[node] = true;
      }
    }
  }
  for (const JointNodes& joint : mesh.joints) {
    for (const int node : joint.a) isJoint[node] = true;
    for (const int node : joint.b) isJoint[node] = true;
  }
  return isJoint;
}

/// Whether six displacements fix a tile whatever its turn: their equations' least singular value,
/// with spins scaled by the tile's size. What falls below is driven by nine.
constexpr double kLeastGrip = 0.1;
/// So many of a tile's turns are looked at.
constexpr std::size_t kTurnsLookedAt = 24;

/// Evenly spread, the first and the last among them.
std::vector<Matrix3> someOf(const std::vector<Quaternion>& turns) {
  std::vector<Matrix3> some;
  const std::size_t step = turns.size() / kTurnsLookedAt + 1;
  for (std::size_t k = 0; k < turns.size(); k += step) some.push_back(turns[k].toRotationMatrix());
  if (!turns.empty()) some.push_back(turns.back().toRotationMatrix());
  return some;
}

/// Finds the displacements of tiles one by one.
class MotionFinder {
 public:
  explicit MotionFinder(const ElementMesh& mesh)
      : mesh_(mesh), isJoint_(jointNodesOf(mesh)), follows_(followers(mesh)) {}

  /// Tries, in this order, nodes of the bottom that no joint touches, all of the bottom that lead,
  /// and all of the tile: displacements at joints would act on the neighbours at first hand.
  TileMotion of(int tile, const std::vector<Quaternion>& turns = {}) const {
    const TileElements& elements = mesh_.tiles[tile];
    std::vector<int> apart;
    std::vector<int> leading;
    for (const int node : elements.bottom) {
      if (!follows_[node]) leading.push_back(node);
      if (!follows_[node] && !isJoint_[node]) apart.push_back(node);
    }
    for (const std::vector<int>& nodes : {apart, leading, leadingNodes(elements)}) {
      TileMotion motion;
      if (!choose(nodes, Matrix3::Identity(), motion)) continue;
      if (!turns.empty()) keepGrip(nodes, someOf(turns), motion);
      for (NodeDisplacement& displacement : motion.displacements) displacement.tile = tile;
      return motion;
    }
    throw InputError(
        fmt::format("error: all nodes of tile {} follow joints, so nothing can hold or drive it; "
                    "use more elements per edge",
                    tile + mesh_.rule.countsFrom));
  }

 private:
  std::vector<int> leadingNodes(const TileElements& elements) const {
    std::vector<int> nodes;
    std::ranges::copy_if(elements.nodes, std::back_inserter(nodes),
                         [this](int node) { return !follows_[node]; });
    return nodes;
  }

  bool isPlane() const { return mesh_.rule.family == ElementFamily::Plane; }

  /// Whether displacements of these nodes fix the tile when it is turned so: those that a pivoted
  /// QR factorisation of all their rows takes first. Column k of the 6 x 3n matrix is what one
  /// displacement of one node sees of the tile's six motions. The first six pivots are the
  /// best-conditioned that a greedy choice finds.
  bool choose(const std::vector<int>& nodes, const Matrix3& turn, TileMotion& motion) const {
    if (nodes.size() < 3) return false;
    Eigen::AlignedBox3d box;
    for (const int node : nodes) box.extend(mesh_.nodes[node]);
    motion.centre = box.center();
    motion.size = 0.5 * box.sizes().norm();
    Eigen::Matrix<double, 6, Eigen::Dynamic> rows(6, 3 * nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      auto own = rows.middleCols<3>(static_cast<Eigen::Index>(3 * k));
      own = motion.motionOf(turned(nodes[k], turn, motion)).transpose();
      // Plane elements have no displacement along z.
      if (isPlane()) own.col(2).setZero();
    }
    Eigen::ColPivHouseholderQR<Eigen::Matrix<double, 6, Eigen::Dynamic>> factors(rows);
    // Relative to the largest pivot: nodes in one line give rank 5.
    factors.setThreshold(1e-6);
    const int count = isPlane() ? 3 : 6;
    if (factors.rank() < count) return false;
    motion.displacements.clear();
    for (int k = 0; k < count; ++k) {
      const int column = static_cast<int>(factors.colsPermutation().indices()[k]);
      motion.displacements.push_back({nodes[column / 3], column % 3});
    }
    if (!isPlane()) motion.fromDisplacements = rowsOf(motion, turn).inverse();
    return true;
  }

  /// Where a node is when the tile is turned about its centre.
  Vector3 turned(int node, const Matrix3& turn, const TileMotion& motion) const {
    return motion.centre + turn * (mesh_.nodes[node] - motion.centre);
  }

  /// The rows of a motion's displacements.
  Eigen::MatrixXd rowsOf(const TileMotion& motion, const Matrix3& turn) const {
    Eigen::MatrixXd rows(motion.displacements.size(), 6);
    for (std::size_t k = 0; k < motion.displacements.size(); ++k) {
      const NodeDisplacement& one = motion.displacements[k];
      rows.row(static_cast<Eigen::Index>(k)) =
          motion.motionOf(turned(one.node, turn, motion)).row(one.axis);
    }
    return rows;
  }

  /// How well displacements fix the tile in the worst of its turns. The least singular value of the
  /// rows. 1 would be six displacements as good as velocity and spin themselves; 0 is a motion that
  /// none of them sees.
  double gripOf(const TileMotion& motion, const std::vector<Matrix3>& turns) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Matrix3& turn : turns) {
      const Eigen::VectorXd values = rowsOf(motion, turn).jacobiSvd().singularValues();
      least = std::min(least, values[isPlane() ? 2 : 5]);
    }
    return least;
  }

  /// Replaces displacements that a turn makes useless (all in one line with what they should stop)
  /// by those that suit another turn and all others, or else by all of three nodes. Tries the best
  /// choice for each turn in turn and keeps the one that is best in its worst.
  void keepGrip(const std::vector<int>& nodes, const std::vector<Matrix3>& turns,
                TileMotion& motion) const {
    double best = gripOf(motion, turns);
    for (const Matrix3& turn : turns) {
      if (best >= kLeastGrip) return;
      TileMotion other;
      if (!choose(nodes, turn, other)) continue;
      const double grip = gripOf(other, turns);
      if (grip > best) motion = other;
      best = std::max(best, grip);
    }
    if (best < kLeastGrip) motion.displacements = allOfThree(nodes);
  }

  /// All displacements of a node, the one farthest from it, and the one farthest from their line.
  std::vector<NodeDisplacement> allOfThree(const std::vector<int>& nodes) const {
    const auto farthest = [&](const auto& distance) {
      return *std::ranges::max_element(nodes, {},
                                       [&](int node) { return distance(mesh_.nodes[node]); });
    };
    const Vector3& start = mesh_.nodes[nodes[0]];
    const int first = farthest([&](const Vector3& at) { return (at - start).norm(); });
    const Vector3& from = mesh_.nodes[first];
    const int second = farthest([&](const Vector3& at) { return (at - from).norm(); });
    const Vector3 along = mesh_.nodes[second] - from;
    const int third = farthest([&](const Vector3& at) { return (at - from).cross(along).norm(); });
    std::vector<NodeDisplacement> all;
    for (const int node : {first, second, third}) {
      for (int axis = 0; axis < (isPlane() ? 2 : 3); ++axis) all.push_back({node, axis});
    }
    return all;
  }

  const ElementMesh& mesh_;
  std::vector<bool> isJoint_;
  std::vector<bool> follows_;
};

/// The normal of a tile's bottom, by its first element.
Vector3 normalOf(const ElementMesh& mesh, const TileElements& tile) {
  const auto at = [&](int k) { return mesh.nodes[mesh.elements[tile.firstElement].nodes[k]]; };
  return (at(2) - at(0)).cross(at(3) - at(1)).normalized();
}

/// What a joint asks of two tiles.
PairEquations equationsOf(const ElementMesh& mesh, const JointNodes& joint,
                          const std::vector<TileMotion>& motions) {
  // The middle between both tiles' nodes: where a gap is left the joint is thought halfway.
  const auto at = [&](std::size_t k) {
    return Vector3(0.5 * (mesh.nodes[joint.a[k]] + mesh.nodes[joint.b[k]]));
  };
  const Vector3 bottom = at(0);
  const Vector3 top = at(joint.a.size() - 1);
  // A shell's joint has one node; its line is the tile's normal.
  const Vector3 line = joint.a.size() > 1 ? Vector3((top - bottom).normalized())
                                          : normalOf(mesh, mesh.tiles[joint.tileA]);
  const double size = 0.5 * (motions[joint.tileA].size + motions[joint.tileB].size);
  const auto rowsOf = [&](const TileMotion& motion, double sign) {
    PairEquations::Rows rows = PairEquations::Rows::Zero(joint.isHinge ? 6 : 3, 6);
    rows.topRows<3>() = motion.motionOf(0.5 * (bottom + top));
    if (joint.isHinge) {
      // s (w x d): a turn about d itself drops out, so that these three rows have rank 2.
      rows.bottomRightCorner<3, 3>() = -size / motion.size * crossMatrix(line);
    }
    return PairEquations::Rows(sign * rows * motion.fromDisplacements);
  };
  return {joint.tileA, joint.tileB, rowsOf(motions[joint.tileA], 1),
          rowsOf(motions[joint.tileB], -1)};
}

/// What ties ask of tiles while control nodes rest; one body alone where `motions` has one. u_node
/// = u_leader, since the control nodes stand still.
std::vector<PairEquations> tieEquations(const ElementMesh& mesh,
                                        const std::vector<TileMotion>& motions) {
  std::vector<int> owner(mesh.nodes.size());
  for (std::size_t t = 0; t < mesh.tiles.size() && motions.size() > 1; ++t) {
    for (const int node : mesh.tiles[t].nodes) owner[node] = static_cast<int>(t);
  }
  std::vector<PairEquations> equations;
  for (const PeriodicTie& tie : mesh.ties) {
    const auto rowsOf = [&](int node, double sign) {
      const TileMotion& motion = motions[owner[node]];
      return PairEquations::Rows(sign * motion.motionOf(mesh.nodes[node]) *
                                 motion.fromDisplacements);
    };
    equations.push_back(
        {owner[tie.node], owner[tie.leader], rowsOf(tie.node, 1), rowsOf(tie.leader, -1)});
  }
  return equations;
}

/// Whether springs stand wherever tiles turn against each other, so that no mechanism is left.
bool hasSpringsEverywhere(const ElementMesh& mesh) {
  std::vector<bool> hasSpring(mesh.clusters.size());
  for (const PatchSpring& spring : mesh.springs) hasSpring[spring.cluster] = true;
  return !mesh.springs.empty() && std::ranges::find(hasSpring, false) == hasSpring.end();
}

/// How short the columns are that have nothing left. As said at the head of the file: min(1e-3,
/// sqrt(n) (1e-8 + g / s)).
double nothingLeft(const ElementMesh& mesh, const std::vector<TileMotion>& motions) {
  constexpr double kRounding = 1e-8;
  constexpr double kMost = 1e-3;
  const double least = std::ranges::min(motions, {}, &TileMotion::size).size;
  const auto unknowns = static_cast<double>(6 * motions.size());
  return std::min(kMost, std::sqrt(unknowns) * (kRounding + mesh.largestGap / least));
}

}  // namespace

std::vector<std::vector<NodeDisplacement>> tileDisplacements(
    const ElementMesh& mesh, const std::vector<int>& tiles,
    const std::vector<std::vector<Quaternion>>& turns) {
  const MotionFinder finder(mesh);
  std::vector<std::vector<NodeDisplacement>> displacements;
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    displacements.push_back(
        (turns.empty() ? finder.of(tiles[k]) : finder.of(tiles[k], turns[k])).displacements);
  }
  return displacements;
}

std::vector<NodeDisplacement> leastSupports(const ElementMesh& mesh,
                                            const std::vector<int>& fixedTiles) {
  const MotionFinder finder(mesh);
  const bool isOneBody = mesh.rule.joints == JointStyle::Neck || hasSpringsEverywhere(mesh);
  // One body that a fixed tile holds already needs no more.
  if (isOneBody && !fixedTiles.empty()) return {};
  std::vector<NodeDisplacement> held;
  if (isOneBody && mesh.ties.empty()) {
    // Six displacements of any one tile hold a body.
    held = finder.of(0).displacements;
    std::ranges::sort(held);
    return held;
  }
  // A plane sheet whose ends are tied cannot turn: two displacements are left.
  if (mesh.rule.family == ElementFamily::Plane) {
    const NodeDisplacement first = finder.of(0).displacements[0];
    return {{first.node, 0, 0}, {first.node, 1, 0}};
  }
  std::vector<TileMotion> motions;
  for (std::size_t t = 0; t < (isOneBody ? 1 : mesh.tiles.size()); ++t) {
    motions.push_back(finder.of(static_cast<int>(t)));
  }
  std::vector<PairEquations> equations = tieEquations(mesh, motions);
  for (const JointNodes& joint : mesh.joints) {
    if (!isOneBody) equations.push_back(equationsOf(mesh, joint, motions));
  }
  std::vector<bool> isFixed(motions.size());
  for (const int tile : fixedTiles) isFixed[tile] = true;
  for (const FreeColumn& column : freeColumns(static_cast<int>(motions.size()), equations, isFixed,
                                              nothingLeft(mesh, motions))) {
    held.push_back(motions[column.tile].displacements[column.unknown]);
  }
  std::ranges::sort(held);
  return held;
}

}  // namespace kirireel
