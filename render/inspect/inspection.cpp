// Tells what a model is without running it. For each state (start, target): the largest gap of
// joints, how uneven tiles are, whether they are convex, which overlap, and how many ways the
// linkage can move (sim/measure/mobility.h: the nullity of the joint equations, by singular
// values). For a target: how much lengths within tiles change, the bound below which no rigid tiles
// can come, and the least error with closed joints that a search of ten seconds finds.
//
// The same facts are printed as text for people and as JSON for programs. In the text tiles count
// as in the model's file; in JSON from 0, and "file_counts_from" tells the difference.
#include "render/inspect/inspection.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/deploy/assembled_state.h"
#include "sim/measure/measures.h"
#include "sim/model/mending.h"

namespace kirireel {
namespace {

using Json = nlohmann::ordered_json;

// Overlap that is told, as a part of a tile.
constexpr double kOverlap = 1e-6;
// Flat states are flat to this part of the model's size.
constexpr double kFlat = 1e-9;
// What looking for the state nearest to the target may cost, seconds of a reference core.
constexpr double kSearchTime = 10;

/// A pivot is told by the face that it lies on.
std::string kindOf(const Joint& joint) {
  if (joint.kind == JointKind::Link) return "link";
  if (joint.kind == JointKind::Fixed) return "fixed";
  if (joint.face == JointFace::Both) return "both";
  return joint.face == JointFace::Top ? "top" : "bottom";
}

/// `tiles` are the start or the target, in the model's order.
StateInspection inspectState(const Scene& scene, const std::vector<Tile>& tiles) {
  const Model& model = scene.model;
  StateInspection state;
  state.jointGap = largestJointGap(model.joints, tiles);
  state.unevenness = largestUnevenness(tiles);
  state.leastCornerSine = leastCornerSine(tiles);
  // Overlaps below a millionth of a tile are rounding of coordinates.
  state.overlaps = tileOverlaps(tiles, kOverlap * tileSize(model));
  state.seesAllPairs = static_cast<long>(state.overlaps.size()) < mostPairs(tiles.size());
  // Freedoms in the plane mean something for flat states alone.
  if (liesFlat(tiles, kFlat * modelSize(model))) {
    state.inPlane = mobility(model, tiles, Freedom::Plane, scene.brick.thickness);
  }
  state.inSpace = mobility(model, tiles, Freedom::Space, scene.brick.thickness);
  return state;
}

/// The two singular values beside the gap between them let a reader judge the count: it is sure
/// where they differ by orders of magnitude.
std::string mobilityText(const char* where, const Mobility& mobility) {
  if (!mobility.isCounted) {
    return fmt::format("  {}: degrees of freedom not counted, {} unknowns are too many\n", where,
                       mobility.unknowns);
  }
  return fmt::format(
      "  {}: {} degree{} of freedom beyond rigid motion; {} of {} joint equations are redundant "
      "(singular values: least kept {:.2g}, largest dropped {:.2g})\n",
      where, mobility.freedoms, mobility.freedoms == 1 ? "" : "s", mobility.redundant,
      mobility.equations, mobility.leastKept, mobility.largestDropped);
}

/// One line for the state, then its overlaps and its freedoms, indented.
std::string stateText(const char* name, const StateInspection& state, int countsFrom) {
  std::string text = fmt::format(
      "{}: joints open by {:.3g} m at most, tiles flat to {:.3g} m, {}, {}{} overlapping pairs\n",
      name, state.jointGap, state.unevenness, state.leastCornerSine > 0 ? "convex" : "not convex",
      state.seesAllPairs ? "" : "at least ", state.overlaps.size());
  // The five deepest; there may be thousands.
  for (std::size_t k = 0; k < std::min<std::size_t>(state.overlaps.size(), 5); ++k) {
    const TileOverlap& overlap = state.overlaps[k];
    text += fmt::format("  tiles {} and {} overlap by {:.3g} m\n", countsFrom + overlap.tileA,
                        countsFrom + overlap.tileB, overlap.depth);
  }
  if (state.inPlane) text += mobilityText("in the plane", *state.inPlane);
  return text + mobilityText("in space", state.inSpace);
}

/// Null degrees of freedom where the unknowns are too many to count them.
Json mobilityJson(const Mobility& mobility) {
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
          {"least_singular_value_kept", mobility.leastKept},
          {"largest_singular_value_dropped", mobility.largestDropped}};
}

/// "plane" is null for states that are not flat.
Json stateJson(const StateInspection& state) {
  Json overlaps = Json::array();
  for (const TileOverlap& overlap : state.overlaps) {
    overlaps.push_back({{"tiles", {overlap.tileA, overlap.tileB}}, {"depth", overlap.depth}});
  }
  Json json = {{"joint_gap_max", state.jointGap},
               {"unevenness_max", state.unevenness},
               {"corner_sine_min", state.leastCornerSine},
               {"overlaps", overlaps}};
  json["mobility"]["plane"] = state.inPlane ? mobilityJson(*state.inPlane) : Json();
  json["mobility"]["space"] = mobilityJson(state.inSpace);
  return json;
}

Json needJson(const Need& need) {
  return {{"on", need.on}, {"reason", need.reason}};
}

std::string needText(const char* name, const Need& need) {
  return fmt::format("{} {} ({})", name, need.on ? "on" : "off", need.reason);
}

/// "12 with 3 vertices, 4 with 4".
template <typename Map>
/// `pattern` has a place for the count and one for the key.
std::string countsText(const Map& counts, const char* pattern) {
  std::string text;
  for (const auto& [key, count] : counts) {
    if (!text.empty()) text += ", ";
    text += fmt::format(fmt::runtime(pattern), count, key);
  }
  return text.empty() ? "none" : text;
}

}  // namespace

Inspection inspect(const Scene& scene, const std::function<void(const char*)>& tell) {
  const auto lookAt = [&tell](const char* what) {
    if (tell) tell(what);
  };
  const Model& model = scene.model;
  Inspection inspection;
  inspection.name = model.name;
  for (const Tile& tile : model.tiles) {
    ++inspection.tilesByVertices[static_cast<int>(tile.vertices.size())];
  }
  for (const Joint& joint : model.joints) ++inspection.jointsByKind[kindOf(joint)];
  inspection.size = modelSize(model);
  inspection.tileSize = tileSize(model);
  inspection.suggestedThickness = kUsualThickness * inspection.tileSize;
  inspection.countsFrom = model.fileOrder.countsFrom;
  inspection.rounding = model.rounding;
  inspection.zeroSingularValue = zeroSingularValue(model);
  for (const Mend& mend : model.mends) inspection.mends.push_back(toString(mend));
  lookAt("looking at the start");
  inspection.start = inspectState(scene, model.tiles);
  inspection.needs = sceneNeeds(scene);
  if (!model.target) return inspection;
  lookAt("looking at the target");
  inspection.target = inspectState(scene, *model.target);
  inspection.shapeChange = largestShapeChange(model.tiles, *model.target);
  inspection.rigidBound = rigidBound(model.tiles, *model.target);
  lookAt("looking for the state nearest to the target");
  // The search is bounded in work and not in time, so that the result does not depend on the
  // machine.
  SearchBudget budget(kSearchTime);
  inspection.assembledError = assembleAtTarget(scene, budget).error;
  return inspection;
}

std::string inspectionText(const Inspection& inspection) {
  std::string text = fmt::format(
      "{}\ntiles: {}\njoints: {}\nsize: {:.4g} m, tiles {:.4g} m; suggested thickness {:.2g} m\n",
      inspection.name, countsText(inspection.tilesByVertices, "{} with {} vertices"),
      countsText(inspection.jointsByKind, "{} {}"), inspection.size, inspection.tileSize,
      inspection.suggestedThickness);
  if (inspection.rounding > 0) {
    text +=
        fmt::format("coordinates are rounded to {:g} m: singular values below {:.2g} are zero\n",
                    inspection.rounding, inspection.zeroSingularValue);
  }
  for (const std::string& mend : inspection.mends) text += mend + "\n";
  text += stateText("start", inspection.start, inspection.countsFrom);
  if (inspection.target) {
    text += stateText("target", *inspection.target, inspection.countsFrom);
    text += fmt::format(
        "congruence: lengths change by {:.3g} m at most; rigid bound {:.3g} m, "
        "assembled error {:.3g} m\n",
        *inspection.shapeChange, *inspection.rigidBound, *inspection.assembledError);
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
  json["size"] = inspection.size;
  json["tile_size"] = inspection.tileSize;
  json["suggested_thickness"] = inspection.suggestedThickness;
  json["rounding"] = inspection.rounding;
  json["file_counts_from"] = inspection.countsFrom;
  json["mended"] = inspection.mends;
  json["start"] = stateJson(inspection.start);
  json["target"] = inspection.target ? stateJson(*inspection.target) : Json();
  json["shape_change_max"] = inspection.shapeChange ? Json(*inspection.shapeChange) : Json();
  json["rigid_bound"] = inspection.rigidBound ? Json(*inspection.rigidBound) : Json();
  json["assembled_error"] = inspection.assembledError ? Json(*inspection.assembledError) : Json();
  json["needs"] = {{"planar", needJson(inspection.needs.planar)},
                   {"contacts", needJson(inspection.needs.contacts)},
                   {"ground", needJson(inspection.needs.ground)}};
  // A folder's name may hold bytes that are not UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kirireel
