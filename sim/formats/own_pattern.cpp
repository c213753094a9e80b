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
// 3. *Tiles* are the faces of these lines (arrangement.h). A region next to the outside is a tile.
//    Of two neighbours across a cut, one is a tile. Two cuts at one place are a slit, which has a
//    tile on both sides. Editors reverse and mirror lines, so their directions do not count.
// 4. *Corners* of a tile are the nodes of its outline at which no single line continues.
// 5. *Joints* connect the two tiles on both sides of the gap in which the line of the hinge lies.
//
// All tolerances are fractions of the pattern's size: 1e-7 for points, ten times that for ends
// computed from a neck, a hundred times that for lines that point at a joint. In a drawing with
// fewer digits they are 2, 4 and 6 units of the last digit. The direction of a line of length L has
// the tolerance of points / L. At a distance d beyond its end, the line deviates by d / L
// times the error of its ends.
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
    findTiles();
  }

  /// The sheet, with a joint for each drawn hinge.
  model::Model read() {
    model::Model model;
    // Joints first: their corners count, also if a line continues there.
    std::vector<std::pair<int, int>> joined;  // half edges that start at the joint
    for (const DrawnNeck& neck : necks_) {
      joined.push_back(gapAt(neck));
      isCorner_[joined.back().first] = isCorner_[joined.back().second] = true;
    }
    std::vector<model::Corner> cornerAt(isCorner_.size());
    for (std::size_t cycle = 0; cycle < isTile_.size(); ++cycle) {
      if (!isTile_[cycle]) continue;
      model::Tile& tile = model.tiles.emplace_back();
      for (const int half : sheet_.cycles()[cycle]) {
        if (!isCorner_[half]) continue;
        cornerAt[half] = {static_cast<int>(model.tiles.size()) - 1,
                          static_cast<int>(tile.vertices.size())};
        const Vector2& point = sheet_.at(sheet_.from(half));
        tile.vertices.emplace_back(point.x(), point.y(), 0);
      }
    }
    for (std::size_t k = 0; k < necks_.size(); ++k) {
      model::Joint& joint = model.joints.emplace_back(model::Joint{
          cornerAt[joined[k].first], cornerAt[joined[k].second], model::JointFace::Both});
      joint.neck.width = (necks_[k].middle - necks_[k].joint).norm();
    }
    return model;
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
    for (DrawnLine& line : lines_) {
      const auto wholeEnd = [&](const Vector2& end, const Vector2& other) {
        const std::optional<int> known = shortened_.find(end);
        if (known && pointsAt(necks_[shortenedBy_[*known]].joint, other, end)) {
          return necks_[shortenedBy_[*known]].joint;
        }
        const bool isLoose = uses[*ends.find(end)] == 1 && !points_.find(end);
        return isLoose ? jointAhead(end, other) : end;
      };
      const int from = points_.add(wholeEnd(line.from, line.to));
      const int to = points_.add(wholeEnd(line.to, line.from));
      if (from == to) throw patternFault(file_, "a line has no length");
      line.from = points_[from];
      line.to = points_[to];
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

  /// Steps 3 and 4.
  void findTiles() {
    std::vector<PlaneSegment> segments;
    for (const DrawnLine& line : lines_) segments.emplace_back(line.from, line.to);
    sheet_ = Arrangement(segments, tolerance_);
    const int edges = static_cast<int>(sheet_.edges().size());
    std::vector<bool> isBoundary;
    for (int edge = 0; edge < edges; ++edge) {
      const auto& drawn = sheet_.segmentsOf(edge);
      isBoundary.push_back(drawn.size() % 2 == 1 && lines_[drawn[0]].layer == LineLayer::Cuts);
    }
    isTile_ = sheetCycles(sheet_, isBoundary, 0);
    isCorner_.assign(2 * edges, false);
    for (const std::vector<int>& cycle : sheet_.cycles()) {
      for (std::size_t k = 0; k < cycle.size(); ++k) {
        const auto& before = sheet_.segmentsOf(cycle[(k + cycle.size() - 1) % cycle.size()] / 2);
        isCorner_[cycle[k]] =
            std::ranges::find_first_of(before, sheet_.segmentsOf(cycle[k] / 2)) == before.end();
      }
    }
    const auto around = faceAround(sheet_, isTile_);
    if (!around) return;
    throw inputErrorAt(
        {file_},
        fmt::format("the lines around {} cut a hole into a tile. Tiles cannot have holes. Remove "
                    "the hole, or divide the tile into hinged tiles without holes",
                    drawing_.place(sheet_.at(around->second))));
  }

  /// Step 5: half edges that start at the joint, of the two tiles next to the gap of a hinge. The
  /// gap is where the line of the hinge is; a slit is a gap along a side of a tile.
  std::pair<int, int> gapAt(const DrawnNeck& neck) const {
    constexpr double kMinCorner = 0.02;  // radians
    const InputError fault = patternFault(
        file_, fmt::format("the hinge at {} does not join two tiles", drawing_.place(neck.joint)));
    const std::optional<int> node = sheet_.nodeAt(neck.joint);
    if (!node) throw fault;
    const std::vector<int>& around = sheet_.leaving(*node);
    const int count = static_cast<int>(around.size());
    const auto at = [&](int k) { return around[(k + 2 * count) % count]; };
    const auto isTile = [&](int k) { return isTile_[sheet_.cycleOf(at(k))]; };
    const Vector2 towards = neck.middle - neck.joint;
    const auto alongOf = [&](int k) { return Vector2(sheet_.at(sheet_.to(at(k))) - neck.joint); };
    // Anticlockwise from the hinge to a line.
    const auto turnTo = [&](int k) {
      const double turn = angleOf(alongOf(k)) - angleOf(towards);
      return turn - kTurn * std::floor(turn / kTurn);
    };
    int after = 0;  // the first line after the hinge, with a tile or a gap after it
    for (int k = 1; k < count; ++k) {
      if (turnTo(k) < turnTo(after)) after = k;
    }
    bool isBetween = true;
    if (isTile(after - 1)) {
      const double ahead = turnTo(after), behind = kTurn - turnTo(after - 1);
      const Vector2 along = alongOf(ahead < behind ? after : after - 1);
      const double most = tolerance_ / towards.norm() + tolerance_ / along.norm();
      isBetween = std::min(ahead, behind) <= std::min(most, kMinCorner);
      if (behind <= ahead) --after;
    }
    int before = after - 1;
    for (int k = 1; k < count && !isTile(before); ++k) --before;
    for (int k = 1; k < count && !isTile(after); ++k) ++after;
    if (isBetween && isTile(before) && isTile(after) &&
        sheet_.cycleOf(at(before)) != sheet_.cycleOf(at(after))) {
      return {at(before), at(after)};
    }
    throw fault;
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
  Arrangement sheet_;
  std::vector<bool> isTile_;    // of cycles
  std::vector<bool> isCorner_;  // of half edges: whether their start is a corner of the tile
};

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
  model::Model model = PatternReader(drawing, file).read();
  model.name = file.stem().string();
  if (model.tiles.empty()) throw patternFault(file, "the file has no tiles");
  const TileTable table = patternTable(file, model.tiles);
  checkTiles(table);
  turnClockwiseTiles(table, model, warnings);
  return model;
}

}  // namespace kirireel::formats
