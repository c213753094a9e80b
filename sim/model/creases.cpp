// Joints from edges, and edges from joints.
//
// 1. *Joints.* All corners at one vertex are one, unless a cut edge ends there. Then the corners
//    are parted into groups that the vertex's other edges hold together (two faces with a common
//    uncut edge are in one group), and each group is a chain of joints of its own.
// 2. *Folding.* A face is placed by an isometry T of the flat sheet. Across an edge with the fold
//    angle a (radians) its neighbour is placed by
//   T' = T P R(-a, e) P^-1
// where P moves the origin to a point of the edge, and R(-a, e) turns by -a about the edge's
// direction e, with the first face on its left seen from above. A positive angle so lifts the
// neighbour, on the right of e, to the upper side: a valley. The faces are walked outwards from one
// face of each piece. Loops of edges are not checked here: where angles do not fit each other, the
// joints of the last edge in a loop stand open, and the caller measures that.
// 3. *Angles* of a folded state: a = -atan2((n x n') . e, n . n'), n and n' the unit normals of
//    both faces; atan2 keeps its digits near 0 and near 180 degrees, where an arc cosine would lose
//    half of them.
//
// The format: E. D. Demaine, J. S. Ku, R. J. Lang, A new file standard to represent folded
// structures, Fall Workshop on Computational Geometry, 2016.
#include "sim/model/creases.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace kirireel {
namespace {

using Ends = std::pair<int, int>;  // vertex numbers, the smaller first

// Below this angle, degrees, an edge is flat.
constexpr double kFlatEdge = 1e-6;

/// A side of a face: corner k and the next.
struct FaceSide {
  int face = 0;
  int corner = 0;
};

// A std::map keeps the edges in the order of their vertex numbers, so that results do not depend on
// addresses or hashes.
std::map<Ends, std::vector<FaceSide>> sidesByEnds(const CornerNumbers& faces) {
  std::map<Ends, std::vector<FaceSide>> sides;
  for (int face = 0; face < std::ssize(faces); ++face) {
    const int count = static_cast<int>(faces[face].size());
    for (int k = 0; k < count; ++k) {
      sides[std::minmax(faces[face][k], faces[face][(k + 1) % count])].push_back({face, k});
    }
  }
  return sides;
}

const Vector3& startOf(const std::vector<Tile>& tiles, const FaceSide& side) {
  return tiles[side.face].vertices[side.corner];
}

const Vector3& endOf(const std::vector<Tile>& tiles, const FaceSide& side) {
  const std::vector<Vector3>& vertices = tiles[side.face].vertices;
  return vertices[(side.corner + 1) % vertices.size()];
}

using FacePairs = std::vector<std::pair<int, int>>;

/// Which faces uncut edges hold together.
struct HeldFaces {
  std::map<int, FacePairs> atVertex;    ///< hinged at this vertex, by an edge that ends there
  std::set<std::pair<int, int>> fixed;  ///< joined to one piece, the smaller number first
};

// Goes through all edges that two faces or more share and no cut parts.
HeldFaces heldFaces(const CornerNumbers& faces, const std::map<Ends, char>& assignments) {
  HeldFaces held;
  for (const auto& [ends, sides] : sidesByEnds(faces)) {
    const auto found = assignments.find(ends);
    const char assignment = found == assignments.end() ? 'U' : found->second;
    // An edge of three faces or more holds each with the next.
    for (std::size_t k = 1; k < sides.size() && assignment != 'C'; ++k) {
      const std::pair<int, int> two = std::minmax(sides[k - 1].face, sides[k].face);
      held.atVertex[ends.first].push_back(two);
      held.atVertex[ends.second].push_back(two);
      if (assignment == 'J' && two.first != two.second) held.fixed.insert(two);
    }
  }
  return held;
}

// Corners of the faces at each vertex, by rising face.
std::map<int, std::vector<Corner>> cornersByVertex(const CornerNumbers& faces) {
  std::map<int, std::vector<Corner>> corners;
  for (int face = 0; face < std::ssize(faces); ++face) {
    for (int k = 0; k < std::ssize(faces[face]); ++k) corners[faces[face][k]].push_back({face, k});
  }
  return corners;
}

/// Corners at one vertex in groups that its uncut edges hold together, by their faces.
std::vector<std::vector<Corner>> groupsAt(const std::vector<Corner>& corners,
                                          const FacePairs& held) {
  std::vector<std::size_t> group(corners.size());
  std::iota(group.begin(), group.end(), 0);
  const auto placeOf = [&](int face) {
    return static_cast<std::size_t>(
        std::find_if(corners.begin(), corners.end(),
                     [face](const Corner& corner) { return corner.tile == face; }) -
        corners.begin());
  };
  for (const auto& [a, b] : held) {
    const std::size_t kept = group[placeOf(a)], lost = group[placeOf(b)];
    // A vertex has few corners, so that renaming a group is cheaper than a tree of sets.
    std::replace(group.begin(), group.end(), lost, kept);
  }
  std::map<std::size_t, std::vector<Corner>> groups;
  for (std::size_t k = 0; k < corners.size(); ++k) groups[group[k]].push_back(corners[k]);
  std::vector<std::vector<Corner>> result;
  for (auto& [number, members] : groups) result.push_back(std::move(members));
  return result;
}

}  // namespace

// Joints come by rising vertex number, and fixed joints after them.
std::vector<Joint> jointsOfCreases(const CornerNumbers& faces, const std::vector<Crease>& creases,
                                   const std::vector<Tile>& tiles) {
  std::map<Ends, char> assignments;
  std::set<int> cutAt;  // vertices
  for (const Crease& crease : creases) {
    assignments[std::minmax(crease.from, crease.to)] = crease.assignment;
    if (crease.assignment == 'C') cutAt.insert({crease.from, crease.to});
  }
  const HeldFaces held = heldFaces(faces, assignments);
  std::vector<Joint> joints;
  for (const auto& [vertex, corners] : cornersByVertex(faces)) {
    const auto pairs = held.atVertex.find(vertex);
    const bool isCut = cutAt.contains(vertex);
    const auto groups =
        !isCut ? std::vector<std::vector<Corner>>{corners}
               : groupsAt(corners, pairs == held.atVertex.end() ? FacePairs{} : pairs->second);
    for (const std::vector<Corner>& group : groups) {
      for (std::size_t k = 1; k < group.size(); ++k) {
        const std::pair<int, int> two = std::minmax(group[k - 1].tile, group[k].tile);
        // A joint within one tile says nothing, and one within a rigid piece is held by the fixed
        // joint.
        if (two.first == two.second || held.fixed.contains(two)) continue;
        joints.push_back({group[k - 1], group[k], JointFace::Bottom});
      }
    }
  }
  for (const auto& [a, b] : held.fixed) joints.push_back(makeFixedJoint(tiles, a, b));
  return joints;
}

// Depth first from the lowest face of each piece; a face is placed by the first edge that reaches
// it.
std::optional<std::vector<Tile>> foldedTiles(const CornerNumbers& faces,
                                             const std::vector<Crease>& creases,
                                             const std::vector<Tile>& tiles) {
  std::map<Ends, double> angles;
  bool folds = false;
  for (const Crease& crease : creases) {
    // These have one face at each side, so that nothing turns about them.
    if (crease.assignment == 'C' || crease.assignment == 'B') continue;
    const double angle = crease.foldAngle.value_or(0);
    angles[std::minmax(crease.from, crease.to)] = angle;
    folds = folds || std::abs(angle) > kFlatEdge;
  }
  if (!folds) return std::nullopt;
  const auto sides = sidesByEnds(faces);
  std::vector<std::optional<Eigen::Isometry3d>> placed(faces.size());
  for (std::size_t root = 0; root < faces.size(); ++root) {
    if (placed[root]) continue;
    placed[root] = Eigen::Isometry3d::Identity();
    std::vector<int> waiting = {static_cast<int>(root)};
    while (!waiting.empty()) {
      const int face = waiting.back();
      waiting.pop_back();
      const int count = static_cast<int>(faces[face].size());
      for (int k = 0; k < count; ++k) {
        const Ends ends = std::minmax(faces[face][k], faces[face][(k + 1) % count]);
        const auto angle = angles.find(ends);
        if (angle == angles.end()) continue;
        for (const FaceSide& other : sides.at(ends)) {
          // Each face is placed once, by the first path that reaches it.
          if (placed[other.face]) continue;
          const FaceSide own{face, k};
          // Along the edge with this face on the left, seen from above.
          const double sense = tileNormal(tiles[face]).z() > 0 ? 1 : -1;
          const Vector3 along = sense * (endOf(tiles, own) - startOf(tiles, own)).normalized();
          const Vector3& hinge = startOf(tiles, own);
          Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
          turn.translate(hinge);
          turn.rotate(Eigen::AngleAxisd(-angle->second * kDegree, along));
          turn.translate(-hinge);
          placed[other.face] = *placed[face] * turn;
          waiting.push_back(other.face);
        }
      }
    }
  }
  std::vector<Tile> folded = tiles;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (Vector3& vertex : folded[face].vertices) vertex = *placed[face] * vertex;
  }
  return folded;
}

std::vector<Crease> creasesOf(const CornerNumbers& faces, const std::vector<Tile>& state) {
  std::vector<Crease> creases;
  for (const auto& [ends, both] : sidesByEnds(faces)) {
    Crease& crease = creases.emplace_back(Crease{ends.first, ends.second, 'B', {}});
    // A boundary edge has no angle.
    if (both.size() == 1) continue;
    const FaceSide &first = both[0], &second = both[1];
    const Vector3 along = (endOf(state, first) - startOf(state, first)).normalized();
    const Vector3 normal = tileNormal(state[first.face]);
    // Faces of one sense run along their common edge in opposite directions.
    const bool isAlike = faces[first.face][first.corner] != faces[second.face][second.corner];
    const Vector3 other = (isAlike ? 1 : -1) * tileNormal(state[second.face]);
    const double angle = -std::atan2(normal.cross(other).dot(along), normal.dot(other)) / kDegree;
    crease.foldAngle = std::abs(angle) > kFlatEdge ? angle : 0;
    crease.assignment = *crease.foldAngle > 0 ? 'V' : *crease.foldAngle < 0 ? 'M' : 'F';
  }
  return creases;
}

}  // namespace kirireel
