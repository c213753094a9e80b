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

#include <Eigen/Dense>
#include <fmt/format.h>

#include "render/fea/free_columns.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// How a tile's points follow its six displacements.
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

/// The nodes of joints, and those that tiles share with necks or each other.
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

/// Finds the displacements of tiles one by one.
class MotionFinder {
 public:
  explicit MotionFinder(const ElementMesh& mesh)
      : mesh_(mesh), isJoint_(jointNodesOf(mesh)), follows_(followers(mesh)) {}

  TileMotion of(int tile) const {
    const TileElements& elements = mesh_.tiles[tile];
    std::vector<int> apart;
    std::vector<int> leading;
    for (const int node : elements.bottom) {
      if (!follows_[node]) leading.push_back(node);
      if (!follows_[node] && !isJoint_[node]) apart.push_back(node);
    }
    for (const std::vector<int>& nodes : {apart, leading, leadingNodes(elements)}) {
      TileMotion motion;
      if (!choose(nodes, motion)) continue;
      for (NodeDisplacement& displacement : motion.displacements) displacement.tile = tile;
      return motion;
    }
    throw InputError(
        fmt::format("error: all nodes of tile {} follow joints, so nothing can hold or drive it; "
                    "use more elements per edge",
                    tile));
  }

 private:
  std::vector<int> leadingNodes(const TileElements& elements) const {
    std::vector<int> nodes;
    std::ranges::copy_if(elements.nodes, std::back_inserter(nodes),
                         [this](int node) { return !follows_[node]; });
    return nodes;
  }

  /// Whether six displacements of these nodes fix the tile: those that a pivoted QR factorisation
  /// of all their rows takes first.
  bool choose(const std::vector<int>& nodes, TileMotion& motion) const {
    if (nodes.size() < 3) return false;
    Eigen::AlignedBox3d box;
    for (const int node : nodes) box.extend(mesh_.nodes[node]);
    motion.centre = box.center();
    motion.size = 0.5 * box.sizes().norm();
    Eigen::Matrix<double, 6, Eigen::Dynamic> rows(6, 3 * nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      rows.middleCols<3>(static_cast<Eigen::Index>(3 * k)) =
          motion.motionOf(mesh_.nodes[nodes[k]]).transpose();
    }
    const bool isPlane = mesh_.rule.family == ElementFamily::Plane;
    if (isPlane) {
      for (std::size_t k = 0; k < nodes.size(); ++k) rows.col(3 * k + 2).setZero();
    }
    Eigen::ColPivHouseholderQR<Eigen::Matrix<double, 6, Eigen::Dynamic>> factors(rows);
    factors.setThreshold(1e-6);
    if (isPlane) {
      for (int k = 0; k < 3; ++k) {
        const int column = static_cast<int>(factors.colsPermutation().indices()[k]);
        motion.displacements.push_back({nodes[column / 3], column % 3});
      }
      return factors.rank() == 3;
    }
    if (factors.rank() < 6) return false;
    Matrix6 chosen;
    for (int k = 0; k < 6; ++k) {
      const int column = static_cast<int>(factors.colsPermutation().indices()[k]);
      motion.displacements.push_back({nodes[column / 3], column % 3});
      chosen.row(k) = rows.col(column).transpose();
    }
    motion.fromDisplacements = chosen.inverse();
    return true;
  }

  const ElementMesh& mesh_;
  std::vector<bool> isJoint_;
  std::vector<bool> follows_;
};

/// What a joint asks of two tiles.
PairEquations equationsOf(const ElementMesh& mesh, const JointNodes& joint,
                          const std::vector<TileMotion>& motions) {
  const auto at = [&](std::size_t k) {
    return Vector3(0.5 * (mesh.nodes[joint.a[k]] + mesh.nodes[joint.b[k]]));
  };
  const Vector3 bottom = at(0);
  const Vector3 top = at(joint.a.size() - 1);
  const bool isHinge = joint.a.size() > 1;
  const double size = 0.5 * (motions[joint.tileA].size + motions[joint.tileB].size);
  const auto rowsOf = [&](const TileMotion& motion, double sign) {
    PairEquations::Rows rows = PairEquations::Rows::Zero(isHinge ? 6 : 3, 6);
    rows.topRows<3>() = motion.motionOf(0.5 * (bottom + top));
    if (isHinge) {
      const Vector3 line = (top - bottom).normalized();
      rows.bottomRightCorner<3, 3>() = -size / motion.size * crossMatrix(line);
    }
    return PairEquations::Rows(sign * rows * motion.fromDisplacements);
  };
  return {joint.tileA, joint.tileB, rowsOf(motions[joint.tileA], 1),
          rowsOf(motions[joint.tileB], -1)};
}

/// How short the columns are that have nothing left.
double nothingLeft(const ElementMesh& mesh, const std::vector<TileMotion>& motions) {
  constexpr double kRounding = 1e-8;
  constexpr double kMost = 1e-3;
  const double least = std::ranges::min(motions, {}, &TileMotion::size).size;
  const auto unknowns = static_cast<double>(6 * motions.size());
  return std::min(kMost, std::sqrt(unknowns) * (kRounding + mesh.largestGap / least));
}

}  // namespace

std::vector<std::vector<NodeDisplacement>> tileDisplacements(const ElementMesh& mesh,
                                                             const std::vector<int>& tiles) {
  const MotionFinder finder(mesh);
  std::vector<std::vector<NodeDisplacement>> displacements;
  for (const int tile : tiles) displacements.push_back(finder.of(tile).displacements);
  return displacements;
}

std::vector<NodeDisplacement> leastSupports(const ElementMesh& mesh,
                                            const std::vector<int>& fixedTiles) {
  const MotionFinder finder(mesh);
  if (mesh.rule.joints == JointStyle::Neck) {
    if (!fixedTiles.empty()) return {};
    std::vector<NodeDisplacement> held = finder.of(0).displacements;
    std::ranges::sort(held);
    return held;
  }
  std::vector<TileMotion> motions;
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
    motions.push_back(finder.of(static_cast<int>(t)));
  }
  std::vector<PairEquations> equations;
  for (const JointNodes& joint : mesh.joints) {
    equations.push_back(equationsOf(mesh, joint, motions));
  }
  std::vector<bool> isFixed(motions.size());
  for (const int tile : fixedTiles) isFixed[tile] = true;
  std::vector<NodeDisplacement> held;
  for (const FreeColumn& column : freeColumns(static_cast<int>(motions.size()), equations, isFixed,
                                              nothingLeft(mesh, motions))) {
    held.push_back(motions[column.tile].displacements[column.unknown]);
  }
  std::ranges::sort(held);
  return held;
}

}  // namespace kirireel
