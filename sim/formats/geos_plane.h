/// Areas in the plane, by GEOS.
#pragma once

#include <vector>

#include <geos_c.h>

#include "sim/formats/arrangement.h"

namespace kirireel::formats {

/// A GEOS context with the objects that it made. Throws InputError if GEOS fails.
class GeosPlane {
 public:
  GeosPlane() : handle_(GEOS_init_r()) {}
  ~GeosPlane();
  GeosPlane(const GeosPlane&) = delete;
  GeosPlane& operator=(const GeosPlane&) = delete;

  /// All that a ring encloses. It may cross itself.
  GEOSGeometry* polygon(const PlaneRing& ring);
  GEOSGeometry* united(const std::vector<PlaneRing>& rings);
  GEOSGeometry* difference(const GEOSGeometry* a, const GEOSGeometry* b);
  GEOSGeometry* sum(const GEOSGeometry* a, const GEOSGeometry* b);
  /// The polygons offset by `by` metres with mitred corners; < 0 shrinks them.
  GEOSGeometry* grown(const GEOSGeometry* a, double by);
  double area(const GEOSGeometry* a);

  /// The rings of all polygons, material on their left; holes in the second list if it is given.
  std::vector<PlaneRing> rings(const GEOSGeometry* all, std::vector<PlaneRing>* holes = nullptr);

 private:
  GEOSGeometry* wound(const GEOSGeometry* whole, const PlaneRing& ring);
  GEOSGeometry* keep(GEOSGeometry* one);
  PlaneRing ring(const GEOSGeometry* line, bool isAnticlockwise);

  GEOSContextHandle_t handle_;
  std::vector<GEOSGeometry*> made_;
};

}  // namespace kirireel::formats
