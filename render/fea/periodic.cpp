// 1. A translation that takes one tile to another is a symmetry if it takes every tile to a tile or
//    to where there is none, and every joint to a joint or across the border. Such translations
//    generate a lattice L (Lagrange's reduction keeps its basis short).
// 2. Tiles that L maps onto each other are of one class. Each class has m tiles. The periods P are
//    a sublattice of L of index m that tells the tiles of a class apart: the shortest one. All of
//    them lie in Hermite's normal form, (a b; 0 d) with a d = m, 0 <= b < a.
// 3. A joint of tiles u and v is moved to every tile of u's class. Where v then lies in another
//    cell, the border cuts the joint.
//
// A cell without symmetries is set beside itself if its straight ends meet edge by edge. Corners
// that meet in pairs are joined.
#include "render/fea/periodic.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "render/fea/sheet_ends.h"
#include "sim/base/error.h"
#include "sim/base/interruption.h"
#include "sim/model/convex_parts.h"

namespace kirireel::fea {
namespace {

using Flat = Eigen::Vector2d;
using Offset = std::array<int, 2>;

constexpr double kSameLattice = 1e-5;  ///< of the sheet's size, what a run leaves of symmetry
/// So many tiles are taken to all others, those nearest to the middle.
constexpr std::size_t kMostReferences = 60;
constexpr std::size_t kMostPeriods = 20;  ///< that are compared

/// The lattice that vectors generate, of rank 0, 1 or 2.
class VectorLattice {
 public:
  explicit VectorLattice(double tolerance) : tolerance_(tolerance) {}

  const std::vector<Vector3>& basis() const { return basis_; }

  /// A vector's whole multiples of the basis, and what they leave.
  std::pair<Offset, Vector3> reduce(const Vector3& vector) const {
    Offset times{};
    Vector3 rest = vector;
    if (basis_.empty()) return {times, rest};
    Eigen::MatrixXd columns(3, basis_.size());
    for (std::size_t k = 0; k < basis_.size(); ++k) columns.col(k) = basis_[k];
    const Eigen::VectorXd shares = columns.colPivHouseholderQr().solve(vector);
    for (std::size_t k = 0; k < basis_.size(); ++k) {
      times[k] = static_cast<int>(std::lround(shares[k]));
      rest -= times[k] * basis_[k];
    }
    return {times, rest};
  }

  bool contains(const Vector3& vector) const { return reduce(vector).second.norm() <= tolerance_; }

  /// Each reduction of a vector by shorter ones ends, since lengths fall and are not below the
  /// tolerance.
  void add(const Vector3& vector) {
    std::vector<Vector3> waiting = {vector};
    while (!waiting.empty()) {
      const Vector3 rest = reduce(waiting.back()).second;
      waiting.pop_back();
      if (rest.norm() <= tolerance_) continue;
      std::vector<Vector3> all = basis_;
      all.push_back(rest);
      std::ranges::sort(all, {}, [](const Vector3& one) { return one.norm(); });
      basis_.clear();
      for (const Vector3& one : all) {
        const bool isParallel =
            basis_.size() == 1 && basis_[0].cross(one).norm() <= tolerance_ * basis_[0].norm();
        if (basis_.size() < 2 && !isParallel) {
          basis_.push_back(one);
        } else {
          waiting.push_back(one);
        }
      }
      shorten();
    }
  }

 private:
  /// Lagrange's reduction.
  void shorten() {
    while (basis_.size() == 2) {
      if (basis_[0].norm() > basis_[1].norm()) std::swap(basis_[0], basis_[1]);
      const double times = std::round(basis_[0].dot(basis_[1]) / basis_[0].squaredNorm());
      if (times == 0) return;
      basis_[1] -= times * basis_[0];
      if (basis_[1].norm() >= basis_[0].norm()) return;
    }
  }

  double tolerance_;
  std::vector<Vector3> basis_;
};

/// A corner of a tile.
using CornerPlace = std::pair<int, int>;

class LatticeFinder {
 public:
  LatticeFinder(const std::vector<std::vector<Vector3>>& tiles,
                const std::vector<model::Joint>& joints, int countsFrom)
      : tiles_(tiles), joints_(joints), countsFrom_(countsFrom) {
    Eigen::AlignedBox3d box;
    double edges = 0;
    std::size_t count = 0;
    for (const auto& tile : tiles) {
      Vector3 sum = Vector3::Zero();
      Vector3 normal = Vector3::Zero();
      for (std::size_t k = 0; k < tile.size(); ++k) {
        const Vector3& next = tile[(k + 1) % tile.size()];
        box.extend(tile[k]);
        sum += tile[k];
        normal += (tile[k] - tile[0]).cross(next - tile[0]);
        edges += (next - tile[k]).norm();
        ++count;
      }
      centres_.push_back(sum / static_cast<double>(tile.size()));
      for (const Vector3& corner : tile) {
        reach_ = std::max(reach_, 2 * (corner - centres_.back()).norm());
      }
      if (normals_.empty()) normal_ = normal.normalized();
      normals_.push_back(normal.normalized());
    }
    size_ = box.sizes().norm();
    tolerance_ = kSameLattice * size_;
    tileSize_ = edges / static_cast<double>(count);
    for (const auto& tile : tiles) {
      for (const Vector3& corner : tile) {
        isFlat_ = isFlat_ && std::abs((corner - tiles[0][0]).dot(normal_)) <= 1e-3 * size_;
      }
    }
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      grid_[placeOf(centres_[t])].push_back(static_cast<int>(t));
    }
    for (const model::Joint& joint : joints) {
      jointsAt_[{joint.a.tile, joint.a.vertex}].push_back({joint.b.tile, joint.b.vertex});
      jointsAt_[{joint.b.tile, joint.b.vertex}].push_back({joint.a.tile, joint.a.vertex});
    }
  }

  SheetLattice find() {
    const VectorLattice lattice = symmetries();
    SheetLattice sheet;
    if (lattice.basis().size() == 2) {
      // Straight ends that continue each other must do so with their joints.
      const bool isOdd = !obstacle(lattice, true).empty();
      std::optional<SheetLattice> found;
      if (!isOdd) found = bySymmetry(lattice);
      if (!found) refuse(lattice);
      sheet = *found;
    } else {
      sheet = byContact(lattice);
    }
    chooseAxes(sheet);
    return sheet;
  }

 private:
  using GridPlace = std::array<long, 3>;

  GridPlace placeOf(const Vector3& point) const {
    GridPlace place{};
    for (int axis = 0; axis < 3; ++axis) place[axis] = std::lround(point[axis] / reach_);
    return place;
  }

  /// Tiles whose centres are less than the largest tile's size apart from a point.
  std::vector<int> tilesNear(const Vector3& point) const {
    std::vector<int> found;
    const GridPlace place = placeOf(point);
    for (long x = -1; x <= 1; ++x) {
      for (long y = -1; y <= 1; ++y) {
        for (long z = -1; z <= 1; ++z) {
          const auto cell = grid_.find({place[0] + x, place[1] + y, place[2] + z});
          if (cell == grid_.end()) continue;
          found.insert(found.end(), cell->second.begin(), cell->second.end());
        }
      }
    }
    return found;
  }

  /// By how many vertices tile `to` begins later than tile `from` moved onto it; nothing where they
  /// differ.
  std::optional<int> shiftBetween(int from, int to, const Vector3& move) const {
    const auto &a = tiles_[from], &b = tiles_[to];
    const std::size_t count = a.size();
    if (b.size() != count) return std::nullopt;
    for (std::size_t shift = 0; shift < count; ++shift) {
      bool isSame = true;
      for (std::size_t k = 0; k < count && isSame; ++k) {
        isSame = (a[k] + move - b[(k + shift) % count]).norm() <= tolerance_;
      }
      if (isSame) return static_cast<int>(shift);
    }
    return std::nullopt;
  }

  /// The tile that another is moved onto, and the shift of its vertices.
  std::optional<std::pair<int, int>> imageOf(int tile, const Vector3& move) const {
    const Vector3 centre = centres_[tile] + move;
    for (const int other : tilesNear(centre)) {
      if ((centres_[other] - centre).norm() > tolerance_) continue;
      if (const auto shift = shiftBetween(tile, other, move)) return std::pair{other, *shift};
    }
    return std::nullopt;
  }

  bool overlap(int first, const Vector3& move, int second) const {
    std::vector<Flat> a, b;
    const Vector3 along = (tiles_[0][1] - tiles_[0][0]).normalized();
    const Vector3 up = normal_.cross(along);
    for (const Vector3& corner : tiles_[first]) {
      const Vector3 moved = corner + move;
      a.emplace_back(along.dot(moved), up.dot(moved));
    }
    for (const Vector3& corner : tiles_[second]) b.emplace_back(along.dot(corner), up.dot(corner));
    return sidesCross(a, b) || hasMiddleIn(first, a, b) || hasMiddleIn(second, b, a);
  }

  bool sidesCross(const std::vector<Flat>& a, const std::vector<Flat>& b) const {
    const auto distance = [](const Flat& from, const Flat& to, const Flat& point) {
      const Flat along = (to - from).normalized();
      return along.x() * (point.y() - from.y()) - along.y() * (point.x() - from.x());
    };
    const auto parts = [&](const Flat& from, const Flat& to, const Flat& p, const Flat& q) {
      const double first = distance(from, to, p), second = distance(from, to, q);
      return std::min(first, second) < -tolerance_ && std::max(first, second) > tolerance_;
    };
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t j = 0; j < b.size(); ++j) {
        const Flat &p = a[i], &q = a[(i + 1) % a.size()];
        const Flat &r = b[j], &s = b[(j + 1) % b.size()];
        if (parts(p, q, r, s) && parts(r, s, p, q)) return true;
      }
    }
    return false;
  }

  /// Whether the middle of one of a tile's triangles lies within another polygon.
  bool hasMiddleIn(int tile, const std::vector<Flat>& own, const std::vector<Flat>& other) const {
    for (const std::array<int, 3>& triangle : model::trianglesOf(tiles_[tile], normals_[tile])) {
      const Flat middle = (own[triangle[0]] + own[triangle[1]] + own[triangle[2]]) / 3;
      bool isInside = false;
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < other.size(); ++k) {
        const Flat &p = other[k], &q = other[(k + 1) % other.size()];
        const Flat along = q - p;
        const double share = std::clamp((middle - p).dot(along) / along.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (p + share * along - middle).norm());
        if ((p.y() > middle.y()) == (q.y() > middle.y())) continue;
        const double x = p.x() + (middle.y() - p.y()) / along.y() * along.x();
        if (x > middle.x()) isInside = !isInside;
      }
      if (isInside && nearest > tolerance_) return true;
    }
    return false;
  }

  /// Whether a tile that is moved lies on no other. Tiles of sheets that are not flat are not
  /// compared.
  bool isFree(int tile, const Vector3& move) const {
    if (!isFlat_) return true;
    return std::ranges::none_of(tilesNear(centres_[tile] + move),
                                [&](int other) { return overlap(tile, move, other); });
  }

  bool areJoined(const CornerPlace& a, const CornerPlace& b) const {
    const auto found = jointsAt_.find(a);
    return found != jointsAt_.end() && std::ranges::find(found->second, b) != found->second.end();
  }

  bool isSymmetry(const Vector3& move) const {
    for (int t = 0; t < static_cast<int>(tiles_.size()); ++t) {
      if (!imageOf(t, move) && !isFree(t, move)) return false;
    }
    for (const model::Joint& joint : joints_) {
      for (const double sign : {-1.0, 1.0}) {
        const auto a = imageOf(joint.a.tile, sign * move), b = imageOf(joint.b.tile, sign * move);
        if (a && b && !areJoined(cornerOf(joint.a, *a), cornerOf(joint.b, *b))) return false;
      }
    }
    return true;
  }

  CornerPlace cornerOf(const model::Corner& corner, const std::pair<int, int>& image) const {
    const int count = static_cast<int>(tiles_[corner.tile].size());
    return {image.first, (corner.vertex + image.second) % count};
  }

  /// The lattice of all translations that are symmetries.
  VectorLattice symmetries() const {
    Vector3 middle = Vector3::Zero();
    for (const Vector3& centre : centres_) middle += centre / static_cast<double>(centres_.size());
    std::vector<int> references(tiles_.size());
    std::iota(references.begin(), references.end(), 0);
    std::ranges::stable_sort(references, {}, [&](int t) { return (centres_[t] - middle).norm(); });
    if (references.size() > kMostReferences) references.resize(kMostReferences);
    std::vector<Vector3> moves;
    for (const int from : references) {
      for (int to = 0; to < static_cast<int>(tiles_.size()); ++to) {
        const Vector3 move = centres_[to] - centres_[from];
        if (to != from && shiftBetween(from, to, move)) moves.push_back(move);
      }
    }
    std::ranges::stable_sort(moves, {}, [](const Vector3& move) { return move.norm(); });
    VectorLattice lattice(2 * tolerance_);
    std::vector<Vector3> refused;
    for (const Vector3& move : moves) {
      checkInterruption();
      // Longer ones than twice the basis are sums of shorter ones.
      const bool isFull = lattice.basis().size() == 2;
      if (isFull && move.norm() > 2.01 * lattice.basis()[1].norm()) break;
      if (!lattice.basis().empty() && lattice.contains(move)) continue;
      const bool wasRefused = std::ranges::any_of(refused, [&](const Vector3& other) {
        return std::min((other - move).norm(), (other + move).norm()) <= tolerance_;
      });
      if (wasRefused) continue;
      isSymmetry(move) ? lattice.add(move) : refused.push_back(move);
    }
    return lattice;
  }

  /// The number of each tile's class, and where it is from the first of its class on, in the
  /// lattice's basis.
  void classify(const VectorLattice& lattice) {
    classOf_.assign(tiles_.size(), -1);
    members_.clear();
    for (int t = 0; t < static_cast<int>(tiles_.size()); ++t) {
      for (std::size_t c = 0; c < members_.size() && classOf_[t] < 0; ++c) {
        const Vector3 move = centres_[t] - centres_[members_[c][0]];
        if (lattice.contains(move) && shiftBetween(members_[c][0], t, move)) {
          classOf_[t] = static_cast<int>(c);
          members_[c].push_back(t);
        }
      }
      if (classOf_[t] >= 0) continue;
      classOf_[t] = static_cast<int>(members_.size());
      members_.push_back({t});
    }
  }

  /// Whether the periods tell the tiles of each class apart.
  bool tellsApart(const VectorLattice& lattice, int a, int b, int d) const {
    for (const std::vector<int>& members : members_) {
      std::set<Offset> seen;
      for (const int tile : members) {
        auto [i, j] = lattice.reduce(centres_[tile] - centres_[members[0]]).first;
        // Modulo the rows (a, b; 0, d) of Hermite's form.
        const int rows = static_cast<int>(std::floor(static_cast<double>(j) / d));
        j -= rows * d;
        i -= rows * b;
        i -= static_cast<int>(std::floor(static_cast<double>(i) / a)) * a;
        if (!seen.insert({i, j}).second) return false;
      }
    }
    return true;
  }

  std::optional<SheetLattice> bySymmetry(const VectorLattice& lattice) {
    classify(lattice);
    const int m = static_cast<int>(members_[0].size());
    for (const std::vector<int>& members : members_) {
      if (static_cast<int>(members.size()) != m) return std::nullopt;
    }
    std::vector<VectorLattice> found;
    for (int d = 1; d <= m; ++d) {
      if (m % d != 0) continue;
      for (int b = 0; b < m / d; ++b) {
        if (!tellsApart(lattice, m / d, b, d)) continue;
        VectorLattice& periods = found.emplace_back(tolerance_);
        periods.add(m / d * lattice.basis()[0]);
        periods.add(b * lattice.basis()[0] + d * lattice.basis()[1]);
      }
    }
    const auto sum = [](const VectorLattice& one) {
      return one.basis()[0].squaredNorm() + one.basis()[1].squaredNorm();
    };
    std::ranges::stable_sort(found, [&](const VectorLattice& one, const VectorLattice& other) {
      return sum(one) < (1 - 1e-9) * sum(other);
    });
    // All of them make the same infinite sheet. Best is that by which whole sides of cells meet.
    if (found.size() > kMostPeriods) found.resize(kMostPeriods, found[0]);
    std::optional<VectorLattice> best;
    std::size_t most = 0;
    for (const VectorLattice& periods : found) {
      const std::size_t count = meetingEdges(periods.basis()[0]) + meetingEdges(periods.basis()[1]);
      if (best && count <= most) continue;
      best = periods;
      most = count;
    }
    if (!best || !areApart(best->basis()[0], best->basis()[1])) return std::nullopt;
    SheetLattice sheet;
    sheet.periods = {best->basis()[0], best->basis()[1]};
    if (!addTwins(*best, sheet)) return std::nullopt;
    return sheet;
  }

  /// How many edges of the cell lie where another one's do when it is moved.
  std::size_t meetingEdges(const Vector3& move) const {
    std::size_t count = 0;
    for (std::size_t t = 0; t < tiles_.size(); ++t) {
      for (const int other : tilesNear(centres_[t] + move)) {
        const auto &own = tiles_[t], &next = tiles_[other];
        for (std::size_t k = 0; k < own.size(); ++k) {
          for (std::size_t j = 0; j < next.size(); ++j) {
            const bool meet = (own[k] + move - next[(j + 1) % next.size()]).norm() <= tolerance_ &&
                              (own[(k + 1) % own.size()] + move - next[j]).norm() <= tolerance_;
            count += meet ? 1 : 0;
          }
        }
      }
    }
    return count;
  }

  /// Whether cells set side by side do not overlap.
  bool areApart(const Vector3& first, const Vector3& second) const {
    for (int t = 0; t < static_cast<int>(tiles_.size()); ++t) {
      for (int i = -1; i <= 1; ++i) {
        for (int j = -1; j <= 1; ++j) {
          if ((i != 0 || j != 0) && !isFree(t, i * first + j * second)) return false;
        }
      }
    }
    return true;
  }

  /// Where a tile is once it is moved: the tile of the cell, and the cell.
  struct CellPlace {
    int tile = 0;
    int shift = 0;
    Offset cell{};
  };
  std::optional<CellPlace> placeOfMoved(int tile, const Vector3& move,
                                        const VectorLattice& periods) const {
    for (const int other : members_[classOf_[tile]]) {
      const auto [cell, rest] = periods.reduce(centres_[tile] + move - centres_[other]);
      if (rest.norm() > 2 * tolerance_) continue;
      const Vector3 within = centres_[other] - centres_[tile];
      if (const auto shift = shiftBetween(tile, other, within))
        return CellPlace{other, *shift, cell};
    }
    return std::nullopt;
  }

  /// The joints that the border cuts; false where joints contradict each other.
  bool addTwins(const VectorLattice& periods, SheetLattice& sheet) const {
    std::set<std::tuple<CornerPlace, CornerPlace, Offset>> known;
    for (const model::Joint& joint : joints_) {
      for (const int twin : members_[classOf_[joint.a.tile]]) {
        const Vector3 move = centres_[twin] - centres_[joint.a.tile];
        const auto a = placeOfMoved(joint.a.tile, move, periods);
        const auto b = placeOfMoved(joint.b.tile, move, periods);
        if (!a || !b) return false;
        CornerPlace from = cornerOf(joint.a, {a->tile, a->shift});
        CornerPlace to = cornerOf(joint.b, {b->tile, b->shift});
        Offset cell = {b->cell[0] - a->cell[0], b->cell[1] - a->cell[1]};
        if (cell == Offset{}) {
          if (!areJoined(from, to)) return false;
          continue;
        }
        if (to < from || (to == from && cell < Offset{})) {
          std::swap(from, to);
          cell = {-cell[0], -cell[1]};
        }
        if (!known.insert({from, to, cell}).second) continue;
        model::Joint own = joint;
        own.a = {from.first, from.second};
        own.b = {to.first, to.second};
        sheet.joints.push_back({own, cell});
      }
    }
    return !sheet.joints.empty();
  }

  /// Cells side by side along the sheet's axes, if all edges at one end lie where those at the
  /// other do.
  SheetLattice byContact(const VectorLattice& lattice) const {
    SheetLattice sheet;
    const EndEdges ends = findEndEdges(tiles_, tileSize_);
    for (const int axis : {0, 1}) {
      sheet.periods[axis] = extentAlong(ends.axes.col(axis));
      for (const int end : {2 * axis, 2 * axis + 1}) {
        const std::vector<PolygonEdge>& edges = ends.edges[end];
        const Vector3 out = end % 2 == 0 ? Vector3(-sheet.periods[axis]) : sheet.periods[axis];
        const bool isMet = !edges.empty() && std::ranges::all_of(edges, [&](const auto& edge) {
          return continuesAt(edge, out);
        });
        if (!isMet) refuse(lattice);
      }
    }
    if (!isFlat_ || !areApart(sheet.periods[0], sheet.periods[1])) refuse(lattice);
    addMeetings(sheet);
    if (!isHeld(sheet)) refuse(lattice);
    return sheet;
  }

  /// From one end of the sheet to the other along a direction.
  Vector3 extentAlong(const Vector3& direction) const {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const auto& tile : tiles_) {
      for (const Vector3& corner : tile) {
        least = std::min(least, direction.dot(corner));
        most = std::max(most, direction.dot(corner));
      }
    }
    return (most - least) * direction;
  }

  /// Joins corners of different cells that meet in pairs.
  void addMeetings(SheetLattice& sheet) const {
    struct CornerMeeting {
      CornerPlace corner;
      Offset cell;
    };
    for (int t = 0; t < static_cast<int>(tiles_.size()); ++t) {
      for (int k = 0; k < static_cast<int>(tiles_[t].size()); ++k) {
        std::vector<CornerMeeting> others;
        for (int s = 0; s < static_cast<int>(tiles_.size()); ++s) {
          for (int j = 0; j < static_cast<int>(tiles_[s].size()); ++j) {
            for (const int x : {-1, 0, 1}) {
              for (const int y : {-1, 0, 1}) {
                const Vector3 moved = at({s, j}) + x * sheet.periods[0] + y * sheet.periods[1];
                const bool isItself = s == t && j == k && x == 0 && y == 0;
                if (!isItself && (moved - at({t, k})).norm() <= tolerance_) {
                  others.push_back({{s, j}, {x, y}});
                }
              }
            }
          }
        }
        const bool isBorder = std::ranges::any_of(
            others, [](const CornerMeeting& one) { return one.cell != Offset{}; });
        if (!isBorder || jointsAt_.contains({t, k})) continue;
        if (others.size() > 1) refuseUnknown(t, k);
        const auto& [corner, cell] = others[0];
        if (corner < CornerPlace{t, k} || (corner == CornerPlace{t, k} && cell < Offset{}))
          continue;
        model::Joint joint = joints_.empty() ? model::Joint{} : joints_[0];
        joint.a = {t, k};
        joint.b = {corner.first, corner.second};
        sheet.joints.push_back({joint, cell});
      }
    }
  }

  /// Whether joints hold cells together along both periods.
  static bool isHeld(const SheetLattice& sheet) {
    for (const BorderJoint& one : sheet.joints) {
      for (const BorderJoint& other : sheet.joints) {
        if (one.cell[0] * other.cell[1] != one.cell[1] * other.cell[0]) return true;
      }
    }
    return false;
  }

  const Vector3& at(const CornerPlace& corner) const { return tiles_[corner.first][corner.second]; }

  /// The x axis lies along or across one of the shortest periods, the nearest to the sheet's x
  /// axis.
  void chooseAxes(SheetLattice& sheet) const {
    const auto& [p, q] = sheet.periods;
    Vector3 normal = p.cross(q).normalized();
    if (normal.dot(normal_) < 0) normal = -normal;
    // The sheet's own x axis, which turns with it.
    const Matrix3 own = findEndEdges(tiles_, tileSize_).axes;
    const Vector3 sheetX = own.col(std::abs(normal.dot(own.col(0))) < 0.9 ? 0 : 1);
    double best = 0;
    double length = 0;
    bool isAlong = true;
    Vector3 along = Vector3::Zero();
    for (const Vector3& period : {p, q, Vector3(p + q), Vector3(p - q)}) {
      for (const bool isTurned : {false, true}) {
        const Vector3 direction =
            isTurned ? Vector3(normal.cross(period).normalized()) : Vector3(period.normalized());
        const double cosine = direction.dot(sheetX);
        if (std::abs(cosine) <= best + 1e-9) continue;
        best = std::abs(cosine);
        along = std::copysign(1, cosine) * direction;
        length = period.norm();
        isAlong = !isTurned;
      }
    }
    // Rounding must not turn a sheet that lies in the world's axes.
    if ((along - sheetX).norm() < 1e-9) along = sheetX;
    sheet.axes.col(0) = along;
    sheet.axes.col(1) = normal.cross(along);
    sheet.axes.col(2) = normal;
    const double area = p.cross(q).norm();
    sheet.lengths = isAlong ? std::array<double, 2>{length, area / length}
                            : std::array<double, 2>{area / length, length};
  }

  std::string edgeWords(const PolygonEdge& edge) const {
    return fmt::format("edge {} of tile {}", edge.edge + countsFrom_, edge.polygon + countsFrom_);
  }

  /// Whether the sheet goes on at an edge: the tile that the move takes onto its neighbour's place.
  bool continuesAt(const PolygonEdge& edge, const Vector3& out) const {
    const Vector3 &a = tiles_[edge.polygon][edge.edge],
                  &b = tiles_[edge.polygon][(edge.edge + 1) % tiles_[edge.polygon].size()];
    for (const auto& tile : tiles_) {
      for (std::size_t k = 0; k < tile.size(); ++k) {
        const Vector3 &c = tile[k], &d = tile[(k + 1) % tile.size()];
        if ((a - out - d).norm() <= tolerance_ && (b - out - c).norm() <= tolerance_) return true;
      }
    }
    return false;
  }

  /// What keeps a cell from being set beside itself along the sheet's axes; empty if nothing does.
  /// `lattice` has the sheet's own translations.
  std::string obstacle(const VectorLattice& lattice, bool isStraightOnly) const {
    static constexpr const char* kNames[] = {"XMIN", "XMAX", "YMIN", "YMAX"};
    const EndEdges ends = findEndEdges(tiles_, tileSize_);
    for (int axis = 0; axis < 2; ++axis) {
      const Vector3 out = extentAlong(ends.axes.col(axis));
      const std::vector<PolygonEdge>& edges = ends.edges[2 * axis + 1];
      if (edges.empty()) continue;
      const auto lonely =
          std::ranges::find_if(edges, [&](const auto& edge) { return !continuesAt(edge, out); });
      if (lonely == edges.end()) {
        if (lattice.contains(out)) continue;
        return fmt::format("joints beyond {} at {} are at other corners than at {}",
                           edgeWords(edges[0]), kNames[2 * axis + 1], kNames[2 * axis]);
      }
      if (isStraightOnly) continue;
      return fmt::format("{} at {} meets no edge at {}", edgeWords(*lonely), kNames[2 * axis + 1],
                         kNames[2 * axis]);
    }
    return {};
  }

  [[noreturn]] void refuse(const VectorLattice& lattice) const {
    std::string words = obstacle(lattice, false);
    if (words.empty()) words = "its tiles do not fill a cell";
    throw InputError(fmt::format(
        "error: --periodic needs a sheet that repeats, but {}; choose a state or a number of tiles "
        "in which the sheet repeats",
        words));
  }

  [[noreturn]] void refuseUnknown(int tile, int vertex) const {
    throw InputError(fmt::format(
        "error: --periodic cannot tell which corners the border joins: more than two meet vertex "
        "{} of tile {}; choose a state or a number of tiles in which the sheet repeats at least "
        "twice along x and y",
        vertex + countsFrom_, tile + countsFrom_));
  }

  const std::vector<std::vector<Vector3>>& tiles_;
  const std::vector<model::Joint>& joints_;
  int countsFrom_;
  std::vector<Vector3> centres_;
  std::vector<Vector3> normals_;
  Vector3 normal_ = Vector3::UnitZ();
  double size_ = 0;
  double tolerance_ = 0;
  double tileSize_ = 0;
  double reach_ = 0;  ///< the largest tile's size, metres
  bool isFlat_ = true;
  std::map<GridPlace, std::vector<int>> grid_;
  std::map<CornerPlace, std::vector<CornerPlace>> jointsAt_;
  std::vector<int> classOf_;
  std::vector<std::vector<int>> members_;  ///< the tiles of each class
};

}  // namespace

SheetLattice findSheetLattice(const std::vector<std::vector<Vector3>>& tiles,
                              const std::vector<model::Joint>& joints, int countsFrom) {
  return LatticeFinder(tiles, joints, countsFrom).find();
}

}  // namespace kirireel::fea
