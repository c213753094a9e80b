// Finds the tiles and joints of a sheet.
//
// 1. *Rays*: each open end of a cut is extended straight (cut_rays.cpp). Centre lines of slots that
//    meet are first extended to their junctions, so necks aim at these.
// 2. *Necks* are the rays up to a maximum width. Tips of openings have rays too
//    (opening_tips.cpp).
// 3. *Tiles* are the faces between lines and necks. A face without a neck is not a tile: it falls
//    out, or is a hole, a frame or a mark. Two tiles with two necks between them must bend.
// 4. *Joints* are at the far ends of the necks, the vertices of the design.
#include "sim/formats/cut_sheet.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/words.h"
#include "sim/formats/cut_rays.h"

namespace kirireel::formats {
namespace {

namespace fs = std::filesystem;

// An end of a cut beyond a line is inaccurate drawing up to this fraction of a tile.
constexpr double kStub = 0.25;

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

class SheetMaker {
 public:
  SheetMaker(const CutLines& cuts, const Drawing& drawing, const ReadSettings& settings,
             double tolerance, const fs::path& file)
      : cuts_(cuts),
        drawing_(drawing),
        settings_(settings),
        tolerance_(tolerance),
        file_(file),
        lines_(cuts.lines),
        leftOut_(cuts.leftOut) {}

  CutSheet make() {
    Arrangement lines = traceRays();
    if (joinSlots()) lines = traceRays();
    scale_ = tileScale(extended(lines_, rays_, tolerance_));
    dropBeyondBorder(lines);
    requireClosed(lines);
    takeNecks();
    takeTips();
    Arrangement whole = arranged();
    requireInside(lines, whole);
    whole.dropBridges();
    findFaces(whole);
    addJoints(whole);
    dropLooseFaces(whole);
    CutSheet sheet;
    sheet.model = model(whole);
    if (sheet.model.tiles.empty())
      throw fault("the drawing has no tiles. Draw the outline of the sheet");
    sheet.found = (cuts_.kerf > 0 ? "slots: " : "slits: ") + found(sheet.model);
    sheet.leftOut = leftOut_;
    return sheet;
  }

 private:
  /// Summary of the result, one line.
  std::string found(const model::Model& model) const {
    std::string text =
        counted(model.tiles.size(), "tile") + " and " + counted(model.joints.size(), "hinge");
    if (joints_.empty()) text += " (to find more, set `neck_width`, or `cut` and `ignore`)";
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
  void requireNoCrossing(const Arrangement& lines, const CutRay& ray) const {
    const Stub stub = stubOf(lines, ray.node);
    const std::vector<int>& leaving = lines.leaving(stub.node);
    if (leaving.size() < 4 || stub.length > kStub * scale_ || stub.length < 2 * cuts_.kerf) return;
    const Vector2 crossing = lines.at(stub.node);
    const Vector2 along = (lines.at(stub.before) - crossing).normalized();
    const bool crosses = std::ranges::any_of(leaving, [&](int half) {
      return (lines.at(lines.to(half)) - crossing).normalized().dot(along) < -0.99;
    });
    if (!crosses) return;
    throw faultAt({crossing},
                  fmt::format("a cut crosses a line at {} and ends {} beyond it. End it at "
                              "the line, or before the line to keep a neck",
                              drawing_.place(crossing), drawing_.length(stub.length)));
  }

  /// Removes short pieces of cuts beyond the border of their sheet.
  void dropBeyondBorder(const Arrangement& lines) {
    const std::vector<int> parts = lines.parts();
    std::vector<PlaneRing> rings;
    std::vector<int> ringParts;
    for (int c = 0; c < std::ssize(lines.cycles()); ++c) {
      if (lines.areaOf(c) <= 0) continue;
      rings.push_back(ring(lines, c));
      ringParts.push_back(parts[lines.from(lines.cycles()[c][0])]);
    }
    const auto isBeyond = [&](const CutRay& ray) {
      const auto [node, before, length] = stubOf(lines, ray.node);
      if (lines.leaving(node).size() < 3 || length > kStub * scale_) return false;
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
    const Vector2 end = outermostEnd(lines);
    throw faultAt({end},
                  fmt::format("the outline is open: the line that ends at {} leaves the sheet. "
                              "Close the outline, or end the line at it",
                              drawing_.place(end)));
  }

  /// The open end with the widest view out of the drawing: half a turn or more for ends of a convex
  /// outline, less for ends of cuts.
  Vector2 outermostEnd(const Arrangement& lines) const {
    const CutRay* best = nullptr;
    double widest = 0;
    for (const CutRay& ray : rays_) {
      std::vector<double> angles;
      for (const Vector2& node : lines.nodes()) {
        const Vector2 apart = node - ray.from;
        if (node != ray.from) angles.push_back(std::atan2(apart.y(), apart.x()));
      }
      std::ranges::sort(angles);
      double view = angles.front() + 2 * std::numbers::pi - angles.back();
      for (std::size_t k = 1; k < angles.size(); ++k) {
        view = std::max(view, angles[k] - angles[k - 1]);
      }
      if (best && view < widest + 1e-9) continue;
      best = &ray;
      widest = view;
    }
    return best->from;
  }

  /// The extension of an open outline's end has the outside of the sheet on one side.
  void requireNoGap() const {
    const Arrangement whole = extended(lines_, rays_, tolerance_);
    // The outline leaves a wider gap than the cuts, whose ends may also have the outside next to
    // them.
    const CutRay* widest = nullptr;
    for (const CutRay& ray : rays_) {
      if (ray.stop == kNever) continue;
      bool hasTile = false, hasOutside = false;
      for (const int half : whole.leaving(*whole.nodeAt(ray.from))) {
        if ((whole.at(whole.to(half)) - ray.from).dot(ray.along) <= 0) continue;
        for (const int side : {half, half ^ 1}) {
          (whole.areaOf(whole.cycleOf(side)) > 0 ? hasTile : hasOutside) = true;
        }
      }
      if (hasTile && hasOutside && (!widest || ray.hit > widest->hit)) widest = &ray;
    }
    if (widest) throw openOutline(widest->from, widest->hit, "");
  }

  DrawingFault openOutline(const Vector2& end, double gap, const std::string& remedy) const {
    return faultAt({end},
                   fmt::format("the outline is open at {}, {} from the next line; close it{}",
                               drawing_.place(end), drawing_.length(gap), remedy));
  }

  /// The lines, with the rays of their ends.
  Arrangement traceRays() {
    Arrangement lines(lines_, tolerance_);
    // Pieces of a curve that an editor straightened deviate by less than half a slot.
    const double curveError = std::max(2 * drawing_.flattening, 0.5 * cuts_.kerf);
    rays_ = traceCutRays(lines, curveError, tolerance_);
    findNeckTips(rays_, cuts_.border, cuts_.kerf, tolerance_);
    return lines;
  }

  /// Extends centre lines of slots to the junctions at which their slots meet. Returns whether
  /// there are any.
  bool joinSlots() {
    std::vector<Vector2> overlaps;
    bool isAny = false;
    for (const CutRay& ray : rays_) {
      if (!ray.isJoined || ray.stop == kNever) continue;
      isAny = true;
      noteDeviation(ray);
      if (!isOpenToStop(ray)) overlaps.push_back(ray.from);
      for (std::size_t k = 0; k < lines_.size(); ++k) {
        const auto& [first, last] = cuts_.lines[k];
        if ((first - ray.from).norm() <= tolerance_) lines_[k].first = ray.stopPlace;
        if ((last - ray.from).norm() <= tolerance_) lines_[k].second = ray.stopPlace;
      }
    }
    if (!overlaps.empty()) {
      leftOut_[fmt::format("neck without material, as slots overlap (one at {})",
                           drawing_.place(overlaps.front()))] += static_cast<int>(overlaps.size());
    }
    return isAny;
  }

  /// Whether a slot has its width up to its junction. One that stopped short of another slot, and
  /// overlaps it by its rounded end, leaves material next to the end.
  bool isOpenToStop(const CutRay& ray) const {
    constexpr double kWidth = 0.95;  // of the slot; its sides are rounded
    constexpr int kSamples = 16;
    const Vector2 back = ray.from - 0.25 * cuts_.kerf * ray.along;
    // A slot may have a flat end at the junction.
    const Vector2 path = std::max(1 - tolerance_ / ray.stop, 0.0) * (ray.stopPlace - ray.from);
    const Vector2 across(-ray.along.y(), ray.along.x());
    double left = cuts_.kerf, right = -cuts_.kerf;
    for (const double side : crossingsOf(cuts_.border, back, across)) {
      if (side > 0) {
        left = std::min(left, side);
      } else {
        right = std::max(right, side);
      }
    }
    for (const double side : {kWidth * left, kWidth * right}) {
      for (int k = 0; k <= kSamples; ++k) {
        const double share = static_cast<double>(k) / kSamples;
        if (isWithin(cuts_.border, ray.from + share * path + side * across)) return false;
      }
    }
    return true;
  }

  /// Updates the largest deviation of a cut from its aim.
  void noteDeviation(const CutRay& ray) {
    const Vector2 path = ray.stopPlace - ray.from;
    moved_ = std::max(moved_, std::abs(crossZ(ray.along, path)));
  }

  void takeNecks() {
    const double widest = settings_.neckWidth > 0 ? settings_.neckWidth * (1 + 1e-9) + tolerance_
                                                  : widestNeck(rays_, scale_);
    for (int k = 0; k < std::ssize(rays_); ++k) {
      const CutRay& ray = rays_[k];
      if (ray.stop == kNever) continue;
      if (!ray.isJoined && ray.width() > widest) continue;
      isExtended_.insert(k);
      noteDeviation(ray);
      if (!ray.isJoined && ray.stop > tolerance_) addNeck(k);
    }
  }

  void addNeck(int number) {
    const CutRay& ray = rays_[number];
    CutNeck& neck = necks_.emplace_back();
    neck.ray = number;
    neck.joint = ray.stopPlace;
    if (!settings_.areJointsInNecks || ray.isFacing) return;
    const double share = (ray.tip + 0.5 * ray.width()) / ray.stop;
    neck.joint = ray.from + share * (ray.stopPlace - ray.from);
  }

  /// Adds the necks at tips of openings.
  void takeTips() {
    firstTip_ = static_cast<int>(rays_.size());
    if (cuts_.tips.empty()) return;
    double known = 0, area = 0;
    for (const CutNeck& neck : necks_) known = std::max(known, rays_[neck.ray].width());
    const Arrangement whole = arranged();
    int faces = 0;
    for (int c = 0; c < std::ssize(whole.cycles()); ++c) {
      if (whole.areaOf(c) <= 0 || isOpening(whole, c)) continue;
      area += whole.areaOf(c);
      ++faces;
    }
    const std::vector<CutRay> rays = traceTips(cuts_.tips, whole, tolerance_);
    double widest = settings_.neckWidth > 0 ? settings_.neckWidth * (1 + 1e-9) + tolerance_
                                            : widestTip(rays, known, area, std::max(faces, 1));
    // Without the widest necks until all are narrower than their tiles.
    addTips(rays, widest);
    while (const double wide = widestInTiles()) {
      removeTips();
      widest = wide * (1 - 1e-9);
      addTips(rays, widest);
    }
  }

  void addTips(const std::vector<CutRay>& rays, double widest) {
    for (std::size_t k = 0; k < rays.size(); ++k) {
      if (rays[k].stop > widest || rays[k].stop <= 0.5 * cuts_.kerf + tolerance_) continue;
      isExtended_.insert(static_cast<int>(rays_.size()));
      rays_.push_back(rays[k]);
      addNeck(static_cast<int>(rays_.size()) - 1);
      tipEnds_.push_back(rays[k].from);
      tipEnds_.insert(tipEnds_.end(), cuts_.tips[k].ends.begin(), cuts_.tips[k].ends.end());
    }
  }

  void removeTips() {
    std::erase_if(necks_, [&](const CutNeck& neck) { return neck.ray >= firstTip_; });
    std::erase_if(isExtended_, [&](int ray) { return ray >= firstTip_; });
    rays_.resize(firstTip_);
    tipEnds_.clear();
  }

  /// The widest neck at a tip that is not narrower than its tiles, of the width 4 area / perimeter,
  /// or 0. Material between openings may be a frame.
  double widestInTiles() const {
    constexpr double kOfTile = 0.5;
    Arrangement whole = arranged();
    whole.dropBridges();
    double widest = 0;
    for (const CutNeck& neck : necks_) {
      if (neck.ray < firstTip_) continue;
      const std::optional<int> half = arriving(whole, neck);
      if (!half) continue;
      for (const int side : {*half, *half ^ 1}) {
        double perimeter = 0;
        for (const int edge : whole.cycles()[whole.cycleOf(side)]) {
          perimeter += (whole.at(whole.to(edge)) - whole.at(whole.from(edge))).norm();
        }
        const double width = rays_[neck.ray].stop;
        if (width * perimeter > kOfTile * 4 * whole.areaOf(whole.cycleOf(side))) {
          widest = std::max(widest, width);
        }
      }
    }
    return widest;
  }

  /// Whether a cycle is the border of an opening: a point on its left is inside one.
  bool isOpening(const Arrangement& whole, int cycle) const {
    const auto lengthOf = [&](int half) {
      return (whole.at(whole.to(half)) - whole.at(whole.from(half))).norm();
    };
    const int half = *std::ranges::max_element(whole.cycles()[cycle], {}, lengthOf);
    const Vector2 along = whole.at(whole.to(half)) - whole.at(whole.from(half));
    const Vector2 left = Vector2(-along.y(), along.x()).normalized();
    const Vector2 place = whole.at(whole.from(half)) + 0.5 * along + 4 * tolerance_ * left;
    return std::ranges::any_of(cuts_.openings, [&](const std::vector<Vector2>& opening) {
      return isWithinRing(opening, place);
    });
  }

  Arrangement arranged() const {
    std::vector<PlaneSegment> all = lines_;
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
  void requireInside(const Arrangement& lines, const Arrangement& whole) {
    const std::vector<int> parts = whole.parts();
    std::set<int> closed;
    for (int c = 0; c < std::ssize(whole.cycles()); ++c) {
      if (whole.areaOf(c) > 0) closed.insert(parts[whole.from(whole.cycles()[c][0])]);
    }
    for (int k = 0; k < std::ssize(rays_); ++k) {
      if (isExtended_.contains(k)) continue;
      const int node = *whole.nodeAt(rays_[k].from);
      // Another cut may end here, with the outside on one side only.
      const bool isOutside = std::ranges::any_of(
          whole.leaving(node), [&](int half) { return whole.areaOf(whole.cycleOf(half)) <= 0; });
      if (isOutside && closed.contains(parts[node])) {
        throw openOutline(rays_[k].from, rays_[k].stop,
                          ", or give `widest_neck` if a neck is there");
      }
      requireNoCrossing(lines, rays_[k]);
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
    std::optional<int> last;
    for (int node = *whole.nodeAt(rays_[neck.ray].from);;) {
      // Several nodes may be near the joint, so it follows the neck.
      const Vector2 rest = neck.joint - whole.at(node);
      if (last && rest.norm() <= 2 * tolerance_) return last;
      std::optional<int> next;
      double straightest = std::cos(0.2);
      for (const int half : whole.leaving(node)) {
        const Vector2 step = whole.at(whole.to(half)) - whole.at(node);
        const double turn = step.dot(rest) / (step.norm() * rest.norm());
        if (turn <= straightest || (rest - step).norm() >= rest.norm()) continue;
        straightest = turn;
        next = half;
      }
      if (!next) return std::nullopt;
      last = next;
      node = whole.to(*next);
    }
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
      const bool isTip = neck.ray >= firstTip_;
      if (!half) {
        if (!isTip) ++leftOut_["cut that separates no tiles"];
        continue;
      }
      const int left = faceOf_[whole.cycleOf(*half)], right = faceOf_[whole.cycleOf(*half ^ 1)];
      if (left < 0 || right < 0) throw openOutline(ray.from, ray.stop, "");
      const int node = whole.to(*half);
      std::vector<Between>& others = known[std::minmax(left, right)];
      const auto same = std::ranges::find(others, node, &Between::node);
      if (same != others.end()) {
        joints_[same->joint].width += ray.width();  // from both sides
        joints_[same->joint].material += materialOf(ray);
        continue;
      }
      if (!others.empty()) {
        const Vector2 first = whole.at(others.front().node), second = whole.at(node);
        if (isDashed(ray, first, second)) {
          FaceJoint& joint = joints_[others.front().joint];
          joint.width += ray.width();
          joint.material += materialOf(ray);
          if (ray.isFacing) continue;
          joint.half = *half;  // the end of the dashes is the vertex of the design
          others.front().node = node;
          continue;
        }
        const Vector2 strip = inner(whole, faces_[left]);
        throw faultAt(
            {strip, first, second},
            fmt::format("the strip of material at {} has necks to its neighbour at {} and {}. It "
                        "can only bend and is not a rigid tile. See docs/drawings.md",
                        drawing_.place(strip), drawing_.place(first), drawing_.place(second)));
      }
      others.push_back({node, joints_.size()});
      hasNeck_[left] = hasNeck_[right] = true;
      joints_.push_back({*half, ray.width(), materialOf(ray)});
    }
  }

  /// Whether a neck and another one between the same tiles are parts of one hinge that is cut in
  /// dashes: near each other, on a straight line.
  bool isDashed(const CutRay& ray, const Vector2& other, const Vector2& place) const {
    const Vector2 apart = place - other;
    return apart.norm() <= kStub * scale_ &&
           std::abs(crossZ(ray.along, apart)) <= ray.slack(apart.norm(), tolerance_);
  }

  double materialOf(const CutRay& ray) const {
    return cuts_.kerf > 0 ? neckMaterial(ray, cuts_.border, tolerance_) : ray.width();
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

  /// Lines such as creases, that meet each other everywhere.
  DrawingFault withoutNecks(const Vector2& piece) const {
    return faultAt(
        {piece},
        fmt::format("the drawing has {} pieces without necks, such as the one at {}: no cut "
                    "stops short of another line{}. Creases are read from FOLD files",
                    faces_.size(), drawing_.place(piece),
                    rays_.empty() ? ". End cuts before the lines that they meet"
                                  : ", or by too much. Give `widest_neck`"));
  }

  /// Faces without a neck.
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
      const bool isShared = facesOf[partOf(f)] > 1, isOpen = isOpening(whole, faces_[f]);
      if (isShared && !isOpen && (isLikeTile || sheets.empty())) {
        const Vector2 piece = inner(whole, faces_[f]);
        if (sheets.empty()) throw withoutNecks(piece);
        throw faultAt({piece}, fmt::format("the piece at {} hangs by nothing. End a cut around it "
                                           "before the line that it meets",
                                           drawing_.place(piece)));
      }
      if (isWithin)
        ++leftOut_["hole in a tile"];
      else if (isOpen)
        ++leftOut_["opening between tiles"];
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

  /// Joints, and tiles without the vertices that are no longer corners.
  model::Model model(const Arrangement& whole) const {
    std::set<int> cutEnds;
    for (const int k : isExtended_) {
      const auto node = whole.nodeAt(rays_[k].from);
      if (k < firstTip_ && node && whole.leaving(*node).size() <= 2) cutEnds.insert(*node);
    }
    for (const Vector2& end : tipEnds_) {
      if (const auto node = whole.nodeAt(end)) cutEnds.insert(*node);
    }
    const std::set<int> bends = bendsOf(whole, cutEnds);
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
      std::vector<int> kept =
          keptCorners(whole, whole.cycles()[faces_[f]], corners, cutEnds, bends);
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
      // A cut through the joint would leave this material. At the outline there is none.
      made.neck = {joint.material + 0.5 * cuts_.kerf, cuts_.kerf, cuts_.kerf};
    }
    return model;
  }

  struct FaceJoint {
    int half;         // edge that ends at the joint
    double width;     // of the neck up to the joint, metres
    double material;  // of this width
  };

  /// Nodes of two lines that are corners of both tiles next to them, of the chains between other
  /// nodes. `cutEnds` are not corners.
  std::set<int> bendsOf(const Arrangement& whole, const std::set<int>& cutEnds) const {
    std::set<int> bends;
    std::vector<bool> isVisited(whole.edges().size(), false);
    const auto follow = [&](int half) {
      const int start = whole.from(half);
      std::vector<int> nodes = {start};
      for (bool continues = true; continues;) {
        isVisited[half / 2] = true;
        const int node = whole.to(half);
        continues = whole.leaving(node).size() == 2 && node != start;
        if (!cutEnds.contains(node) || !continues) nodes.push_back(node);
        if (!continues) break;
        const std::vector<int>& leaving = whole.leaving(node);
        half = leaving[0] == (half ^ 1) ? leaving[1] : leaving[0];
      }
      std::vector<Vector2> chain;
      for (const int node : nodes) chain.push_back(whole.at(node));
      const std::vector<bool> isKept = simplifiedChain(chain, tolerance_);
      for (std::size_t k = 0; k < nodes.size(); ++k) {
        if (isKept[k] && whole.leaving(nodes[k]).size() == 2) bends.insert(nodes[k]);
      }
    };
    // Rings start at the lowest of their leftmost nodes, which is a corner.
    std::vector<int> halves(2 * whole.edges().size());
    std::iota(halves.begin(), halves.end(), 0);
    std::ranges::stable_sort(halves, {}, [&](int half) {
      const Vector2& at = whole.at(whole.from(half));
      return std::pair(at.x(), at.y());
    });
    for (const bool isRing : {false, true}) {
      for (const int half : halves) {
        const bool isStart = isRing || whole.leaving(whole.from(half)).size() != 2;
        if (isStart && !isVisited[half / 2]) follow(half);
      }
    }
    return bends;
  }

  /// Half edges whose starts stay corners: joints, and points that deviate from a straight line by
  /// more than the tolerance.
  std::vector<int> keptCorners(const Arrangement& whole, const std::vector<int>& cycle,
                               const std::set<int>& joints, const std::set<int>& cutEnds,
                               const std::set<int>& bends) const {
    std::vector<int> halves;
    for (const int half : cycle) {
      const int node = whole.from(half);
      const bool isStraight =
          cutEnds.contains(node) || (whole.leaving(node).size() == 2 && !bends.contains(node));
      if (!isStraight || joints.contains(half)) halves.push_back(half);
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
      const bool isSure = k == halves.size() || half == far || joints.contains(half) ||
                          bends.contains(whole.from(half));
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
  std::vector<PlaneSegment> lines_;  // those of cuts_, with joined slots
  double scale_ = 0;                 // size of a tile, metres
  std::map<std::string, int> leftOut_;
  std::vector<CutRay> rays_;
  std::set<int> isExtended_;
  std::vector<CutNeck> necks_;
  int firstTip_ = 0;              // of rays_; then those of the tips follow
  std::vector<Vector2> tipEnds_;  // vertices at tips with necks, no corners of tiles
  std::vector<int> faces_;        // anticlockwise cycles
  std::vector<int> faceOf_;       // by cycles
  std::vector<bool> hasNeck_;     // of faces
  std::vector<FaceJoint> joints_;
  double moved_ = 0;
};

}  // namespace

CutSheet sheetOfCuts(const CutLines& cuts, const Drawing& drawing, const ReadSettings& settings,
                     double tolerance, const fs::path& file) {
  return SheetMaker(cuts, drawing, settings, tolerance, file).make();
}

}  // namespace kirireel::formats
