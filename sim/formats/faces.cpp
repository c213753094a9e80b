// Faces as tiles.
//
// Joining. Each face gives its directed edges. An edge between two joined faces occurs in both
// directions, and the two cancel. The rest is the outline: one closed polygon if each of its
// vertices has one edge in and one out.
//
// Faces of a drawing. Each edge is two half-edges. At each vertex the outgoing half-edges are
// sorted by angle. After the half-edge u -> v, the face on its left continues with the half-edge
// that follows v -> u clockwise at v. A traversal until the first half-edge returns gives one face.
// Its area is positive, except for the outside of each connected part of the drawing. Each
// half-edge is visited once, so all faces cost O(n log n) for n edges.
//
// Sheet and holes. A region next to the outside is sheet. From there on, a boundary edge (B)
// separates sheet and hole, and any other edge has the same on both sides.
//
// D. E. Muller, F. P. Preparata, Finding the intersection of two convex polyhedra, Theoretical
// Computer Science 7, 1978 (half-edges).
#include "sim/formats/faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"
#include "sim/formats/written_digits.h"

namespace kirireel::formats {
namespace {

// Normals with a smaller angle are of one plane, radians.
constexpr double kCoplanar = 1e-6;

/// The outline of faces of one piece; empty if it is not one closed polygon.
std::vector<int> outlineOf(const CornerNumbers& faces, const std::vector<int>& piece) {
  std::set<std::pair<int, int>> directed;
  for (const int face : piece) {
    const std::vector<int>& corners = faces[face];
    for (std::size_t k = 0; k < corners.size(); ++k) {
      if (!directed.emplace(corners[k], corners[(k + 1) % corners.size()]).second) return {};
    }
  }
  std::map<int, int> next;
  for (const auto& [from, to] : directed) {
    if (directed.contains({to, from})) continue;
    if (!next.emplace(from, to).second) return {};
  }
  // The first corner of the lowest face that is on the outline begins it.
  const std::vector<int>& first = faces[piece.front()];
  const auto begin = std::ranges::find_if(first, [&](int corner) { return next.contains(corner); });
  std::vector<int> outline;
  if (begin == first.end()) return outline;
  int at = *begin;
  do {
    outline.push_back(at);
    const auto found = next.find(at);
    if (found == next.end()) return {};
    at = found->second;
  } while (at != *begin && outline.size() <= next.size());
  const bool isWhole = outline.size() == next.size() && outline.size() <= model::kMostTileVertices;
  return isWhole ? outline : std::vector<int>();
}

}  // namespace

std::vector<int> faceOutline(std::vector<int> corners,
                             const std::function<bool(int, int)>& isSame) {
  for (std::size_t k = 0; k < corners.size() && corners.size() > 1;) {
    const std::size_t count = corners.size();
    const std::size_t next = (k + 1) % count, last = (k + count - 1) % count;
    const bool isRepeated = isSame(corners[k], corners[next]);
    const bool isTip = count > 2 && corners[last] == corners[next];
    if (!isRepeated && !isTip) {
      ++k;
      continue;
    }
    // Removes the later one of two equal corners, and the tip of a slit. Corners before it may have
    // become a tip.
    corners.erase(corners.begin() + static_cast<long>(isTip ? k : next == 0 ? k : next));
    k = k > 1 ? k - 2 : 0;
  }
  return corners;
}

JoinedFaces joinFaces(const CornerNumbers& faces, const FacePairs& pairs) {
  DisjointSets parent(faces.size());
  for (const auto& [a, b] : pairs) parent.unite(a, b);
  std::map<int, std::vector<int>> pieces;  // by lowest face
  for (int face = 0; face < std::ssize(faces); ++face) {
    pieces[parent.lowestOf(face)].push_back(face);
  }
  std::vector<std::pair<int, std::vector<int>>> tiles;  // lowest face, outline
  std::vector<int> lowest = numbersBelow(faces.size());
  for (const auto& [first, piece] : pieces) {
    std::vector<int> outline = piece.size() > 1 ? outlineOf(faces, piece) : std::vector<int>();
    if (outline.empty()) {
      for (const int face : piece) tiles.emplace_back(face, faces[face]);
      continue;
    }
    for (const int face : piece) lowest[face] = first;
    tiles.emplace_back(first, std::move(outline));
  }
  std::ranges::sort(tiles, {}, &std::pair<int, std::vector<int>>::first);
  JoinedFaces joined;
  std::map<int, int> numberOf;
  for (auto& [first, outline] : tiles) {
    numberOf[first] = static_cast<int>(joined.tiles.size());
    joined.tiles.push_back(std::move(outline));
  }
  for (const int first : lowest) joined.tileOf.push_back(numberOf.at(first));
  return joined;
}

FacePairs coplanarFaces(const CornerNumbers& faces,
                        const std::vector<const std::vector<model::Tile>*>& states,
                        const std::set<std::pair<int, int>>* edges) {
  std::map<std::pair<int, int>, int> faceAt;  // by directed edge
  for (int face = 0; face < std::ssize(faces); ++face) {
    const std::vector<int>& corners = faces[face];
    for (std::size_t k = 0; k < corners.size(); ++k) {
      faceAt[{corners[k], corners[(k + 1) % corners.size()]}] = face;
    }
  }
  FacePairs pairs;
  for (const auto& [edge, faceOfEdge] : faceAt) {
    const auto face = faceOfEdge;  // lambdas cannot capture it as a binding
    if (edges != nullptr && !edges->contains(std::minmax(edge.first, edge.second))) continue;
    const auto other = faceAt.find({edge.second, edge.first});
    if (other == faceAt.end() || other->second <= face) continue;
    const bool areCoplanar =
        std::ranges::all_of(states, [&](const std::vector<model::Tile>* tiles) {
          const Vector3 a = model::tileNormal((*tiles)[face]),
                        b = model::tileNormal((*tiles)[other->second]);
          return a.dot(b) > 0 && a.cross(b).norm() < kCoplanar;
        });
    if (areCoplanar) pairs.emplace_back(face, other->second);
  }
  return pairs;
}

namespace {

using Point = Eigen::Vector2d;

double crossOf(const Point& a, const Point& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The drawing as half-edges: 2 k runs along edge k, 2 k + 1 back.
class PlanarGraph {
 public:
  PlanarGraph(const std::vector<Vector3>& points, const std::vector<model::Crease>& edges,
              const std::filesystem::path& file)
      : file_(file) {
    project(points);
    vertex_ = numbersByPlace(points);
    addEdges(edges);
    requireNoCrossing();
    linkHalfEdges();
    walkFaces();
    findSheet();
  }

  CornerNumbers faces() const {
    CornerNumbers sheet;
    for (std::size_t k = 0; k < walks_.size(); ++k) {
      if (isSheet_[k]) sheet.push_back(cornersOf(walks_[k]));
    }
    if (sheet.empty()) {
      throw fault(
          "the edges enclose no face. Close the outline of the sheet, or add faces_vertices");
    }
    return sheet;
  }

 private:
  InputError fault(const std::string& message) const { return inputErrorAt({file_}, message); }

  // Onto the plane of all points, seen from above, or from the front if the plane is upright.
  void project(const std::vector<Vector3>& points) {
    Vector3 mean = Vector3::Zero();
    for (const Vector3& point : points) mean += point / static_cast<double>(points.size());
    Matrix3 spread = Matrix3::Zero();
    for (const Vector3& point : points) spread += (point - mean) * (point - mean).transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3> axes(spread);
    size_ = std::sqrt(axes.eigenvalues().maxCoeff());
    // Points of a horizontal sheet keep all their digits.
    const bool isLevel =
        std::ranges::all_of(points, [&](const Vector3& p) { return p.z() == points.front().z(); });
    Vector3 normal = isLevel ? Vector3::UnitZ() : Vector3(axes.eigenvectors().col(0));
    if (normal.z() < 0 || (normal.z() == 0 && normal.y() > 0)) normal = -normal;
    const Vector3 x = isLevel ? Vector3::UnitX() : Vector3(axes.eigenvectors().col(2)).normalized();
    const Vector3 y = normal.cross(x);
    for (const Vector3& point : points) {
      if (std::abs((point - mean).dot(normal)) > 1e-6 * size_) {
        throw fault(
            "faces_vertices is missing, and faces can be found from edges only if the drawing is "
            "flat. Add faces_vertices");
      }
      places_.emplace_back(point.dot(x), point.dot(y));
    }
  }

  void addEdges(const std::vector<model::Crease>& edges) {
    std::set<std::pair<int, int>> known;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const int from = vertex_[edges[k].from], to = vertex_[edges[k].to];
      // An edge that was drawn twice counts once.
      if (from == to || !known.insert(std::minmax(from, to)).second) continue;
      tails_.push_back(from);
      tails_.push_back(to);
      edgeNumber_.push_back(k);
      isBoundary_.push_back(edges[k].assignment == 'B');
    }
  }

  int tail(int half) const { return tails_[half]; }
  int head(int half) const { return tails_[half ^ 1]; }
  double tolerance() const { return 1e-9 * size_; }

  // Edges sorted by their left ends, each compared with those that begin before it ends.
  void requireNoCrossing() const {
    std::vector<int> order = numbersBelow(edgeNumber_.size());
    const auto left = [&](int e) {
      return std::min(places_[tail(2 * e)].x(), places_[head(2 * e)].x());
    };
    const auto right = [&](int e) {
      return std::max(places_[tail(2 * e)].x(), places_[head(2 * e)].x());
    };
    std::ranges::stable_sort(order, {}, left);
    for (std::size_t a = 0; a < order.size(); ++a) {
      for (std::size_t b = a + 1; b < order.size(); ++b) {
        if (left(order[b]) > right(order[a])) break;
        requireApart(order[a], order[b]);
      }
    }
  }

  /// The distance of a point to the line of an edge, and its position along the edge, [0, 1].
  std::pair<double, double> alongEdge(int point, int edge) const {
    const Point origin = places_[tail(2 * edge)], along = places_[head(2 * edge)] - origin;
    const Point offset = places_[point] - origin;
    return {crossOf(along, offset) / along.norm(), along.dot(offset) / along.squaredNorm()};
  }

  void requireApart(int a, int b) const {
    const std::array<int, 2> endsA = {tail(2 * a), head(2 * a)}, endsB = {tail(2 * b), head(2 * b)};
    const auto [lowA, highA] = std::minmax(places_[endsA[0]].y(), places_[endsA[1]].y());
    const auto [lowB, highB] = std::minmax(places_[endsB[0]].y(), places_[endsB[1]].y());
    if (lowA > highB + tolerance() || lowB > highA + tolerance()) return;
    // An end of one within the other.
    const auto touches = [&](int point, int edge, const std::array<int, 2>& ends) {
      const auto [distance, share] = alongEdge(point, edge);
      const bool isOwn = point == ends[0] || point == ends[1];
      return !isOwn && std::abs(distance) <= tolerance() && share > 0 && share < 1;
    };
    const auto parts = [&](const std::array<int, 2>& points, int edge) {
      const double first = alongEdge(points[0], edge).first,
                   second = alongEdge(points[1], edge).first;
      return std::min(first, second) < -tolerance() && std::max(first, second) > tolerance();
    };
    const bool cross = parts(endsA, b) && parts(endsB, a);
    if (!cross && !touches(endsA[0], b, endsB) && !touches(endsA[1], b, endsB) &&
        !touches(endsB[0], a, endsA) && !touches(endsB[1], a, endsA)) {
      return;
    }
    throw fault(
        fmt::format("edges {} and {} {} without a common vertex, and faces_vertices is missing. "
                    "Split the edges at a common vertex",
                    std::min(edgeNumber_[a], edgeNumber_[b]),
                    std::max(edgeNumber_[a], edgeNumber_[b]), cross ? "cross" : "touch"));
  }

  // The next half-edge round the face on the left.
  void linkHalfEdges() {
    std::map<int, std::vector<int>> outgoing;
    for (int half = 0; half < std::ssize(tails_); ++half) outgoing[tail(half)].push_back(half);
    next_.resize(tails_.size());
    for (auto& [vertex, halves] : outgoing) {
      std::ranges::stable_sort(halves, {}, [&](int half) {
        const Point along = places_[head(half)] - places_[tail(half)];
        return std::atan2(along.y(), along.x());
      });
      // The half-edge opposite to half-edge k is followed by the one before k.
      for (std::size_t k = 0; k < halves.size(); ++k) {
        next_[halves[k] ^ 1] = halves[(k + halves.size() - 1) % halves.size()];
      }
    }
  }

  void walkFaces() {
    walkOf_.assign(tails_.size(), -1);
    for (int first = 0; first < std::ssize(tails_); ++first) {
      if (walkOf_[first] >= 0) continue;
      std::vector<int>& walk = walks_.emplace_back();
      double area = 0;
      const Point origin = places_[tail(first)];
      for (int half = first; walkOf_[half] < 0; half = next_[half]) {
        walkOf_[half] = static_cast<int>(walks_.size()) - 1;
        walk.push_back(half);
        area += crossOf(places_[tail(half)] - origin, places_[head(half)] - origin) / 2;
      }
      isOutside_.push_back(area <= tolerance() * size_);
    }
  }

  // Breadth first from the outside of all parts of the drawing.
  void findSheet() {
    std::vector<std::optional<bool>> isSheet(walks_.size());
    std::vector<int> waiting;
    const auto set = [&](int walk, bool value) {
      if (isSheet[walk] || isOutside_[walk]) return;
      isSheet[walk] = value;
      waiting.push_back(walk);
    };
    for (int half = 0; half < std::ssize(tails_); ++half) {
      if (isOutside_[walkOf_[half]]) set(walkOf_[half ^ 1], true);
    }
    for (std::size_t k = 0; k < waiting.size(); ++k) {
      const int walk = waiting[k];
      for (const int half : walks_[walk]) {
        set(walkOf_[half ^ 1], *isSheet[walk] != isBoundary_[half / 2]);
      }
    }
    for (const std::optional<bool>& value : isSheet) isSheet_.push_back(value.value_or(false));
    requireBoundariesAround();
    requireNoIslands();
  }

  // Boundary edges have the sheet on one side.
  void requireBoundariesAround() const {
    for (int half = 0; half < std::ssize(tails_); half += 2) {
      const int left = walkOf_[half], right = walkOf_[half ^ 1];
      if (left == right || isOutside_[left] || isOutside_[right]) continue;
      const bool isBorder = isSheet_[left] != isSheet_[right];
      if (isBorder == isBoundary_[half / 2]) continue;
      throw fault(
          fmt::format("boundary edges (B) near vertex {} have the sheet on both sides. Give "
                      "cuts the letter C, or add faces_vertices",
                      tail(half)));
    }
  }

  // A part of the drawing that lies in a face of another part makes a hole in it.
  void requireNoIslands() const {
    DisjointSets part(places_.size());
    for (int half = 0; half < std::ssize(tails_); half += 2) part.unite(tail(half), head(half));
    std::map<int, int> faceOfPart;
    for (int walk = 0; walk < std::ssize(walks_); ++walk) {
      if (isSheet_[walk]) faceOfPart.emplace(part.lowestOf(tail(walks_[walk].front())), walk);
    }
    if (faceOfPart.size() < 2) return;
    for (const auto& [own, walk] : faceOfPart) {
      for (int face = 0; face < std::ssize(walks_); ++face) {
        const bool isOther = isSheet_[face] && part.lowestOf(tail(walks_[face].front())) != own;
        if (!isOther || !holds(face, places_[own])) continue;
        throw fault(
            fmt::format("the face at vertex {} has a separate drawing inside, at vertex {}. Tiles "
                        "cannot have holes. Connect the two by an edge, or add faces_vertices",
                        tail(walks_[face].front()), own));
      }
    }
  }

  // Even-odd rule.
  bool holds(int walk, const Point& point) const {
    bool isInside = false;
    for (const int half : walks_[walk]) {
      const Point a = places_[tail(half)] - point, b = places_[head(half)] - point;
      if ((a.y() > 0) == (b.y() > 0)) continue;
      if ((crossOf(a, b) > 0) == (b.y() > a.y())) isInside = !isInside;
    }
    return isInside;
  }

  std::vector<int> cornersOf(const std::vector<int>& walk) const {
    std::vector<int> corners;
    for (const int half : walk) corners.push_back(tail(half));
    return corners;
  }

  std::filesystem::path file_;
  double size_ = 0;
  std::vector<Point> places_;
  std::vector<int> vertex_;                // the lowest vertex in the same place
  std::vector<int> tails_;                 // of half-edges
  std::vector<std::size_t> edgeNumber_;    // in the file
  std::vector<bool> isBoundary_;           // of edges
  std::vector<int> next_;                  // of half-edges
  CornerNumbers walks_;                    // half-edges round each region
  std::vector<int> walkOf_;                // of half-edges
  std::vector<bool> isOutside_, isSheet_;  // of traversals
};

}  // namespace

std::vector<int> numbersByPlace(const std::vector<Vector3>& points) {
  const double tolerance = samePlaceTolerance({model::Tile{points}});
  DisjointSets places(points.size());
  std::vector<int> order = numbersBelow(points.size());
  std::ranges::stable_sort(order, {}, [&](int k) { return points[k].x(); });
  for (std::size_t b = 0; b < order.size(); ++b) {
    for (std::size_t a = b; a-- > 0;) {
      const Vector3 apart = points[order[b]] - points[order[a]];
      if (apart.x() > tolerance) break;
      if (apart.norm() <= tolerance) places.unite(order[a], order[b]);
    }
  }
  std::vector<int> numbers;
  for (const int k : numbersBelow(points.size())) numbers.push_back(places.lowestOf(k));
  return numbers;
}

CornerNumbers planarFaces(const std::vector<Vector3>& points,
                          const std::vector<model::Crease>& edges,
                          const std::filesystem::path& file) {
  return PlanarGraph(points, edges, file).faces();
}

}  // namespace kirireel::formats
