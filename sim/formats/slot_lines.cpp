// Converts slots to their centre lines.
//
// 1. *Material* M is the outlines of sheets minus all rings in them (by GEOS, so slots may overlap
//    each other and the outline). A ring around one outline that itself contains rings is the frame
//    of a page and is ignored.
// 2. *Facing edges*: two edges of M's border with opposite directions and only removed material
//    between them. The median of their distances over their lengths is the kerf k.
// 3. *Centre lines* lie midway between facing edges, where these overlap. Connected ones that are
//    together shorter than 1.1 k are notches and holes.
// 4. *Outline*: closing M by at least 0.6 k (dilation and erosion with mitred corners, J. Serra,
//    Image Analysis and Mathematical Morphology, 1982) fills slots and their mouths and preserves
//    straight edges. Remaining holes are wider than slots.
//
// Open lines are slits without a width. Those that enclose a narrow face together with other lines,
// such as a mouth of a slot at the outline, are slots: a cutter removes what is inside.
//
// At junctions of slots, centre lines end half a kerf before each other. sheetOfCuts() extends all
// ends and finds no material in between.
#include "sim/formats/slot_lines.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <geos_c.h>

#include "sim/base/error.h"

namespace kirireel::formats {
namespace {

using SlotRing = std::vector<Vector2>;

/// Number of anticlockwise turns of a ring around a point.
int windingNumber(const SlotRing& ring, const Vector2& point) {
  int turns = 0;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Vector2 a = ring[k] - point, b = ring[(k + 1) % ring.size()] - point;
    if ((a.y() <= 0) == (b.y() <= 0)) continue;
    const double side = crossOf(a, b);
    if (a.y() <= 0 && side > 0) ++turns;
    if (b.y() <= 0 && side < 0) --turns;
  }
  return turns;
}

/// A GEOS context with the objects that it made.
class GeosPlane {
 public:
  GeosPlane() : handle_(GEOS_init_r()) {}
  ~GeosPlane() {
    for (GEOSGeometry* one : made_) GEOSGeom_destroy_r(handle_, one);
    GEOS_finish_r(handle_);
  }
  GeosPlane(const GeosPlane&) = delete;
  GeosPlane& operator=(const GeosPlane&) = delete;

  GEOSGeometry* polygon(const SlotRing& ring) {
    GEOSCoordSequence* points =
        GEOSCoordSeq_create_r(handle_, static_cast<unsigned>(ring.size()) + 1, 2);
    for (std::size_t k = 0; k <= ring.size(); ++k) {
      const Vector2& p = ring[k % ring.size()];
      GEOSCoordSeq_setXY_r(handle_, points, static_cast<unsigned>(k), p.x(), p.y());
    }
    GEOSGeometry* shell = GEOSGeom_createLinearRing_r(handle_, points);
    GEOSGeometry* whole = shell ? GEOSGeom_createPolygon_r(handle_, shell, nullptr, 0) : nullptr;
    if (!whole) throw InputError("error: an outline of the drawing is not a polygon");
    keep(whole);
    return GEOSisValid_r(handle_, whole) == 1 ? whole : wound(whole, ring);
  }
  GEOSGeometry* united(const std::vector<SlotRing>& rings) {
    std::vector<GEOSGeometry*> parts;
    for (const SlotRing& ring : rings) {
      parts.push_back(GEOSGeom_clone_r(handle_, polygon(ring)));
    }
    GEOSGeometry* all = keep(GEOSGeom_createCollection_r(
        handle_, GEOS_GEOMETRYCOLLECTION, parts.data(), static_cast<unsigned>(parts.size())));
    return keep(GEOSUnaryUnion_r(handle_, all));
  }
  GEOSGeometry* difference(const GEOSGeometry* a, const GEOSGeometry* b) {
    return keep(GEOSDifference_r(handle_, a, b));
  }
  double area(const GEOSGeometry* a) {
    double area = 0;
    GEOSArea_r(handle_, a, &area);
    return area;
  }
  GEOSGeometry* sum(const GEOSGeometry* a, const GEOSGeometry* b) {
    return keep(GEOSUnion_r(handle_, a, b));
  }
  GEOSGeometry* grown(const GEOSGeometry* a, double by) {
    return keep(GEOSBufferWithStyle_r(handle_, a, by, 8, GEOSBUF_CAP_FLAT, GEOSBUF_JOIN_MITRE, 20));
  }

  /// The rings of all polygons, material on their left; holes in the second list if it is given.
  std::vector<SlotRing> rings(const GEOSGeometry* all, std::vector<SlotRing>* holes = nullptr) {
    std::vector<SlotRing> found;
    for (int k = 0; k < GEOSGetNumGeometries_r(handle_, all); ++k) {
      const GEOSGeometry* one = GEOSGetGeometryN_r(handle_, all, k);
      if (GEOSGeomTypeId_r(handle_, one) != GEOS_POLYGON) continue;
      found.push_back(ring(GEOSGetExteriorRing_r(handle_, one), true));
      for (int h = 0; h < GEOSGetNumInteriorRings_r(handle_, one); ++h) {
        (holes ? *holes : found).push_back(ring(GEOSGetInteriorRingN_r(handle_, one, h), false));
      }
    }
    return found;
  }

 private:
  /// The whole area inside an outline that crosses or touches itself, for either orientation.
  GEOSGeometry* wound(const GEOSGeometry* whole, const SlotRing& ring) {
    const GEOSGeometry* line = keep(GEOSBoundary_r(handle_, whole));
    const GEOSGeometry* noded = keep(GEOSUnaryUnion_r(handle_, line));
    const GEOSGeometry* faces = keep(GEOSPolygonize_r(handle_, &noded, 1));
    std::vector<GEOSGeometry*> parts;
    for (int k = 0; k < GEOSGetNumGeometries_r(handle_, faces); ++k) {
      const GEOSGeometry* face = GEOSGetGeometryN_r(handle_, faces, k);
      const GEOSGeometry* point = keep(GEOSPointOnSurface_r(handle_, face));
      Vector2 inside;
      GEOSGeomGetX_r(handle_, point, &inside.x());
      GEOSGeomGetY_r(handle_, point, &inside.y());
      if (windingNumber(ring, inside) != 0) parts.push_back(GEOSGeom_clone_r(handle_, face));
    }
    const GEOSGeometry* all = keep(GEOSGeom_createCollection_r(
        handle_, GEOS_GEOMETRYCOLLECTION, parts.data(), static_cast<unsigned>(parts.size())));
    return keep(GEOSUnaryUnion_r(handle_, all));
  }

  GEOSGeometry* keep(GEOSGeometry* one) {
    if (!one) throw InputError("error: the outlines of the drawing have too many crossings");
    made_.push_back(one);
    return one;
  }
  SlotRing ring(const GEOSGeometry* line, bool isAnticlockwise) {
    const GEOSCoordSequence* points = GEOSGeom_getCoordSeq_r(handle_, line);
    unsigned count = 0;
    GEOSCoordSeq_getSize_r(handle_, points, &count);
    SlotRing ring;
    for (unsigned k = 0; k + 1 < count; ++k) {
      double x = 0, y = 0;
      GEOSCoordSeq_getXY_r(handle_, points, k, &x, &y);
      ring.emplace_back(x, y);
    }
    if ((ringArea(ring) > 0) != isAnticlockwise) std::ranges::reverse(ring);
    return ring;
  }

  GEOSContextHandle_t handle_;
  std::vector<GEOSGeometry*> made_;
};

bool holds(const SlotRing& outer, const SlotRing& inner) {
  return std::ranges::all_of(inner, [&](const Vector2& p) { return isWithinRing(outer, p); });
}

std::vector<PlaneSegment> segmentsOf(const std::vector<SlotRing>& rings) {
  std::vector<PlaneSegment> segments;
  for (const SlotRing& ring : rings) {
    for (std::size_t k = 0; k < ring.size(); ++k) {
      segments.emplace_back(ring[k], ring[(k + 1) % ring.size()]);
    }
  }
  return segments;
}

/// Two edges that face each other across removed material.
struct FacingEdges {
  PlaneSegment middle;
  double width = 0;
  double length = 0;
  int edges[2] = {0, 0};
};

std::vector<FacingEdges> facingEdges(const std::vector<PlaneSegment>& border, double reach,
                                     double tolerance) {
  std::vector<FacingEdges> found;
  std::vector<double> nearest(border.size(), reach);
  visitNearSegments(border, reach, [&](int i, int j) {
    const Vector2 a = border[i].first, b = border[i].second;
    const Vector2 c = border[j].first, d = border[j].second;
    const Vector2 u = (b - a).normalized(), v = (d - c).normalized();
    if (u.dot(v) > -0.985) return;  // cosine of ten degrees
    // Removed material is on the right of both.
    const Vector2 right(u.y(), -u.x());
    const double from = std::max(0.0, (d - a).dot(u));
    const double to = std::min((b - a).norm(), (c - a).dot(u));
    if (to - from <= tolerance) return;
    const auto across = [&](double s) {
      const double share = ((a + s * u) - c).dot(u) / (d - c).dot(u);
      return Vector2(c + share * (d - c));
    };
    const Vector2 first = across(from), last = across(to);
    const double near = (first - (a + from * u)).dot(right), far = (last - (a + to * u)).dot(right);
    const double width = 0.5 * (near + far);
    if (near <= tolerance || far <= tolerance || width > reach) return;
    found.push_back(
        {{0.5 * (a + from * u + first), 0.5 * (a + to * u + last)}, width, to - from, {i, j}});
    // Short overlaps come from ends and corners.
    if (to - from < width) return;
    nearest[i] = std::min(nearest[i], width);
    nearest[j] = std::min(nearest[j], width);
  });
  // More distant pairs have other edges between them.
  std::erase_if(found, [&](const FacingEdges& pair) {
    return pair.width > 1.5 * nearest[pair.edges[0]] || pair.width > 1.5 * nearest[pair.edges[1]];
  });
  return found;
}

/// The median width of slots, by length. Pairs that are much wider than others that are longer than
/// wide are openings.
double medianWidth(std::vector<FacingEdges> pairs) {
  constexpr double kWider = 4;
  std::ranges::sort(pairs, {}, &FacingEdges::width);
  double slot = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (slot > 0 && pairs[k].width > kWider * slot)
      pairs.resize(k);
    else if (pairs[k].length > pairs[k].width)
      slot = pairs[k].width;
  }
  double whole = 0, sum = 0;
  for (const FacingEdges& pair : pairs) whole += pair.length;
  for (const FacingEdges& pair : pairs) {
    if ((sum += pair.length) >= 0.5 * whole) return pair.width;
  }
  return 0;
}

/// Outlines of the sheets without slots, and their holes that are wider than slots.
std::vector<SlotRing> filledOutlines(GeosPlane& plane, const GEOSGeometry* material,
                                     const std::vector<FacingEdges>& pairs, double kerf,
                                     double tolerance, std::vector<SlotRing>& holes) {
  std::vector<SlotRing> outlines;
  const auto isFilled = [&](const FacingEdges& pair) {
    if (pair.width > 1.1 * kerf) return true;  // wider than most slots
    const Vector2 middle = 0.5 * (pair.middle.first + pair.middle.second);
    const auto holdsIt = [&](const SlotRing& ring) { return isWithinRing(ring, middle); };
    return std::ranges::any_of(outlines, holdsIt) && std::ranges::none_of(holes, holdsIt);
  };
  constexpr double kCut = 0.1;  // of the square of a slot's width
  // Slots that end at the outline within rounding leave needles of material, with mitres far away.
  const double needle = 2 * tolerance;
  const GEOSGeometry* eroded = plane.grown(material, -needle);
  // Mitred buffers of GEOS may be wrong. Slots then stay open, and another distance works better.
  for (const double share : {0.6, 0.7, 0.85, 1.0}) {
    holes.clear();
    const double distance = share * kerf;
    const GEOSGeometry* closed = plane.grown(plane.grown(eroded, distance + needle), -distance);
    // Mitres of blunt tips may cut through necks.
    const double cut = plane.area(plane.difference(material, closed));
    if (cut > kCut * kerf * kerf) closed = plane.sum(closed, material);
    outlines = plane.rings(closed, &holes);
    if (std::ranges::all_of(pairs, isFilled)) break;
  }
  return outlines;
}

/// Junction of two centre lines that end near a position: their crossing if it is near.
Vector2 bendOf(const std::vector<PlaneSegment>& lines, const Vector2& place, double near) {
  constexpr double kLeastBend = 0.01;  // radians; straighter lines cross far away
  if (lines.size() != 2) return place;
  const Vector2 u = (lines[0].second - lines[0].first).normalized();
  const Vector2 v = (lines[1].second - lines[1].first).normalized();
  const double sine = crossOf(u, v);
  if (std::abs(sine) < kLeastBend) return place;
  const Vector2 apart = lines[1].first - lines[0].first;
  const Vector2 bend = lines[0].first + crossOf(apart, v) / sine * u;
  return (bend - place).norm() <= near ? bend : place;
}

}  // namespace

double extentOf(const SlotRing& ring) {
  Eigen::AlignedBox2d box;
  for (const Vector2& point : ring) box.extend(point);
  return box.diagonal().norm();
}

void dropFrames(std::vector<SlotRing>& rings, std::map<std::string, int>& leftOut) {
  std::ranges::stable_sort(rings, std::greater<>(),
                           [](const SlotRing& ring) { return std::abs(ringArea(ring)); });
  const auto holdsFrom = [&](std::size_t outer) {
    return std::all_of(rings.begin() + static_cast<std::ptrdiff_t>(outer) + 1, rings.end(),
                       [&](const SlotRing& ring) { return holds(rings[outer], ring); });
  };
  while (rings.size() > 2 && holdsFrom(0) && holdsFrom(1)) {
    rings.erase(rings.begin());
    ++leftOut["frame around the sheet"];
  }
}

namespace {

/// Finds narrow faces that open lines enclose together with other lines, such as the mouths of
/// slots at the outline. `slits` receives the open lines that enclose none.
void takeEnclosedSlots(const std::vector<SlotRing>& rings,
                       const std::vector<const DrawnPath*>& open, double reach, double tolerance,
                       std::vector<SlotRing>& removed, std::vector<PlaneSegment>& slits) {
  constexpr double kSlender = 0.1;  // of 4 area / perimeter^2; 0.25 for a square
  if (open.empty()) return;
  std::vector<PlaneSegment> segments = segmentsOf(rings);
  std::vector<std::vector<PlaneSegment>> pieces;
  for (const DrawnPath* path : open) {
    std::vector<PlaneSegment>& own = pieces.emplace_back();
    for (std::size_t k = 0; k + 1 < path->points.size(); ++k) {
      own.emplace_back(path->points[k], path->points[k + 1]);
    }
    segments.insert(segments.end(), own.begin(), own.end());
  }
  Arrangement faces(segments, tolerance);
  faces.dropBridges();
  std::vector<SlotRing> narrow;
  for (int c = 0; c < std::ssize(faces.cycles()); ++c) {
    const double area = faces.areaOf(c);
    if (!(area > 0)) continue;
    SlotRing ring;
    double perimeter = 0;
    for (const int half : faces.cycles()[c]) {
      ring.push_back(faces.at(faces.from(half)));
      perimeter += (faces.at(faces.to(half)) - ring.back()).norm();
    }
    if (4 * area > kSlender * perimeter * perimeter || 2 * area > reach * perimeter) continue;
    narrow.push_back(std::move(ring));
  }
  // Open lines along the edges of narrow faces.
  std::vector<PlaneSegment> near;
  std::vector<int> pathOf;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    near.insert(near.end(), pieces[k].begin(), pieces[k].end());
    pathOf.resize(near.size(), static_cast<int>(k));
  }
  const int lines = static_cast<int>(near.size());
  for (const auto& [a, b] : segmentsOf(narrow)) near.emplace_back(0.5 * (a + b), 0.5 * (a + b));
  std::vector<bool> isOfSlot(pieces.size(), false);
  visitNearSegments(near, 2 * tolerance, [&](int i, int j) {
    if ((i < lines) == (j < lines)) return;
    const auto& [from, to] = near[std::min(i, j)];
    const Vector2 along = to - from, apart = near[std::max(i, j)].first - from;
    const double length = along.norm();
    const bool isBeside = apart.dot(along) >= 0 && apart.dot(along) <= length * length;
    if (isBeside && std::abs(crossOf(along, apart)) <= tolerance * length) {
      isOfSlot[pathOf[std::min(i, j)]] = true;
    }
  });
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (!isOfSlot[k]) slits.insert(slits.end(), pieces[k].begin(), pieces[k].end());
  }
  removed.insert(removed.end(), narrow.begin(), narrow.end());
}

}  // namespace

std::vector<SlotRing> closedRings(const std::vector<const DrawnPath*>& paths, double tolerance,
                                  std::vector<const DrawnPath*>& leftOpen) {
  std::vector<SlotRing> rings;
  std::vector<const DrawnPath*> open;
  for (const DrawnPath* path : paths) {
    path->isClosed ? rings.push_back(path->points) : open.push_back(path);
  }
  if (open.empty()) return rings;
  PointNumbers numbers(tolerance, open.front()->points.front());
  std::vector<std::pair<int, int>> ends;
  std::vector<std::vector<int>> at;
  for (std::size_t k = 0; k < open.size(); ++k) {
    const int first = numbers.add(open[k]->points.front());
    ends.emplace_back(first, numbers.add(open[k]->points.back()));
    at.resize(numbers.count());
    at[ends.back().first].push_back(static_cast<int>(k));
    at[ends.back().second].push_back(static_cast<int>(k));
  }
  std::vector<bool> isTaken(open.size(), false);
  // If more than two lines end here, for example at touching outlines, the straightest continues.
  const auto nextAt = [&](int node, const Vector2& along) {
    int next = -1;
    double straightest = -2;
    for (const int path : at[node]) {
      if (isTaken[path] || at[node].size() % 2 == 1) continue;
      const std::vector<Vector2>& points = open[path]->points;
      const bool isForward = ends[path].first == node;
      const Vector2 first =
          isForward ? points[1] - points[0] : points[points.size() - 2] - points.back();
      const double turn = first.normalized().dot(along);
      if (turn <= straightest) continue;
      straightest = turn;
      next = path;
    }
    return next;
  };
  for (std::size_t k = 0; k < open.size(); ++k) {
    if (isTaken[k]) continue;
    SlotRing ring;
    std::vector<const DrawnPath*> chain;
    const int start = ends[k].first;
    int node = start;
    for (int path = static_cast<int>(k); path >= 0;) {
      isTaken[path] = true;
      chain.push_back(open[path]);
      const bool isForward = ends[path].first == node;
      std::vector<Vector2> points = open[path]->points;
      if (!isForward) std::ranges::reverse(points);
      ring.insert(ring.end(), points.begin(), points.end() - 1);
      node = isForward ? ends[path].second : ends[path].first;
      path = node == start ? -1
                           : nextAt(node, (points.back() - points[points.size() - 2]).normalized());
    }
    const bool closes = node == start && at[start].size() % 2 == 0 && ring.size() > 2;
    if (closes) {
      rings.push_back(std::move(ring));
    } else {
      leftOpen.insert(leftOpen.end(), chain.begin(), chain.end());
    }
  }
  return rings;
}

CutLines slotLines(const std::vector<SlotRing>& rings, const std::vector<const DrawnPath*>& open,
                   double tolerance) {
  CutLines cuts;
  std::vector<SlotRing> all = rings;
  dropFrames(all, cuts.leftOut);
  std::vector<SlotRing> sheets, removed;
  for (const SlotRing& ring : all) {
    const bool isIn = std::ranges::any_of(sheets, [&](const SlotRing& sheet) {
      const auto inside = std::ranges::count_if(
          ring, [&](const Vector2& point) { return isWithinRing(sheet, point); });
      return 2 * inside >= std::ssize(ring);
    });
    (isIn ? removed : sheets).push_back(ring);
  }
  double area = 0;
  for (const SlotRing& sheet : sheets) area += std::abs(ringArea(sheet));
  // Slots are narrower than tiles. In a sheet with slits, wide gaps are notches of the outline.
  const double reach = (open.empty() ? 1 : 0.25) *
                       std::sqrt(area / static_cast<double>(all.size() + open.size() + 1));
  std::vector<PlaneSegment> slits;
  takeEnclosedSlots(rings, open, reach, tolerance, removed, slits);
  GeosPlane plane;
  const GEOSGeometry* material = plane.united(sheets);
  if (!removed.empty()) material = plane.difference(material, plane.united(removed));
  const std::vector<PlaneSegment> border = segmentsOf(plane.rings(material));
  std::vector<FacingEdges> pairs = facingEdges(border, reach, tolerance);
  cuts.kerf = medianWidth(pairs);
  if (!(cuts.kerf > 0)) return cuts;
  std::erase_if(pairs, [&](const FacingEdges& pair) {
    return pair.width > 2.5 * cuts.kerf || pair.length < 0.25 * cuts.kerf;
  });
  PointNumbers ends(0.25 * cuts.kerf, border.front().first);
  std::vector<std::vector<PlaneSegment>> linesAt;
  std::vector<std::pair<int, int>> centreLines;
  for (const FacingEdges& pair : pairs) {
    const int first = ends.add(pair.middle.first), last = ends.add(pair.middle.second);
    linesAt.resize(ends.count());
    if (first == last) continue;
    linesAt[first].push_back(pair.middle);
    linesAt[last].push_back(pair.middle);
    centreLines.emplace_back(first, last);
  }
  std::vector<Vector2> places = ends.points();
  for (int k = 0; k < ends.count(); ++k) places[k] = bendOf(linesAt[k], places[k], cuts.kerf);
  // A slot is longer than wide. Others are notches and holes.
  constexpr double kSlender = 1.1;  // length / width
  const std::vector<int> partOf = Arrangement(places, centreLines).parts();
  std::vector<double> lengths(places.size(), 0);  // by part
  const auto lengthOf = [&](const std::pair<int, int>& line) {
    return (places[line.second] - places[line.first]).norm();
  };
  for (const auto& line : centreLines) lengths[partOf[line.first]] += lengthOf(line);
  std::erase_if(centreLines, [&](const auto& line) {
    return lengths[partOf[line.first]] < kSlender * cuts.kerf;
  });
  if (centreLines.empty()) return cuts;
  for (const auto& [first, last] : centreLines)
    cuts.lines.emplace_back(places[first], places[last]);
  std::vector<SlotRing> holes;
  const std::vector<SlotRing> outlines =
      filledOutlines(plane, material, pairs, cuts.kerf, tolerance, holes);
  for (const PlaneSegment& one : segmentsOf(outlines)) cuts.lines.push_back(one);
  for (const SlotRing& hole : holes) {
    // A hole at the end of one slot is a relief. Several slots may end at a hole of the design.
    int slots = 0;
    bool isRelief = false;
    for (int k = 0; k < ends.count(); ++k) {
      if (linesAt[k].size() != 1) continue;
      double nearest = isWithinRing(hole, places[k]) ? 0 : 1e9;
      for (const Vector2& point : hole) nearest = std::min(nearest, (point - places[k]).norm());
      if (nearest >= 1.5 * cuts.kerf) continue;
      ++slots;
      isRelief = extentOf(hole) <= kRelief * lengths[partOf[k]];
    }
    const bool isRound = openingTips({hole}, tolerance).empty();
    if (slots == 0 && isRound) ++cuts.leftOut["hole in a tile"];
    if (slots == 1 ? isRelief : slots == 0 && isRound) continue;
    for (const PlaneSegment& one : segmentsOf({hole})) cuts.lines.push_back(one);
    cuts.openings.push_back(hole);
  }
  std::vector<SlotRing> bounds = outlines;
  bounds.insert(bounds.end(), cuts.openings.begin(), cuts.openings.end());
  cuts.tips = openingTips(bounds, tolerance);
  cuts.lines.insert(cuts.lines.end(), slits.begin(), slits.end());
  cuts.border = border;
  return cuts;
}

}  // namespace kirireel::formats
