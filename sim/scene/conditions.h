/// Conditions of a sheet: grips, obstacles, initial velocities and the timeline.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/model/brick.h"
#include "sim/model/model.h"
#include "sim/scene/toml_file.h"

namespace kirireel::scene {

// ------------------------------------------------------------------------------------------------
// Numbers of tiles and vertices as files and scene files have them.

/// A whole number >= 0. Throws InputError with `allowed` in its message.
int readIndex(const TomlValue& value, const std::string& allowed);

/// One or more of them. Throws InputError with `allowed` for the list, or `allowedElement` for an
/// element.
std::vector<int> readIndices(const TomlValue& value, const std::string& allowed,
                             const std::string& allowedElement);

/// The model's own number of a tile that has this one in the model's file. Throws InputError where
/// the model has no such tile.
int tileOfModel(int number, const model::Model& model, const FileLocation& where);

// ------------------------------------------------------------------------------------------------
// [[grip]] in a scene file: what holds, moves or pushes parts of a sheet while it is loaded.

/// One grip. Its moves or forces grow in proportion to the load and are complete at the load 1.
/// Directions that it does not name are free.
struct GripSetting {
  std::vector<int> tiles;     ///< held tiles, at least one
  std::vector<int> vertices;  ///< of each of them: none, where the tile as a whole is held (its
                              ///< middle), one, or the two of an edge
  std::vector<model::Corner>
      corners;                 ///< these vertices in the model's numbers, see numberAsModel()
  bool isForce = false;        ///< newtons and N m that push, else metres and radians of moves
  std::optional<double> x;     ///< fixed if 0
  std::optional<double> y;     ///< the same
  std::optional<double> z;     ///< the same, of sheets in space
  std::optional<double> turn;  ///< anticlockwise; only of whole tiles
  Matrix3 axes = Matrix3::Identity();  ///< the directions of x, y and z, as columns
  FileLocation where;                  ///< in the scene file, for messages
};

/// Reads the [[grip]] entries of a scene file:
///
///     tile = NUMBER or tiles = [NUMBERS], and where not all of it: vertex = NUMBER or
///     edge = [NUMBER, NUMBER]; then one of move = {x = METRES, y = METRES, turn = DEGREES} and
///     force = {x = NEWTONS, y = NEWTONS, turn = N_M}, each optional; z like x.
///
/// Throws InputError with file:line:column for anything else.
std::vector<GripSetting> readGrips(const TomlValue& value);

/// Turns numbers of tiles, as the model's file has them, into the model's own, and sets the corners
/// that the vertices are. Throws InputError where a grip names no tile or vertex of the model.
void numberAsModel(std::vector<GripSetting>& grips, const model::Model& model);

// ------------------------------------------------------------------------------------------------
// Fixed obstacles.

/// A fixed obstacle. Joints, forces and drags do not move it.
struct Obstacle {
  /// What it is.
  enum class Shape {
    Box,     ///< with six flat sides
    Sphere,  ///< round
    Mesh,    ///< a surface without thickness, with contact on both sides
  };
  Shape shape = Shape::Box;        ///< what it is
  Vector3 size = Vector3::Ones();  ///< of a box, along its own axes, metres, > 0
  double radius = 1;               ///< of a sphere, metres, > 0
  std::vector<model::Tile> mesh;   ///< flat convex faces of a mesh, in its own axes
  Pose pose;                       ///< of the middle of a box or sphere, of a mesh's axes
  double friction = 0.5;           ///< Coulomb coefficient, >= 0
};

/// The surface of an obstacle as outward anticlockwise polygons (a mesh's as they are), world axes.
/// A sphere's are the faces of a fine polyhedron with its corners on the sphere, for pictures.
std::vector<model::Tile> obstacleFaces(const Obstacle& obstacle);

/// The same for all obstacles, one after the other.
std::vector<model::Tile> obstacleFaces(const std::vector<Obstacle>& obstacles);

/// The lower face of an upright box about an obstacle's origin, turned and placed with it, and
/// anticlockwise seen from within: thickened by size.z it is the box.
model::Tile boxFloor(const Obstacle& obstacle, const Vector3& size);

// ------------------------------------------------------------------------------------------------
// How fast tiles move when a run begins.

/// Tiles that begin to move as one rigid whole; joints take from that what they do not allow.
struct InitialVelocity {
  std::vector<int> tiles;             ///< empty: all
  Vector3 linear = Vector3::Zero();   ///< of their common centre of mass, m/s
  Vector3 angular = Vector3::Zero();  ///< about that, world axes, rad/s
  FileLocation where;                 ///< of the table in the scene file
};

/// Turns numbers of tiles as the model's file counts them into those of the model. Throws
/// InputError for a tile that the model does not have.
void numberAsModel(std::vector<InitialVelocity>& velocities, const model::Model& model);

/// The velocity of each brick at these poses; where several are given for a brick they add up.
std::vector<Velocity> initialVelocities(const std::vector<InitialVelocity>& given,
                                        const std::vector<model::Brick>& bricks,
                                        const Poses& poses);

// ------------------------------------------------------------------------------------------------
// The timeline: what happens to a running deployment, and when. The headless form of pinning and
// dragging tiles by hand.

/// When an entry of a timeline happens. Entries happen in their order: each waits until all before
/// it have happened.
struct Trigger {
  /// What it waits for.
  enum class Kind {
    AtTime,         ///< at `value` simulated seconds
    After,          ///< `value` simulated seconds after the entry before (the start for the first)
    AtRest,         ///< once nothing moves any more
    AtTarget,       ///< once at rest at the present target (or what rigid tiles can reach of it)
    ErrorBelow,     ///< once the error to the present target is below `value` metres
    ProgressAbove,  ///< once the error to the present target has shrunk by this share of what it
                    ///< was when that target was set, 0 to 1
  };
  Kind kind = Kind::After;  ///< what it waits for
  double value = 0;         ///< seconds, metres or a share, by the kind
};

/// What a timeline does, one struct an action.
namespace timeline {

/// Fixes tiles to the world where they are.
struct Pin {
  std::vector<int> tiles;  ///< their numbers
};

/// Frees pinned tiles.
struct Unpin {
  std::vector<int> tiles;  ///< all that are pinned when empty
};

/// Pulls a tile along a path by a damped spring, then lets go.
struct Drag {
  int tile = 0;               ///< its number
  std::optional<int> vertex;  ///< of the tile's bottom, where the spring is tied; absent: the
                              ///< brick's centre of mass
  std::vector<Vector3> path;  ///< at least one point, world axes; from where the tile is, at even
                              ///< speed
  double seconds = 1;         ///< that the path takes, positive
  double stiffness = 1000;    ///< N/m, >= 0
  double damping = 50;        ///< N s/m, >= 0
};

/// Switches the actuation.
struct Forces {
  bool on = true;  ///< or off
};

/// Holds all tiles still; their speeds come back afterwards. Pins may change meanwhile.
struct Pause {
  double seconds = 1;  ///< positive
};

/// Heads for another target.
struct GoTo {
  std::filesystem::path file;      ///< in the format of target.txt; empty: the model's own target
  std::vector<model::Tile> tiles;  ///< what the file holds, once it has been read
};

/// A picture of this moment.
struct Snapshot {};

/// Meshes of this moment.
struct Export {};

/// Back to the start, at rest, nothing pinned.
struct Reset {};

/// Ends the run.
struct Quit {};

/// What an entry does.
using Action = std::variant<Pin, Unpin, Drag, Forces, Pause, GoTo, Snapshot, Export, Reset, Quit>;

}  // namespace timeline

/// One thing that happens.
struct TimelineEntry {
  Trigger when;             ///< when it happens
  timeline::Action action;  ///< what happens then
  FileLocation where;       ///< in the scene file, for messages
};

/// All that happens, in order.
using Timeline = std::vector<TimelineEntry>;

/// "pin", "unpin", "drag", "forces", "pause", "target", "snapshot", "export", "reset", "quit".
std::string actionName(const timeline::Action& action);

/// Throws InputError where the timeline, in the numbers of the model's file, does not fit the
/// model: tiles or vertices that do not exist, a target without one.
void checkTimeline(const Timeline& timeline, const model::Model& model);

/// Turns numbers of tiles and vertices, as the model's file has them, into the model's own, which
/// everything else goes by.
void numberAsModel(Timeline& timeline, const model::Model& model);

}  // namespace kirireel::scene
