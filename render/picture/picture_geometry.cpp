// Converts items into flat polygons of one colour. The painter draws them as triangles and the
// canvas as shapes, so both show the same.
//
// A shadow is the projection of the bricks onto the plate, away from the style's shadowSource. For
// a convex brick it is the convex hull of the projected corners. Facets of the shadow overlap and
// have one colour, so together they are one flat shape. A light with an extent makes the edge soft:
// the shadow of a point at height h fades out over s h, with the style's softness s. It is sharp
// where bricks touch the plate. With t = 1 - d / (s h) at the distance d from the edge, the
// fraction 3 t^2 - 2 t^3 of the full shadow is drawn. t is rounded to one of n steps, from the
// palest to the full. Step i has the fraction at t = i / n and extends to t = (i - 1/2) / n: its
// outlines are the hulls of the projected corners widened to discs of radius s h (1 - t). The main
// cost of a shadow are its pixels, painted once per step, so there are only as many steps as are
// visible.
//
// Faces that face away from the camera are omitted, because bricks are closed. This includes
// translucent bricks: they are one layer of colour at any thickness.
#include "render/picture/picture_geometry.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

#include "sim/base/interruption.h"
#include "sim/model/convex_parts.h"

namespace kirireel::picture {
namespace {

/// Sides of the polygon of a dot. Its radius differs from that of a true circle by 2% at most.
constexpr int kDotSides = 16;

/// Sine of the smallest angle between a visible face and the line of sight; below it the face is
/// edge-on.
constexpr double kEdgeOn = 1e-9;

/// A line on a brick is moved towards the eye by this many of its widths.
constexpr double kLineLift = 1;

/// Width of the steps in which a shadow fades out, in heights of the picture, and their largest
/// number. Such steps are invisible.
constexpr double kShadowStep = 0.004;
constexpr int kMaxShadowSteps = 10;

/// Number of directions in which the corner of a shadow is widened.
constexpr int kShadowDirections = 12;

/// Length of a dash, and of the gap after it, in widths of the line.
constexpr double kDashWidths = 3;

/// Towards the eye from a point, not normalised.
Vector3 towardsEye(const Camera& camera, const Vector3& point) {
  return camera.orthographic ? camera.eye - camera.centre : camera.eye - point;
}

/// Appends a polygon without outline.
Facet appendFacet(PictureGeometry& geometry, std::span<const Vector3> corners, Colour colour) {
  const int first = static_cast<int>(geometry.points.size());
  geometry.points.insert(geometry.points.end(), corners.begin(), corners.end());
  return {first, static_cast<int>(corners.size()), colour};
}

/// Four corners, anticlockwise from above.
void drawPlate(const GroundPlate& plate, Colour colour, PictureGeometry& geometry) {
  std::array<Vector3, 4> corners;
  for (int k = 0; k < 4; ++k) {
    corners[k] = {plate.centre.x() + (k == 1 || k == 2 ? 1 : -1) * plate.halfSize,
                  plate.centre.y() + (k >= 2 ? 1 : -1) * plate.halfSize, plate.height};
  }
  geometry.ground.push_back(appendFacet(geometry, corners, colour));
}

/// The directions in which the corners of a shadow are widened, unit vectors.
std::vector<Eigen::Vector2d> shadowDirections() {
  std::vector<Eigen::Vector2d> directions;
  for (int k = 0; k < kShadowDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kShadowDirections;
    directions.emplace_back(std::cos(angle), std::sin(angle));
  }
  return directions;
}

/// The convex outline of discs around horizontal points, anticlockwise from above. Radii are the
/// softness times the heights.
std::vector<Vector3> widened(const std::vector<Vector3>& points, const std::vector<double>& heights,
                             double softness) {
  static const std::vector<Eigen::Vector2d> directions = shadowDirections();
  std::vector<Eigen::Vector2d> rims;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double radius = softness * heights[k];
    for (const Eigen::Vector2d& direction : directions) {
      rims.emplace_back(points[k].head<2>() + radius * direction);
      if (radius <= 0) break;
    }
  }
  std::vector<Vector3> outline;
  for (const Eigen::Vector2d& point : model::convexOutline(std::move(rims))) {
    outline.emplace_back(point.x(), point.y(), points[0].z());
  }
  return outline;
}

/// Dots that face the camera.
void drawMarks(const std::vector<Vector3>& marks, double radius, Colour colour,
               const Camera& camera, PictureGeometry& geometry) {
  std::array<Vector3, kDotSides> corners;
  for (const Vector3& mark : marks) {
    const Vector3 back = towardsEye(camera, mark).normalized();
    const Vector3 right = camera.up.cross(back).normalized();
    const Vector3 up = back.cross(right);
    const Vector3 centre = mark + kDotLift * radius * back;
    for (int k = 0; k < kDotSides; ++k) {
      const double angle = 2 * std::numbers::pi * k / kDotSides;
      corners[k] = centre + radius * (std::cos(angle) * right + std::sin(angle) * up);
    }
    geometry.solid.push_back(appendFacet(geometry, corners, colour));
  }
}

/// Polygons in one colour, lit on the side that faces the camera.
void drawScenery(const std::vector<model::Tile>& polygons, const Style& style, const Camera& camera,
                 PictureGeometry& geometry) {
  const Matrix3 towardsPicture = pictureFromWorld(camera);
  for (const auto& [corners] : polygons) {
    const Vector3 normal = doubledVectorArea(corners).normalized();
    const bool isFront = normal.dot(towardsEye(camera, corners[0])) > 0;
    std::vector<Vector3> seen = corners;
    if (!isFront) std::reverse(seen.begin(), seen.end());
    const Vector3 towards = isFront ? normal : Vector3(-normal);
    geometry.solid.push_back(
        appendFacet(geometry, seen, faceColour(towardsPicture * towards, style.scenery, style)));
  }
}

/// A flat ribbon of a line that faces the camera.
struct Ribbon {
  Vector3 from;
  Vector3 along;     ///< unit
  Vector3 halfWide;  ///< from the middle to a side, metres
  Vector3 lift;      ///< towards the eye, so faces that the line lies in do not hide it

  /// The corners of its part between these distances from `from`.
  std::array<Vector3, 4> part(double begin, double end) const {
    return {from + begin * along - halfWide, from + end * along - halfWide,
            from + end * along + halfWide, from + begin * along + halfWide};
  }
};

/// Absent for a line that points at the camera.
std::optional<Ribbon> ribbonOf(const Vector3& from, const Vector3& to, double width,
                               const Camera& camera) {
  const Vector3 along = (to - from).normalized();
  const Vector3 back = towardsEye(camera, 0.5 * (from + to)).normalized();
  const Vector3 across = back.cross(along);
  if (!(across.norm() > 1e-6)) return std::nullopt;
  return Ribbon{from, along, 0.5 * width * across.normalized(), kLineLift * width * back};
}

/// The visible part of a straight line, among the solid facets. Half a width longer at both ends,
/// so corners of two lines are closed.
void drawVisibleLine(const Ribbon& ribbon, double length, double width, Colour colour,
                     PictureGeometry& geometry) {
  std::array<Vector3, 4> whole = ribbon.part(-0.5 * width, length + 0.5 * width);
  for (Vector3& corner : whole) corner += ribbon.lift;
  geometry.solid.push_back(appendFacet(geometry, whole, colour));
}

/// A straight line as a ribbon that faces the camera, once as a whole among the solid facets and
/// once in dashes over everything, which show its hidden parts. Empty if it points at the camera.
void drawLine(const Vector3& from, const Vector3& to, double width, Colour colour,
              const Camera& camera, PictureGeometry& geometry) {
  const double length = (to - from).norm();
  const std::optional<Ribbon> ribbon = ribbonOf(from, to, width, camera);
  if (!ribbon) return;
  drawVisibleLine(*ribbon, length, width, colour, geometry);
  // Begins and ends with half a dash, lengthened as above.
  const double dashes = std::max(1.0, std::round(length / (2 * kDashWidths * width)));
  const double dash = 0.5 * length / dashes;
  for (int k = 0; k <= static_cast<int>(dashes); ++k) {
    const double middle = 2 * k * dash;
    const double begin = std::max(-0.5 * width, middle - 0.5 * dash);
    const double end = std::min(length + 0.5 * width, middle + 0.5 * dash);
    geometry.overlay.push_back(appendFacet(geometry, ribbon->part(begin, end), colour));
  }
}

/// The background's share of a face's colour.
double distantShare(const DepthCue& cue, const Camera& camera, std::span<const Vector3> corners) {
  if (cue.share <= 0 || !(cue.farthest > cue.nearest)) return 0;
  double sum = 0;
  for (const Vector3& corner : corners) sum += distanceAlongView(camera, corner);
  const double distance = sum / static_cast<double>(corners.size());
  return cue.share * std::clamp((distance - cue.nearest) / (cue.farthest - cue.nearest), 0.0, 1.0);
}

/// The same point in the picture, farther from the eye. A face keeps its normal.
Vector3 setBack(const Vector3& point, const Camera& camera, double distance) {
  const Vector3 view = camera.centre - camera.eye;
  if (camera.orthographic) return point + distance * view.normalized();
  return point + distance / view.norm() * (point - camera.eye);
}

void drawOverlay(const std::vector<model::Tile>& polygons, double width, Colour colour,
                 const Camera& camera, PictureGeometry& geometry) {
  for (const auto& [corners] : polygons) {
    checkInterruption();
    for (std::size_t k = 0; k < corners.size(); ++k) {
      drawLine(corners[k], corners[(k + 1) % corners.size()], width, colour, camera, geometry);
    }
  }
}

/// Dashes over everything in the part of a longer line that begins `start` from its first point.
/// They keep their places when the line grows. Half a width longer inside a dash, as above.
void drawDashes(const Ribbon& ribbon, double start, double length, double width, Colour colour,
                PictureGeometry& geometry) {
  const double period = 2 * kDashWidths * width;
  for (double dash = period * std::floor(start / period); dash < start + length; dash += period) {
    const double begin = dash - start, end = begin + 0.5 * period;
    if (end <= 0) continue;
    geometry.overlay.push_back(appendFacet(
        geometry, ribbon.part(std::max(begin, -0.5 * width), std::min(end, length + 0.5 * width)),
        colour));
  }
}

/// Lines with dashes in their hidden parts. Points nearer than a width to the previous drawn one
/// are left out, except the last.
void drawTrails(const std::vector<std::vector<Vector3>>& trails, double width, Colour colour,
                const Camera& camera, PictureGeometry& geometry) {
  for (const std::vector<Vector3>& trail : trails) {
    checkInterruption();
    double start = 0;
    for (std::size_t k = 1, from = 0; k < trail.size(); ++k) {
      const double length = (trail[k] - trail[from]).norm();
      if (length < width && (k + 1 < trail.size() || length == 0)) continue;
      if (const auto ribbon = ribbonOf(trail[from], trail[k], width, camera)) {
        drawVisibleLine(*ribbon, length, width, colour, geometry);
        drawDashes(*ribbon, start, length, width, colour, geometry);
      }
      start += length;
      from = k;
    }
  }
}

}  // namespace

/// Computed once for each face of a run; each picture only moves and rotates faces.
GeometryBuilder::Face GeometryBuilder::makeFace(const std::vector<Vector3>& corners) {
  Face face{corners, {}, doubledVectorArea(corners).normalized()};
  if (!model::isConvexPolygon(corners, face.normal))
    face.triangles = model::trianglesOf(corners, face.normal);
  return face;
}

GeometryBuilder::GeometryBuilder(const std::vector<brick::Brick>& bricks, const Style& style)
    : style_(style) {
  for (const brick::Brick& brick : bricks) {
    std::vector<Face>& faces = faces_.emplace_back();
    for (const std::vector<Vector3>& corners : brick::brickFaces(brick))
      faces.push_back(makeFace(corners));
  }
}

/// Faces: bottom, top, then sides. Concave ones are divided into triangles.
void GeometryBuilder::drawBrick(const std::vector<Face>& faces, const Pose& pose,
                                const BrickColours& colours, const Camera& camera,
                                const DepthCue& depthCue, const Occluded& occluded,
                                PictureGeometry& geometry) const {
  std::vector<Facet>& layer = colours.top.alpha < 255 ? geometry.translucent : geometry.solid;
  const Matrix3 rotation = pose.rotation.toRotationMatrix();
  const Matrix3 towardsPicture = pictureFromWorld(camera);
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const Face& face = faces[k];
    const Vector3 normal = rotation * face.normal;
    const Vector3 corner = pose.position + rotation * face.corners[0];
    const Vector3 towards = towardsEye(camera, corner);
    if (normal.dot(towards) <= kEdgeOn * towards.norm()) continue;
    const Colour base = k == 0 ? colours.bottom : k == 1 ? colours.top : colours.side;
    std::vector<Vector3> corners;
    for (const Vector3& point : face.corners) {
      corners.push_back(pose.position + rotation * point);
    }
    const Colour lit =
        faceColour(towardsPicture * normal, base, style_, occluded ? occluded(corners, normal) : 0);
    const Facet whole = appendFacet(
        geometry, corners, mixed(lit, style_.background, distantShare(depthCue, camera, corners)));
    if (face.triangles.empty()) layer.push_back(whole);
    for (const auto& [a, b, c] : face.triangles) {
      layer.push_back(
          appendFacet(geometry, std::array{corners[a], corners[b], corners[c]}, whole.colour));
      layer.back().isPart = true;
    }
    if (style_.slitWidth <= 0) continue;
    geometry.outlines.push_back({whole.first, whole.count, whole.colour.alpha / 255.0});
  }
}

std::vector<BrickColours> GeometryBuilder::coloursOf(const PictureItems& items) const {
  std::vector<BrickColours> colours = items.colours;
  if (colours.empty()) colours.assign(faces_.size(), style_.brick);
  for (const int brick : items.pinned) {
    colours.at(brick) = withOpacity(style_.pinned, colours.at(brick).top.alpha / 255.0);
  }
  return colours;
}

GeometryBuilder::PlacedFaces GeometryBuilder::place(
    const Poses& poses, const std::vector<BrickColours>& colours) const {
  PlacedFaces placed(faces_.size());
  for (std::size_t brick = 0; brick < faces_.size(); ++brick) {
    if (!isDrawn(colours[brick])) continue;
    for (const Face& face : faces_[brick]) {
      std::vector<Vector3>& corners = placed[brick].emplace_back();
      for (const Vector3& point : face.corners) corners.push_back(poses[brick].apply(point));
    }
  }
  return placed;
}

void GeometryBuilder::CastPoints::add(const Vector3& point, const Style& style) {
  points.push_back(shadowOf(point, style));
  heights.push_back(std::max(0.0, point.z() - style.plate->height));
}

/// The shadow of a convex brick is the hull of all its projected corners. That of a concave brick
/// is the union of the shadows of its lit faces, divided into triangles if they are concave.
void GeometryBuilder::appendCast(const std::vector<Face>& faces, const Pose& pose,
                                 std::vector<CastPoints>& cast) const {
  if (faces[0].triangles.empty()) {
    CastPoints& whole = cast.emplace_back();
    for (const int end : {0, 1}) {
      for (const Vector3& corner : faces[end].corners) whole.add(pose.apply(corner), style_);
    }
    return;
  }
  for (const Face& face : faces) {
    if (style_.shadowSource.dot(pose.rotation * face.normal) <= 0) continue;
    for (const auto& triangle : face.triangles) {
      CastPoints& part = cast.emplace_back();
      for (const int corner : triangle) part.add(pose.apply(face.corners[corner]), style_);
    }
    if (!face.triangles.empty()) continue;
    CastPoints& side = cast.emplace_back();
    for (const Vector3& corner : face.corners) side.add(pose.apply(corner), style_);
  }
}

void GeometryBuilder::drawShadow(const Poses& poses, const std::vector<BrickColours>& colours,
                                 double pictureHeight, PictureGeometry& geometry) const {
  std::vector<CastPoints> cast;
  for (std::size_t brick = 0; brick < faces_.size(); ++brick) {
    checkInterruption();
    if (isDrawn(colours[brick])) appendCast(faces_[brick], poses[brick], cast);
  }
  double highest = 0;
  for (const CastPoints& polygon : cast) {
    for (const double height : polygon.heights) highest = std::max(highest, height);
  }
  const double width = style_.shadowSoftness * highest / pictureHeight;
  const int steps =
      static_cast<int>(std::clamp<double>(std::ceil(width / kShadowStep), 1, kMaxShadowSteps));
  for (int step = 1; step <= steps; ++step) {
    const double softness = style_.shadowSoftness * (1 - (step - 0.5) / steps);
    const double part = static_cast<double>(step) / steps;
    const Colour colour = partialShadow(style_, part * part * (3 - 2 * part));
    for (const CastPoints& polygon : cast) {
      checkInterruption();
      const std::vector<Vector3> outline = widened(polygon.points, polygon.heights, softness);
      if (outline.size() > 2) geometry.shadow.push_back(appendFacet(geometry, outline, colour));
    }
  }
}

void GeometryBuilder::drawGhosts(const PictureItems& items, const Camera& camera,
                                 PictureGeometry& geometry) const {
  const BrickColours colours = withOpacity(style_.brick, kGhostOpacity);
  const double distance = kGhostSetback * heightAtCentre(camera);
  for (const std::vector<std::vector<Vector3>>& ghost : items.ghosts) {
    checkInterruption();
    std::vector<Face> faces;
    for (std::vector<Vector3> corners : ghost) {
      for (Vector3& corner : corners) corner = setBack(corner, camera, distance);
      faces.push_back(makeFace(corners));
    }
    drawBrick(faces, {}, colours, camera, items.depthCue, {}, geometry);
  }
}

/// Order: ground, shadow, bricks, ghosts, obstacles, dots, trails, lines.
void GeometryBuilder::draw(const PictureItems& items, const Camera& camera,
                           PictureGeometry& geometry) const {
  assert(items.poses.size() == faces_.size());
  assert(items.colours.empty() || items.colours.size() == faces_.size());
  geometry.points.clear();
  geometry.outlines.clear();
  for (auto* layer : {&geometry.ground, &geometry.shadow, &geometry.solid, &geometry.translucent,
                      &geometry.overlay}) {
    layer->clear();
  }

  const double height = heightAtCentre(camera);
  const std::vector<BrickColours> colours = coloursOf(items);
  const std::optional<GroundPlate>& plate = style_.plate;
  const Vector3 middle = plate ? Vector3(plate->centre.x(), plate->centre.y(), plate->height)
                               : Vector3(Vector3::Zero());
  if (plate && towardsEye(camera, middle).z() > 0) {
    if (plate->visible) drawPlate(*plate, style_.ground, geometry);
    if (plate->shadow) drawShadow(items.poses, colours, height, geometry);
  }

  std::optional<Occluders> occluders;
  if (style_.occlusion > 0) occluders.emplace(place(items.poses, colours));
  for (int brick = 0; brick < static_cast<int>(faces_.size()); ++brick) {
    checkInterruption();
    if (!isDrawn(colours[brick])) continue;
    Occluded occluded;
    if (occluders) {
      occluded = [&](std::span<const Vector3> corners, const Vector3& normal) {
        return occluders->occlusion(brick, corners, normal);
      };
    }
    drawBrick(faces_[brick], items.poses[brick], colours[brick], camera, items.depthCue, occluded,
              geometry);
  }
  drawGhosts(items, camera, geometry);
  drawScenery(items.scenery, style_, camera, geometry);
  drawMarks(items.marks, 0.5 * style_.markSize * height, style_.mark, camera, geometry);
  drawTrails(items.trails, style_.overlayWidth * height, style_.overlay, camera, geometry);
  drawOverlay(items.overlay, style_.overlayWidth * height, style_.overlay, camera, geometry);
}

// ------------------------------------------------------------------------------------------------
// A polygon blocks from a point with normal n the fraction
//
//   F = (1 / 2 pi) sum_k angle(r_k, r_k+1) n . (r_k x r_k+1) / |r_k x r_k+1|
//
// of the light of a uniformly bright sky, where r_k are the directions from the point to its
// corners. This is Lambert's formula, exact for polygons above the point's horizon, at which they
// are clipped first (J. Arvo, "Analytic Methods for Simulated Light Transport", 1995, section 4.3).
// The faces of a convex brick that face the point tile its outline, so their fractions add up to
// that of the brick. Bricks that may hide each other are treated as independent:
//   1 - prod_b (1 - w_b F_b)
// The weight w_b falls to 0 at a reach of two or three tiles, so creases, gaps and the insides of
// tubes are dark.
//
// The result is smooth in the poses and needs no random directions. It is one number per face, so
// faces have one colour in pixels and in vector graphics.

namespace {

/// Distance at which faces occlude each other, in mean radii of bricks.
constexpr double kOcclusionReach = 2.5;

/// Points of a face are halfway between its centre and its corners; thin faces have only their
/// centre.
constexpr double kThinFace = 0.25;

double longestSide(std::span<const Vector3> corners) {
  double longest = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    longest = std::max(longest, (corners[(k + 1) % corners.size()] - corners[k]).norm());
  }
  return longest;
}

/// The part of a polygon above a point's horizon; corners are relative to the point. Sutherland and
/// Hodgman's clipping at one plane. `above` is cleared first and keeps its memory.
void cutToHorizon(std::span<const Vector3> corners, const Vector3& point, const Vector3& normal,
                  std::vector<Vector3>& above) {
  above.clear();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector3 here = corners[k] - point, next = corners[(k + 1) % corners.size()] - point;
    const double height = normal.dot(here), nextHeight = normal.dot(next);
    if (height > 0) above.push_back(here);
    if ((height > 0) == (nextHeight > 0)) continue;
    above.push_back(here + height / (height - nextHeight) * (next - here));
  }
}

/// Lambert's formula for corners relative to the point. 0 for fewer than three corners. The angle
/// between two directions is atan2(|r x r'|, r . r'), which is also accurate for small angles.
double skyPart(const std::vector<Vector3>& corners, const Vector3& normal) {
  double sum = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector3& from = corners[k];
    const Vector3& to = corners[(k + 1) % corners.size()];
    const Vector3 across = from.cross(to);
    const double size = across.norm();
    if (size > 0) sum += std::atan2(size, from.dot(to)) * normal.dot(across) / size;
  }
  return std::abs(sum) / (2 * std::numbers::pi);
}

/// Smooth from 1 at distance 0 to 0 at the reach and beyond: 1 - 3 s^2 + 2 s^3, whose slope is zero
/// at both ends.
double weightAt(double distance, double reach) {
  const double share = std::clamp(distance / reach, 0.0, 1.0);
  return 1 - share * share * (3 - 2 * share);
}

}  // namespace

Occluders::Occluders(const std::vector<std::vector<std::vector<Vector3>>>& faces) {
  double radii = 0;
  for (std::size_t brick = 0; brick < faces.size(); ++brick) {
    if (faces[brick].empty()) continue;
    Occluder& made = occluders_.emplace_back();
    made.brick = static_cast<int>(brick);
    made.centre = 0.5 * (meanPoint(faces[brick][0]) + meanPoint(faces[brick][1]));
    for (const std::vector<Vector3>& corners : faces[brick]) {
      Wall wall{corners, doubledVectorArea(corners).normalized(), 0};
      wall.offset = wall.normal.dot(corners[0]);
      for (const Vector3& corner : corners) {
        made.radius = std::max(made.radius, (corner - made.centre).norm());
      }
      made.walls.push_back(std::move(wall));
    }
    radii += made.radius;
    maxRadius_ = std::max(maxRadius_, made.radius);
  }
  reach_ = kOcclusionReach * radii / std::max<double>(1, static_cast<double>(occluders_.size()));
  std::ranges::stable_sort(occluders_, {}, [](const Occluder& o) { return o.centre.x(); });
}

double Occluders::occlusionAt(int brick, const Vector3& point, const Vector3& normal) const {
  const double farthest = reach_ + maxRadius_;
  std::vector<Vector3> above;
  double open = 1;
  auto at = std::ranges::lower_bound(occluders_, point.x() - farthest, {},
                                     [](const Occluder& o) { return o.centre.x(); });
  for (; at != occluders_.end() && at->centre.x() <= point.x() + farthest; ++at) {
    const Vector3 towards = at->centre - point;
    const double distance = towards.norm() - at->radius;
    const bool isBelow = normal.dot(towards) <= -at->radius;
    if (at->brick == brick || distance >= reach_ || isBelow) continue;
    double part = 0;
    for (const Wall& wall : at->walls) {
      if (wall.normal.dot(point) <= wall.offset) continue;
      cutToHorizon(wall.corners, point, normal, above);
      part += skyPart(above, normal);
    }
    open *= 1 - weightAt(distance, reach_) * std::min(1.0, part);
  }
  return 1 - open;
}

double Occluders::occlusion(int brick, std::span<const Vector3> corners,
                            const Vector3& normal) const {
  const Vector3 middle = meanPoint(corners);
  const double side = longestSide(corners);
  if (0.5 * doubledVectorArea(corners).norm() < kThinFace * side * side) {
    return occlusionAt(brick, middle, normal);
  }
  double sum = 0;
  for (const Vector3& corner : corners) {
    sum += occlusionAt(brick, 0.5 * (middle + corner), normal);
  }
  return sum / static_cast<double>(corners.size());
}

}  // namespace kirireel::picture
