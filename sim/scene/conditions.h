/// Conditions of a sheet: grips, obstacles, initial velocities and the timeline.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"
#include "sim/scene/toml_file.h"

namespace kirireel::scene {

// ------------------------------------------------------------------------------------------------
// Numbers of tiles and vertices in files and scene files.

/// A whole number >= 0. Throws InputError with `allowed` in its message.
int readIndex(const TomlValue& value, const std::string& allowed);

/// One or more indices. Throws InputError with `allowed` for the list, or `allowedElement` for an
/// element.
std::vector<int> readIndices(const TomlValue& value, const std::string& allowed,
                             const std::string& allowedElement);

/// The model's own number of the tile with this number in the model's file. Throws InputError if
/// the model has no such tile.
int tileOfModel(int number, const model::Model& model, const FileLocation& where);

// ------------------------------------------------------------------------------------------------
// [[grip]] in a scene file: holds, moves or pushes parts of a sheet during loading.

/// One grip. Its displacements or forces are proportional to the load and complete at load 1.
/// Directions without a value are free.
struct GripSetting {
  std::vector<int> tiles;     ///< held tiles, at least one
  std::vector<int> vertices;  ///< of each tile: empty for the whole tile (its middle), one vertex,
                              ///< or the two of an edge; empty if each tile has its own vertex
  std::vector<model::Corner>
      corners;                 ///< these vertices in the model's numbers, see numberAsModel()
  bool isForce = false;        ///< newtons and N m of forces, else metres and radians of moves
  std::optional<double> x;     ///< fixed if 0
  std::optional<double> y;     ///< the same
  std::optional<double> z;     ///< the same, for spatial sheets
  std::optional<double> turn;  ///< anticlockwise; only for whole tiles
  Matrix3 axes = Matrix3::Identity();  ///< the directions of x, y and z, as columns
  FileLocation where;                  ///< position in the scene file, for messages
};

/// Reads the [[grip]] entries of a scene file:
///
///     tile = NUMBER or tiles = [NUMBERS], for a part: vertex = NUMBER, or [one per tile], or
///     edge = [NUMBER, NUMBER]; then one of move = {x = LENGTH, y = LENGTH, turn = DEGREES} and
///     force = {x = NEWTONS, y = NEWTONS, turn = N_M}, each optional; z like x.
///
/// Throws InputError with file:line:column for other entries.
std::vector<GripSetting> readGrips(const TomlValue& value);

/// Converts tile numbers of the model's file to the model's own, and sets the corners of the
/// vertices. Throws InputError if a grip refers to a tile or vertex that does not exist.
void numberAsModel(std::vector<GripSetting>& grips, const model::Model& model);

// ------------------------------------------------------------------------------------------------
// Fixed obstacles.

/// A fixed obstacle. Joints, forces and drags do not move it.
struct Obstacle {
  /// Shape of an obstacle.
  enum class Shape {
    Box,     ///< with six flat sides
    Sphere,  ///< round
    Mesh,    ///< a surface without thickness, with contact on both sides
  };
  Shape shape = Shape::Box;            ///< shape
  Vector3 size = Vector3::Ones();      ///< of a box, along its own axes, metres, > 0
  double radius = 1;                   ///< of a sphere, metres, > 0
  std::vector<model::Tile> mesh;       ///< flat convex faces of a mesh, in its own axes
  std::optional<LengthUnit> meshUnit;  ///< that the mesh's file declares; absent: the model's
  Pose pose;                           ///< of the middle of a box or sphere, of a mesh's axes
  double friction = 0.5;               ///< Coulomb coefficient, >= 0
};

/// The surface of an obstacle as outward anticlockwise polygons (a mesh's own polygons), world
/// axes. A sphere becomes a fine polyhedron with its corners on the sphere, for pictures.
std::vector<model::Tile> obstacleFaces(const Obstacle& obstacle);

/// The faces of all obstacles, in their order.
std::vector<model::Tile> obstacleFaces(const std::vector<Obstacle>& obstacles);

/// The lower face of an upright box at an obstacle's origin, with the obstacle's position and
/// rotation, anticlockwise seen from within. Thickening it by size.z gives the box.
model::Tile boxFloor(const Obstacle& obstacle, const Vector3& size);

// ------------------------------------------------------------------------------------------------
// Velocities of tiles at the start.

/// Initial velocity of tiles as one rigid body. Joints remove components that they prevent.
struct InitialVelocity {
  std::vector<int> tiles;             ///< empty: all
  Vector3 linear = Vector3::Zero();   ///< of their common centre of mass, m/s
  Vector3 angular = Vector3::Zero();  ///< about the centre of mass, world axes, rad/s
  FileLocation where;                 ///< of the table in the scene file
};

/// Converts tile numbers of the model's file to the model's own. Throws InputError for a tile that
/// does not exist.
void numberAsModel(std::vector<InitialVelocity>& velocities, const model::Model& model);

/// The velocity of each brick at these poses; several velocities of a brick are added.
std::vector<Velocity> initialVelocities(const std::vector<InitialVelocity>& given,
                                        const std::vector<brick::Brick>& bricks,
                                        const Poses& poses);

// ------------------------------------------------------------------------------------------------
// The timeline: timed actions during a deployment. It replaces pinning and dragging tiles by hand.

/// Condition for an entry of a timeline. Entries happen in their order: each waits for all previous
/// entries.
struct Trigger {
  /// Condition to wait for.
  enum class Kind {
    AtTime,         ///< at `value` simulated seconds
    After,          ///< `value` simulated seconds after the previous entry (first entry: the start)
    AtRest,         ///< when everything is at rest
    AtTarget,       ///< at rest at the current target (or as near as rigid tiles can get)
    ErrorBelow,     ///< when the error to the current target is below `value` metres
    ProgressAbove,  ///< when the error to the current target has shrunk by this fraction of its
                    ///< initial value, [0, 1]
  };
  Kind kind = Kind::After;  ///< kind of condition
  double value = 0;         ///< seconds, metres or a fraction, by the kind
};

/// Actions of a timeline, one struct per action.
namespace timeline {

/// Fixes tiles at their current position.
struct Pin {
  std::vector<int> tiles;  ///< tile numbers
};

/// Frees pinned tiles.
struct Unpin {
  std::vector<int> tiles;  ///< empty: all pinned tiles
};

/// Pulls a tile along a path by a damped spring, then releases it.
struct Drag {
  int tile = 0;               ///< tile number
  std::optional<int> vertex;  ///< of the tile's bottom, attached to the spring; absent: the brick's
                              ///< centre of mass
  std::vector<Vector3> path;  ///< at least one point, world axes; from the tile's current position,
                              ///< at constant speed
  double seconds = 1;         ///< duration, > 0
  double stiffness = 1000;    ///< N/m, >= 0
  double damping = 50;        ///< N s/m, >= 0
};

/// Switches the actuation on or off.
struct Forces {
  bool on = true;  ///< new state
};

/// Stops all tiles and restores their speeds afterwards. Pins may change meanwhile.
struct Pause {
  double seconds = 1;  ///< > 0
};

/// Sets another target.
struct GoTo {
  std::filesystem::path file;      ///< in the format of target.txt; empty: the model's own target
  std::vector<model::Tile> tiles;  ///< contents of the file after reading
};

/// Takes a picture of this moment.
struct Snapshot {};

/// Exports meshes of this moment.
struct Export {};

/// Returns to the start, at rest, without pins.
struct Reset {};

/// Ends the run.
struct Quit {};

/// Action of an entry.
using Action = std::variant<Pin, Unpin, Drag, Forces, Pause, GoTo, Snapshot, Export, Reset, Quit>;

}  // namespace timeline

/// A timed action.
struct TimelineEntry {
  Trigger when;             ///< condition
  timeline::Action action;  ///< action
  FileLocation where;       ///< position in the scene file, for messages
};

/// All entries, in order.
using Timeline = std::vector<TimelineEntry>;

/// "pin", "unpin", "drag", "forces", "pause", "target", "snapshot", "export", "reset", "quit".
std::string actionName(const timeline::Action& action);

/// Throws InputError if the timeline, with the numbers of the model's file, does not fit the model:
/// tiles or vertices that do not exist, or a target action for a model without a target.
void checkTimeline(const Timeline& timeline, const model::Model& model);

/// Converts tile and vertex numbers of the model's file to the model's own, which all other code
/// uses.
void numberAsModel(Timeline& timeline, const model::Model& model);

}  // namespace kirireel::scene
