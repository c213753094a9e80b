/// The timeline: what happens to a running deployment, and when. The headless form of pinning and
/// dragging tiles by hand.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/base/error.h"
#include "sim/model/model.h"

namespace kirireel {

/// When an entry of a timeline comes due. Entries happen in their order: each waits until all
/// before it have happened.
struct Occasion {
  enum class Kind {
    AtTime,         ///< at `value` simulated seconds
    After,          ///< `value` simulated seconds after the entry before (the start for the first)
    AtRest,         ///< once nothing moves any more
    AtTarget,       ///< once at rest at the present target (or what rigid tiles can reach of it)
    ErrorBelow,     ///< once the error to the present target is below `value` metres
    ProgressAbove,  ///< once the error to the present target has shrunk by this share of what it
                    ///< was when that target was set, 0 to 1
  };
  Kind kind = Kind::After;
  double value = 0;
};

/// What a timeline does, one struct an action.
namespace timeline {

/// Fixes tiles to the world where they are.
struct Pin {
  std::vector<int> tiles;
};

/// Frees pinned tiles.
struct Unpin {
  std::vector<int> tiles;  ///< all that are pinned when empty
};

/// Pulls a tile along a path by a damped spring, then lets go.
struct Drag {
  int tile = 0;
  std::optional<int> vertex;  ///< of the tile's bottom, where the spring is tied; absent: the
                              ///< brick's centre of mass
  std::vector<Vector3> path;  ///< at least one point, world axes; from where the tile is, at even
                              ///< speed
  double seconds = 1;         ///< that the path takes, positive
  double stiffness = 1000;    ///< N/m, from 0
  double damping = 50;        ///< N s/m, from 0
};

/// Switches the actuation.
struct Forces {
  bool on = true;
};

/// Holds all tiles still; their speeds come back afterwards. Pins may change meanwhile.
struct Pause {
  double seconds = 1;  ///< positive
};

/// Heads for another target.
struct GoTo {
  std::filesystem::path file;  ///< in the format of target.txt; empty: the model's own target
  std::vector<Tile> tiles;     ///< what the file holds, once it has been read
};

/// A picture of this moment.
struct Snapshot {};

/// Meshes of this moment.
struct Export {};

/// Back to the start, at rest, nothing pinned.
struct Reset {};

/// Ends the run.
struct Quit {};

using Action = std::variant<Pin, Unpin, Drag, Forces, Pause, GoTo, Snapshot, Export, Reset, Quit>;

}  // namespace timeline

/// One thing that happens.
struct TimelineEntry {
  Occasion when;
  timeline::Action action;
  FileLocation where;  ///< in the scene file, for messages
};

/// All that happens, in order.
using Timeline = std::vector<TimelineEntry>;

/// "pin", "unpin", "drag", "forces", "pause", "target", "snapshot", "export", "reset", "quit".
std::string actionName(const timeline::Action& action);

/// Throws InputError where the timeline, in the numbers of the model's file, does not fit the
/// model: tiles or vertices that do not exist, a target without one.
void checkTimeline(const Timeline& timeline, const Model& model);

/// Turns numbers of tiles and vertices, as the model's file has them, into the model's own, which
/// everything else goes by.
void numberAsModel(Timeline& timeline, const Model& model);

}  // namespace kirireel
