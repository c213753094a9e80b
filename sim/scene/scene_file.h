/// scene.toml: the settings and the timeline of a run, in a file next to the model.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/scene/conditions.h"
#include "sim/scene/toml_file.h"

namespace kirireel::scene {

/// One key of one table, as text. The owner of the setting interprets it.
struct SceneSetting {
  std::string table;                ///< "model", "environment", ...
  std::string key;                  ///< as written
  std::vector<std::string> values;  ///< one, or one per element for arrays of texts or arrays; an
                                    ///< array of numbers is one text, "0,0,-9.81"
  bool isSwitch = false;            ///< true or false, see values.front()
  FileLocation where;               ///< of the value
};

/// A key of a table as a setting.
SceneSetting settingOf(const std::string& table, const TomlEntry& entry);

/// An error of a setting with its position in a file. Unchanged if it has a position.
InputError locatedAt(const FileLocation& where, const InputError& error);

/// Contents of a scene file.
struct SceneFile {
  std::filesystem::path path;          ///< of the scene file
  std::vector<SceneSetting> settings;  ///< by table and key
  Timeline timeline;                   ///< targets are named but not read yet; file paths are
                                       ///< relative to the scene file's folder
  std::vector<Obstacle> obstacles;
  std::vector<InitialVelocity> velocities;  ///< of tiles at the start
  std::vector<GripSetting> grips;           ///< in the numbers of the model's file
  TomlTable entries;                        ///< the lists of tables, in file order
};

/// The entries of these lists in scene file syntax with one spelling. Without file names if only
/// the contents of the files matter.
std::string entriesText(const SceneFile& file, bool withFileNames);

/// Reads a scene file. Its lengths stay in the unit of the model. It has the tables [model]
/// [environment] [actuation] [solver] [stop] [camera] [style] [recording], and [[timeline]],
/// [[obstacle]], [[velocity]], [[grip]] (see readGrips()).
///
/// A velocity is linear = [X, Y, Z] (lengths/s), angular = [X, Y, Z] (rad/s) or both, of
/// tiles = [TILES], by default of all. They start as one rigid body.
///
/// An obstacle is shape = "box" with size = [X, Y, Z], "sphere" with radius, or "mesh" with
/// file = "FILE.obj" (flat convex faces). It is at position = [X, Y, Z], rotated by
/// rotation = [X, Y, Z] (degrees about the axes, x first), with friction.
///
/// The time of a timeline entry is one of
///   at = SECONDS, at = "rest", at = "target", after = SECONDS (0), error_below = LENGTH,
///   progress = SHARE,
/// and its action one of
///   pin = [TILES], unpin = [TILES] or "all", drag = {tile, vertex, path, seconds, stiffness,
///   damping}, forces = "on" or "off", pause = SECONDS, target = "FILE" or "model",
///   snapshot = true, export = true, reset = true, quit = true.
///
/// Throws InputError with file:line:column for invalid TOML, for unknown tables and timeline keys
/// (suggesting the nearest), and for values that a timeline or an obstacle does not allow.
SceneFile readSceneFile(const std::filesystem::path& path);

}  // namespace kirireel::scene
