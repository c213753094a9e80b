// Checks of a timeline against its model, in the numbers of the model's file, and the change to the
// model's own numbers. The order matters: checking needs the file's numbers for its messages, and
// everything after it the model's.
#include "sim/scene/timeline.h"

#include <array>

#include <fmt/format.h>

#include "sim/scene/tile_numbers.h"

namespace kirireel {
namespace {

void requireTiles(const std::vector<int>& tiles, const Model& model, const FileLocation& where) {
  for (const int tile : tiles) tileOfModel(tile, model, where);
}

// The tile must have been checked before: its vertices are counted here.
void requireVertex(const timeline::Drag& drag, const Model& model, const FileLocation& where) {
  // The centre of mass of any brick can be dragged.
  if (!drag.vertex) return;
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles[drag.tile - first].vertices.size());
  if (*drag.vertex >= first && *drag.vertex < end) return;
  throw inputErrorAt(where, fmt::format("tile {} has vertices {}-{}, not {}; correct this number",
                                        drag.tile, first, end - 1, *drag.vertex));
}

// Only these three actions name tiles.
void check(const TimelineEntry& entry, const Model& model) {
  if (const auto* pin = std::get_if<timeline::Pin>(&entry.action)) {
    requireTiles(pin->tiles, model, entry.where);
  } else if (const auto* unpin = std::get_if<timeline::Unpin>(&entry.action)) {
    requireTiles(unpin->tiles, model, entry.where);
  } else if (const auto* drag = std::get_if<timeline::Drag>(&entry.action)) {
    tileOfModel(drag->tile, model, entry.where);
    requireVertex(*drag, model, entry.where);
  }
}

// Whether an entry waits for, or goes to, the target that the model has.
bool needsTarget(const TimelineEntry& entry) {
  const Occasion::Kind kind = entry.when.kind;
  const auto* goTo = std::get_if<timeline::GoTo>(&entry.action);
  return kind == Occasion::Kind::AtTarget || kind == Occasion::Kind::ErrorBelow ||
         kind == Occasion::Kind::ProgressAbove || (goTo && goTo->file.empty());
}

}  // namespace

std::string actionName(const timeline::Action& action) {
  static const std::array<const char*, std::variant_size_v<timeline::Action>> kNames = {
      "pin", "unpin", "drag", "forces", "pause", "target", "snapshot", "export", "reset", "quit"};
  // In the order of timeline::Action.
  return kNames[action.index()];
}

// Throws InputError at the first entry that makes no sense. Entries are looked at in their order,
// because one may set the target that a later one waits for.
void checkTimeline(const Timeline& timeline, const Model& model) {
  bool hasTarget = model.target.has_value();
  for (const TimelineEntry& entry : timeline) {
    check(entry, model);
    if (needsTarget(entry) && !hasTarget) {
      throw inputErrorAt(entry.where,
                         "this waits for a target, but there is none; add target.txt to the model "
                         "or name one with --target");
    }
    // From this entry on there is a target to wait for.
    hasTarget = hasTarget || std::holds_alternative<timeline::GoTo>(entry.action);
  }
}

// To be called once, after checkTimeline(): a second call would count from the wrong number.
void numberAsModel(Timeline& timeline, const Model& model) {
  const int first = model.fileOrder.countsFrom;
  for (TimelineEntry& entry : timeline) {
    if (auto* pin = std::get_if<timeline::Pin>(&entry.action)) {
      for (int& tile : pin->tiles) tile -= first;
    } else if (auto* unpin = std::get_if<timeline::Unpin>(&entry.action)) {
      for (int& tile : unpin->tiles) tile -= first;
    } else if (auto* drag = std::get_if<timeline::Drag>(&entry.action)) {
      const Corner corner =
          model.fileOrder.toModel({drag->tile, drag->vertex.value_or(first)}, model.tiles);
      drag->tile = corner.tile;
      // Of a tile that was turned round, the file's vertex has another number in the model.
      if (drag->vertex) drag->vertex = corner.vertex;
    }
  }
}

}  // namespace kirireel
