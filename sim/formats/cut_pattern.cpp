// Converts a drawing to tiles and joints.
//
// 1. *Groups*: lines of one colour, layer and dash. Two kinds are ignored: hinge marks, which
//    continue open ends of other lines, and engraved lines, which touch nothing.
// 2. *Slots* become centre lines (slot_lines.cpp).
// 3. *Sheet*: tiles and joints between these lines (cut_sheet.cpp).
#include "sim/formats/cut_pattern.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <map>
#include <optional>
#include <set>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/formats/cut_sheet.h"
#include "sim/formats/middle_lines.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/own_pattern.h"
#include "sim/formats/written_digits.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;

double lengthOf(const DrawnPath& path) {
  double length = 0;
  for (std::size_t k = 0; k + 1 < path.points.size(); ++k) {
    length += (path.points[k + 1] - path.points[k]).norm();
  }
  return path.isClosed ? length + (path.points.front() - path.points.back()).norm() : length;
}

void appendSegments(const DrawnPath& path, std::vector<PlaneSegment>& segments) {
  for (std::size_t k = 0; k + 1 < path.points.size(); ++k) {
    segments.emplace_back(path.points[k], path.points[k + 1]);
  }
  if (path.isClosed) segments.emplace_back(path.points.back(), path.points.front());
}

/// " (2 x mask, which is not applied)" for what a fault may come from.
std::string notApplied(const Drawing& drawing) {
  std::vector<std::string> entries = entriesOf(drawing.ignored);
  std::erase_if(entries,
                [](const std::string& what) { return what.find(", which is not ") == what.npos; });
  return entries.empty() ? "" : fmt::format(" ({})", listed(entries));
}

/// Lines of one colour, layer and dash.
struct LineGroup {
  std::string colour, layer;
  bool isDashed = false;
  std::vector<const DrawnPath*> paths;
  std::string role = "cut";

  double length() const {
    double sum = 0;
    for (const DrawnPath* path : paths) sum += lengthOf(*path);
    return sum;
  }
};

/// Whether rigid tiles can move in their plane, to first order. Computes the rank of the joint
/// equations: w x (p - c) + v is equal for both tiles, three unknowns per tile, rotations scaled by
/// tile size. For large sheets it only counts unknowns (J. C. Maxwell).
bool movesInPlane(const model::Model& model, double tolerance) {
  constexpr std::size_t kMaxTiles = 300;  // for a dense factorisation
  const auto tiles = static_cast<Eigen::Index>(model.tiles.size());
  const auto joints = static_cast<Eigen::Index>(model.joints.size());
  if (3 * tiles - 3 > 2 * joints || model.tiles.size() > kMaxTiles) {
    return 3 * tiles - 3 > 2 * joints;
  }
  const double size = model::tileSize(model);
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(2 * joints, 3 * tiles);
  for (Eigen::Index k = 0; k < joints; ++k) {
    const model::Joint& joint = model.joints[k];
    for (const auto& [corner, sign] : {std::pair(joint.a, 1.0), {joint.b, -1.0}}) {
      const model::Tile& tile = model.tiles[corner.tile];
      const Vector3 arm = (tile.vertices[corner.vertex] - model::tileCentroid(tile)) / size;
      equations.block<2, 3>(2 * k, 3 * corner.tile) << sign, 0, -sign * arm.y(), 0, sign,
          sign * arm.x();
    }
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors(equations);
  factors.setThreshold(std::max(1e-6, 30 * tolerance / size));
  return factors.rank() < 3 * tiles - 3;
}

class CutPatternReader {
 public:
  CutPatternReader(const Drawing& drawing, const ReadSettings& settings, const fs::path& file)
      : drawing_(drawing),
        settings_(settings),
        file_(file),
        // Ends on a curve deviate from its straight pieces.
        tolerance_(std::clamp(std::max(1.5 * drawing.rounding, 1.2 * drawing.flattening),
                              1e-7 * drawing.size(), 1e-4 * drawing.size())) {
    collectGroups();
    takeRounding();
    takeDoubledLines();
    joinParallelLines();
  }

  /// Lines of ignored groups, after read().
  std::vector<DrawnPath> ignoredLines() const {
    std::vector<DrawnPath> lines = notChosen_;
    for (const DrawnPath* path :
         pathsOf([](const LineGroup& group) { return group.role != "cut"; })) {
      lines.push_back(*path);
    }
    return lines;
  }

  model::Model read(std::vector<std::string>& warnings) {
    if (groups_.empty())
      throw inputErrorAt({file_}, "no line is left to cut; choose fewer lines to ignore");
    if (settings_.cut.empty()) {
      findMarks();
      findEngraving();
    }
    CutSheet reading;
    const auto explained = [this](const InputError& error) {
      std::string text = error.what();
      if (groups_.size() > 1)
        text += fmt::format(" (lines: {}; `cut` and `ignore` choose)", describeGroups());
      text += notApplied(drawing_);
      std::deque<DrawnPath> lines;
      if (takeThinSlots(pathsOf([](const LineGroup&) { return true; }), lines) > 0) {
        text += fmt::format(
            " (slots are narrower than {:.2g} mm, but the coordinates are rounded to {:.2g} mm. "
            "Save the drawing with more decimals)",
            thinWidth() * 1e3, drawing_.rounding * 1e3);
      }
      return InputError(text);
    };
    try {
      reading = sheetOf(pathsOf([](const LineGroup& group) { return group.role == "cut"; }));
    } catch (const DrawingFault& fault) {
      throw DrawingFault(explained(fault), fault.lines(), fault.places());
    } catch (const InputError& error) {
      throw explained(error);
    }
    const TileTable table = patternTable(file_, reading.model.tiles);
    checkTiles(table);
    turnClockwiseTiles(table, reading.model, warnings);
    // Necks of a sheet that cannot open in its plane bend and twist: they are ball joints.
    const bool isHeld = reading.model.tiles.size() > 1 && !reading.model.joints.empty() &&
                        !movesInPlane(reading.model, tolerance_);
    if (isHeld) {
      for (model::Joint& joint : reading.model.joints) joint.face = model::JointFace::Bottom;
    }
    warnings.push_back(describe(reading) +
                       (isHeld ? "; no motion in its plane, so its hinges are ball joints" : ""));
    return std::move(reading.model);
  }

 private:
  /// Whether one of the words names the path's colour, layer, id, label or class.
  static bool isNamed(const DrawnPath& path, const std::vector<std::string>& words,
                      std::set<std::string>* used) {
    bool isOne = false;
    for (const std::string& word : words) {
      const std::string name = normalColour(word);
      const bool fits = path.colour == name || path.layer == name ||
                        std::ranges::find(path.names, name) != path.names.end();
      if (fits && used) used->insert(word);
      isOne |= fits;
    }
    return isOne;
  }

  /// The coordinates of a line, equal in both directions.
  static std::vector<std::pair<double, double>> undirected(const DrawnPath& path) {
    std::vector<std::pair<double, double>> points, reversed;
    for (const Vector2& point : path.points) points.emplace_back(point.x(), point.y());
    reversed.assign(points.rbegin(), points.rend());
    return std::min(points, reversed);
  }

  void collectGroups() {
    std::set<std::string> used;
    std::set<std::pair<std::ptrdiff_t, std::vector<std::pair<double, double>>>> drawn;  // by group
    for (const DrawnPath& path : drawing_.paths) {
      const bool isIgnored = isNamed(path, settings_.ignore, &used);
      const bool isCut = settings_.cut.empty() || isNamed(path, settings_.cut, &used);
      if (isIgnored || !isCut) {
        notChosen_.push_back(path);
        continue;
      }
      auto group = std::ranges::find_if(groups_, [&](const LineGroup& one) {
        return one.colour == path.colour && one.layer == path.layer &&
               one.isDashed == path.isDashed;
      });
      if (group == groups_.end()) {
        groups_.push_back({path.colour, path.layer, path.isDashed, {}, "cut"});
        group = groups_.end() - 1;
      }
      if (drawn.insert({group - groups_.begin(), undirected(path)}).second) {
        group->paths.push_back(&path);
      } else {
        ++repeated_;
      }
    }
    for (const auto* words : {&settings_.cut, &settings_.ignore}) {
      for (const std::string& word : *words) {
        if (used.contains(word)) continue;
        std::set<std::string> names;
        for (const DrawnPath& path : drawing_.paths) {
          names.insert(shown(path.colour));
          if (!path.layer.empty()) names.insert(shown(path.layer));
        }
        throw inputErrorAt(
            {file_}, fmt::format("no line has the colour, layer or id '{}' of {}. Available: {}",
                                 shown(word), words == &settings_.cut ? "`cut`" : "`ignore`",
                                 listed({names.begin(), names.end()}, 20)));
      }
    }
  }

  template <typename Filter>
  std::vector<const DrawnPath*> pathsOf(Filter filter) const {
    std::vector<const DrawnPath*> paths;
    for (const LineGroup& group : groups_) {
      if (filter(group)) paths.insert(paths.end(), group.paths.begin(), group.paths.end());
    }
    return paths;
  }

  static std::vector<PlaneSegment> segmentsOf(const std::vector<const DrawnPath*>& paths) {
    std::vector<PlaneSegment> segments;
    for (const DrawnPath* path : paths) appendSegments(*path, segments);
    return segments;
  }

  /// Coordinates with few digits are rounded, or exact because the design is on a grid. If rounded,
  /// most ends miss the sloping line to which they were drawn by a fraction of the last digit. Then
  /// the tolerance is the rounding, but less than necks.
  void takeRounding() {
    const double most = 1.5 * drawing_.rounding;
    if (tolerance_ >= most) return;
    const auto paths = pathsOf([](const LineGroup&) { return true; });
    std::vector<PlaneSegment> segments = segmentsOf(paths);
    std::vector<int> pathOf;
    for (std::size_t k = 0; k < paths.size(); ++k) {
      pathOf.insert(pathOf.end(), paths[k]->points.size() - (paths[k]->isClosed ? 0 : 1),
                    static_cast<int>(k));
    }
    const int lines = static_cast<int>(segments.size());
    for (std::size_t k = 0; k < paths.size(); ++k) {
      if (paths[k]->isClosed) continue;
      for (const Vector2& end : {paths[k]->points.front(), paths[k]->points.back()}) {
        segments.emplace_back(end, end);
        pathOf.push_back(static_cast<int>(k));
      }
    }
    const double far = 4 * most;
    std::vector<double> misses(segments.size() - lines, far);
    std::vector<bool> isTold(misses.size(), false);  // by the nearest line
    visitNearSegments(segments, far, [&](int i, int j) {
      if ((i < lines) == (j < lines) || pathOf[i] == pathOf[j]) return;
      const int k = std::max(i, j) - lines;
      const PlaneSegment& line = segments[std::min(i, j)];
      const Vector2& end = segments[std::max(i, j)].first;
      const double miss = distanceTo(line, end);
      if (miss >= misses[k]) return;
      misses[k] = miss;
      const bool isSloping = (line.second - line.first).cwiseAbs().minCoeff() > drawing_.rounding;
      const double off = std::min((end - line.first).norm(), (end - line.second).norm());
      isTold[k] = isSloping && off > most;
    });
    // Ends of a design on a grid miss by multiples of the last digit.
    int exact = 0, near = 0;
    for (std::size_t k = 0; k < misses.size(); ++k) {
      if (!isTold[k] || misses[k] >= 0.5 * drawing_.rounding) continue;
      ++(misses[k] < 0.02 * drawing_.rounding ? exact : near);
    }
    if (near <= exact) return;
    double neck = far;
    for (const double miss : misses) {
      if (miss > most) neck = std::min(neck, miss);
    }
    tolerance_ = std::max(tolerance_, std::min(most, 0.5 * neck));
  }

  /// A cut that is drawn as two parallel lines, without the ends of its slot, is their middle line.
  /// A strip of this shape between three or more lines is material.
  void joinParallelLines() {
    constexpr double kStrip = 0.02;  // width / length, less than of any tile
    for (LineGroup& group : groups_) {
      std::vector<const DrawnPath*> open;
      closedRings(group.paths, tolerance_, open);
      dropSidesOfOutlines(open);
      std::vector<PlaneSegment> chords;
      for (const DrawnPath* path : open)
        chords.emplace_back(path->points.front(), path->points.back());
      std::vector<std::vector<int>> partners(open.size());
      visitNearSegments(chords, kStrip * drawing_.size(), [&](int i, int j) {
        const double apart = apartOf(*open[i], *open[j]);
        const double length = std::min(lengthOf(*open[i]), lengthOf(*open[j]));
        if (apart > kStrip * length) return;
        partners[i].push_back(j);
        partners[j].push_back(i);
      });
      for (int i = 0; i < std::ssize(open); ++i) {
        if (partners[i].size() != 1 || partners[i][0] < i) continue;
        const int j = partners[i][0];
        const double apart = apartOf(*open[i], *open[j]);
        if (partners[j].size() != 1 || apart <= tolerance_) continue;
        middles_.push_back(middleOf(*open[i], *open[j]));
        std::erase(group.paths, open[j]);
        std::ranges::replace(group.paths, open[i], &middles_.back());
        joinedApart_ = std::max(joinedApart_, apart);
      }
    }
  }

  /// Drops lines that continue with a bend, such as the sides of a slot in separate lines.
  void dropSidesOfOutlines(std::vector<const DrawnPath*>& open) const {
    constexpr double kMinBend = 0.02;  // radians
    if (open.empty()) return;
    struct CutPathEnd {
      std::size_t path = 0;
      Vector2 inwards;  // unit vector
    };
    PointNumbers numbers(tolerance_, open.front()->points.front());
    std::vector<std::vector<CutPathEnd>> at;
    for (std::size_t k = 0; k < open.size(); ++k) {
      const auto& p = open[k]->points;
      for (const auto& [end, before] : {std::pair(p.front(), p[1]), {p.back(), p[p.size() - 2]}}) {
        const int number = numbers.add(end);
        at.resize(numbers.count());
        at[number].push_back({k, (before - end).normalized()});
      }
    }
    std::set<const DrawnPath*> bent;
    for (const std::vector<CutPathEnd>& ends : at) {
      for (const CutPathEnd& one : ends) {
        for (const CutPathEnd& other : ends) {
          if (one.path == other.path || (one.inwards + other.inwards).norm() < kMinBend) continue;
          bent.insert(open[one.path]);
        }
      }
    }
    std::erase_if(open, [&](const DrawnPath* path) { return bent.contains(path); });
  }

  /// Lines drawn twice may differ by more than the tolerance. Raises the tolerance to that. Slots
  /// are wider than kTwice of their drawing.
  void takeDoubledLines() {
    constexpr double kTwice = 1e-5;  // fraction of the drawing's size
    const double most = kTwice * drawing_.size();
    if (tolerance_ >= most) return;
    const std::vector<PlaneSegment> segments =
        segmentsOf(pathsOf([](const LineGroup&) { return true; }));
    double apart = 0;
    visitNearSegments(segments, most, [&](int i, int j) {
      const auto lengthOf = [&](int k) { return (segments[k].second - segments[k].first).norm(); };
      const bool isFirstShorter = lengthOf(i) < lengthOf(j);
      const PlaneSegment& one = segments[isFirstShorter ? i : j];
      const PlaneSegment& other = segments[isFirstShorter ? j : i];
      if ((one.second - one.first).norm() < 100 * most) return;
      const double off = std::max(distanceTo(other, one.first), distanceTo(other, one.second));
      if (off <= most) apart = std::max(apart, off);
    });
    tolerance_ = std::max(tolerance_, 1.5 * apart);
  }

  /// The number of hinges if these lines are the cuts; 0 if they are not a sheet.
  std::size_t hingesOf(const std::vector<const DrawnPath*>& paths) const {
    try {
      return sheetOf(paths).model.joints.size();
    } catch (const InputError&) {
      return 0;
    }
  }

  /// Finds hinge marks: short straight continuations of open ends of other lines, and dashed lines
  /// if they add no hinges as cuts.
  void findMarks() {
    std::vector<LineGroup*> byLength;
    for (LineGroup& group : groups_) byLength.push_back(&group);
    std::ranges::stable_sort(byLength, {}, &LineGroup::length);
    const bool hasSolid =
        std::ranges::any_of(groups_, [](const LineGroup& group) { return !group.isDashed; });
    for (LineGroup* group : byLength) {
      const auto others =
          pathsOf([&](const LineGroup& one) { return &one != group && one.role == "cut"; });
      if (others.empty()) return;
      if (group->isDashed && hasSolid) {
        auto both = others;
        both.insert(both.end(), group->paths.begin(), group->paths.end());
        if (hingesOf(both) <= hingesOf(others)) group->role = "hinge mark";
        continue;
      }
      const Arrangement lines(segmentsOf(others), tolerance_);
      const auto isMark = [&](const DrawnPath* path) {
        const double apart = (path->points.back() - path->points.front()).norm();
        if (path->isClosed || lengthOf(*path) > 1.05 * apart) return false;
        for (const bool isReversed : {false, true}) {
          const Vector2& from = isReversed ? path->points.back() : path->points.front();
          const Vector2& to = isReversed ? path->points.front() : path->points.back();
          const std::optional<int> node = lines.nodeAt(from);
          if (!node || lines.leaving(*node).size() != 1) continue;
          const Vector2 mark = to - from;
          // The straight cut before it, regardless of crossing lines.
          int last = *node;
          double length = 0;
          for (bool continues = true; continues && length <= 4 * mark.norm();) {
            continues = false;
            for (const int half : lines.leaving(last)) {
              const Vector2 step = lines.at(last) - lines.at(lines.to(half));
              if (step.dot(mark) < 0.98 * step.norm() * mark.norm()) continue;
              length += step.norm();
              last = lines.to(half);
              continues = true;
              break;
            }
          }
          if (length > 2 * mark.norm()) return true;
        }
        return false;
      };
      const auto marks = std::ranges::count_if(group->paths, isMark);
      if (5 * marks >= 4 * std::ssize(group->paths) || areBridges(*group, others)) {
        group->role = "hinge mark";
      }
    }
  }

  /// Whether a group of short straight lines would cut hinges between the other lines.
  bool areBridges(const LineGroup& group, const std::vector<const DrawnPath*>& others) const {
    constexpr double kShort = 0.25;  // fraction of a tile
    const auto sheet = ifSheet([&] { return sheetOf(others); });
    if (!sheet || sheet->model.joints.empty()) return false;
    const double most = kShort * model::tileSize(sheet->model);
    const bool areShort = std::ranges::all_of(group.paths, [&](const DrawnPath* path) {
      return !path->isClosed && path->points.size() == 2 && lengthOf(*path) <= most;
    });
    if (!areShort) return false;
    auto both = others;
    both.insert(both.end(), group.paths.begin(), group.paths.end());
    return hingesOf(both) < sheet->model.joints.size();
  }

  /// Whether all lines of a group have a name for engraving.
  static bool isNamedEngraving(const LineGroup& group) {
    static const std::vector<std::string> kWords = {"engrav", "etch",       "score",    "scoring",
                                                    "gravur", "annotation", "dimension"};
    const auto isOne = [](const std::string& name) {
      return name == "eng" || std::ranges::any_of(kWords, [&](const std::string& word) {
               return name.find(word) != name.npos;
             });
    };
    return std::ranges::all_of(group.paths, [&](const DrawnPath* path) {
      return isOne(path->layer) || std::ranges::any_of(path->names, isOne);
    });
  }

  /// Finds engraving: lines with such a name, and lines that touch nothing and are not the aim of a
  /// neck, or closed lines that cross others and add no hinges. Without them the remaining lines
  /// must still form a sheet.
  void findEngraving() {
    if (groups_.size() < 2 || groups_.size() > 12) return;
    std::vector<PlaneSegment> segments;
    std::vector<int> groupOf;
    for (int g = 0; g < std::ssize(groups_); ++g) {
      for (const DrawnPath* path : groups_[g].paths) appendSegments(*path, segments);
      groupOf.resize(segments.size(), g);
    }
    std::vector<bool> touches(groups_.size(), false), crosses(groups_.size(), false);
    visitNearSegments(segments, 2 * tolerance_, [&](int i, int j) {
      const int one = groupOf[i], other = groupOf[j];
      if (one == other || (crosses[one] && crosses[other])) return;
      if (groups_[one].role != "cut" || groups_[other].role != "cut") return;
      if (!meet(segments[i], segments[j])) return;
      touches[one] = touches[other] = true;
      if (touchesEnd(segments[i], segments[j])) return;
      crosses[one] = crosses[other] = true;
    });
    for (int g = 0; g < std::ssize(groups_); ++g) {
      const bool isNamed = isNamedEngraving(groups_[g]);
      const bool isCrossing =
          crosses[g] && std::ranges::all_of(groups_[g].paths, &DrawnPath::isClosed);
      if (groups_[g].role != "cut" || (touches[g] && !isCrossing && !isNamed)) continue;
      const auto rest =
          pathsOf([&](const LineGroup& one) { return &one != &groups_[g] && one.role == "cut"; });
      if (rest.empty() || (!isNamed && isCrossing && areReliefs(groups_[g], rest))) continue;
      if (isNamed || touches[g]) {
        const std::size_t hinges = hingesOf(rest);
        if (hinges > 0 && (isNamed || hinges >= hingesOf(pathsOf([](const LineGroup& one) {
                                        return one.role == "cut";
                                      })))) {
          groups_[g].role = "engraved";
        }
        continue;
      }
      try {
        const CutSheet reading = sheetOf(rest);
        if (reading.model.joints.empty() || stopsShort(groups_[g], rest, reading.model)) continue;
        groups_[g].role = "engraved";
      } catch (const InputError&) {
        continue;  // without it the remaining lines are not a sheet
      }
    }
  }

  /// Whether each line of a group, all closed, is a relief at the end of a slit.
  bool areReliefs(const LineGroup& group, std::vector<const DrawnPath*> others) const {
    std::vector<PlaneRing> rings;
    for (const DrawnPath* path : group.paths) rings.push_back(path->points);
    const std::size_t count = others.size();
    others.insert(others.end(), group.paths.begin(), group.paths.end());
    CutLines cuts;
    takeReliefs(others, rings, cuts);
    return others.size() == count;
  }

  /// Whether an end of one line is on the other.
  bool touchesEnd(const PlaneSegment& a, const PlaneSegment& b) const {
    const auto near = [&](const Vector2& point, const PlaneSegment& line) {
      return distanceTo(line, point) <= tolerance_;
    };
    return near(a.first, b) || near(a.second, b) || near(b.first, a) || near(b.second, a);
  }

  bool meet(const PlaneSegment& a, const PlaneSegment& b) const {
    if (touchesEnd(a, b)) return true;
    const auto side = [](const PlaneSegment& line, const Vector2& point) {
      return crossZ(line.second - line.first, point - line.first) > 0;
    };
    return side(a, b.first) != side(a, b.second) && side(b, a.first) != side(b, a.second);
  }

  /// Whether half of a group's open ends would be necks to the other lines.
  bool stopsShort(const LineGroup& group, const std::vector<const DrawnPath*>& rest,
                  const model::Model& model) const {
    const std::vector<PlaneSegment> lines = segmentsOf(rest);
    const double near = 0.25 * model::tileSize(model);
    int ends = 0, necks = 0;
    for (const DrawnPath* path : group.paths) {
      if (path->isClosed) continue;
      const auto& p = path->points;
      for (const auto& [end, before] : {std::pair(p.front(), p[1]), {p.back(), p[p.size() - 2]}}) {
        ++ends;
        const PlaneSegment ray(end, end + near * (end - before).normalized());
        necks +=
            std::ranges::any_of(lines, [&](const PlaneSegment& line) { return meet(ray, line); });
      }
    }
    return ends > 0 && 2 * necks >= ends;
  }

  /// Reads the lines as a sheet. Rounding closes, opens and bends slots that are about as narrow as
  /// the last digit of their coordinates: they are read as lines.
  CutSheet sheetOf(std::vector<const DrawnPath*> paths) const {
    std::map<std::string, int> leftOut;
    dropMarksOutside(paths, leftOut);
    std::deque<DrawnPath> thinned;
    const int thin = takeThinSlots(paths, thinned);
    if (thin == 0) return readPaths(paths, leftOut, tolerance_);
    std::map<std::string, int> leftOutOfLines = leftOut;
    leftOutOfLines["width of a slot (about the last digit of its coordinates)"] += thin;
    std::vector<const DrawnPath*> lines;
    for (const DrawnPath& path : thinned) lines.push_back(&path);
    // Ends that meet may differ by a digit in each direction.
    const double tolerance = std::max(tolerance_, 2 * drawing_.rounding);
    return readBest([&] { return readPaths(paths, leftOut, tolerance_); },
                    [&] { return readPaths(lines, leftOutOfLines, tolerance); });
  }

  CutSheet readPaths(std::vector<const DrawnPath*> paths, const std::map<std::string, int>& leftOut,
                     double tolerance) const {
    std::vector<const DrawnPath*> open;
    const auto rings = closedRings(paths, tolerance, open);
    requireApart(rings, open);
    const auto readAs = [&](CutLines cuts) {
      for (const auto& [what, count] : leftOut) cuts.leftOut[what] += count;
      const auto sheet = [&] {
        // Centre lines are accurate to a small fraction of their slots' width.
        return sheetOfCuts(cuts, drawing_, settings_, std::max(tolerance, 0.03 * cuts.kerf), file_);
      };
      const std::vector<OpeningTip> tips = std::exchange(cuts.tips, {});
      if (tips.empty()) return sheet();
      const auto openings = std::exchange(cuts.openings, {});
      return readBest(sheet, [&] {
        cuts.tips = tips;
        cuts.openings = openings;
        return sheet();
      });
    };
    const auto asSlots = [&]() -> std::optional<CutSheet> {
      if (rings.empty()) return std::nullopt;
      CutLines cuts = slotLines(rings, open, tolerance);
      if (cuts.lines.empty()) return std::nullopt;
      requireSimple(rings);
      return readAs(std::move(cuts));
    };
    std::optional<CutSheet> slots;
    if (open.empty()) slots = asSlots();
    CutLines slits;
    takeReliefs(paths, rings, slits);
    slits.lines = segmentsOf(paths);
    takeTips(rings, tolerance, slits);
    // Openings may overlap each other, and the outline.
    const auto asMaterial = [&]() -> std::optional<CutSheet> {
      if (!crossingOf(rings, false)) return std::nullopt;
      const auto material = materialRings(rings);
      if (material.empty()) return std::nullopt;
      CutLines cuts;
      cuts.lines = segmentsOf(open);
      for (const auto& ring : material) appendRing(ring, cuts.lines);
      takeTips(material, tolerance, cuts);
      return readAs(std::move(cuts));
    };
    const auto asLines = [&] { return readAs(std::move(slits)); };
    const auto asOpenings = [&] { return readBest(asLines, asMaterial); };
    // Slots without a hinge are holes, or openings as wide as tiles.
    if (slots && !slots->model.joints.empty())
      return readBest([&] { return std::move(*slots); }, asOpenings);
    if (open.empty()) return asOpenings();
    // Closed outlines next to open lines are slots, reliefs, holes or marks.
    return readBest([&] { return readBest(asLines, asSlots); }, asMaterial);
  }

  /// A point where a closed line crosses itself, or another one; absent if there is none.
  std::optional<Vector2> crossingOf(const std::vector<PlaneRing>& rings, bool isItself) const {
    std::vector<PlaneSegment> sides;
    std::vector<std::size_t> ringOf;
    for (std::size_t k = 0; k < rings.size(); ++k) {
      appendRing(rings[k], sides);
      ringOf.resize(sides.size(), k);
    }
    std::optional<Vector2> place;
    visitNearSegments(sides, tolerance_, [&](int i, int j) {
      if (place || (ringOf[i] == ringOf[j]) != isItself) return;
      const Vector2 u = sides[i].second - sides[i].first, v = sides[j].second - sides[j].first;
      const auto shares = crossingShares(sides[i].first, u, sides[j].first, v);
      const auto isInside = [&](double share, const Vector2& side) {
        return std::min(share, 1 - share) * side.norm() > tolerance_;
      };
      if (shares && isInside(shares->first, u) && isInside(shares->second, v)) {
        place = sides[i].first + shares->first * u;
      }
    });
    return place;
  }

  DrawingFault crossingAt(const Vector2& place, fmt::format_string<std::string> what) const {
    return {
        inputErrorAt({file_}, fmt::format(what, drawing_.place(place))), drawing_.paths, {place}};
  }

  /// Refuses outlines of sheets, with cuts inside, that cross each other.
  void requireApart(const std::vector<PlaneRing>& rings,
                    const std::vector<const DrawnPath*>& open) const {
    constexpr int kCuts = 2;  // a slot or a hole may hold a mark
    std::vector<PlaneRing> sheets;
    for (const PlaneRing& ring : rings) {
      const Eigen::AlignedBox2d box = boundingBox(ring);
      const auto cuts =
          std::ranges::count_if(rings,
                                [&](const PlaneRing& cut) {
                                  return box.contains(cut.front()) && areWithinRing(ring, cut);
                                }) +
          std::ranges::count_if(
              open, [&](const DrawnPath* path) { return areWithinRing(ring, path->points); });
      if (cuts >= kCuts) sheets.push_back(ring);
    }
    if (const std::optional<Vector2> place = crossingOf(sheets, false)) {
      throw crossingAt(*place,
                       "outlines of two sheets cross at {}. Draw the sheets next to each other");
    }
  }

  template <typename Read>
  static std::optional<CutSheet> ifSheet(Read read) {
    try {
      return read();
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  /// The reading with more hinges is right: lines that are not cuts separate no tiles. If both have
  /// as many, the first one.
  template <typename ReadFirst, typename ReadSecond>
  static CutSheet readBest(ReadFirst readFirst, ReadSecond readSecond) {
    try {
      CutSheet reading = readFirst();
      auto other = ifSheet(readSecond);
      const bool isOther = other && other->model.joints.size() > reading.model.joints.size();
      return isOther ? std::move(*other) : std::move(reading);
    } catch (const InputError&) {
      auto other = ifSheet(readSecond);
      if (!other || other->model.joints.empty()) throw;
      return std::move(*other);
    }
  }

  /// Width below which rounding can close, open or bend a slot, metres.
  double thinWidth() const {
    constexpr double kDigits = 5;
    return kDigits * drawing_.rounding;
  }

  /// The lines with closed outlines of thin slots as their middle lines. Returns their number.
  int takeThinSlots(const std::vector<const DrawnPath*>& paths,
                    std::deque<DrawnPath>& lines) const {
    std::vector<const DrawnPath*> open;
    std::vector<DrawnPath> outlines;
    for (const std::vector<Vector2>& ring : closedRings(paths, tolerance_, open)) {
      DrawnPath& outline = outlines.emplace_back(*paths.front());
      outline.points = ring;
      outline.isClosed = true;
    }
    const auto isThin = [&](const DrawnPath& outline) {
      return middleOfThin(outline, thinWidth()).has_value();
    };
    if (std::ranges::none_of(outlines, isThin)) return 0;
    // Widths of equal slots differ by the rounding of both sides.
    const double widest = thinWidth() + 2 * drawing_.rounding;
    int count = 0;
    for (const DrawnPath& outline : outlines) {
      const std::optional<DrawnPath> middle = middleOfThin(outline, widest);
      count += middle ? 1 : 0;
      lines.push_back(middle.value_or(outline));
    }
    for (const DrawnPath* path : open) lines.push_back(*path);
    return count;
  }

  /// Outlines of sheets and slots must not cross themselves. If more than two lines meet at a
  /// point, the outline is ambiguous.
  void requireSimple(const std::vector<PlaneRing>& rings) const {
    PointNumbers numbers(tolerance_, rings.front().front());
    std::vector<int> uses;
    for (const std::vector<Vector2>& ring : rings) {
      for (const Vector2& point : ring) {
        const int number = numbers.add(point);
        uses.resize(numbers.count());
        ++uses[number];
      }
    }
    std::vector<PlaneRing> own;
    std::ranges::copy_if(rings, std::back_inserter(own), [&](const std::vector<Vector2>& ring) {
      return std::ranges::all_of(
          ring, [&](const Vector2& point) { return uses[*numbers.find(point)] == 1; });
    });
    if (const std::optional<Vector2> place = crossingOf(own, true)) {
      throw crossingAt(*place, "an outline crosses itself at {}; draw it without the crossing");
    }
  }

  /// Removes parts of the drawing that are one ring around another part with most open ends: the
  /// frames of pages. `boxes`: of the parts with faces, by their numbers. Returns their numbers.
  static std::set<int> dropFrameParts(const Arrangement& lines, const std::vector<int>& parts,
                                      std::map<int, Eigen::AlignedBox2d>& boxes) {
    std::vector<Vector2> ends;
    std::set<int> rings;
    for (const auto& [part, box] : boxes) rings.insert(part);
    for (int node = 0; node < std::ssize(parts); ++node) {
      if (lines.leaving(node).size() == 1) ends.push_back(lines.at(node));
      if (lines.leaving(node).size() != 2) rings.erase(parts[node]);
    }
    const auto isFramed = [&](const auto& box) {
      return std::ranges::any_of(boxes, [&](const auto& other) {
        const auto inside =
            std::ranges::count_if(ends, [&](const Vector2& p) { return other.second.contains(p); });
        return other.first != box.first && box.second.contains(other.second) &&
               2 * inside > std::ssize(ends);
      });
    };
    std::set<int> frames;
    for (const auto& box : boxes) {
      if (rings.contains(box.first) && isFramed(box)) frames.insert(box.first);
    }
    for (const int part : frames) boxes.erase(part);
    return frames;
  }

  /// Removes crosses and similar marks outside the sheet. They may have faces if they are small and
  /// have open ends outside of these.
  void dropMarksOutside(std::vector<const DrawnPath*>& paths,
                        std::map<std::string, int>& leftOut) const {
    const Arrangement lines(segmentsOf(paths), tolerance_);
    const std::vector<int> parts = lines.parts();
    std::map<int, Eigen::AlignedBox2d> boxes;
    for (int c = 0; c < std::ssize(lines.cycles()); ++c) {
      if (lines.areaOf(c) <= 0) continue;
      for (const int half : lines.cycles()[c]) {
        boxes[parts[lines.from(half)]].extend(lines.at(lines.from(half)));
      }
    }
    const std::set<int> frames = dropFrameParts(lines, parts, boxes);
    if (boxes.empty()) return;
    constexpr double kMark = 0.1;  // fraction of the largest part
    const auto sizeOf = [](const auto& box) { return box.second.diagonal().norm(); };
    const double most = sizeOf(*std::ranges::max_element(boxes, {}, sizeOf));
    for (int node = 0; node < std::ssize(parts); ++node) {
      const auto box = boxes.find(parts[node]);
      if (lines.leaving(node).size() != 1 || box == boxes.end()) continue;
      const bool isOutside = lines.areaOf(lines.cycleOf(lines.leaving(node)[0])) <= 0;
      if (isOutside && sizeOf(*box) < kMark * most) boxes.erase(box);
    }
    const auto isOutside = [&](const DrawnPath* path) {
      const auto node = lines.nodeAt(path->points.front());
      if (!node || boxes.contains(parts[*node])) return false;
      return std::ranges::none_of(boxes, [&](const auto& box) {
        return std::ranges::any_of(path->points,
                                   [&](const Vector2& p) { return box.second.contains(p); });
      });
    };
    const auto isFrame = [&](const DrawnPath* path) {
      const auto node = lines.nodeAt(path->points.front());
      return node && frames.contains(parts[*node]);
    };
    std::erase_if(paths, isFrame);
    if (!frames.empty()) leftOut["frame around the sheet"] += static_cast<int>(frames.size());
    const auto count = std::erase_if(paths, isOutside);
    if (count > 0) leftOut["line outside the sheet"] += static_cast<int>(count);
  }

  /// Removes relief circles at the ends of slits. The slit then ends on their far side.
  void takeReliefs(std::vector<const DrawnPath*>& paths, const std::vector<PlaneRing>& rings,
                   CutLines& cuts) const {
    std::vector<Vector2> firsts, lasts;
    std::vector<double> lengths;
    for (const DrawnPath* path : paths) {
      if (path->isClosed) continue;
      firsts.push_back(path->points.front());
      lasts.push_back(path->points.back());
      lengths.push_back(lengthOf(*path));
    }
    const auto touches = [&](const std::vector<Vector2>& ring, const Vector2& point) {
      if (isWithinRing(ring, point)) return true;
      for (std::size_t k = 0; k < ring.size(); ++k) {
        const PlaneSegment side(ring[k], ring[(k + 1) % ring.size()]);
        if (meet({point, point}, side)) return true;
      }
      return false;
    };
    for (const std::vector<Vector2>& ring : rings) {
      int oneEnd = 0, bothEnds = 0;
      double length = 0;  // of the slit
      for (std::size_t k = 0; k < firsts.size(); ++k) {
        const int inside = (touches(ring, firsts[k]) ? 1 : 0) + (touches(ring, lasts[k]) ? 1 : 0);
        if (inside == 1) length = lengths[k];
        oneEnd += inside == 1 ? 1 : 0;
        bothEnds += inside == 2 ? 1 : 0;
      }
      // A hole of the design has more ends, or is larger.
      if (oneEnd != 1 || bothEnds > 0 || extentOf(ring) > kRelief * length) continue;
      const auto count = std::erase_if(
          paths, [&](const DrawnPath* path) { return path->isClosed && path->points == ring; });
      if (count == 0) continue;
      appendRing(ring, cuts.border);
      ++cuts.leftOut["relief at the end of a slit"];
    }
  }

  /// The tips of closed outlines, and their openings. `rings`: the closed lines, which count if
  /// other lines connect them.
  static void takeTips(std::vector<PlaneRing> rings, double tolerance, CutLines& cuts) {
    Arrangement closed(cuts.lines, tolerance);
    closed.dropBridges();
    std::vector<PlaneRing> found;
    std::vector<PlaneSegment> near;
    bool areApart = true;
    for (int c = 0; c < std::ssize(closed.cycles()); ++c) {
      if (closed.areaOf(c) <= 0) continue;
      std::vector<Vector2>& ring = found.emplace_back();
      for (const int half : closed.cycles()[c]) {
        areApart &= closed.areaOf(closed.cycleOf(half ^ 1)) <= 0;
        ring.push_back(closed.at(closed.from(half)));
        near.emplace_back(ring.back(), closed.at(closed.to(half)));
      }
    }
    if (areApart) rings = std::move(found);
    // Slits are in the material.
    const int edges = static_cast<int>(near.size());
    for (const auto& [first, last] : cuts.lines) {
      const Vector2 middle = 0.5 * (first + last);
      near.emplace_back(middle, middle);
    }
    std::vector<bool> isSlit(near.size() - edges, true);
    visitNearSegments(near, 2 * tolerance, [&](int i, int j) {
      if ((i < edges) == (j < edges)) return;
      const Vector2& middle = near[std::max(i, j)].first;
      if (distanceTo(near[std::min(i, j)], middle) <= tolerance)
        isSlit[std::max(i, j) - edges] = false;
    });
    std::vector<Vector2> middles;
    for (std::size_t k = 0; k < isSlit.size(); ++k) {
      if (isSlit[k]) middles.push_back(near[edges + k].first);
    }
    std::map<std::string, int> frames;
    if (middles.empty()) dropFrames(rings, frames);
    rings = orientedRings(std::move(rings), middles);
    cuts.tips = openingTips(rings, tolerance);
    std::ranges::copy_if(rings, std::back_inserter(cuts.openings),
                         [](const std::vector<Vector2>& ring) { return ringArea(ring) < 0; });
  }

  std::string describeGroups() const {
    std::set<std::string> layers;
    for (const LineGroup& group : groups_) layers.insert(group.layer);
    std::vector<std::string> texts;
    for (const LineGroup& group : groups_) {
      texts.push_back(fmt::format(
          "{} {}{}{} ({})", group.paths.size(), shown(group.colour),
          layers.size() > 1 && !group.layer.empty() ? " on layer " + shown(group.layer) : "",
          group.isDashed ? ", dashed" : "", group.role));
    }
    return listed(texts);
  }

  std::string describe(const CutSheet& reading) const {
    Eigen::AlignedBox2d box;
    for (const model::Tile& tile : reading.model.tiles) {
      for (const Vector3& vertex : tile.vertices) box.extend(vertex.head<2>());
    }
    std::string text = fmt::format("{}: note: {}, sheet {:.4g} x {:.4g} mm", file_.string(),
                                   reading.found, box.sizes().x() * 1e3, box.sizes().y() * 1e3);
    if (groups_.size() > 1) text += "; lines: " + describeGroups();
    if (drawing_.flattening > 0)
      text += fmt::format("; curves straight to within {:.2g} mm",
                          (drawing_.flattening + tolerance_) * 1e3);
    std::map<std::string, int> leftOut = reading.leftOut;
    for (const auto& [what, count] : drawing_.ignored) leftOut[what] += count;
    if (repeated_ > 0) leftOut["line that is drawn twice"] += repeated_;
    if (!notChosen_.empty()) {
      leftOut["line that was not chosen"] += static_cast<int>(notChosen_.size());
    }
    if (!middles_.empty()) {
      text += fmt::format("; {} cuts drawn as two lines up to {:.4g} mm apart", middles_.size(),
                          joinedApart_ * 1e3);
    }
    if (!leftOut.empty()) text += "; left out: " + listed(entriesOf(leftOut), 30);
    return text;
  }

  const Drawing& drawing_;
  const ReadSettings& settings_;
  const fs::path& file_;
  double tolerance_;
  std::vector<LineGroup> groups_;
  std::vector<DrawnPath> notChosen_;
  std::deque<DrawnPath> middles_;  // of parallel lines; their addresses are in groups_
  int repeated_ = 0;               // lines of a group that are there twice, dropped
  double joinedApart_ = 0;         // distance of parallel lines that became one, metres
};

/// Scales a drawing without a length unit: one of its units becomes this long.
void rescale(Drawing& drawing, const LengthUnit& unit) {
  const double factor = unit.metres / drawing.unit;
  for (auto* paths : {&drawing.paths, &drawing.shapes}) {
    for (DrawnPath& path : *paths) {
      for (Vector2& point : path.points) point *= factor;
    }
  }
  drawing.origin *= factor;
  drawing.rounding *= factor;
  drawing.flattening *= factor;
  drawing.unit = unit.metres;
  drawing.unitName = unit.name;
  drawing.hasUnit = true;
}

/// `ignored` receives the lines that are not cut.
model::Model readDrawnModel(const Drawing& drawing, const fs::path& file,
                            const ReadSettings& settings, std::vector<std::string>& warnings,
                            std::vector<DrawnPath>& ignored) {
  const auto readAs = [&](const ReadSettings& used) {
    CutPatternReader reader(drawing, used, file);
    model::Model model = reader.read(warnings);
    ignored = reader.ignoredLines();
    return model;
  };
  // Smaller drawings are points. Their tolerance is below the precision of doubles.
  constexpr double kMinDrawing = 1e-9;  // metres
  if (!(drawing.size() > kMinDrawing)) {
    const std::vector<std::string> others = entriesOf(drawing.ignored);
    throw inputErrorAt(
        {file}, fmt::format("the drawing has no lines of a sheet{}. Draw its outline and its cuts",
                            others.empty() ? "" : ", but " + listed(others)));
  }
  const bool isPlain = settings.cut.empty() && settings.ignore.empty() && settings.neckWidth == 0 &&
                       !settings.areJointsInNecks;
  if (isPlain && isOwnPattern(drawing)) {
    std::vector<std::string> own;
    try {
      model::Model model = ownPattern(drawing, file, own);
      warnings.insert(warnings.end(), own.begin(), own.end());
      return model;
    } catch (const InputError& error) {
      // Editors join, split and round lines. If so, read it as any other drawing, but each hinge is
      // a joint.
      ReadSettings others = settings;
      std::size_t hinges = 0;
      for (const DrawnPath& path : drawing.paths) {
        const bool isHinge = std::ranges::find(path.names, "hinges") != path.names.end();
        hinges += isHinge ? path.points.size() - 1 : 0;
      }
      if (hinges > 0) others.ignore = {"hinges"};
      try {
        model::Model model = readAs(others);
        if (hinges == 0 || model.joints.size() == hinges) return model;
      } catch (const InputError&) {
      }
      throw error;
    }
  }
  return readAs(settings);
}

}  // namespace

model::Model readCutPattern(const fs::path& file, const ReadSettings& settings,
                            std::vector<std::string>& warnings) {
  return readDrawnSheet(file, settings, warnings).model;
}

DrawnSheet readDrawnSheet(const fs::path& file, const ReadSettings& settings,
                          std::vector<std::string>& warnings) {
  Drawing drawing = readDrawing(file);
  if (!drawing.hasUnit && settings.unit) rescale(drawing, *settings.unit);
  if (!drawing.hasUnit) {
    warnings.push_back(fmt::format(
        "{}: note: the drawing has no unit of length, so {}. `unit` sets another", file.string(),
        drawing.unitName == "px" ? "pixels are 1/96 inch" : "its numbers are in mm"));
  }
  // Other units, such as px, are shown in millimetres, the most common unit of exported drawings.
  const LengthUnit unit =
      settings.unit.value_or(findLengthUnit(drawing.unitName).value_or(millimetre()));
  ReadSettings inMetres = settings;
  inMetres.neckWidth *= unit.metres;
  DrawnSheet sheet;
  std::vector<std::string> notes;
  sheet.model = readDrawnModel(drawing, file, inMetres, notes, sheet.ignored);
  // Without hinges, the shapes that were omitted may be the slots.
  if (sheet.model.joints.empty() && !drawing.shapes.empty()) {
    Drawing whole = drawing;
    whole.paths.insert(whole.paths.end(), drawing.shapes.begin(), drawing.shapes.end());
    whole.ignored.erase(kShapeWithoutStroke);
    DrawnSheet other;
    std::vector<std::string> otherNotes;
    try {
      other.model = readDrawnModel(whole, file, inMetres, otherNotes, other.ignored);
    } catch (const InputError&) {
    }
    if (!other.model.joints.empty()) {
      sheet = std::move(other);
      notes = std::move(otherNotes);
    }
  }
  warnings.insert(warnings.end(), notes.begin(), notes.end());
  sheet.model.unit = unit;
  // Corners where lines meet have more digits than the lines.
  sheet.model.rounding = roundingOf(sheet.model.tiles, drawing.rounding);
  return sheet;
}

}  // namespace kirireel::formats
