// Let the unknowns be six displacements u_t of nodes of each tile t, which fix it as a rigid body.
// A point p of the tile then moves by R(p) B_t^-1 u_t, where R(p) = [1, -[p - c]x] maps velocity
// and spin to the point and B_t holds the rows of R that belong to u_t. A joint asks that two tiles
// move alike at its points: J u = 0. What J leaves free is the null space of M = J^T J.
//
// A symmetric elimination M = L D L^T meets a zero pivot exactly where an unknown can be chosen
// freely, given those before it: holding just these unknowns makes M regular, and their number is
// the nullity (C. Farhat, M. Geradin, On the general solution by a direct method of a large-scale
// singular system of linear equations, Int. J. Numer. Meth. Engng. 41, 1998). A shift of 1e-13
// keeps the elimination running past such a pivot.
#include "render/fea/supports.h"

#include <algorithm>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// Both are parts of the largest diagonal entry.
constexpr double kShift = 1e-14;
constexpr double kZeroPivot = 1e-6;

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

/// The matrix M of all joints.
Sparse jointMatrix(const ElementMesh& mesh, const std::vector<TileMotion>& motions) {
  std::vector<Eigen::Triplet<double>> entries;
  int row = 0;
  for (const JointNodes& joint : mesh.joints) {
    // Points between the two faces say nothing new, and one face has a single point.
    for (std::size_t k = 0; k < joint.a.size(); k += std::max<std::size_t>(joint.a.size() - 1, 1)) {
      const Vector3 point = 0.5 * (mesh.nodes[joint.a[k]] + mesh.nodes[joint.b[k]]);
      for (const auto& [tile, sign] : {std::pair{joint.tileA, 1.0}, {joint.tileB, -1.0}}) {
        const TileMotion& motion = motions[tile];
        const Eigen::Matrix<double, 3, 6> block =
            sign * motion.motionOf(point) * motion.fromDisplacements;
        for (int axis = 0; axis < 3; ++axis) {
          for (int c = 0; c < 6; ++c)
            entries.emplace_back(row + axis, 6 * tile + c, block(axis, c));
        }
      }
      row += 3;
    }
  }
  Sparse jacobian(row, static_cast<Eigen::Index>(6 * motions.size()));
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian.transpose() * jacobian;
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
  Sparse matrix = jointMatrix(mesh, motions);
  const double largest = mesh.joints.empty() ? 1 : matrix.diagonal().maxCoeff();
  for (const int tile : fixedTiles) {
    for (int k = 0; k < 6; ++k) matrix.coeffRef(6 * tile + k, 6 * tile + k) += largest;
  }
  Sparse identity(matrix.rows(), matrix.cols());
  identity.setIdentity();
  const Eigen::SimplicialLDLT<Sparse> factors(Sparse(matrix + kShift * largest * identity));
  const Eigen::VectorXd pivots = factors.vectorD();
  std::vector<NodeDisplacement> held;
  for (Eigen::Index k = 0; k < pivots.size(); ++k) {
    const auto place = factors.permutationP().indices()[k];
    if (pivots[place] > kZeroPivot * largest) continue;
    held.push_back(motions[k / 6].displacements[k % 6]);
  }
  std::ranges::sort(held);
  return held;
}

}  // namespace kirireel
