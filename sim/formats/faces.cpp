// Faces as tiles.
//
// Joining. Each face gives its directed edges. An edge between two joined faces occurs in both
// directions, and the two cancel. The rest is the outline: one closed polygon if each of its
// vertices has one edge in and one out.
//
// Faces of a drawing are the cycles of positive area of the planar graph (arrangement.cpp).
//
// Sheet and holes. A region next to the outside is sheet. Of two other neighbouring regions, one is
// sheet and one a hole if their common edge is a boundary (B). Otherwise both are the same.
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
#include "sim/formats/arrangement.h"
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
  const bool isWhole = outline.size() == next.size() && outline.size() <= model::kMaxTileVertices;
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

/// The drawing as a planar graph, without crossings.
class PlanarDrawing {
 public:
  PlanarDrawing(const std::vector<Vector3>& points, const std::vector<model::Crease>& edges,
                const std::filesystem::path& file)
      : file_(file) {
    project(points);
    addEdges(edges, numbersByPlace(points));
    requireNoCrossing();
    graph_ = Arrangement(places_, ends_);
    findSheet();
  }

  CornerNumbers faces() const {
    CornerNumbers sheet;
    for (std::size_t k = 0; k < isSheet_.size(); ++k) {
      if (!isSheet_[k]) continue;
      std::vector<int>& corners = sheet.emplace_back();
      for (const int half : graph_.cycles()[k]) corners.push_back(graph_.from(half));
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

  void addEdges(const std::vector<model::Crease>& edges, const std::vector<int>& vertex) {
    std::set<std::pair<int, int>> known;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      const int from = vertex[edges[k].from], to = vertex[edges[k].to];
      // An edge that was drawn twice counts once.
      if (from == to || !known.insert(std::minmax(from, to)).second) continue;
      ends_.emplace_back(from, to);
      edgeNumber_.push_back(k);
      isBoundary_.push_back(edges[k].assignment == 'B');
    }
  }

  double tolerance() const { return 1e-9 * size_; }

  void requireNoCrossing() const {
    std::vector<PlaneSegment> segments;
    for (const auto& [from, to] : ends_) segments.emplace_back(places_[from], places_[to]);
    // The lowest pair, which does not depend on the directions of the axes.
    std::optional<std::pair<std::size_t, std::size_t>> first;
    bool isCrossing = false;
    visitNearSegments(segments, 2 * tolerance(), [&](int a, int b) {
      const bool cross = separatesEnds(a, b) && separatesEnds(b, a);
      if (!cross && !touches(a, b) && !touches(b, a)) return;
      const std::pair<std::size_t, std::size_t> pair = std::minmax(edgeNumber_[a], edgeNumber_[b]);
      if (first && *first <= pair) return;
      first = pair;
      isCrossing = cross;
    });
    if (!first) return;
    throw fault(
        fmt::format("edges {} and {} {} without a common vertex, and faces_vertices is missing. "
                    "Split the edges at a common vertex",
                    first->first, first->second, isCrossing ? "cross" : "touch"));
  }

  /// The distance of a point to the line of an edge, and its position along the edge, [0, 1].
  std::pair<double, double> alongEdge(int point, int edge) const {
    const Vector2 origin = places_[ends_[edge].first];
    const Vector2 along = places_[ends_[edge].second] - origin, offset = places_[point] - origin;
    return {crossZ(along, offset) / along.norm(), along.dot(offset) / along.squaredNorm()};
  }

  /// Whether an end of one edge lies within the other.
  bool touches(int one, int other) const {
    return std::ranges::any_of(std::array{ends_[one].first, ends_[one].second}, [&](int point) {
      const auto [distance, share] = alongEdge(point, other);
      const bool isOwn = point == ends_[other].first || point == ends_[other].second;
      return !isOwn && std::abs(distance) <= tolerance() && share > 0 && share < 1;
    });
  }

  /// Whether the line of an edge has the ends of another one on different sides.
  bool separatesEnds(int edge, int other) const {
    const auto [low, high] = std::minmax(
        {alongEdge(ends_[other].first, edge).first, alongEdge(ends_[other].second, edge).first});
    return low < -tolerance() && high > tolerance();
  }

  void findSheet() {
    for (int cycle = 0; cycle < std::ssize(graph_.cycles()); ++cycle) {
      isOutside_.push_back(graph_.areaOf(cycle) <= tolerance() * size_);
    }
    isSheet_ = sheetCycles(graph_, isBoundary_, tolerance() * size_);
    requireBoundariesAround();
    const auto around = faceAround(graph_, isSheet_);
    if (!around) return;
    throw fault(
        fmt::format("the face at vertex {} has a separate drawing inside, at vertex {}. Tiles "
                    "cannot have holes. Connect the two by an edge, or add faces_vertices",
                    around->first, around->second));
  }

  // Boundary edges have the sheet on one side.
  void requireBoundariesAround() const {
    for (int edge = 0; edge < std::ssize(ends_); ++edge) {
      const int left = graph_.cycleOf(2 * edge), right = graph_.cycleOf(2 * edge + 1);
      if (left == right || isOutside_[left] || isOutside_[right]) continue;
      const bool isBorder = isSheet_[left] != isSheet_[right];
      if (isBorder == isBoundary_[edge]) continue;
      throw fault(
          fmt::format("boundary edges (B) near vertex {} have the sheet on both sides. Give "
                      "cuts the letter C, or add faces_vertices",
                      ends_[edge].first));
    }
  }

  std::filesystem::path file_;
  double size_ = 0;
  std::vector<Vector2> places_;
  std::vector<std::pair<int, int>> ends_;  // of edges: the lowest vertices at their positions
  std::vector<std::size_t> edgeNumber_;    // in the file
  std::vector<bool> isBoundary_;           // of edges
  Arrangement graph_;
  std::vector<bool> isOutside_, isSheet_;  // of cycles
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
  return PlanarDrawing(points, edges, file).faces();
}

}  // namespace kirireel::formats
