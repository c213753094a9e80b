// Converts a drawing to tiles and joints.
//
// 1. *Groups*: lines of one colour, layer and dash. Two kinds are ignored: hinge marks, which
//    continue open ends of other lines, and engraved lines, which touch nothing.
// 2. *Slots* become centre lines (slot_lines.cpp).
// 3. *Rays*: each open end of a cut is extended straight. All rays grow at the same speed. A
//    ray stops at the first line or earlier ray. Two rays towards one vertex both stop
//    there. Ends that face each other meet midway. This is the motorcycle graph (D.
//    Eppstein, J. Erickson 1999), except that the first ray at a crossing waits there for
//    the second.
// 4. *Necks* are the rays up to a maximum width. The number of tiles changes only at ray lengths.
//    The maximum lies in the longest interval without a change below half a tile.
// 5. *Tiles* are the faces between lines and necks. A face without a neck is not a tile: it falls
//    out, or is a hole, a frame or a mark. Two tiles with two necks between them must bend.
// 6. *Joints* are at the far ends of the necks, the vertices of the design.
#include "sim/formats/cut_pattern.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/written_digits.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;

constexpr double kNever = std::numeric_limits<double>::infinity();
// Maximum deviation of a cut's direction from its aim, as a fraction of the distance.
constexpr double kAim = 0.03;
// An end of a cut beyond a line is inaccurate drawing up to this fraction of a tile.
constexpr double kStub = 0.25;

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

// ------------------------------------------------------------------------------------------------

/// An open end of a cut, and its straight continuation.
struct CutRay {
  int node = 0;
  Vector2 from = Vector2::Zero();
  Vector2 along = Vector2::Zero();  // unit vector
  double straight = 0;              // straight length of the cut up to its end
  double hit = kNever;              // distance of the first line from the end, metres
  Vector2 hitPlace = Vector2::Zero();
  int partner = -1;  // the ray of the end that it runs into, in opposite direction
  double stop = kNever;
  Vector2 stopPlace = Vector2::Zero();
  bool isRunning = true;
  double tip = 0;         // end of the removed material, begin of the neck
  bool isJoined = false;  // no material in between: the cuts meet
  bool isFacing = false;  // met its partner midway, where the vertex of the neck is

  double width() const { return stop - tip; }
  /// Maximum deviation of a point at this distance from the cut's aim.
  double slack(double distance, double tolerance) const {
    return tolerance * (1 + distance / std::max(straight, tolerance)) + kAim * distance;
  }
};

/// Steps 3 and 4.
class RayTracer {
 public:
  /// `curveError`: deviation of straight pieces from their curve, metres; 0 without curves.
  RayTracer(const Arrangement& lines, double curveError, double tolerance)
      : lines_(lines), curveError_(curveError), tolerance_(tolerance) {
    for (int node = 0; node < std::ssize(lines.nodes()); ++node) {
      if (lines.leaving(node).size() == 1) rays_.push_back(rayAt(node));
    }
    std::vector<int> rayOf(lines.nodes().size(), -1);
    for (int k = 0; k < std::ssize(rays_); ++k) rayOf[rays_[k].node] = k;
    for (CutRay& ray : rays_) findHit(ray, rayOf);
  }

  /// Finds the stop of every ray.
  std::vector<CutRay> run() {
    struct RayEvent {
      double time;
      int one, other;  // other: -1 at a line
      double alongOne, alongOther;
    };
    std::vector<RayEvent> events;
    for (int i = 0; i < std::ssize(rays_); ++i) {
      const CutRay& ray = rays_[i];
      if (ray.hit == kNever) continue;
      // Ends that face each other wait for rays that aim between them.
      events.push_back({ray.partner >= 0 ? 3 * ray.hit : ray.hit, i, -1, ray.hit, 0});
    }
    for (int i = 0; i < std::ssize(rays_); ++i) {
      for (int j = i + 1; j < std::ssize(rays_); ++j) {
        const double area = crossOf(rays_[i].along, rays_[j].along);
        if (std::abs(area) < 1e-3) continue;
        const Vector2 apart = rays_[j].from - rays_[i].from;
        const double s = crossOf(apart, rays_[j].along) / area;
        const double t = crossOf(apart, rays_[i].along) / area;
        const bool isAhead = s > tolerance_ && t > tolerance_;
        if (!isAhead || s > rays_[i].hit + tolerance_ || t > rays_[j].hit + tolerance_) continue;
        if (s == kNever || t == kNever) continue;
        events.push_back({std::max(s, t), i, j, s, t});
      }
    }
    std::ranges::stable_sort(events, {}, &RayEvent::time);
    for (const RayEvent& event : events) {
      CutRay& one = rays_[event.one];
      if (event.other < 0) {
        if (one.isRunning) reachLine(event.one);
        continue;
      }
      CutRay& other = rays_[event.other];
      const auto covers = [&](const CutRay& ray, double distance) {
        return ray.isRunning || ray.stop >= distance - ray.slack(distance, tolerance_);
      };
      if ((!one.isRunning && !other.isRunning) || !covers(one, event.alongOne) ||
          !covers(other, event.alongOther)) {
        continue;
      }
      Vector2 place = one.from + event.alongOne * one.along;
      if (one.isRunning && other.isRunning) {
        place = settled(place, event.time);
      } else {
        // On the path of the stopped ray, or at its stop.
        const CutRay& trail = one.isRunning ? other : one;
        const double near = tolerance_ + kAim * event.time;
        if ((trail.stopPlace - place).norm() <= near) place = trail.stopPlace;
      }
      for (CutRay* ray : {&one, &other}) {
        if (ray->isRunning) stopAt(*ray, place);
      }
    }
    return std::move(rays_);
  }

 private:
  CutRay rayAt(int node) const {
    CutRay ray;
    ray.node = node;
    ray.from = lines_.at(node);
    int last = lines_.to(lines_.leaving(node)[0]);
    const Vector2 piece = ray.from - lines_.at(last);
    ray.along = piece.normalized();
    // Backwards along the straight line. A longer line gives a more accurate direction.
    for (int before = node; before >= 0;) {
      int further = -1;
      for (const int half : lines_.leaving(last)) {
        const Vector2 whole = ray.from - lines_.at(lines_.to(half));
        const Vector2 step = lines_.at(last) - lines_.at(lines_.to(half));
        if (lines_.to(half) == before || step.dot(ray.along) <= 0.99 * step.norm()) continue;
        const double off = std::abs(crossOf(whole, ray.from - lines_.at(last))) / whole.norm();
        if (off <= tolerance_) further = lines_.to(half);
      }
      if (further < 0) break;
      before = last;
      last = further;
      ray.along = (ray.from - lines_.at(last)).normalized();
    }
    ray.straight = (ray.from - lines_.at(last)).norm();
    // The tangent at a curve's end is half a turn angle beyond its last piece. A piece of length L
    // that turns by a deviates from its curve by L a / 8.
    if (curveError_ > 0 && lines_.leaving(last).size() == 2) {
      for (const int half : lines_.leaving(last)) {
        const Vector2 before = lines_.at(last) - lines_.at(lines_.to(half));
        const double turn = std::atan2(crossOf(before, ray.along), before.dot(ray.along));
        const double ratio = before.norm() / ray.straight;
        const bool isCurve = ray.straight * std::abs(turn) <= 8 * curveError_;
        if (isCurve && std::abs(turn) < 0.8 && ratio > 0.5 && ratio < 2) {
          ray.along = Eigen::Rotation2Dd(turn / 2) * ray.along;
        }
      }
    }
    return ray;
  }

  void findHit(CutRay& ray, const std::vector<int>& rayOf) const {
    for (const auto& [first, second] : lines_.edges()) {
      if (first == ray.node || second == ray.node) continue;
      // Whether there are ends of the line that the cut aims at.
      bool hasEnd = false;
      for (const int node : {first, second}) {
        const Vector2 rest = lines_.at(node) - ray.from;
        const double ahead = rest.dot(ray.along);
        if (ahead <= tolerance_ ||
            std::abs(crossOf(ray.along, rest)) > ray.slack(ahead, tolerance_)) {
          continue;
        }
        hasEnd = true;
        if (ahead >= ray.hit) continue;
        ray.hit = ahead;
        ray.hitPlace = lines_.at(node);
        const int facing = rayOf[node];
        const bool faces = facing >= 0 && rays_[facing].along.dot(ray.along) < -0.9;
        ray.partner = faces ? facing : -1;
      }
      if (hasEnd) continue;
      const Vector2 a = lines_.at(first), line = lines_.at(second) - a;
      const double area = crossOf(ray.along, line);
      if (area == 0) continue;
      const double ahead = crossOf(a - ray.from, line) / area;
      const double share = crossOf(a - ray.from, ray.along) / area;
      if (ahead <= tolerance_ || ahead >= ray.hit || share < 0 || share > 1) continue;
      ray.hit = ahead;
      ray.hitPlace = a + share * line;
      ray.partner = -1;
    }
  }

  void stopAt(CutRay& ray, const Vector2& place) {
    ray.isRunning = false;
    ray.stop = (place - ray.from).norm();
    ray.stopPlace = place;
    stops_.push_back(place);
  }

  void reachLine(int number) {
    CutRay& ray = rays_[number];
    if (ray.partner < 0) return stopAt(ray, ray.hitPlace);
    CutRay& partner = rays_[ray.partner];
    if (!partner.isRunning) return stopAt(ray, partner.stopPlace);
    const Vector2 middle = 0.5 * (ray.from + partner.from);
    stopAt(ray, middle);
    stopAt(partner, middle);
    ray.isFacing = partner.isFacing = true;
  }

  /// One vertex for all rays that meet there within rounding.
  Vector2 settled(const Vector2& place, double distance) const {
    for (const Vector2& known : stops_) {
      if ((known - place).norm() <= tolerance_ + kAim * distance) return known;
    }
    return place;
  }

  const Arrangement& lines_;
  double curveError_;  // metres
  double tolerance_;
  std::vector<CutRay> rays_;
  std::vector<Vector2> stops_;
};

/// Whether a point is within the border of the material: a ray along x crosses it an odd number of
/// times.
bool isInMaterial(const std::vector<PlaneSegment>& border, const Vector2& point) {
  bool isInside = false;
  for (const auto& [a, b] : border) {
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (x > point.x()) isInside = !isInside;
  }
  return isInside;
}

/// Finds the begin of each neck: the end of the removed material around the cut's end.
void findTips(std::vector<CutRay>& rays, const CutLines& cuts, double tolerance) {
  for (CutRay& ray : rays) {
    if (ray.stop == kNever || cuts.border.empty()) continue;
    // A slit in the material between slots has no width.
    if (cuts.kerf > 0 && isInMaterial(cuts.border, ray.from)) {
      ray.isJoined = ray.stop < 0.5 * cuts.kerf + tolerance;
      continue;
    }
    double first = kNever, last = 0;
    for (const auto& [a, b] : cuts.border) {
      const Vector2 line = b - a;
      const double area = crossOf(ray.along, line);
      if (area == 0) continue;
      const double ahead = crossOf(a - ray.from, line) / area;
      const double share = crossOf(a - ray.from, ray.along) / area;
      if (share < 0 || share > 1 || ahead < -tolerance || ahead > ray.stop - tolerance) continue;
      first = std::min(first, std::max(ahead, 0.0));
      // For a relieved slit, the far side of its own relief.
      if (ahead <= 0.5 * ray.stop) last = std::max(last, ahead);
    }
    // A neck thinner than half the kerf does not exist: the cut runs along the border.
    ray.isJoined = cuts.kerf > 0 && (first == kNever || ray.stop - first < 0.5 * cuts.kerf);
    ray.tip = ray.isJoined ? 0 : cuts.kerf > 0 ? first : last;
  }
}

/// The lines with all rays up to their stops.
Arrangement extended(std::vector<PlaneSegment> lines, const std::vector<CutRay>& rays,
                     double tolerance) {
  for (const CutRay& ray : rays) {
    if (ray.stop < kNever) lines.emplace_back(ray.from, ray.stopPlace);
  }
  return {lines, tolerance};
}

/// The mean size of the faces if all rays are necks, metres.
double tileScale(const Arrangement& whole) {
  double area = 0;
  int count = 0;
  for (int c = 0; c < std::ssize(whole.cycles()); ++c) {
    if (whole.areaOf(c) <= 0) continue;
    area += whole.areaOf(c);
    ++count;
  }
  return count == 0 ? 0 : std::sqrt(area / count);
}

/// Step 4: the largest width of a neck, metres.
double widestNeck(const std::vector<CutRay>& rays, double scale) {
  const double cap = 0.5 * scale;
  std::vector<double> widths;
  for (const CutRay& ray : rays) {
    if (ray.stop < kNever && !ray.isJoined && ray.width() < cap) widths.push_back(ray.width());
  }
  if (widths.empty()) return 0;
  std::ranges::sort(widths);
  widths.push_back(cap);
  std::size_t best = 0;
  for (std::size_t k = 0; k + 1 < widths.size(); ++k) {
    // If intervals are equal, take the one with wider necks.
    if (widths[k + 1] - widths[k] >= widths[best + 1] - widths[best]) best = k;
  }
  return 0.5 * (widths[best] + widths[best + 1]);
}

// ------------------------------------------------------------------------------------------------

/// Steps 3 to 6 for one set of lines.
class SheetMaker {
 public:
  SheetMaker(const CutLines& cuts, const Drawing& drawing, const ReadSettings& settings,
             double tolerance, const fs::path& file)
      : cuts_(cuts),
        drawing_(drawing),
        settings_(settings),
        tolerance_(tolerance),
        file_(file),
        leftOut_(cuts.leftOut) {}

  model::Model make() {
    const Arrangement lines(cuts_.lines, tolerance_);
    // Pieces of a curve that an editor straightened deviate by less than half a slot.
    const double curveError = std::max(2 * drawing_.flattening, 0.5 * cuts_.kerf);
    rays_ = RayTracer(lines, curveError, tolerance_).run();
    findTips(rays_, cuts_, tolerance_);
    const double scale = tileScale(extended(cuts_.lines, rays_, tolerance_));
    dropBeyondBorder(lines, scale);
    requireClosed(lines);
    takeNecks(scale);
    Arrangement whole = arranged();
    requireInside(lines, whole, scale);
    whole.dropBridges();
    findFaces(whole);
    addJoints(whole);
    dropLooseFaces(whole);
    model::Model made = model(whole);
    if (made.tiles.empty()) throw fault("the drawing has no tiles. Draw the outline of the sheet");
    return made;
  }

  /// Summary of the result, one line.
  std::string found(const model::Model& model) const {
    std::string text = fmt::format("{} tile{} and {} hinge{}", model.tiles.size(),
                                   model.tiles.size() == 1 ? "" : "s", model.joints.size(),
                                   model.joints.size() == 1 ? "" : "s");
    if (!joints_.empty()) {
      const auto [narrowest, widest] = std::ranges::minmax_element(joints_, {}, &FaceJoint::width);
      text += widest->width - narrowest->width <= 0.01 * widest->width
                  ? fmt::format(", necks {}", millimetres(widest->width))
                  : fmt::format(", necks {:.4g} to {}", narrowest->width * 1e3,
                                millimetres(widest->width));
    }
    if (cuts_.kerf > 0) text += fmt::format(", slots {}", millimetres(cuts_.kerf));
    if (moved_ > tolerance_) text += fmt::format(", cuts bent by up to {}", millimetres(moved_));
    if (moved_ > tolerance_ && drawing_.rounding > 0.25 * cuts_.kerf && cuts_.kerf > 0) {
      text += fmt::format(
          ", but its coordinates are rounded to {}: check the hinges, or save it "
          "with more decimals",
          millimetres(drawing_.rounding));
    }
    return text;
  }
  const std::map<std::string, int>& leftOut() const { return leftOut_; }

 private:
  struct CutNeck {
    int ray = 0;
    Vector2 joint = Vector2::Zero();
  };

  static std::string millimetres(double metres) { return fmt::format("{:.4g} mm", metres * 1e3); }

  InputError fault(const std::string& what) const { return inputErrorAt({file_}, what); }
  DrawingFault faultAt(std::vector<Vector2> places, const std::string& what) const {
    return {fault(what), drawing_.paths, std::move(places)};
  }

  /// The end of a cut beyond the last line that meets it.
  struct Stub {
    int node = 0, before = -1;  // where lines meet it, and the next node
    double length = 0;
  };

  static Stub stubOf(const Arrangement& lines, int end) {
    Stub stub{end, -1, 0};
    for (bool continues = true; continues;) {
      continues = false;
      for (const int half : lines.leaving(stub.node)) {
        if (lines.to(half) == stub.before) continue;
        stub.length += (lines.at(lines.to(half)) - lines.at(stub.node)).norm();
        stub.before = stub.node;
        stub.node = lines.to(half);
        continues = lines.leaving(stub.node).size() == 2;
        break;
      }
    }
    return stub;
  }

  /// Refuses a cut that crosses a line and ends a little beyond it: no neck remains there.
  void requireNoCrossing(const Arrangement& lines, const CutRay& ray, double scale) const {
    const auto [node, before, length] = stubOf(lines, ray.node);
    if (lines.leaving(node).size() < 4 || length > kStub * scale || length < 2 * cuts_.kerf) return;
    const Vector2 along = (lines.at(before) - lines.at(node)).normalized();
    const bool crosses = std::ranges::any_of(lines.leaving(node), [&](int half) {
      return (lines.at(lines.to(half)) - lines.at(node)).normalized().dot(along) < -0.99;
    });
    if (!crosses) return;
    throw faultAt({lines.at(node)},
                  fmt::format("a cut crosses a line at {} and ends {:.4g} mm beyond it. End it at "
                              "the line, or before the line to keep a neck",
                              drawing_.place(lines.at(node)), length * 1e3));
  }

  /// Removes short pieces of cuts beyond the border of their sheet.
  void dropBeyondBorder(const Arrangement& lines, double scale) {
    const std::vector<int> parts = lines.parts();
    std::vector<std::vector<Vector2>> rings;
    std::vector<int> ringParts;
    for (int c = 0; c < std::ssize(lines.cycles()); ++c) {
      if (lines.areaOf(c) <= 0) continue;
      rings.push_back(ring(lines, c));
      ringParts.push_back(parts[lines.from(lines.cycles()[c][0])]);
    }
    const auto isBeyond = [&](const CutRay& ray) {
      const auto [node, before, length] = stubOf(lines, ray.node);
      if (lines.leaving(node).size() < 3 || length > kStub * scale) return false;
      bool isOfSheet = false;
      for (std::size_t k = 0; k < rings.size(); ++k) {
        isOfSheet |= ringParts[k] == parts[ray.node];
        if (isWithinRing(rings[k], ray.from)) return false;
      }
      return isOfSheet;
    };
    const auto count = std::erase_if(rays_, isBeyond);
    // Not meaningful for slots, whose mouths may be bent.
    if (count > 0 && cuts_.kerf == 0) {
      leftOut_["end of a cut beyond the border"] += static_cast<int>(count);
    }
  }

  void requireClosed(const Arrangement& lines) const {
    bool hasFace = false;
    for (int c = 0; c < std::ssize(lines.cycles()) && !hasFace; ++c) hasFace = lines.areaOf(c) > 0;
    const auto open = std::ranges::find(rays_, kNever, &CutRay::hit);
    if (open == rays_.end() && hasFace) return;
    if (open == rays_.end()) requireNoGap();
    if (rays_.empty())
      throw fault("the drawing has no lines of a sheet. Draw its outline and its cuts");
    const Vector2& end = open == rays_.end() ? rays_.front().from : open->from;
    throw faultAt({end},
                  fmt::format("the outline is open: the line that ends at {} leaves the sheet. "
                              "Close the outline, or end the line at it",
                              drawing_.place(end)));
  }

  /// The extension of an open outline's end has the outside of the sheet on one side.
  void requireNoGap() const {
    const Arrangement whole = extended(cuts_.lines, rays_, tolerance_);
    for (const CutRay& ray : rays_) {
      if (ray.stop == kNever) continue;
      bool hasTile = false, hasOutside = false;
      for (const int half : whole.leaving(*whole.nodeAt(ray.from))) {
        if ((whole.at(whole.to(half)) - ray.from).dot(ray.along) <= 0) continue;
        for (const int side : {half, half ^ 1}) {
          (whole.areaOf(whole.cycleOf(side)) > 0 ? hasTile : hasOutside) = true;
        }
      }
      if (hasTile && hasOutside) throw openOutline(ray.from, ray.hit, "");
    }
  }

  DrawingFault openOutline(const Vector2& end, double gap, const std::string& remedy) const {
    return faultAt(
        {end}, fmt::format("the outline is open at {}, {:.4g} mm from the next line; close it{}",
                           drawing_.place(end), gap * 1e3, remedy));
  }

  void takeNecks(double scale) {
    const double widest = settings_.neckWidth > 0 ? settings_.neckWidth * (1 + 1e-9) + tolerance_
                                                  : widestNeck(rays_, scale);
    for (int k = 0; k < std::ssize(rays_); ++k) {
      const CutRay& ray = rays_[k];
      if (ray.stop == kNever) continue;
      if (!ray.isJoined && ray.width() > widest) continue;
      isExtended_.insert(k);
      const double aim = (ray.stopPlace - ray.from).dot(ray.along);
      moved_ = std::max(moved_, (ray.stopPlace - ray.from - aim * ray.along).norm());
      if (ray.isJoined || ray.stop <= tolerance_) continue;
      CutNeck& neck = necks_.emplace_back();
      neck.ray = k;
      neck.joint = ray.stopPlace;
      if (!settings_.areJointsInNecks) continue;
      const double share = (ray.tip + 0.5 * ray.width()) / ray.stop;
      if (!ray.isFacing) neck.joint = ray.from + share * (ray.stopPlace - ray.from);
    }
  }

  Arrangement arranged() const {
    std::vector<PlaneSegment> all = cuts_.lines;
    std::map<int, Vector2> jointOf;
    for (const CutNeck& neck : necks_) jointOf[neck.ray] = neck.joint;
    for (const int k : isExtended_) {
      const CutRay& ray = rays_[k];
      const auto joint = jointOf.find(k);
      if (joint == jointOf.end() || joint->second == ray.stopPlace) {
        all.emplace_back(ray.from, ray.stopPlace);
      } else {
        all.emplace_back(ray.from, joint->second);
        all.emplace_back(joint->second, ray.stopPlace);
      }
    }
    return Arrangement(all, tolerance_);
  }

  /// An end outside all faces belongs to an open outline. Other ends lie within a tile.
  void requireInside(const Arrangement& lines, const Arrangement& whole, double scale) {
    const std::vector<int> parts = whole.parts();
    std::set<int> closed;
    for (int c = 0; c < std::ssize(whole.cycles()); ++c) {
      if (whole.areaOf(c) > 0) closed.insert(parts[whole.from(whole.cycles()[c][0])]);
    }
    for (int k = 0; k < std::ssize(rays_); ++k) {
      if (isExtended_.contains(k)) continue;
      const int node = *whole.nodeAt(rays_[k].from);
      const int cycle = whole.cycleOf(whole.leaving(node)[0]);
      if (whole.areaOf(cycle) <= 0 && closed.contains(parts[node])) {
        throw openOutline(rays_[k].from, rays_[k].stop,
                          ", or give `widest_neck` if a neck is there");
      }
      requireNoCrossing(lines, rays_[k], scale);
      ++leftOut_["cut that ends within a tile"];
    }
  }

  void findFaces(const Arrangement& whole) {
    faceOf_.assign(whole.cycles().size(), -1);
    for (int c = 0; c < std::ssize(whole.cycles()); ++c) {
      if (whole.areaOf(c) <= 0) continue;
      faceOf_[c] = static_cast<int>(faces_.size());
      faces_.push_back(c);
    }
    hasNeck_.assign(faces_.size(), false);
  }

  /// The half edge of the neck that arrives at its joint.
  std::optional<int> arriving(const Arrangement& whole, const CutNeck& neck) const {
    const std::optional<int> node = whole.nodeAt(neck.joint);
    if (!node) return std::nullopt;
    const CutRay& ray = rays_[neck.ray];
    const Vector2 back = (ray.from - neck.joint).normalized();
    std::optional<int> best;
    double nearest = std::cos(0.2);
    for (const int half : whole.leaving(*node)) {
      const double turn = (whole.at(whole.to(half)) - whole.at(*node)).normalized().dot(back);
      if (turn <= nearest) continue;
      nearest = turn;
      best = half ^ 1;
    }
    return best;
  }

  void addJoints(const Arrangement& whole) {
    struct Between {
      int node;
      std::size_t joint;  // index into joints_
    };
    std::map<std::pair<int, int>, std::vector<Between>> known;
    for (const CutNeck& neck : necks_) {
      const CutRay& ray = rays_[neck.ray];
      const std::optional<int> half = arriving(whole, neck);
      if (!half) {
        ++leftOut_["cut that separates no tiles"];
        continue;
      }
      const int left = faceOf_[whole.cycleOf(*half)], right = faceOf_[whole.cycleOf(*half ^ 1)];
      if (left < 0 || right < 0) throw openOutline(ray.from, ray.stop, "");
      const int node = whole.to(*half);
      std::vector<Between>& others = known[std::minmax(left, right)];
      const auto same = std::ranges::find(others, node, &Between::node);
      if (same != others.end()) {
        joints_[same->joint].width += ray.width();  // from both sides
        continue;
      }
      if (!others.empty()) {
        const Vector2 strip = inner(whole, faces_[left]);
        const Vector2 first = whole.at(others.front().node), second = whole.at(node);
        throw faultAt(
            {strip, first, second},
            fmt::format("the strip of material at {} has necks to its neighbour at {} and {}. It "
                        "can only bend and is not a rigid tile. See docs/drawings.md",
                        drawing_.place(strip), drawing_.place(first), drawing_.place(second)));
      }
      others.push_back({node, joints_.size()});
      hasNeck_[left] = hasNeck_[right] = true;
      joints_.push_back({*half, left, right, ray.width()});
    }
  }

  /// A point that identifies a face: the mean of its corners.
  Vector2 inner(const Arrangement& whole, int cycle) const {
    Vector2 sum(0, 0);
    for (const int half : whole.cycles()[cycle]) sum += whole.at(whole.from(half));
    return sum / static_cast<double>(whole.cycles()[cycle].size());
  }

  std::vector<Vector2> ring(const Arrangement& whole, int cycle) const {
    std::vector<Vector2> points;
    for (const int half : whole.cycles()[cycle]) points.push_back(whole.at(whole.from(half)));
    return points;
  }

  /// Step 5.
  void dropLooseFaces(const Arrangement& whole) {
    const std::vector<int> parts = whole.parts();
    const auto partOf = [&](int face) {
      return parts[whole.from(whole.cycles()[faces_[face]][0])];
    };
    std::map<int, int> facesOf;
    std::set<int> sheets;
    std::string fallen;
    for (int f = 0; f < std::ssize(faces_); ++f) {
      ++facesOf[partOf(f)];
      if (hasNeck_[f]) sheets.insert(partOf(f));
    }
    for (int f = 0; f < std::ssize(faces_); ++f) {
      if (hasNeck_[f]) continue;
      const double area = whole.areaOf(faces_[f]);
      const Vector2 corner = whole.at(whole.from(whole.cycles()[faces_[f]][0]));
      const auto holdsIt = [&](int other) {
        return other != f && partOf(other) != partOf(f) && whole.areaOf(faces_[other]) > area &&
               isWithinRing(ring(whole, faces_[other]), corner);
      };
      bool isWithin = false, isLikeTile = false, isRound = false;
      const std::vector<Vector2> own = ring(whole, faces_[f]);
      for (int other = 0; other < std::ssize(faces_); ++other) {
        if (sheets.empty() ? other != f : static_cast<bool>(hasNeck_[other])) {
          isWithin |= holdsIt(other);
          isRound |= partOf(other) != partOf(f) &&
                     isWithinRing(own, whole.at(whole.from(whole.cycles()[faces_[other]][0])));
        }
        isLikeTile |= hasNeck_[other] && std::abs(whole.areaOf(faces_[other]) - area) < 0.01 * area;
      }
      const bool isShared = facesOf[partOf(f)] > 1;
      if (isShared && (isLikeTile || sheets.empty())) {
        const Vector2 piece = inner(whole, faces_[f]);
        throw faultAt({piece}, fmt::format("the piece at {} hangs by nothing. End a cut around it "
                                           "before the line that it meets",
                                           drawing_.place(piece)));
      }
      if (isWithin)
        ++leftOut_["hole in a tile"];
      else if (isShared) {
        if (fallen.empty()) fallen = drawing_.place(inner(whole, faces_[f]));
        ++leftOut_[fmt::format("piece that falls out (one at {})", fallen)];
      } else if (isRound && !sheets.empty())
        ++leftOut_["frame around the sheet"];
      else if (!sheets.empty())
        ++leftOut_["outline without cuts"];
      else
        hasNeck_[f] = true;  // sheets of one tile
    }
  }

  /// Step 6, and tiles without the vertices that are no longer corners.
  model::Model model(const Arrangement& whole) const {
    std::set<int> cutEnds;
    for (const int k : isExtended_) {
      if (const auto node = whole.nodeAt(rays_[k].from)) cutEnds.insert(*node);
    }
    // Half edges that start at a joint of their tile.
    std::set<int> corners;
    const auto next = [&](int half) {
      const std::vector<int>& cycle = whole.cycles()[whole.cycleOf(half)];
      const auto at = std::ranges::find(cycle, half) - cycle.begin();
      return cycle[(at + 1) % std::ssize(cycle)];
    };
    for (const FaceJoint& joint : joints_) {
      corners.insert(next(joint.half));
      corners.insert(joint.half ^ 1);
    }
    model::Model model;
    model.name = file_.stem().string();
    std::map<int, model::Corner> cornerAt;
    for (int f = 0; f < std::ssize(faces_); ++f) {
      if (!hasNeck_[f]) continue;
      std::vector<int> kept = keptCorners(whole, whole.cycles()[faces_[f]], corners, cutEnds);
      model::Tile& tile = model.tiles.emplace_back();
      for (const int half : kept) {
        cornerAt[half] = {static_cast<int>(model.tiles.size()) - 1,
                          static_cast<int>(tile.vertices.size())};
        const Vector2& at = whole.at(whole.from(half));
        tile.vertices.emplace_back(at.x(), at.y(), 0);
      }
    }
    for (const FaceJoint& joint : joints_) {
      const auto a = cornerAt.find(next(joint.half)), b = cornerAt.find(joint.half ^ 1);
      if (a == cornerAt.end() || b == cornerAt.end()) continue;
      model::Joint& made =
          model.joints.emplace_back(model::Joint{a->second, b->second, model::JointFace::Both});
      made.neck = {joint.width, cuts_.kerf, cuts_.kerf};
    }
    return model;
  }

  struct FaceJoint {
    int half, left, right;
    double width;  // of the neck, metres
  };

  /// Half edges whose starts stay corners: joints, and points that deviate from a straight line by
  /// more than the tolerance.
  std::vector<int> keptCorners(const Arrangement& whole, const std::vector<int>& cycle,
                               const std::set<int>& joints, const std::set<int>& cutEnds) const {
    std::vector<int> halves;
    for (const int half : cycle) {
      const bool isEnd =
          cutEnds.contains(whole.from(half)) && whole.leaving(whole.from(half)).size() <= 2;
      if (!isEnd || joints.contains(half)) halves.push_back(half);
    }
    // Starts at the lowest of the leftmost points, which is always a corner.
    const auto first = std::ranges::min_element(halves, {}, [&](int half) {
      const Vector2& at = whole.at(whole.from(half));
      return std::pair(at.x(), at.y());
    });
    std::rotate(halves.begin(), first, halves.end());
    std::vector<int> kept;
    std::vector<Vector2> chain;
    std::vector<int> chainHalves;
    const auto flush = [&] {
      const std::vector<bool> isKept = simplifiedChain(chain, tolerance_);
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        if (isKept[k]) kept.push_back(chainHalves[k]);
      }
    };
    // Between known corners: the first, the farthest from it, and joints.
    const Vector2 start = whole.at(whole.from(halves[0]));
    const auto farthest = std::ranges::max_element(
        halves, {}, [&](int half) { return (whole.at(whole.from(half)) - start).norm(); });
    const int far = *farthest;
    for (std::size_t k = 0; k <= halves.size(); ++k) {
      const int half = halves[k % halves.size()];
      chain.push_back(whole.at(whole.from(half)));
      chainHalves.push_back(half);
      const bool isSure = k == halves.size() || half == far || joints.contains(half);
      if (k == 0 || !isSure) continue;
      flush();
      chain = {chain.back()};
      chainHalves = {half};
    }
    return kept;
  }

  const CutLines& cuts_;
  const Drawing& drawing_;
  const ReadSettings& settings_;
  double tolerance_;
  const fs::path& file_;
  std::map<std::string, int> leftOut_;
  std::vector<CutRay> rays_;
  std::set<int> isExtended_;
  std::vector<CutNeck> necks_;
  std::vector<int> faces_;     // anticlockwise cycles
  std::vector<int> faceOf_;    // by cycles
  std::vector<bool> hasNeck_;  // of faces
  std::vector<FaceJoint> joints_;
  double moved_ = 0;
};

// ------------------------------------------------------------------------------------------------

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
  constexpr std::size_t kMostTiles = 300;  // for a dense factorisation
  const auto tiles = static_cast<Eigen::Index>(model.tiles.size());
  const auto joints = static_cast<Eigen::Index>(model.joints.size());
  if (3 * tiles - 3 > 2 * joints || model.tiles.size() > kMostTiles) {
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

struct SheetReading {
  model::Model model;
  std::string found;
  std::map<std::string, int> leftOut;
};

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
    SheetReading reading;
    const auto explained = [this](const InputError& error) {
      std::string text = error.what();
      if (groups_.size() > 1)
        text += fmt::format(" (lines: {}; `cut` and `ignore` choose)", describeGroups());
      for (const auto& [what, count] : drawing_.ignored) {
        if (what.find(", which is not ") != what.npos)
          text += fmt::format(" ({} x {})", count, what);
      }
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

  void collectGroups() {
    std::set<std::string> used;
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
      group->paths.push_back(&path);
    }
    for (const auto* words : {&settings_.cut, &settings_.ignore}) {
      for (const std::string& word : *words) {
        if (used.contains(word)) continue;
        std::set<std::string> names;
        for (const DrawnPath& path : drawing_.paths) {
          names.insert(path.colour);
          if (!path.layer.empty()) names.insert(path.layer);
        }
        throw inputErrorAt(
            {file_}, fmt::format("no line has the colour, layer or id '{}' of {}. Available: {}",
                                 shown(word), words == &settings_.cut ? "`cut`" : "`ignore`",
                                 fmt::join(names, ", ")));
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

  /// Coordinates with few digits are coarse, or exact because the design is on a grid. Ends of
  /// lines tell: most rounded ends miss the sloping line that they were drawn to, by a fraction of
  /// the last digit. Then the tolerance is the rounding, but less than necks.
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
    constexpr double kLeastBend = 0.02;  // radians
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
          if (one.path == other.path || (one.inwards + other.inwards).norm() < kLeastBend) continue;
          bent.insert(open[one.path]);
        }
      }
    }
    std::erase_if(open, [&](const DrawnPath* path) { return bent.contains(path); });
  }

  static Vector2 nearestOn(const DrawnPath& path, const Vector2& point) {
    Vector2 nearest = path.points.front();
    for (std::size_t k = 0; k + 1 < path.points.size(); ++k) {
      const Vector2 place = nearestOn({path.points[k], path.points[k + 1]}, point);
      if ((place - point).norm() < (nearest - point).norm()) nearest = place;
    }
    return nearest;
  }

  /// Largest distance between two open lines, and between their ends, metres.
  static double apartOf(const DrawnPath& a, const DrawnPath& b) {
    const auto ends = [&](const Vector2& first, const Vector2& last) {
      return std::max((a.points.front() - first).norm(), (a.points.back() - last).norm());
    };
    double apart =
        std::min(ends(b.points.front(), b.points.back()), ends(b.points.back(), b.points.front()));
    for (const auto& [one, other] : {std::pair(&a, &b), {&b, &a}}) {
      for (const Vector2& point : one->points) {
        apart = std::max(apart, (nearestOn(*other, point) - point).norm());
      }
    }
    return apart;
  }

  /// The middle of two lines, up to the further end of both.
  static DrawnPath middleOf(const DrawnPath& a, const DrawnPath& b) {
    DrawnPath middle = a;
    const bool isSame =
        (a.points.front() - b.points.front()).norm() < (a.points.front() - b.points.back()).norm();
    for (Vector2& point : middle.points) point = 0.5 * (point + nearestOn(b, point));
    const auto furtherEnd = [](const Vector2& end, const Vector2& before, const Vector2& other) {
      const Vector2 along = (end - before).normalized();
      return Vector2(0.5 * (end + other) + 0.5 * std::abs((end - other).dot(along)) * along);
    };
    const auto& p = a.points;
    middle.points.front() =
        furtherEnd(p.front(), p[1], isSame ? b.points.front() : b.points.back());
    middle.points.back() =
        furtherEnd(p.back(), p[p.size() - 2], isSame ? b.points.back() : b.points.front());
    return middle;
  }

  /// Lines drawn twice may differ by more than the tolerance. Raises the tolerance to that. Slots
  /// are wider than kTwice of their drawing.
  void takeDoubledLines() {
    constexpr double kTwice = 1e-5;  // of the drawing's size
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
      if (5 * marks >= 4 * std::ssize(group->paths)) group->role = "hinge mark";
    }
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
        const SheetReading reading = sheetOf(rest);
        if (reading.model.joints.empty() || stopsShort(groups_[g], rest, reading.model)) continue;
        groups_[g].role = "engraved";
      } catch (const InputError&) {
        continue;  // without it the remaining lines are not a sheet
      }
    }
  }

  /// Whether each line of a group, all closed, is a relief at the end of a slit.
  bool areReliefs(const LineGroup& group, std::vector<const DrawnPath*> others) const {
    std::vector<std::vector<Vector2>> rings;
    for (const DrawnPath* path : group.paths) rings.push_back(path->points);
    const std::size_t count = others.size();
    others.insert(others.end(), group.paths.begin(), group.paths.end());
    CutLines cuts;
    takeReliefs(others, rings, cuts);
    return others.size() == count;
  }

  static Vector2 nearestOn(const PlaneSegment& line, const Vector2& point) {
    const Vector2 along = line.second - line.first;
    const double share = std::clamp(
        (point - line.first).dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
    return line.first + share * along;
  }

  static double distanceTo(const PlaneSegment& line, const Vector2& point) {
    return (nearestOn(line, point) - point).norm();
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
      return crossOf(line.second - line.first, point - line.first) > 0;
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
  SheetReading sheetOf(std::vector<const DrawnPath*> paths) const {
    constexpr double kResolved = 3;  // width of slots that may be right as drawn, in digits
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
    auto asLines = ifSheet([&] { return readPaths(lines, leftOutOfLines, tolerance); });
    if (!asLines || asLines->model.joints.empty()) return readPaths(paths, leftOut, tolerance_);
    auto asDrawn = ifSheet([&] { return readPaths(paths, leftOut, tolerance_); });
    const bool isResolved =
        asDrawn && asDrawn->model.joints.size() >= asLines->model.joints.size() &&
        asDrawn->model.joints.front().neck.kerf >= kResolved * drawing_.rounding;
    return isResolved ? std::move(*asDrawn) : std::move(*asLines);
  }

  SheetReading readPaths(std::vector<const DrawnPath*> paths,
                         const std::map<std::string, int>& leftOut, double tolerance) const {
    std::vector<const DrawnPath*> open;
    const auto rings = closedRings(paths, tolerance, open);
    const auto readAs = [&](CutLines cuts) {
      for (const auto& [what, count] : leftOut) cuts.leftOut[what] += count;
      // Centre lines are accurate to a small fraction of their slots' width.
      SheetMaker maker(cuts, drawing_, settings_, std::max(tolerance, 0.03 * cuts.kerf), file_);
      SheetReading reading;
      reading.model = maker.make();
      reading.found = (cuts.kerf > 0 ? "slots: " : "slits: ") + maker.found(reading.model);
      reading.leftOut = maker.leftOut();
      return reading;
    };
    const auto asSlots = [&]() -> std::optional<SheetReading> {
      if (rings.empty()) return std::nullopt;
      CutLines cuts = slotLines(rings, open, tolerance);
      if (cuts.lines.empty()) return std::nullopt;
      requireSimple(rings);
      return readAs(std::move(cuts));
    };
    if (open.empty()) {
      if (auto reading = asSlots()) return std::move(*reading);
    }
    CutLines slits;
    takeReliefs(paths, rings, slits);
    slits.lines = segmentsOf(paths);
    if (open.empty()) return readAs(std::move(slits));
    return readMixed([&] { return readAs(std::move(slits)); }, asSlots);
  }

  template <typename Read>
  static std::optional<SheetReading> ifSheet(Read read) {
    try {
      return read();
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  /// Closed outlines next to open lines are slots, reliefs, holes or marks. The reading with more
  /// hinges is right: what is no slot separates no tiles.
  template <typename ReadSlits, typename ReadSlots>
  static SheetReading readMixed(ReadSlits readSlits, ReadSlots readSlots) {
    try {
      SheetReading reading = readSlits();
      auto other = ifSheet(readSlots);
      const bool isOther = other && other->model.joints.size() > reading.model.joints.size();
      return isOther ? std::move(*other) : std::move(reading);
    } catch (const InputError&) {
      auto other = ifSheet(readSlots);
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
    const auto rings = closedRings(paths, tolerance_, open);
    int count = 0;
    for (const std::vector<Vector2>& ring : rings) {
      DrawnPath outline = *paths.front();
      outline.points = ring;
      outline.isClosed = true;
      const std::optional<DrawnPath> middle = middleOfThin(outline, thinWidth());
      count += middle ? 1 : 0;
      lines.push_back(middle.value_or(outline));
    }
    for (const DrawnPath* path : open) lines.push_back(*path);
    return count;
  }

  /// The middle line of a closed line whose sides are at most `most` apart, between its points that
  /// are farthest from each other.
  static std::optional<DrawnPath> middleOfThin(const DrawnPath& ring, double most) {
    constexpr double kSlender = 4;  // length / `most`, at least
    std::vector<Vector2> points = ring.points;
    const auto farthestFrom = [&](const Vector2& from) {
      return std::ranges::max_element(points, {},
                                      [&](const Vector2& p) { return (p - from).norm(); });
    };
    std::ranges::rotate(points, farthestFrom(*farthestFrom(points.front())));
    const auto half = farthestFrom(points.front());
    const Vector2 first = points.front(), last = *half;
    if (!(most > 0) || (last - first).norm() <= kSlender * most) return std::nullopt;
    DrawnPath middle = ring, side = ring;
    middle.isClosed = side.isClosed = false;
    middle.points.assign(points.begin(), half + 1);
    side.points.assign(half, points.end());
    side.points.push_back(first);
    const double apart = apartOf(middle, side);
    if (apart > most) return std::nullopt;
    // Corners and round ends become one point.
    const auto isAt = [&](const Vector2& tip, const Vector2& point) {
      return (point - tip).norm() <= 1.5 * apart;
    };
    const auto end = [&](const Vector2& tip) {
      Vector2 sum(0, 0);
      int count = 0;
      for (const Vector2& point : points) {
        if (!isAt(tip, point)) continue;
        sum += point;
        ++count;
      }
      return Vector2(sum / count);
    };
    std::erase_if(middle.points,
                  [&](const Vector2& point) { return isAt(first, point) || isAt(last, point); });
    for (Vector2& point : middle.points) point = 0.5 * (point + nearestOn(side, point));
    middle.points.insert(middle.points.begin(), end(first));
    middle.points.push_back(end(last));
    return middle;
  }

  /// Outlines of sheets and slots must not cross themselves. If more than two lines meet at a
  /// point, the outline is ambiguous.
  void requireSimple(const std::vector<std::vector<Vector2>>& rings) const {
    PointNumbers numbers(tolerance_, rings.front().front());
    std::vector<int> uses;
    for (const std::vector<Vector2>& ring : rings) {
      for (const Vector2& point : ring) {
        const int number = numbers.add(point);
        uses.resize(numbers.count());
        ++uses[number];
      }
    }
    for (const std::vector<Vector2>& ring : rings) {
      const bool isShared = std::ranges::any_of(
          ring, [&](const Vector2& point) { return uses[*numbers.find(point)] > 1; });
      if (isShared) continue;
      std::vector<PlaneSegment> sides;
      for (std::size_t k = 0; k < ring.size(); ++k) {
        sides.emplace_back(ring[k], ring[(k + 1) % ring.size()]);
      }
      visitNearSegments(sides, tolerance_, [&](int i, int j) {
        const Vector2 u = sides[i].second - sides[i].first, v = sides[j].second - sides[j].first;
        const double area = crossOf(u, v);
        if (area == 0) return;
        const Vector2 apart = sides[j].first - sides[i].first;
        const double s = crossOf(apart, v) / area, t = crossOf(apart, u) / area;
        const auto isInside = [&](double share, const Vector2& side) {
          return std::min(share, 1 - share) * side.norm() > tolerance_;
        };
        if (!isInside(s, u) || !isInside(t, v)) return;
        const Vector2 place = sides[i].first + s * u;
        throw DrawingFault(
            inputErrorAt({file_}, fmt::format("an outline crosses itself at {}; draw it without "
                                              "the crossing",
                                              drawing_.place(place))),
            drawing_.paths, {place});
      });
    }
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
    if (boxes.empty()) return;
    constexpr double kMark = 0.1;  // of the largest part
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
    const auto count = std::erase_if(paths, isOutside);
    if (count > 0) leftOut["line outside the sheet"] += static_cast<int>(count);
  }

  /// Removes relief circles at the ends of slits. The slit then ends on their far side.
  void takeReliefs(std::vector<const DrawnPath*>& paths,
                   const std::vector<std::vector<Vector2>>& rings, CutLines& cuts) const {
    std::vector<Vector2> firsts, lasts;
    for (const DrawnPath* path : paths) {
      if (path->isClosed) continue;
      firsts.push_back(path->points.front());
      lasts.push_back(path->points.back());
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
      for (std::size_t k = 0; k < firsts.size(); ++k) {
        const int inside = (touches(ring, firsts[k]) ? 1 : 0) + (touches(ring, lasts[k]) ? 1 : 0);
        oneEnd += inside == 1 ? 1 : 0;
        bothEnds += inside == 2 ? 1 : 0;
      }
      // A hole of the design has more ends.
      if (oneEnd != 1 || bothEnds > 0) continue;
      const auto count = std::erase_if(
          paths, [&](const DrawnPath* path) { return path->isClosed && path->points == ring; });
      if (count == 0) continue;
      for (std::size_t k = 0; k < ring.size(); ++k) {
        cuts.border.emplace_back(ring[k], ring[(k + 1) % ring.size()]);
      }
      ++cuts.leftOut["relief at the end of a slit"];
    }
  }

  std::string describeGroups() const {
    std::set<std::string> layers;
    for (const LineGroup& group : groups_) layers.insert(group.layer);
    std::vector<std::string> texts;
    for (const LineGroup& group : groups_) {
      texts.push_back(fmt::format("{} {}{}{} ({})", group.paths.size(), group.colour,
                                  layers.size() > 1 ? " on layer " + shown(group.layer) : "",
                                  group.isDashed ? ", dashed" : "", group.role));
    }
    return fmt::format("{}", fmt::join(texts, ", "));
  }

  std::string describe(const SheetReading& reading) const {
    Eigen::AlignedBox2d box;
    for (const model::Tile& tile : reading.model.tiles) {
      for (const Vector3& vertex : tile.vertices) box.extend(vertex.head<2>());
    }
    std::string text = fmt::format("{}: note: {}, sheet {:.4g} x {:.4g} mm", file_.string(),
                                   reading.found, box.sizes().x() * 1e3, box.sizes().y() * 1e3);
    if (drawing_.unitName == "px") text += " (px of 1/96 inch)";
    if (drawing_.unitName == "units" && std::abs(drawing_.unit - 1e-3) < 1e-12)
      text += " (no unit in the file: mm)";
    if (groups_.size() > 1) text += "; lines: " + describeGroups();
    if (drawing_.flattening > 0)
      text += fmt::format("; curves straight to within {:.2g} mm",
                          (drawing_.flattening + tolerance_) * 1e3);
    std::map<std::string, int> leftOut = reading.leftOut;
    for (const auto& [what, count] : drawing_.ignored) leftOut[what] += count;
    if (!notChosen_.empty()) {
      leftOut["line that was not chosen"] += static_cast<int>(notChosen_.size());
    }
    if (!middles_.empty()) {
      text += fmt::format("; {} cuts drawn as two lines up to {:.4g} mm apart", middles_.size(),
                          joinedApart_ * 1e3);
    }
    std::vector<std::string> texts;
    for (const auto& [what, count] : leftOut) texts.push_back(fmt::format("{} x {}", count, what));
    if (!texts.empty()) text += fmt::format("; left out: {}", fmt::join(texts, ", "));
    return text;
  }

  const Drawing& drawing_;
  const ReadSettings& settings_;
  const fs::path& file_;
  double tolerance_;
  std::vector<LineGroup> groups_;
  std::vector<DrawnPath> notChosen_;
  std::deque<DrawnPath> middles_;  // of parallel lines; their addresses are in groups_
  double joinedApart_ = 0;         // distance of parallel lines that became one, metres
};

}  // namespace

namespace {

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
  constexpr double kLeastDrawing = 1e-9;  // metres
  if (!(drawing.size() > kLeastDrawing)) {
    throw inputErrorAt({file},
                       "the drawing has no lines of a sheet. Draw its outline and its cuts");
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
  const std::optional<LengthUnit> declared = findLengthUnit(drawing.unitName);
  if (!declared && settings.unit) rescale(drawing, *settings.unit);
  // An unknown unit such as px means millimetres, the most common unit of exported drawings.
  const LengthUnit unit = settings.unit.value_or(declared.value_or(millimetre()));
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
