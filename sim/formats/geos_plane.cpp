#include "sim/formats/geos_plane.h"

#include <algorithm>

#include "sim/base/error.h"

namespace kirireel::formats {
namespace {

/// Number of anticlockwise turns of a ring around a point.
int windingNumber(const PlaneRing& ring, const Vector2& point) {
  int turns = 0;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Vector2 a = ring[k] - point, b = ring[(k + 1) % ring.size()] - point;
    if ((a.y() <= 0) == (b.y() <= 0)) continue;
    const double side = crossZ(a, b);
    if (a.y() <= 0 && side > 0) ++turns;
    if (b.y() <= 0 && side < 0) --turns;
  }
  return turns;
}

}  // namespace

GeosPlane::~GeosPlane() {
  for (GEOSGeometry* one : made_) GEOSGeom_destroy_r(handle_, one);
  GEOS_finish_r(handle_);
}

GEOSGeometry* GeosPlane::polygon(const PlaneRing& ring) {
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

GEOSGeometry* GeosPlane::united(const std::vector<PlaneRing>& rings) {
  std::vector<GEOSGeometry*> parts;
  for (const PlaneRing& ring : rings) {
    parts.push_back(GEOSGeom_clone_r(handle_, polygon(ring)));
  }
  GEOSGeometry* all = keep(GEOSGeom_createCollection_r(
      handle_, GEOS_GEOMETRYCOLLECTION, parts.data(), static_cast<unsigned>(parts.size())));
  return keep(GEOSUnaryUnion_r(handle_, all));
}

GEOSGeometry* GeosPlane::difference(const GEOSGeometry* a, const GEOSGeometry* b) {
  return keep(GEOSDifference_r(handle_, a, b));
}

double GeosPlane::area(const GEOSGeometry* a) {
  double area = 0;
  GEOSArea_r(handle_, a, &area);
  return area;
}

GEOSGeometry* GeosPlane::sum(const GEOSGeometry* a, const GEOSGeometry* b) {
  return keep(GEOSUnion_r(handle_, a, b));
}

GEOSGeometry* GeosPlane::grown(const GEOSGeometry* a, double by) {
  GEOSGeometry* buffer =
      keep(GEOSBufferWithStyle_r(handle_, a, by, 8, GEOSBUF_CAP_FLAT, GEOSBUF_JOIN_MITRE, 20));
  if (GEOSisValid_r(handle_, buffer) == 1) return buffer;
  // Without the lines that the repair leaves.
  return keep(GEOSBuffer_r(handle_, keep(GEOSMakeValid_r(handle_, buffer)), 0, 8));
}

std::vector<PlaneRing> GeosPlane::rings(const GEOSGeometry* all, std::vector<PlaneRing>* holes) {
  std::vector<PlaneRing> found;
  for (int k = 0; k < GEOSGetNumGeometries_r(handle_, all); ++k) {
    const GEOSGeometry* one = GEOSGetGeometryN_r(handle_, all, k);
    if (GEOSGeomTypeId_r(handle_, one) != GEOS_POLYGON || GEOSisEmpty_r(handle_, one)) continue;
    found.push_back(ring(GEOSGetExteriorRing_r(handle_, one), true));
    for (int h = 0; h < GEOSGetNumInteriorRings_r(handle_, one); ++h) {
      (holes ? *holes : found).push_back(ring(GEOSGetInteriorRingN_r(handle_, one, h), false));
    }
  }
  return found;
}

/// The whole area inside an outline that crosses or touches itself, for either orientation.
GEOSGeometry* GeosPlane::wound(const GEOSGeometry* whole, const PlaneRing& ring) {
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

GEOSGeometry* GeosPlane::keep(GEOSGeometry* one) {
  if (!one) throw InputError("error: the outlines of the drawing have too many crossings");
  made_.push_back(one);
  return one;
}

PlaneRing GeosPlane::ring(const GEOSGeometry* line, bool isAnticlockwise) {
  const GEOSCoordSequence* points = GEOSGeom_getCoordSeq_r(handle_, line);
  unsigned count = 0;
  GEOSCoordSeq_getSize_r(handle_, points, &count);
  PlaneRing ring;
  for (unsigned k = 0; k + 1 < count; ++k) {
    double x = 0, y = 0;
    GEOSCoordSeq_getXY_r(handle_, points, k, &x, &y);
    ring.emplace_back(x, y);
  }
  if ((ringArea(ring) > 0) != isAnticlockwise) std::ranges::reverse(ring);
  return ring;
}

}  // namespace kirireel::formats
