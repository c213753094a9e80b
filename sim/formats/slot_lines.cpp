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

#include "sim/formats/geos_plane.h"

namespace kirireel::formats {
namespace {

std::vector<PlaneSegment> segmentsOf(const std::vector<PlaneRing>& rings) {
  std::vector<PlaneSegment> segments;
  for (const PlaneRing& ring : rings) appendRing(ring, segments);
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

/// A ring without the parts that begin and end at the same position and are smaller than the square
/// of a slot's width, which buffers leave.
PlaneRing withoutSmallLoops(PlaneRing ring, double kerf, double tolerance) {
  const auto lengthAt = [&](std::size_t k) {
    return (ring[(k + ring.size() - 1) % ring.size()] - ring[k]).norm();
  };
  std::size_t longest = 0;
  for (std::size_t k = 1; k < ring.size(); ++k) {
    if (lengthAt(k) > lengthAt(longest)) longest = k;
  }
  std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(longest), ring.end());
  PointNumbers numbers(tolerance, ring.front());
  PlaneRing kept;
  std::vector<int> keptNumbers;
  for (const Vector2& point : ring) {
    const int number = numbers.add(point);
    const auto before = std::ranges::find(keptNumbers, number) - keptNumbers.begin();
    const bool isLoop = before < std::ssize(kept);
    if (isLoop && std::abs(ringArea({kept.begin() + before, kept.end()})) < kerf * kerf) {
      kept.resize(before);
      keptNumbers.resize(before);
    }
    kept.push_back(point);
    keptNumbers.push_back(number);
  }
  return kept;
}

/// Outlines of the sheets without slots, and their holes that are wider than slots.
std::vector<PlaneRing> filledOutlines(GeosPlane& plane, const GEOSGeometry* material,
                                      const std::vector<FacingEdges>& pairs, double kerf,
                                      double tolerance, std::vector<PlaneRing>& holes) {
  std::vector<PlaneRing> outlines;
  const auto isFilled = [&](const FacingEdges& pair) {
    if (pair.width > 1.1 * kerf) return true;  // wider than most slots
    const Vector2 middle = 0.5 * (pair.middle.first + pair.middle.second);
    const auto holdsIt = [&](const PlaneRing& ring) { return isWithinRing(ring, middle); };
    return std::ranges::any_of(outlines, holdsIt) && std::ranges::none_of(holes, holdsIt);
  };
  constexpr double kCut = 0.1;  // area over the square of a slot's width
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
    for (auto* rings : {&outlines, &holes}) {
      for (PlaneRing& ring : *rings) ring = withoutSmallLoops(std::move(ring), kerf, tolerance);
    }
    if (std::ranges::all_of(pairs, isFilled)) break;
  }
  return outlines;
}

/// Junction of two centre lines that end near a position: their crossing if it is near.
Vector2 bendOf(const std::vector<PlaneSegment>& lines, const Vector2& place, double near) {
  constexpr double kMinBend = 0.01;  // radians; straighter lines cross far away
  if (lines.size() != 2) return place;
  const Vector2 u = (lines[0].second - lines[0].first).normalized();
  const Vector2 v = (lines[1].second - lines[1].first).normalized();
  if (std::abs(crossZ(u, v)) < kMinBend) return place;
  const double share = crossingShares(lines[0].first, u, lines[1].first, v)->first;
  const Vector2 bend = lines[0].first + share * u;
  return (bend - place).norm() <= near ? bend : place;
}

}  // namespace

double extentOf(const PlaneRing& ring) {
  return boundingBox(ring).diagonal().norm();
}

void dropFrames(std::vector<PlaneRing>& rings, std::map<std::string, int>& leftOut) {
  std::ranges::stable_sort(rings, std::greater<>(),
                           [](const PlaneRing& ring) { return std::abs(ringArea(ring)); });
  const auto holdsFrom = [&](std::size_t outer) {
    return std::all_of(rings.begin() + static_cast<std::ptrdiff_t>(outer) + 1, rings.end(),
                       [&](const PlaneRing& ring) { return areWithinRing(rings[outer], ring); });
  };
  while (rings.size() > 2 && holdsFrom(0) && holdsFrom(1)) {
    rings.erase(rings.begin());
    ++leftOut["frame around the sheet"];
  }
}

namespace {

/// Finds narrow faces that open lines enclose together with other lines, such as the mouths of
/// slots at the outline. `slits` receives the open lines that enclose none.
void takeEnclosedSlots(const std::vector<PlaneRing>& rings,
                       const std::vector<const DrawnPath*>& open, double reach, double tolerance,
                       std::vector<PlaneRing>& removed, std::vector<PlaneSegment>& slits) {
  constexpr double kSlender = 0.1;  // 4 area / perimeter^2; a square has 0.25
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
  std::vector<PlaneRing> narrow;
  for (int c = 0; c < std::ssize(faces.cycles()); ++c) {
    const double area = faces.areaOf(c);
    if (!(area > 0)) continue;
    PlaneRing ring;
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
    if (isBeside && std::abs(crossZ(along, apart)) <= tolerance * length) {
      isOfSlot[pathOf[std::min(i, j)]] = true;
    }
  });
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (!isOfSlot[k]) slits.insert(slits.end(), pieces[k].begin(), pieces[k].end());
  }
  removed.insert(removed.end(), narrow.begin(), narrow.end());
}

/// The rings of sheets, and those of what is removed from them.
struct SheetRings {
  std::vector<PlaneRing> sheets, removed;
};

/// A ring is removed if at least `share` of its points are in a sheet.
SheetRings sheetRings(const std::vector<PlaneRing>& rings, double share,
                      std::map<std::string, int>& leftOut) {
  std::vector<PlaneRing> all = rings;
  dropFrames(all, leftOut);
  SheetRings sorted;
  for (const PlaneRing& ring : all) {
    const bool isIn = std::ranges::any_of(sorted.sheets, [&](const PlaneRing& sheet) {
      const auto inside = std::ranges::count_if(
          ring, [&](const Vector2& point) { return isWithinRing(sheet, point); });
      return static_cast<double>(inside) >= share * static_cast<double>(ring.size());
    });
    (isIn ? sorted.removed : sorted.sheets).push_back(ring);
  }
  return sorted;
}

const GEOSGeometry* materialOf(GeosPlane& plane, const SheetRings& rings) {
  const GEOSGeometry* material = plane.united(rings.sheets);
  return rings.removed.empty() ? material : plane.difference(material, plane.united(rings.removed));
}

/// Centre lines of slots as edges between positions.
struct CentreLines {
  std::vector<Vector2> places;
  std::vector<std::pair<int, int>> edges;
  std::vector<double> slotLengths;  // of the connected lines, by position
  std::vector<int> ends;            // places of one line
};

CentreLines centreLines(const std::vector<FacingEdges>& pairs, double kerf) {
  CentreLines centre;
  if (pairs.empty()) return centre;
  PointNumbers numbers(0.25 * kerf, pairs.front().middle.first);
  std::vector<std::vector<PlaneSegment>> linesAt;
  for (const FacingEdges& pair : pairs) {
    const int first = numbers.add(pair.middle.first), last = numbers.add(pair.middle.second);
    linesAt.resize(numbers.count());
    if (first == last) continue;
    linesAt[first].push_back(pair.middle);
    linesAt[last].push_back(pair.middle);
    centre.edges.emplace_back(first, last);
  }
  centre.places = numbers.points();
  for (int k = 0; k < numbers.count(); ++k) {
    centre.places[k] = bendOf(linesAt[k], centre.places[k], kerf);
    if (linesAt[k].size() == 1) centre.ends.push_back(k);
  }
  const std::vector<int> partOf = Arrangement(centre.places, centre.edges).parts();
  std::vector<double> lengths(centre.places.size(), 0);  // by part
  for (const auto& [first, last] : centre.edges) {
    lengths[partOf[first]] += (centre.places[last] - centre.places[first]).norm();
  }
  for (const int part : partOf) centre.slotLengths.push_back(lengths[part]);
  // A slot is longer than wide. Others are notches and holes.
  constexpr double kSlender = 1.1;  // length / width
  std::erase_if(centre.edges, [&](const std::pair<int, int>& edge) {
    return centre.slotLengths[edge.first] < kSlender * kerf;
  });
  return centre;
}

/// Adds holes that are wider than slots, except reliefs and holes within a tile.
void takeHoles(const std::vector<PlaneRing>& holes, const CentreLines& centre, double tolerance,
               CutLines& cuts) {
  for (const PlaneRing& hole : holes) {
    // A hole at the end of one slot is a relief. Several slots may end at a hole of the design.
    int slots = 0;
    bool isRelief = false;
    for (const int end : centre.ends) {
      double nearest = isWithinRing(hole, centre.places[end]) ? 0 : 1e9;
      for (const Vector2& point : hole) {
        nearest = std::min(nearest, (point - centre.places[end]).norm());
      }
      if (nearest >= 1.5 * cuts.kerf) continue;
      ++slots;
      isRelief = extentOf(hole) <= kRelief * centre.slotLengths[end];
    }
    const bool isRound = openingTips({hole}, tolerance).empty();
    if (slots == 0 && isRound) ++cuts.leftOut["hole in a tile"];
    if (slots == 1 ? isRelief : slots == 0 && isRound) continue;
    appendRing(hole, cuts.lines);
    cuts.openings.push_back(hole);
  }
}

}  // namespace

std::vector<PlaneRing> closedRings(const std::vector<const DrawnPath*>& paths, double tolerance,
                                   std::vector<const DrawnPath*>& leftOpen) {
  std::vector<PlaneRing> rings;
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
    PlaneRing ring;
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

std::vector<PlaneRing> materialRings(const std::vector<PlaneRing>& rings) {
  std::map<std::string, int> leftOut;
  constexpr double kShare = 0.25;  // openings may have their centre on the outline
  GeosPlane plane;
  return plane.rings(materialOf(plane, sheetRings(rings, kShare, leftOut)));
}

CutLines slotLines(const std::vector<PlaneRing>& rings, const std::vector<const DrawnPath*>& open,
                   double tolerance) {
  CutLines cuts;
  SheetRings sheet = sheetRings(rings, 0.5, cuts.leftOut);
  double area = 0;
  for (const PlaneRing& one : sheet.sheets) area += std::abs(ringArea(one));
  const std::size_t parts = sheet.sheets.size() + sheet.removed.size() + open.size() + 1;
  // Slots are narrower than tiles. In a sheet with slits, wide gaps are notches of the outline.
  const double reach = (open.empty() ? 1 : 0.25) * std::sqrt(area / static_cast<double>(parts));
  std::vector<PlaneSegment> slits;
  takeEnclosedSlots(rings, open, reach, tolerance, sheet.removed, slits);
  GeosPlane plane;
  const GEOSGeometry* material = materialOf(plane, sheet);
  const std::vector<PlaneSegment> border = segmentsOf(plane.rings(material));
  std::vector<FacingEdges> pairs = facingEdges(border, reach, tolerance);
  cuts.kerf = medianWidth(pairs);
  if (!(cuts.kerf > 0)) return cuts;
  std::erase_if(pairs, [&](const FacingEdges& pair) {
    return pair.width > 2.5 * cuts.kerf || pair.length < 0.25 * cuts.kerf;
  });
  const CentreLines centre = centreLines(pairs, cuts.kerf);
  if (centre.edges.empty()) return cuts;
  for (const auto& [first, last] : centre.edges)
    cuts.lines.emplace_back(centre.places[first], centre.places[last]);
  std::vector<PlaneRing> holes;
  std::vector<PlaneRing> bounds =
      filledOutlines(plane, material, pairs, cuts.kerf, tolerance, holes);
  for (const PlaneRing& bound : bounds) appendRing(bound, cuts.lines);
  takeHoles(holes, centre, tolerance, cuts);
  bounds.insert(bounds.end(), cuts.openings.begin(), cuts.openings.end());
  cuts.tips = openingTips(bounds, tolerance);
  cuts.lines.insert(cuts.lines.end(), slits.begin(), slits.end());
  cuts.border = border;
  return cuts;
}

}  // namespace kirireel::formats
