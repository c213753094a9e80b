// Describes a model without running it. For each state (start, target): the largest gap of joints,
// the non-planarity and convexity of tiles, overlaps, and the degrees of freedom of the linkage
// (sim/trajectory/sheet.h: the nullity of the joint equations, by singular values). For a target:
// the change of lengths within tiles, a lower bound of the error of rigid tiles, and the least
// error with closed joints found in a search of ten seconds.
//
// The results are printed as text for users and as JSON for programs. Tile numbers in the text are
// those of the model's file. In JSON they are zero-based, and "file_counts_from" has the
// difference.
#include "render/report/inspection.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "render/picture/grid.h"
#include "render/picture/label.h"
#include "render/picture/painter.h"
#include "sim/base/files.h"
#include "sim/base/words.h"
#include "sim/formats/repairs.h"
#include "sim/model/convex_parts.h"
#include "sim/model/isometry.h"
#include "sim/model/sheet_frame.h"
#include "sim/run/assembled_state.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel::report {
namespace {

// Minimum reported overlap, as a fraction of a tile.
constexpr double kOverlap = 1e-6;

/// A pivot is described by its face.
std::string kindOf(const model::Joint& joint) {
  if (joint.kind != model::JointKind::Pivot) return model::kindName(joint);
  if (joint.face == model::JointFace::Both) return "both";
  return joint.face == model::JointFace::Top ? "top" : "bottom";
}

/// `tiles` are the start or the target, in the model's order.
StateInspection inspectState(const scene::Scene& scene, const std::vector<model::Tile>& tiles) {
  const model::Model& model = scene.model;
  StateInspection state;
  state.jointGap = model::largestJointGap(model.joints, tiles);
  state.unevenness = trajectory::largestUnevenness(tiles);
  state.smallestCornerSine = trajectory::smallestCornerSine(tiles);
  // Overlaps below a millionth of a tile are rounding of coordinates.
  state.overlaps = trajectory::tileOverlaps(tiles, kOverlap * model::tileSize(model));
  state.seesAllPairs =
      static_cast<long>(state.overlaps.size()) < trajectory::maxPairs(tiles.size());
  // Planar degrees of freedom exist only for flat states.
  if (model::sheetFrame(tiles, model::flatTolerance(model))) {
    state.inPlane =
        trajectory::mobility(model, tiles, trajectory::Freedom::Plane, scene.brick.thickness);
  }
  state.inSpace =
      trajectory::mobility(model, tiles, trajectory::Freedom::Space, scene.brick.thickness);
  return state;
}

/// Reports the two singular values on both sides of the gap, so the reader can evaluate the count.
/// It is certain if they differ by orders of magnitude.
std::string mobilityText(const char* where, const trajectory::Mobility& mobility) {
  if (!mobility.isCounted) {
    return fmt::format("  {}: degrees of freedom not counted, {} unknowns are too many\n", where,
                       mobility.unknowns);
  }
  const bool hasMisfit = !mobility.areBounds && mobility.largestDropped > model::kClosedShare;
  return fmt::format(
      "  {}: {} of freedom beyond rigid motion; {} of {} joint equations are redundant "
      "({}: least kept {}{:.2g}, largest dropped {}{:.2g}{})\n",
      where, counted(mobility.freedoms, "degree"), mobility.redundant, mobility.equations,
      mobility.areBounds ? "bounds of singular values" : "singular values",
      mobility.areBounds ? ">= " : "", mobility.smallestKept, mobility.areBounds ? "<= " : "",
      mobility.largestDropped, hasMisfit ? ": the misfit of its tiles, in tiles" : "");
}

/// One line for the state, followed by its overlaps and degrees of freedom, indented.
std::string stateText(const char* name, const StateInspection& state, int countsFrom,
                      const LengthUnit& unit) {
  std::string text =
      fmt::format("{}: joints open by {} at most, tiles flat to {}, {}, {}{} overlapping pairs\n",
                  name, lengthText(state.jointGap, unit), lengthText(state.unevenness, unit),
                  state.smallestCornerSine > 0 ? "convex" : "not convex",
                  state.seesAllPairs ? "" : "at least ", state.overlaps.size());
  // Only the five deepest of possibly thousands.
  for (std::size_t k = 0; k < std::min<std::size_t>(state.overlaps.size(), 5); ++k) {
    const trajectory::TileOverlap& overlap = state.overlaps[k];
    text += fmt::format("  tiles {} and {} overlap by {}\n", countsFrom + overlap.tileA,
                        countsFrom + overlap.tileB, lengthText(overlap.depth, unit));
  }
  if (state.inPlane) text += mobilityText("in the plane", *state.inPlane);
  return text + mobilityText("in space", state.inSpace);
}

/// Null degrees of freedom if there are too many unknowns to count them.
Json mobilityJson(const trajectory::Mobility& mobility) {
  if (!mobility.isCounted) {
    return {{"degrees_of_freedom", nullptr},
            {"unknowns", mobility.unknowns},
            {"equations", mobility.equations}};
  }
  return {{"degrees_of_freedom", mobility.freedoms},
          {"unknowns", mobility.unknowns},
          {"equations", mobility.equations},
          {"rank", mobility.rank},
          {"redundant", mobility.redundant},
          {"least_singular_value_kept", mobility.smallestKept},
          {"largest_singular_value_dropped", mobility.largestDropped},
          {"singular_values_are_bounds", mobility.areBounds}};
}

/// "plane" is null for states that are not flat.
Json stateJson(const StateInspection& state) {
  Json overlaps = Json::array();
  for (const trajectory::TileOverlap& overlap : state.overlaps) {
    overlaps.push_back({{"tiles", {overlap.tileA, overlap.tileB}}, {"depth", overlap.depth}});
  }
  Json json = {{"joint_gap_max", state.jointGap},
               {"unevenness_max", state.unevenness},
               {"corner_sine_min", state.smallestCornerSine},
               {"overlaps", overlaps}};
  json["mobility"]["plane"] = state.inPlane ? mobilityJson(*state.inPlane) : Json();
  json["mobility"]["space"] = mobilityJson(state.inSpace);
  return json;
}

NeckInspection inspectNecks(const model::Model& model) {
  NeckInspection necks;
  for (const model::Joint& joint : model.joints) {
    if (!joint.neck) continue;
    if (necks.count++ == 0) necks.least = necks.most = joint.neck;
    for (double model::Neck::*length :
         {&model::Neck::width, &model::Neck::length, &model::Neck::kerf}) {
      necks.least.*length = std::min(necks.least.*length, joint.neck.*length);
      necks.most.*length = std::max(necks.most.*length, joint.neck.*length);
    }
  }
  return necks;
}

/// "necks: 24, 1.05 to 1.06 mm wide, 0.3 mm long, kerf 0.3 mm".
std::string necksText(const NeckInspection& necks, const LengthUnit& unit) {
  const auto range = [&](double model::Neck::*length) {
    const std::string least = lengthText(necks.least.*length, unit);
    const std::string most = lengthText(necks.most.*length, unit);
    return least == most ? least : fmt::format("{} to {}", least, most);
  };
  return fmt::format("necks: {}, {} wide, {} long, kerf {}\n", necks.count,
                     range(&model::Neck::width), range(&model::Neck::length),
                     range(&model::Neck::kerf));
}

/// Null without necks.
Json necksJson(const NeckInspection& necks) {
  if (necks.count == 0) return {};
  const auto range = [&](double model::Neck::*length) {
    return Json::array({necks.least.*length, necks.most.*length});
  };
  return {{"count", necks.count},
          {"width", range(&model::Neck::width)},
          {"length", range(&model::Neck::length)},
          {"kerf", range(&model::Neck::kerf)}};
}

/// "0-3,7" from ascending zero-based numbers, in the syntax of --tile-colour.
std::string tilesText(const std::vector<int>& tiles, int countsFrom) {
  std::string text;
  for (std::size_t k = 0, end = 0; k < tiles.size(); k = end) {
    for (end = k + 1; end < tiles.size() && tiles[end] == tiles[end - 1] + 1;) ++end;
    if (k > 0) text += ',';
    text += fmt::format("{}", countsFrom + tiles[k]);
    if (end > k + 1) text += fmt::format("-{}", countsFrom + tiles[end - 1]);
  }
  return text;
}

/// "12 with 3 vertices, 4 with 4". `pattern` has one placeholder for the count and one for the key.
template <typename Map>
std::string countsText(const Map& counts, const char* pattern) {
  std::string text;
  for (const auto& [key, count] : counts) {
    if (!text.empty()) text += ", ";
    text += fmt::format(fmt::runtime(pattern), count, key);
  }
  return text.empty() ? "none" : text;
}

}  // namespace

Inspection inspect(const scene::Scene& scene, const std::function<void(const char*)>& progress) {
  const auto beginStage = [&progress](const char* what) {
    if (progress) progress(what);
  };
  const model::Model& model = scene.model;
  Inspection inspection;
  inspection.name = model.name;
  inspection.unit = model.unit;
  for (const model::Tile& tile : model.tiles) {
    ++inspection.tilesByVertices[static_cast<int>(tile.vertices.size())];
  }
  for (const model::Joint& joint : model.joints) ++inspection.jointsByKind[kindOf(joint)];
  for (const int piece : model::piecesOf(model)) {
    inspection.pieces.resize(std::max(inspection.pieces.size(), std::size_t(piece) + 1));
    ++inspection.pieces[piece];
  }
  inspection.necks = inspectNecks(model);
  for (std::size_t tile = 0; tile < model.tileNames.size(); ++tile) {
    const std::string& name = model.tileNames[tile];
    if (!name.empty()) inspection.tilesByName[name].push_back(static_cast<int>(tile));
  }
  inspection.size = model::modelSize(model);
  inspection.tileSize = model::tileSize(model);
  inspection.suggestedThickness = brick::kDefaultThickness * inspection.tileSize;
  inspection.countsFrom = model.fileOrder.countsFrom;
  inspection.rounding = model.rounding;
  inspection.zeroSingularValue = trajectory::zeroSingularValue(model);
  for (const model::Repair& repair : model.repairs)
    inspection.repairs.push_back(formats::toString(repair));
  beginStage("checking the start");
  inspection.start = inspectState(scene, model.tiles);
  inspection.needs = scene::sceneNeeds(scene);
  if (!model.target) return inspection;
  beginStage("checking the target");
  inspection.target = inspectState(scene, *model.target);
  inspection.shapeChange = trajectory::largestShapeChange(model.tiles, *model.target);
  inspection.rigidBound = trajectory::rigidBound(model.tiles, *model.target);
  beginStage("searching the state nearest to the target");
  const std::optional<model::SheetFrame> frame = scene::ownAxes(scene);
  inspection.assembledError =
      run::assembleAtTarget(frame ? scene::inAxes(*frame, scene) : scene).error;
  return inspection;
}

std::string needText(const char* name, const scene::Need& need) {
  return fmt::format("{} {} ({})", name, need.on ? "on" : "off", need.reason);
}

std::string inspectionText(const Inspection& inspection) {
  const LengthUnit& unit = inspection.unit;
  std::string text = fmt::format(
      "{}\ntiles: {}\njoints: {}\nsize: {}, tiles {}; suggested thickness {}\n", inspection.name,
      countsText(inspection.tilesByVertices, "{} with {} vertices"),
      countsText(inspection.jointsByKind, "{} {}"), lengthText(inspection.size, unit, 4),
      lengthText(inspection.tileSize, unit, 4), lengthText(inspection.suggestedThickness, unit, 2));
  if (inspection.pieces.size() > 1) {
    std::map<int, int, std::greater<>> bySize;
    for (const int tiles : inspection.pieces) ++bySize[tiles];
    text += fmt::format("pieces: {}, {}\n", inspection.pieces.size(),
                        countsText(bySize, "{} of {} tiles"));
  }
  if (inspection.necks.count > 0) text += necksText(inspection.necks, unit);
  if (inspection.rounding > 0) {
    text += fmt::format("tiles fit each other only to {}: singular values below {:.2g} are zero\n",
                        lengthText(inspection.rounding, unit, 1), inspection.zeroSingularValue);
  }
  for (const auto& [name, tiles] : inspection.tilesByName) {
    text += fmt::format("name {}: tiles {}\n", shown(name, 60),
                        tilesText(tiles, inspection.countsFrom));
  }
  for (const std::string& repair : inspection.repairs) text += repair + "\n";
  text += stateText("start", inspection.start, inspection.countsFrom, unit);
  if (inspection.target) {
    text += stateText("target", *inspection.target, inspection.countsFrom, unit);
    text += fmt::format(
        "congruence: lengths change by {} at most; rigid bound {}, assembled error {}\n",
        lengthText(*inspection.shapeChange, unit), lengthText(*inspection.rigidBound, unit),
        lengthText(*inspection.assembledError, unit));
  } else {
    text += "target: none\n";
  }
  return text + fmt::format("a run: {}; {}; {}\n", needText("planar", inspection.needs.planar),
                            needText("contacts", inspection.needs.contacts),
                            needText("ground", inspection.needs.ground));
}

std::string inspectionJson(const Inspection& inspection) {
  Json json;
  json["name"] = inspection.name;
  for (const auto& [vertices, count] : inspection.tilesByVertices) {
    json["tiles"][fmt::format("{}", vertices)] = count;
  }
  json["joints"] = Json(inspection.jointsByKind);
  json["pieces"] = inspection.pieces;
  json["necks"] = necksJson(inspection.necks);
  json["names"] = Json(inspection.tilesByName);
  json["size"] = inspection.size;
  json["tile_size"] = inspection.tileSize;
  json["suggested_thickness"] = inspection.suggestedThickness;
  json["rounding"] = inspection.rounding;
  json["file_counts_from"] = inspection.countsFrom;
  json["repaired"] = inspection.repairs;
  json["start"] = stateJson(inspection.start);
  json["target"] = inspection.target ? stateJson(*inspection.target) : Json();
  json["shape_change_max"] = inspection.shapeChange ? Json(*inspection.shapeChange) : Json();
  json["rigid_bound"] = inspection.rigidBound ? Json(*inspection.rigidBound) : Json();
  json["assembled_error"] = inspection.assembledError ? Json(*inspection.assembledError) : Json();
  json["needs"] = {{"planar", fieldsJson<Json>(inspection.needs.planar)},
                   {"contacts", fieldsJson<Json>(inspection.needs.contacts)},
                   {"ground", fieldsJson<Json>(inspection.needs.ground)}};
  return jsonText(json, 2) + "\n";
}

// ------------------------------------------------------------------------------------------------
// The painter draws the bricks. Numbers are then drawn over the pixels at the projected middles and
// corners. A number is left out if another tile hides its position. Its size depends on the tile's.
// With s the side of a square of equal pixel area, tiles' numbers are 0.28 s high (7 to 40 pixels),
// corners' 0.14 s (6 to 20). Corners of tiles below 40 pixels have no numbers.
//
// A corner's number is moved into its tile by 22%, which separates the numbers of tiles with a
// common corner.

namespace {

constexpr picture::Colour kTileNumber = {20, 30, 44};
constexpr picture::Colour kVertexNumber = {150, 30, 30};
constexpr picture::Colour kIgnoredLine = {30, 90, 200};

/// A point in the tile for its number: its centroid. The centroid of a concave tile may lie
/// outside, so its largest part is used.
Vector3 middleOf(const model::Tile& tile) {
  model::Tile largest;
  for (const model::PolygonPart& part :
       model::convexParts(tile.vertices, model::tileNormal(tile))) {
    model::Tile piece;
    for (const int corner : part) piece.vertices.push_back(tile.vertices[corner]);
    if (largest.vertices.empty() || model::tileArea(piece) > model::tileArea(largest))
      largest = piece;
  }
  return model::tileCentroid(largest);
}

/// The middle of a convex part with this vertex: the direction into the tile.
Vector3 middleBy(const model::Tile& tile, int vertex) {
  for (const model::PolygonPart& part :
       model::convexParts(tile.vertices, model::tileNormal(tile))) {
    if (std::find(part.begin(), part.end(), vertex) == part.end()) continue;
    model::Tile piece;
    for (const int corner : part) piece.vertices.push_back(tile.vertices[corner]);
    return model::tileCentroid(piece);
  }
  return model::tileCentroid(tile);
}

/// A line as a loop at a height. An open line is traversed forwards and backwards.
model::Tile loopOf(const formats::DrawnPath& path, double height) {
  model::Tile loop;
  for (const formats::Vector2& point : path.points) {
    loop.vertices.emplace_back(point.x(), point.y(), height);
  }
  if (path.isClosed) return loop;
  for (auto k = std::ssize(path.points) - 2; k > 0; --k) {
    loop.vertices.push_back(loop.vertices[static_cast<std::size_t>(k)]);
  }
  return loop;
}

/// In parallel projection, equal tiles have numbers of equal size.
picture::Camera parallelCamera(const std::vector<model::Tile>& tiles, picture::FrameSize size) {
  const std::vector<Vector3> points = model::allVertices(tiles);
  picture::CameraFit fit;
  fit.view = picture::defaultView(points);
  fit.aspect = size.aspect();
  fit.orthographic = true;
  return picture::fitCamera(points, fit);
}

/// Lines and dots without a sheet.
picture::Frame linePicture(std::vector<model::Tile> lines, std::vector<Vector3> dots,
                           picture::FrameSize size) {
  const picture::Camera camera = parallelCamera(lines, size);
  picture::Style style;
  style.markSize = 0.03;
  style.overlay = style.edge;  // lines that differ from dots
  picture::PictureItems items;
  items.overlay = std::move(lines);
  items.marks = std::move(dots);
  return picture::Painter(size, {}, style).paint(items, camera);
}

/// One state: picture and numbers with the same camera.
class StatePicture {
 public:
  StatePicture(const std::vector<model::Tile>& tiles, const model::Model& model,
               const brick::BrickRule& rule, picture::FrameSize size,
               const std::optional<std::vector<formats::DrawnPath>>& ignored = {})
      : tiles_(tiles), order_(model.fileOrder), size_(size), camera_(parallelCamera(tiles, size)) {
    const std::vector<brick::Brick> bricks = brick::makeBricks(tiles, rule);
    picture::PictureItems items;
    items.poses = brick::startPoses(tiles, bricks);
    for (const model::Repair& repair : model.repairs) {
      for (const model::Corner& corner : repair.corners) {
        items.marks.push_back(tiles[corner.tile].vertices[corner.vertex]);
      }
    }
    if (ignored) {
      const double above = 2 * rule.thickness;  // no brick hides them
      for (const model::Joint& joint : model.joints) {
        items.marks.push_back(tiles[joint.a.tile].vertices[joint.a.vertex]);
      }
      for (const formats::DrawnPath& path : *ignored) items.overlay.push_back(loopOf(path, above));
    }
    picture::Style style;
    style.overlay = kIgnoredLine;
    frame_ = picture::Painter(size, bricks, style).paint(items, camera_);
  }

  /// Call only once: it moves the frame out.
  picture::Frame numbered() {
    const Vector3 towardsEye = (camera_.eye - camera_.centre).normalized();
    const LineOfSight sight(tiles_, towardsEye);
    for (std::size_t i = 0; i < tiles_.size(); ++i) {
      const Vector3 middle = middleOf(tiles_[i]);
      const double pixels = apparentSize(tiles_[i], towardsEye);
      if (sight.isVisible(middle, i)) {
        write(fmt::format("{}", order_.countsFrom + i), middle,
              std::clamp(0.28 * pixels, 7.0, 40.0), kTileNumber);
      }
      if (pixels < 40) continue;  // vertices' numbers would be unreadable
      for (std::size_t k = 0; k < tiles_[i].vertices.size(); ++k) {
        const Vector3& vertex = tiles_[i].vertices[k];
        const Vector3 inside = vertex + 0.22 * (middleBy(tiles_[i], static_cast<int>(k)) - vertex);
        if (!sight.isVisible(inside, i)) continue;
        // The reader may have reversed the tile's vertices; the printed number is the file's.
        const int inFile = order_.across({static_cast<int>(i), static_cast<int>(k)}, tiles_).vertex;
        write(fmt::format("{}", order_.countsFrom + inFile), inside,
              std::clamp(0.14 * pixels, 6.0, 20.0), kVertexNumber);
      }
    }
    return std::move(frame_);
  }

 private:
  /// The side of a square with the tile's pixel area. The visible area is |n . e| times the true
  /// one.
  double apparentSize(const model::Tile& tile, const Vector3& towardsEye) const {
    const double area = model::tileArea(tile) * std::abs(model::tileNormal(tile).dot(towardsEye));
    return size_.height / picture::heightAtCentre(camera_) * std::sqrt(area);
  }

  void write(const std::string& text, const Vector3& place, double pixels, picture::Colour colour) {
    const int em = static_cast<int>(pixels);
    // A writer loads a font, so there is one per size.
    const picture::LabelWriter& writer = writers_.try_emplace(em, em).first->second;
    const Eigen::Vector4d clip =
        picture::clipFromWorld(camera_, size_.aspect()) * place.homogeneous();
    // From clip coordinates, [-1, 1] with y up, to pixels with y down.
    const double x = 0.5 * (1 + clip.x() / clip.w()) * size_.width;
    const double y = 0.5 * (1 - clip.y() / clip.w()) * size_.height;
    const int width = writer.width(text);
    // Digits are about 0.7 of the em high, and 0.6 wide.
    const double height = 1.2 * width / static_cast<double>(text.size());
    writer.draw(frame_, text, picture::wholePixels(x - 0.5 * width),
                picture::wholePixels(y + 0.5 * height), colour);
  }

  const std::vector<model::Tile>& tiles_;
  const model::FileOrder& order_;  ///< numbers are the file's
  picture::FrameSize size_;
  picture::Camera camera_;
  picture::Frame frame_;
  std::map<int, picture::LabelWriter> writers_;  ///< by their size, pixels
};

}  // namespace

picture::Frame numberedPicture(const scene::Scene& scene, picture::FrameSize stateSize,
                               const std::optional<std::vector<formats::DrawnPath>>& ignored) {
  std::vector<picture::GridPicture> pictures;
  pictures.push_back(
      {StatePicture(scene.model.tiles, scene.model, scene.brick, stateSize, ignored).numbered(),
       "start"});
  if (scene.model.target) {
    pictures.push_back(
        {StatePicture(*scene.model.target, scene.model, scene.brick, stateSize).numbered(),
         "target"});
  }
  return picture::composeGrid(pictures, {1, static_cast<int>(pictures.size())});
}

picture::Frame crossingPicture(const model::Tile& tile, const Vector3& place,
                               picture::FrameSize size) {
  return linePicture({tile}, {place}, size);
}

picture::Frame faultPicture(const formats::DrawingFault& fault, picture::FrameSize size) {
  std::vector<model::Tile> lines;
  for (const formats::DrawnPath& path : fault.lines()) lines.push_back(loopOf(path, 0));
  std::vector<Vector3> dots;
  for (const formats::Vector2& place : fault.places()) dots.emplace_back(place.x(), place.y(), 0);
  return linePicture(std::move(lines), std::move(dots), size);
}

// ------------------------------------------------------------------------------------------------
// A ray from the point p in the direction e of the eye (unit vector; the eye is infinitely far)
// meets the plane of a tile with normal n and middle m at
//
//     p + t e,    t = n . (m - p) / (n . e).
//
// The tile hides p if t > 0 and the intersection lies in one of the tile's convex parts. Tiles
// farther from the ray than their radius are skipped first: |(m - p) x e| is the distance of m from
// the ray.
//
// Each query checks all tiles, so a picture of n tiles costs n^2 checks.

namespace {

// Tiles nearer than this fraction of their radius touch the point and do not hide it.
constexpr double kTouch = 1e-3;

/// Whether a point of the plane is on the left of every edge.
bool isWithin(const std::vector<Vector3>& corners, const Vector3& normal, const Vector3& point) {
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector3& from = corners[k];
    const Vector3& to = corners[(k + 1) % corners.size()];
    if ((to - from).cross(point - from).dot(normal) < 0) return false;
  }
  return true;
}

}  // namespace

LineOfSight::LineOfSight(const std::vector<model::Tile>& tiles, const Vector3& towardsEye)
    : towardsEye_(towardsEye) {
  for (const model::Tile& tile : tiles) {
    Screen& screen = screens_.emplace_back();
    screen.normal = model::tileNormal(tile);
    for (const model::PolygonPart& part : model::convexParts(tile.vertices, screen.normal)) {
      std::vector<Vector3>& corners = screen.parts.emplace_back();
      for (const int corner : part) corners.push_back(tile.vertices[corner]);
    }
    screen.middle = model::tileCentroid(tile);
    for (const Vector3& vertex : tile.vertices) {
      screen.radius = std::max(screen.radius, (vertex - screen.middle).norm());
    }
  }
}

bool LineOfSight::isVisible(const Vector3& point, std::size_t tile) const {
  for (std::size_t k = 0; k < screens_.size(); ++k) {
    if (k != tile && hides(screens_[k], point)) return false;
  }
  return true;
}

bool LineOfSight::hides(const Screen& screen, const Vector3& point) const {
  const Vector3 offset = screen.middle - point;
  if (offset.cross(towardsEye_).squaredNorm() > screen.radius * screen.radius) return false;
  const double slope = screen.normal.dot(towardsEye_);
  // A tile seen edge-on hides nothing.
  if (slope == 0) return false;
  const double distance = screen.normal.dot(offset) / slope;
  // Behind the point, or touching it, as joined tiles do.
  if (distance < kTouch * screen.radius) return false;
  const Vector3 meeting = point + distance * towardsEye_;
  return std::any_of(screen.parts.begin(), screen.parts.end(),
                     [&](const auto& part) { return isWithin(part, screen.normal, meeting); });
}

}  // namespace kirireel::report
