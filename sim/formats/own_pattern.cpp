// Converts Kirireel's own cut patterns from lines to tiles.
//
// A cut pattern draws each side of a tile as a line in the tile's orientation (its inside on the
// left). Sides shared by two tiles are drawn once, as slits. At each joint m a neck of material
// remains: the two sides around the narrower gap end before m. A line on the layer of hinges goes
// from m to h, the middle between their ends. If the gap is open, a cut connects these ends.
//
// 1. *Necks* are removed: cuts whose middle is the h of a hinge.
// 2. *Ends* that a hinge shortened are moved back to its m: ends at its h, ends of its neck, and
//    ends of a single line that points at an m (if several hinges shortened one side).
// 3. *Cuts* have a tile on one side. A ray from the middle of a cut to its tile crosses an odd
//    number of other cuts. Editors reverse and mirror lines, so their own directions do not count.
// 4. *Tiles* are the cycles of directed sides. At a vertex the next side is the first one clockwise
//    from the reverse of the incoming side. The tile's own corner lies between them.
// 5. *Joints* connect two corners at m. The line of the hinge lies between the bisectors of their
//    angles, and no other bisector does.
//
// Step 4 traces the faces of a planar straight-line graph, as in a doubly connected edge list (M.
// de Berg, O. Cheong, M. van Kreveld, M. Overmars, Computational Geometry, chapter 2). Cuts are
// traced in one direction. Slits have a tile on both sides.
//
// All tolerances are fractions of the pattern's size: 1e-7 for points, ten times that for ends
// computed from a neck, a hundred times that for lines that point at a joint. In a drawing with
// fewer digits they are 2, 4 and 6 units of the last digit. The direction of a line of length L has
// the tolerance of points / L. A distance d beyond its end, the line is off by d / L as much as its
// ends.
#include "sim/formats/own_pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <unordered_map>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/formats/arrangement.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPatternPurpose = "give a cut pattern from `kirireel export`";
// Points nearer than this fraction of the pattern's size are one.
constexpr double kSamePatternPoint = 1e-7;
constexpr double kTurn = 2 * std::numbers::pi;

enum class LineLayer { Cuts, Slits, Hinges, Other };

/// The layer from the first name that is a layer of ours. Editors may have added other layers.
LineLayer layerOf(const DrawnPath& path) {
  for (const std::string& name : path.names) {
    if (name == "cuts") return LineLayer::Cuts;
    if (name == "slits") return LineLayer::Slits;
    if (name == "hinges") return LineLayer::Hinges;
  }
  return LineLayer::Other;
}

struct DrawnLine {
  LineLayer layer = LineLayer::Cuts;
  Vector2 from = Vector2::Zero();
  Vector2 to = Vector2::Zero();
};

InputError patternFault(const fs::path& file, const std::string& what) {
  return inputErrorAt({file}, fmt::format("{}; {}", what, kPatternPurpose));
}

std::vector<DrawnLine> linesOf(const Drawing& drawing) {
  std::vector<DrawnLine> lines;
  for (const DrawnPath& path : drawing.paths) {
    const LineLayer layer = layerOf(path);
    if (layer == LineLayer::Other) continue;
    for (std::size_t k = 0; k + 1 < path.points.size(); ++k) {
      lines.push_back({layer, path.points[k], path.points[k + 1]});
    }
    if (path.isClosed) lines.push_back({layer, path.points.back(), path.points.front()});
  }
  return lines;
}

double angleOf(const Vector2& direction) {
  return std::atan2(direction.y(), direction.x());
}

struct DrawnNeck {
  Vector2 joint;   ///< m
  Vector2 middle;  ///< h
};

/// A directed side of a tile, with the tile on its left.
struct DirectedSide {
  int from = 0;
  int to = 0;
  int twin = -1;  ///< the same slit in the opposite direction; -1 for cuts
  int tile = -1;
  int vertex = -1;         ///< index of its start within its tile
  bool isReverse = false;  ///< the second side of a slit
};

class PatternReader {
 public:
  PatternReader(const Drawing& drawing, const fs::path& file)
      : lines_(linesOf(drawing)),
        drawing_(drawing),
        file_(file),
        isRounded_(2 * drawing.rounding > kSamePatternPoint * sizeOf(lines_)),
        tolerance_(isRounded_ ? std::min(2 * drawing.rounding, 1e-4 * sizeOf(lines_))
                              : kSamePatternPoint * sizeOf(lines_)),
        origin_(lines_.empty() ? Vector2(0, 0) : lines_.front().from),
        points_(tolerance_, origin_) {
    if (!(tolerance_ > 0)) throw patternFault(file_, "the file has no lines of a sheet");
    takeNecks();
    restoreEnds();
    orientCuts();
    for (int k = 0; k < std::ssize(sides_); ++k) leaving_[sides_[k].from].push_back(k);
    for (int k = 0; k < std::ssize(sides_); ++k) {
      // The reverse sides of slits come last, so tiles begin with their own lines.
      if (!sides_[k].isReverse && sides_[k].tile < 0) traceTile(k);
    }
    for (int k = 0; k < std::ssize(sides_); ++k) {
      if (sides_[k].tile < 0) traceTile(k);
    }
  }

  // One tile for each cycle, in tracing order.
  std::vector<model::Tile> tiles() const {
    std::vector<model::Tile> tiles;
    for (const std::vector<int>& cycle : cycles_) {
      model::Tile& tile = tiles.emplace_back();
      for (const int side : cycle) {
        const Vector2& point = points_[sides_[side].from];
        tile.vertices.emplace_back(point.x(), point.y(), 0);
      }
    }
    return tiles;
  }

  // One joint for each drawn hinge.
  std::vector<model::Joint> joints() {
    std::vector<model::Joint> joints;
    for (const DrawnNeck& neck : necks_) joints.push_back(jointAt(neck));
    return joints;
  }

 private:
  double endTolerance() const { return (isRounded_ ? 2 : 10) * tolerance_; }
  double directionTolerance() const { return (isRounded_ ? 3 : 100) * tolerance_; }

  // Diagonal of the bounding box of all lines, metres.
  static double sizeOf(const std::vector<DrawnLine>& lines) {
    Eigen::AlignedBox2d box;
    for (const DrawnLine& line : lines) box.extend(line.from).extend(line.to);
    return box.isEmpty() ? 0 : box.diagonal().norm();
  }

  /// Reverses hinges that end at their m: their begin is the middle of a neck, or the end of one
  /// slit.
  void orientHinges() {
    PointNumbers places(endTolerance(), origin_);
    std::unordered_map<int, int> hinges, ends, middles;  // counts at each position
    for (const DrawnLine& line : lines_) {
      const bool isHinge = line.layer == LineLayer::Hinges;
      for (const Vector2& end : {line.from, line.to}) ++(isHinge ? hinges : ends)[places.add(end)];
      if (line.layer == LineLayer::Cuts) ++middles[places.add(0.5 * (line.from + line.to))];
    }
    const auto isMiddle = [&](const Vector2& point) {
      const int place = *places.find(point);
      return middles[place] > 0 || (ends[place] == 1 && hinges[place] == 1);
    };
    for (DrawnLine& line : lines_) {
      if (line.layer != LineLayer::Hinges || !isMiddle(line.from) || isMiddle(line.to)) continue;
      std::swap(line.from, line.to);
    }
  }

  /// Step 1: hinges, their necks, and the ends that they shortened.
  void takeNecks() {
    orientHinges();
    PointNumbers middles(endTolerance(), origin_);
    for (const DrawnLine& line : lines_) {
      if (line.layer != LineLayer::Hinges) continue;
      necks_.push_back({line.from, line.to});
      const int middle = middles.add(line.to);
      if (middle < std::ssize(neckAt_)) continue;
      neckAt_.push_back(static_cast<int>(necks_.size()) - 1);
    }
    shortened_ = PointNumbers(endTolerance(), origin_);
    for (const int neck : neckAt_) addShortened(necks_[neck].middle, neck);
    std::erase_if(lines_, [&](const DrawnLine& line) {
      if (line.layer == LineLayer::Hinges) return true;
      if (line.layer != LineLayer::Cuts) return false;
      const auto middle = middles.find(0.5 * (line.from + line.to));
      if (!middle) return false;
      const int neck = neckAt_[*middle];
      const Vector2& joint = necks_[neck].joint;
      const double uneven = std::abs((line.from - joint).norm() - (line.to - joint).norm());
      if (uneven > directionTolerance()) return false;
      addShortened(line.from, neck);
      addShortened(line.to, neck);
      return true;
    });
  }

  // Records that the hinge has shortened a side to this point. The first hinge counts.
  void addShortened(const Vector2& point, int neck) {
    const int number = shortened_.add(point);
    if (number == std::ssize(shortenedBy_)) shortenedBy_.push_back(neck);
  }

  /// Whether the extension of a line from `other` to `end` reaches the joint. A short line has an
  /// inaccurate direction.
  bool pointsAt(const Vector2& joint, const Vector2& other, const Vector2& end) const {
    const Vector2 along = (end - other).normalized();
    const Vector2 rest = joint - end;
    const double ahead = rest.dot(along);
    const double slack = directionTolerance() + 4 * tolerance_ * ahead / (end - other).norm();
    return ahead > 0 && (rest - ahead * along).norm() <= slack;
  }

  /// Step 2.
  void restoreEnds() {
    std::unordered_map<int, int> uses;
    PointNumbers ends(tolerance_, origin_);
    for (const DrawnLine& line : lines_) {
      ++uses[ends.add(line.from)];
      ++uses[ends.add(line.to)];
    }
    for (const DrawnNeck& neck : necks_) points_.add(neck.joint);
    for (const DrawnLine& line : lines_) {
      const auto wholeEnd = [&](const Vector2& end, const Vector2& other) {
        const std::optional<int> known = shortened_.find(end);
        if (known && pointsAt(necks_[shortenedBy_[*known]].joint, other, end)) {
          return necks_[shortenedBy_[*known]].joint;
        }
        const bool isLoose = uses[*ends.find(end)] == 1 && !points_.find(end);
        return isLoose ? jointAhead(end, other) : end;
      };
      const Vector2 from = wholeEnd(line.from, line.to);
      const Vector2 to = wholeEnd(line.to, line.from);
      addSide(points_.add(from), points_.add(to), line.layer == LineLayer::Slits);
    }
  }

  // The nearest joint in the direction of a line's end.
  Vector2 jointAhead(const Vector2& end, const Vector2& other) const {
    const DrawnNeck* nearest = nullptr;
    for (const DrawnNeck& neck : necks_) {
      if (!pointsAt(neck.joint, other, end)) continue;
      if (!nearest || (neck.joint - end).norm() < (nearest->joint - end).norm()) nearest = &neck;
    }
    if (nearest) return nearest->joint;
    throw patternFault(
        file_, fmt::format("the line that ends at {} is not connected", drawing_.place(end)));
  }

  // A slit becomes two sides, one for each tile. A cut has a tile on one side.
  void addSide(int from, int to, bool isSlit) {
    if (from == to) throw patternFault(file_, "a line has no length");
    const int number = static_cast<int>(sides_.size());
    sides_.push_back({from, to, isSlit ? number + 1 : -1, -1, -1});

    if (!isSlit) return;
    sides_.push_back({to, from, number, -1, -1, true});
  }

  /// Step 3: the tile is on the left. The drawn direction counts for sides along other cuts. Rays
  /// are along x or y, whichever is farther from the cut's direction. Cuts sorted by their low ends
  /// limit the search to those that a ray may meet.
  void orientCuts() {
    std::vector<DirectedSide*> cuts;
    for (DirectedSide& side : sides_) {
      if (side.twin < 0) cuts.push_back(&side);
    }
    std::vector<DirectedSide*> reversed;
    for (const int ray : {0, 1}) {
      const int across = 1 - ray;
      const auto lowEnd = [&](const DirectedSide* cut) {
        return std::min(points_[cut->from][across], points_[cut->to][across]);
      };
      std::ranges::sort(cuts, {}, lowEnd);
      double longest = 0;
      for (const DirectedSide* cut : cuts) {
        longest = std::max(longest, std::abs(alongOf(*cut)[across]));
      }
      for (DirectedSide* cut : cuts) {
        const Vector2 along = alongOf(*cut);
        const bool isSteep = std::abs(along.y()) > std::abs(along.x());
        if (isSteep != (ray == 0)) continue;
        const Vector2 middle = 0.5 * (points_[cut->from] + points_[cut->to]);
        int crossings = 0;
        bool isShared = false;
        for (auto at = std::ranges::lower_bound(cuts, middle[across] - longest, {}, lowEnd);
             at != cuts.end() && lowEnd(*at) <= middle[across]; ++at) {
          const Vector2 a = points_[(*at)->from] - middle, b = points_[(*at)->to] - middle;
          const double first = a[across], last = b[across];
          if (*at == cut || (first > 0) == (last > 0)) continue;
          const double ahead = a[ray] + first / (first - last) * (b - a)[ray];
          isShared |= std::abs(ahead) <= tolerance_;
          crossings += ahead > 0 ? 1 : 0;
        }
        // An odd number of crossings: the tile is on the side of the ray.
        const bool isRayOnLeft = ray == 0 ? along.y() < 0 : along.x() > 0;
        if (!isShared && (crossings % 2 == 1) != isRayOnLeft) reversed.push_back(cut);
      }
    }
    for (DirectedSide* cut : reversed) std::swap(cut->from, cut->to);
  }

  Vector2 alongOf(const DirectedSide& side) const { return points_[side.to] - points_[side.from]; }

  /// Tolerance of the angle between two lines, radians.
  double angleTolerance(const Vector2& a, const Vector2& b) const {
    constexpr double kMinCorner = 0.02;
    return std::min(tolerance_ / a.norm() + tolerance_ / b.norm(), kMinCorner);
  }

  /// The corner of a tile between the reverse of a side and the next side: (0, 2 pi].
  double cornerBetween(const DirectedSide& incoming, const DirectedSide& next) const {
    const Vector2 back = -alongOf(incoming), along = alongOf(next);
    const double corner = angleOf(back) - angleOf(along);
    const double least = angleTolerance(back, along);
    return corner - kTurn * std::floor((corner - least) / kTurn);
  }

  /// Step 4.
  int nextSide(int side) const {
    const DirectedSide& incoming = sides_[side];
    int best = -1;
    double least = 2 * kTurn;
    const auto found = leaving_.find(incoming.to);
    if (found == leaving_.end()) return -1;
    for (const int candidate : found->second) {
      // The reverse of the incoming slit would turn back at its end.
      if (candidate == incoming.twin) continue;
      const double corner = cornerBetween(incoming, sides_[candidate]);
      if (corner >= least) continue;
      least = corner;
      best = candidate;
    }
    return best;
  }

  // Follows sides until the first one comes again.
  void traceTile(int first) {
    std::vector<int> cycle;
    int side = first;
    do {
      sides_[side].tile = static_cast<int>(cycles_.size());
      sides_[side].vertex = static_cast<int>(cycle.size());
      cycle.push_back(side);
      side = nextSide(side);
      // The line ends, another tile has this side, or the cycle is longer than any tile.
      const bool isStray = side < 0 || (sides_[side].tile >= 0 && side != first) ||
                           cycle.size() > model::kMaxTileVertices;
      if (isStray) {
        const Vector2& where = points_[sides_[cycle.back()].to];
        throw patternFault(
            file_, fmt::format("the lines around {} do not enclose tiles", drawing_.place(where)));
      }
    } while (side != first);
    cycles_.push_back(std::move(cycle));
  }

  /// Step 5.
  model::Joint jointAt(const DrawnNeck& neck) {
    const Vector2 towards = neck.middle - neck.joint;
    std::optional<model::Corner> before, after;
    double minBefore = kTurn, minAfter = kTurn;
    bool isInTile = false;
    for (const int side : leaving_[*points_.find(neck.joint)]) {
      const DirectedSide& leaving = sides_[side];
      const model::Corner corner{leaving.tile, leaving.vertex};
      const std::vector<int>& cycle = cycles_[leaving.tile];
      const int last = cycle[(leaving.vertex + cycle.size() - 1) % cycle.size()];
      const double half = 0.5 * cornerBetween(sides_[last], leaving);
      // Anticlockwise from the line of the hinge to the bisector.
      const double turn = angleOf(alongOf(leaving)) + half - angleOf(towards);
      const double gapAfter = turn - kTurn * std::floor(turn / kTurn);
      const double gapBefore = kTurn - gapAfter;
      isInTile |= std::min(gapBefore, gapAfter) <
                  half - std::max(angleTolerance(towards, alongOf(leaving)),
                                  angleTolerance(towards, alongOf(sides_[last])));
      if (gapAfter < minAfter) {
        minAfter = gapAfter;
        after = corner;
      }
      if (gapBefore < minBefore) {
        minBefore = gapBefore;
        before = corner;
      }
    }
    if (isInTile || !before || !after || before->tile == after->tile) {
      throw patternFault(file_, fmt::format("the hinge at {} does not join two tiles",
                                            drawing_.place(neck.joint)));
    }
    model::Joint joint{*before, *after, model::JointFace::Both};
    joint.neck.width = (neck.middle - neck.joint).norm();
    return joint;
  }

  std::vector<DrawnLine> lines_;
  const Drawing& drawing_;
  const fs::path& file_;
  bool isRounded_;
  double tolerance_;  // metres
  Vector2 origin_;
  std::vector<DrawnNeck> necks_;
  std::vector<int> neckAt_;  // by the numbers of their middles
  PointNumbers shortened_{1, {0, 0}};
  std::vector<int> shortenedBy_;
  PointNumbers points_;  // of the sheet
  std::vector<DirectedSide> sides_;
  std::unordered_map<int, std::vector<int>> leaving_;  // sides by their start point
  std::vector<std::vector<int>> cycles_;
};

std::vector<Vector2> ringOf(const model::Tile& tile) {
  std::vector<Vector2> ring;
  for (const Vector3& vertex : tile.vertices) ring.push_back(vertex.head<2>());
  return ring;
}

/// In a flat sheet, closed lines within a tile are the outline of a hole.
void refuseHoles(const std::vector<model::Tile>& tiles, double tolerance, const Drawing& drawing,
                 const fs::path& file) {
  struct ViewPlace {
    int tile = 0;
    Eigen::AlignedBox2d box;
  };
  std::vector<ViewPlace> places;  // from the left
  for (int i = 0; i < std::ssize(tiles); ++i) {
    ViewPlace& place = places.emplace_back();
    place.tile = i;
    for (const Vector3& vertex : tiles[i].vertices) place.box.extend(vertex.head<2>());
  }
  std::ranges::stable_sort(places, {}, [](const ViewPlace& place) { return place.box.min().x(); });
  const Vector2 margin = Vector2::Constant(tolerance);
  for (auto inner = places.begin(); inner != places.end(); ++inner) {
    const Eigen::AlignedBox2d wide(inner->box.min() - margin, inner->box.max() + margin);
    const std::vector<Vector3>& outline = tiles[inner->tile].vertices;
    for (auto outer = places.begin(); outer != inner; ++outer) {
      const model::Tile& around = tiles[outer->tile];
      const bool isHole =
          outer->box.contains(wide) && std::ranges::all_of(outline, [&](const Vector3& vertex) {
            return isWithinRing(ringOf(around), vertex.head<2>());
          });
      if (!isHole) continue;
      throw inputErrorAt(
          {file},
          fmt::format("the lines around {} cut a hole into a tile. Tiles cannot have holes. Remove "
                      "the hole, or divide the tile into hinged tiles without holes",
                      drawing.place(outline[0].head<2>())));
    }
  }
}

}  // namespace

TileTable patternTable(const fs::path& file, const std::vector<model::Tile>& tiles) {
  TileTable table;
  table.file = file;
  table.tiles = tiles;
  for (const model::Tile& tile : tiles) {
    table.sources.push_back({0, std::vector<int>(tile.vertices.size(), 0)});
  }
  return table;
}

bool isOwnPattern(const Drawing& drawing) {
  bool hasCuts = false, hasOthers = false;
  for (const DrawnPath& path : drawing.paths) {
    const LineLayer layer = layerOf(path);
    hasCuts |= layer == LineLayer::Cuts;
    hasOthers |= layer == LineLayer::Slits || layer == LineLayer::Hinges;
  }
  return hasCuts && hasOthers;
}

model::Model ownPattern(const Drawing& drawing, const fs::path& file,
                        std::vector<std::string>& warnings) {
  PatternReader reader(drawing, file);
  model::Model model;
  model.name = file.stem().string();
  model.tiles = reader.tiles();
  if (model.tiles.empty()) throw patternFault(file, "the file has no tiles");
  const TileTable table = patternTable(file, model.tiles);
  checkTiles(table);
  refuseHoles(model.tiles, kSamePatternPoint * model::modelSize(model), drawing, file);
  model.joints = reader.joints();
  turnClockwiseTiles(table, model, warnings);
  return model;
}

}  // namespace kirireel::formats
