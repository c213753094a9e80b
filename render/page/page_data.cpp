// Makes the JSON of a run that stage.js and the other scripts read. Everything that decides how it
// looks (colours, lights, widths, cameras) comes from render/picture and render/studio, so that a
// page and our pictures agree.
//
//     name; bricks: counts, corners, rises, triangles of concave ones; states: times, progress,
//     gap, error, poses, gaps, errors; joints: bricks, points; target; obstacles; plate; views;
//     curves
//
// Lengths are metres, times seconds. Bricks stand in their own axes as floats: a float has 24 bits,
// 500 times finer than a step of positions.
//
// The states of a page are at equal shares of motion and not of time, so that they are dense where
// something moves.
#include "render/page/page_data.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/grid/grid.h"
#include "render/page/cameras.h"
#include "render/png/png.h"
#include "render/record/album.h"
#include "render/record/pace.h"
#include "render/record/replay.h"
#include "render/studio/studio.h"
#include "sim/measure/brick_measures.h"
#include "sim/measure/run_curves.h"
#include "sim/model/convex_parts.h"

namespace kirireel {
namespace {

/// Of each of the three pictures, pixels.
constexpr FrameSize kStillSize{480, 360};
// Of a colour map: an odd number, so that the middle is among them.
constexpr int kShades = 129;
constexpr std::array<double, 3> kStillShares = {0, 0.5, 1};

Json colourJson(Colour colour) {
  return {colour.red, colour.green, colour.blue};
}

Json coloursJson(const BrickColours& colours) {
  return {colourJson(colours.bottom), colourJson(colours.top), colourJson(colours.side)};
}

/// Directions are unit vectors in the camera's axes, strengths 0 to 1.
Json lightsJson(const Style& style) {
  const auto light = [](const Light& from) -> Json {
    return {{"direction", vectorJson(from.direction)}, {"strength", from.strength}};
  };
  return {{"ambient", style.ambient}, {"key", light(style.key)}, {"fill", light(style.fill)}};
}

/// A motif of one brick: what a style needs that does not depend on the run.
Motif anyMotif() {
  Motif motif;
  motif.points = {Vector3::Zero(), Vector3::Ones()};
  return motif;
}

Style styleOf(const Look& look) {
  // So large that no line is thickened: the page does that for its own size.
  return Stage(look, anyMotif(), {kMaxFrameSide, kMaxFrameSide}).style();
}

void appendPoint(std::vector<float>& numbers, const Vector3& point) {
  for (int axis = 0; axis < 3; ++axis) numbers.push_back(static_cast<float>(point[axis]));
}

/// The corners of all polygons one after the other, and how many each has.
Json polygonsJson(const std::vector<Tile>& tiles) {
  std::vector<float> corners;
  std::vector<std::int32_t> counts;
  for (const Tile& tile : tiles) {
    counts.push_back(static_cast<std::int32_t>(tile.vertices.size()));
    for (const Vector3& vertex : tile.vertices) appendPoint(corners, vertex);
  }
  return {{"counts", packedArray(std::span<const std::int32_t>(counts))},
          {"corners", packedArray(std::span<const float>(corners))}};
}

/// The bricks' bottoms in their own axes, and what leads from there to their tops. A brick is a
/// prism: its top is its bottom moved by one vector, so that one vector a brick is enough.
Json bricksJson(const std::vector<Brick>& bricks) {
  std::vector<Tile> bottoms;
  std::vector<float> rises;
  Json triangles = Json::object();
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Brick& brick = bricks[i];
    bottoms.push_back({brick.bottom});
    appendPoint(rises, brick.top[0] - brick.bottom[0]);
    // The page fans convex polygons by itself.
    if (isConvexPolygon(brick.bottom, brick.normal)) continue;
    triangles[std::to_string(i)] = trianglesOf(brick.bottom, brick.normal);
  }
  Json json = polygonsJson(bottoms);
  json["rises"] = packedArray(std::span<const float>(rises));
  json["triangles"] = std::move(triangles);
  return json;
}

/// Where dots on joints stand: a brick, and a point in its axes. The points of the first brick of
/// each pivot.
Json joinsJson(const std::vector<Pivot>& pivots) {
  std::vector<std::int32_t> bricks;
  std::vector<float> points;
  for (const Pivot& pivot : pivots) {
    bricks.push_back(pivot.brickA);
    appendPoint(points, pivot.pointA);
  }
  return {{"bricks", packedArray(std::span<const std::int32_t>(bricks))},
          {"points", packedArray(std::span<const float>(points))}};
}

/// Metres from the brick's centre of mass, the origin of its axes.
double largestRadius(const std::vector<Brick>& bricks) {
  double radius = 0;
  for (const Brick& brick : bricks) {
    for (const auto* face : {&brick.bottom, &brick.top}) {
      for (const Vector3& corner : *face) radius = std::max(radius, corner.norm());
    }
  }
  return radius;
}

/// The states of a page and what is measured of them, taken one by one. The motif must outlive it.
class StateCollector {
 public:
  StateCollector(const Motif& motif, const PageStates& states)
      : motif_(motif), poses_(stepsFor(motif, states)) {}

  void add(const Sample& sample, double progress) {
    times_.push_back(sample.time);
    progress_.push_back(progress);
    gap_.push_back(sample.jointGap);
    error_.push_back(sample.targetError);
    poses_.add(sample.poses);
    // One value a brick and state; the page colours bricks by them.
    append(gaps_, brickJointGaps(motif_.pivots, sample.poses));
    if (motif_.target) {
      append(errors_, brickTargetErrors(*motif_.target, motif_.bricks, sample.poses));
    }
  }

  Json json() const {
    const bool hasTarget = motif_.target.has_value();
    return {{"times", times_},
            {"progress", progress_},
            {"gap", gap_},
            {"error", hasTarget ? Json(error_) : Json(nullptr)},
            {"poses", poses_.packed()},
            {"gaps", packedMagnitudes(gaps_)},
            {"errors", hasTarget ? packedMagnitudes(errors_) : Json(nullptr)}};
  }

 private:
  static std::optional<PoseSteps> stepsFor(const Motif& motif, const PageStates& states) {
    if (states.exact) return std::nullopt;
    Eigen::AlignedBox3d box;
    for (const Vector3& point : motif.points) box.extend(point);
    return finePoseSteps(box.center(), box.diagonal().norm(), largestRadius(motif.bricks));
  }

  static void append(std::vector<double>& values, const std::vector<double>& more) {
    values.insert(values.end(), more.begin(), more.end());
  }

  const Motif& motif_;
  PosePacker poses_;
  std::vector<double> times_, progress_, gap_, error_;  ///< one a state
  std::vector<double> gaps_, errors_;                   ///< state by state, one a brick
};

/// States between two samples are interpolated with their joints closed, see Replay.
Json statesJson(const TrajectoryReader& run, const Motif& motif, const PageStates& states) {
  const MotionCurve motion = motionOf(run);
  StateCollector collector(motif, states);
  if (states.samples == 0) {
    for (std::size_t k = 0; k < run.times().size(); ++k) {
      collector.add(run.sample(k), motion.shareAt(run.times()[k]));
    }
    return collector.json();
  }
  Replay replay(run);
  for (int k = 0; k < states.samples; ++k) {
    const double share = static_cast<double>(k) / (states.samples - 1);
    // A run in which nothing moves has its states at equal times.
    const double time = motion.length() > 0 ? motion.timeAt(share) : share * motion.endTime();
    collector.add(replay.at(time), share);
  }
  return collector.json();
}

/// The values with as many digits as a diagram can show, and a reader wants to know. Groups without
/// any value are left out; a value that does not exist is null.
Json curvesJson(const RunCurves& curves) {
  Json groups = Json::array();
  for (const CurveGroup& group : curves.groups) {
    if (!group.hasValues()) continue;
    Json lines = Json::array();
    for (const Curve& curve : group.curves) {
      if (!curve.hasValues()) continue;
      Json values = Json::array();
      for (const double value : curve.values)
        // Six digits: a text of fewer digits is shorter as JSON too.
        values.push_back(std::stod(fmt::format("{:.6g}", value)));
      lines.push_back({{"label", curve.name}, {"values", std::move(values)}});
    }
    groups.push_back({{"name", group.name},
                      {"unit", group.unit},
                      {"logarithmic", group.isLogarithmic},
                      {"lines", std::move(lines)}});
  }
  return groups;
}

/// Metres; null where nothing lies under the bricks.
Json plateJson(const std::optional<GroundPlate>& plate) {
  if (!plate) return nullptr;
  return {{"height", plate->height},
          {"centre", {plate->centre.x(), plate->centre.y()}},
          {"half_size", plate->halfSize},
          {"visible", plate->visible},
          {"shadow", plate->shadow}};
}

PictureSettings stillSettings(const Look& look) {
  PictureSettings settings;
  settings.look = look;
  settings.size = kStillSize;
  return settings;
}

}  // namespace

Json styleJson(Theme theme, const Look& look) {
  Look themed = look;
  themed.theme = theme;
  themed.colouring = Colouring::Plain;
  const Style style = styleOf(themed);
  themed.colouring = Colouring::Displacement;
  return {{"background", colourJson(style.background)},
          {"brick", coloursJson(style.brick)},
          {"edge", colourJson(style.edge)},
          {"ground", colourJson(style.ground)},
          {"scenery", colourJson(style.scenery)},
          {"shadow", colourJson(style.shadow)},
          {"mark", colourJson(style.mark)},
          {"overlay", colourJson(style.overlay)},
          {"edge_width", look.outlines ? Style().edgeWidth : 0},
          {"thinnest_edge", look.outlines ? kThinnestEdge : 0},
          {"most_outline_share", kMaxOutlineShare},
          {"mark_size", style.markSize},
          {"mark_lift", kDotLift},
          {"overlay_width", style.overlayWidth},
          {"thinnest_overlay", kThinnestOverlay},
          {"lights", lightsJson(style)},
          {"measure_lights", lightsJson(styleOf(themed))}};
}

Json mapJson(ColourMap map) {
  Json shades = Json::array();
  for (int k = 0; k < kShades; ++k) {
    shades.push_back(coloursJson(evenShades(mapColour(map, k / (kShades - 1.0)))));
  }
  return shades;
}

Json runJson(const TrajectoryReader& run, const Look& look, const PageStates& states) {
  const Subject& subject = run.subject();
  const Motif motif = motifOf(run, stillSettings(look));
  const Stage stage(look, motif, kStillSize);
  Json statesOfPage = statesJson(run, motif, states);
  Json curves = curvesJson(curvesAt(curvesOf(run), statesOfPage["times"]));
  return {{"name", subject.model.name},
          {"bricks", bricksJson(subject.bricks)},
          {"states", std::move(statesOfPage)},
          {"joints", joinsJson(motif.pivots)},
          {"target", motif.target ? polygonsJson(*motif.target) : Json(nullptr)},
          {"obstacles", polygonsJson(motif.obstacles)},
          {"plate", plateJson(stage.style().plate)},
          {"views", camerasJson(look, motif)},
          {"curves", std::move(curves)}};
}

std::string stillPicture(const TrajectoryReader& run, const Look& look) {
  const PictureSettings settings = stillSettings(look);
  const MotionCurve motion = motionOf(run);
  Studio studio(kStillSize, look, motifOf(run, settings));
  Replay replay(run);
  std::vector<GridPicture> pictures;
  for (const double share : kStillShares) {
    const Sample sample = replay.at(motion.timeAt(share));
    pictures.push_back(
        {studio.take({sample.time, sample.poses, {}, share}), fmt::format("{:.0f}%", 100 * share)});
  }
  GridStyle style;
  style.background = studio.stage().style().background;
  style.text = studio.stage().style().text;
  return pngBytes(composeGrid(pictures, {1, static_cast<int>(pictures.size())}, style));
}

}  // namespace kirireel
