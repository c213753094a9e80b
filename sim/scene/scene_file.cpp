// Reads scene.toml into plain values.
//
// Tables of settings ([environment] and others) become texts with a key each. The list of settings
// (settings.h) defines their meaning and allowed values. Lists of tables ([[timeline]],
// [[obstacle]], [[velocity]], [[grip]]) have their own form and are read here. Every value has its
// line and column for messages. Unknown keys are errors, since a misspelt key would have no effect.
#include "sim/scene/scene_file.h"

#include <algorithm>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "sim/base/geometry.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/text_table.h"

namespace kirireel::scene {
namespace {

const std::vector<std::string> kTables = {"model",    "environment", "actuation", "solver",
                                          "stop",     "camera",      "style",     "recording",
                                          "timeline", "obstacle",    "velocity",  "grip"};

/// Largest length, in any unit. It is a metre in nanometres.
constexpr double kMaxNumber = 1e9;

/// A timeline's word for the model's own target.
constexpr std::string_view kOwnTarget = "model";

/// Tile and vertex numbers are checked against the model later.
std::vector<int> readTiles(const TomlValue& value, const std::string& allowed) {
  return readIndices(value, allowed, "a tile number");
}

// Three numbers. `allowed` describes the list.
Vector3 readNumbers(const TomlValue& value, const std::string& allowed) {
  const std::vector<TomlValue>* array = value.array();
  if (!array || array->size() != 3) refuseValue(value, allowed);
  Vector3 result;
  for (int k = 0; k < 3; ++k) {
    result[k] = requireNumber((*array)[k], -kMaxNumber, kMaxNumber,
                              fmt::format("a number, at most {:g} in size", kMaxNumber));
  }
  return result;
}

// In the unit of the model.
Vector3 readPoint(const TomlValue& value) {
  return readNumbers(value, "a point [x, y, z]");
}

// ---- timeline

using namespace timeline;

/// Moments and actions found so far in one entry.
struct EntryParts {
  std::vector<Trigger> moments;
  std::vector<Action> actions;
};

// Each key of an entry appends a moment or an action.
using PartReader = std::function<void(const TomlValue&, EntryParts&)>;

constexpr double kLongest = 1e6;  // seconds
const std::string kSeconds = "a number of seconds, from 0 to 1e6";
const std::string kPositiveSeconds = "a positive number of seconds, at most 1e6";

// A time, or one of the two states that a run may reach.
void readAt(const TomlValue& value, EntryParts& parts) {
  const std::string allowed = kSeconds + ", \"rest\" or \"target\"";
  Trigger moment;
  const std::string* text = value.text();
  if (!text) {
    moment = {Trigger::Kind::AtTime, requireNumber(value, 0, kLongest, allowed)};
  } else if (*text == "rest") {
    moment.kind = Trigger::Kind::AtRest;
  } else if (*text == "target") {
    moment.kind = Trigger::Kind::AtTarget;
  } else {
    refuseValue(value, allowed);
  }
  parts.moments.push_back(moment);
}

/// A moment that is one number.
PartReader numberMoment(Trigger::Kind kind, double most, const std::string& allowed) {
  return [=](const TomlValue& value, EntryParts& parts) {
    parts.moments.push_back({kind, requireNumber(value, 0, most, allowed)});
  };
}

void readPin(const TomlValue& value, EntryParts& parts) {
  parts.actions.emplace_back(Pin{readTiles(value, "a list of tile numbers, [0, 1]")});
}

void readUnpin(const TomlValue& value, EntryParts& parts) {
  const std::string* text = value.text();
  if (text && *text == "all") {
    parts.actions.emplace_back(Unpin{});
  } else {
    parts.actions.emplace_back(Unpin{readTiles(value, "a list of tile numbers, or \"all\"")});
  }
}

std::vector<Vector3> readPath(const TomlValue& value) {
  const std::vector<TomlValue>* array = value.array();
  if (!array || array->empty()) refuseValue(value, "a list of points, [[x, y, z]]");
  std::vector<Vector3> path;
  for (const TomlValue& element : *array) path.push_back(readPoint(element));
  return path;
}

void readDragKey(const TomlEntry& entry, Drag& drag) {
  const double most = 1e12;
  static const std::vector<std::string> kKeys = {"tile",    "vertex",    "path",
                                                 "seconds", "stiffness", "damping"};
  const auto& [key, where, value] = entry;
  if (key == "tile") {
    drag.tile = readIndex(value, "a tile number");
  } else if (key == "vertex") {
    drag.vertex = readIndex(value, "a vertex number");
  } else if (key == "path") {
    drag.path = readPath(value);
  } else if (key == "seconds") {
    drag.seconds = requireNumber(value, 1e-6, kLongest, kPositiveSeconds);
  } else if (key == "stiffness") {
    drag.stiffness = requireNumber(value, 0, most, "a number from 0 to 1e12, N/m");
  } else if (key == "damping") {
    drag.damping = requireNumber(value, 0, most, "a number from 0 to 1e12, N s/m");
  } else {
    refuseKey(entry, "key of a drag", kKeys);
  }
}

// Tile and path are required. The rest has defaults.
void readDrag(const TomlValue& value, EntryParts& parts) {
  const std::string allowed = "a table, {tile = 3, path = [[0, 0, 1]], seconds = 2}";
  const TomlTable* table = value.table();
  if (!table || !find(*table, "tile") || !find(*table, "path")) refuseValue(value, allowed);
  Drag drag;
  for (const TomlEntry& entry : *table) readDragKey(entry, drag);
  parts.actions.emplace_back(std::move(drag));
}

void readForces(const TomlValue& value, EntryParts& parts) {
  const std::string* text = value.text();
  const bool on = text && *text == "on";
  if (!on && !(text && *text == "off")) refuseValue(value, "\"on\" or \"off\"");
  parts.actions.emplace_back(Forces{on});
}

void readPause(const TomlValue& value, EntryParts& parts) {
  parts.actions.emplace_back(Pause{requireNumber(value, 1e-6, kLongest, kPositiveSeconds)});
}

void readTarget(const TomlValue& value, EntryParts& parts) {
  const std::string* text = value.text();
  if (!text || text->empty()) refuseValue(value, "the name of a file, or \"model\"");
  if (*text == kOwnTarget) {
    parts.actions.emplace_back(GoTo{});
  } else {
    // Paths are relative to the scene file, so a folder can be moved as a whole.
    const std::filesystem::path folder = value.where.file.parent_path();
    parts.actions.emplace_back(GoTo{folder / *text, {}});
  }
}

/// An action without parameters.
template <typename T>
void readPlain(const TomlValue& value, EntryParts& parts) {
  if (value.truth() == nullptr || !*value.truth()) refuseValue(value, "true");
  parts.actions.emplace_back(T{});
}

const std::map<std::string, PartReader>& entryKeys() {
  static const std::map<std::string, PartReader> keys = {
      {"at", readAt},
      {"after", numberMoment(Trigger::Kind::After, kLongest, kSeconds)},
      {"error_below", numberMoment(Trigger::Kind::ErrorBelow, kMaxNumber,
                                   "a length in the model's unit, from 0 to 1e9")},
      {"progress", numberMoment(Trigger::Kind::ProgressAbove, 1, "a share from 0 to 1")},
      {"pin", readPin},
      {"unpin", readUnpin},
      {"drag", readDrag},
      {"forces", readForces},
      {"pause", readPause},
      {"target", readTarget},
      {"snapshot", readPlain<Snapshot>},
      {"export", readPlain<Export>},
      {"reset", readPlain<Reset>},
      {"quit", readPlain<Quit>},
  };
  return keys;
}

// At most one moment, and exactly one action.
TimelineEntry readEntry(const TomlValue& value) {
  const TomlTable* table = value.table();
  if (!table) refuseValue(value, "tables, each under [[timeline]]");
  EntryParts parts;
  for (const TomlEntry& entry : *table) {
    const auto found = entryKeys().find(entry.key);
    if (found == entryKeys().end()) {
      std::vector<std::string> known;
      for (const auto& keyAndReader : entryKeys()) known.push_back(keyAndReader.first);
      refuseKey(entry, "key of a timeline entry", known);
    }
    found->second(entry.value, parts);
  }
  // Possible mistakes: no action, two actions, two moments.
  if (parts.actions.size() != 1 || parts.moments.size() > 1) {
    throw inputErrorAt(
        value.where,
        fmt::format("this entry has {} times and {} actions. It needs at most one of at, after, "
                    "error_below, progress (none: immediately), and exactly one of pin, unpin, "
                    "drag, forces, pause, target, snapshot, export, reset, quit",
                    parts.moments.size(), parts.actions.size()));
  }
  return {parts.moments.empty() ? Trigger{} : parts.moments.front(), parts.actions.front(),
          value.where};
}

Timeline readTimeline(const TomlValue& value) {
  const std::vector<TomlValue>* array = value.array();
  if (!array) refuseValue(value, "tables, each under [[timeline]]");
  Timeline timeline;
  for (const TomlValue& entry : *array) timeline.push_back(readEntry(entry));
  return timeline;
}

// ---- obstacles

// Each is a body of the broad phase. The number of faces of a mesh is not limited.
constexpr std::size_t kMaxObstacles = 1000;

const std::vector<std::string> kObstacleKeys = {"shape",    "size",     "radius",  "file",
                                                "position", "rotation", "friction"};

/// The required key of each shape of obstacle.
const std::map<std::string, std::pair<Obstacle::Shape, std::string>>& obstacleShapes() {
  static const std::map<std::string, std::pair<Obstacle::Shape, std::string>> shapes = {
      {"box", {Obstacle::Shape::Box, "size"}},
      {"sphere", {Obstacle::Shape::Sphere, "radius"}},
      {"mesh", {Obstacle::Shape::Mesh, "file"}},
  };
  return shapes;
}

Vector3 boxSize(const TomlValue& value) {
  const Vector3 size = readPoint(value);
  if (!(size.minCoeff() > 0)) refuseValue(value, "three positive lengths");
  return size;
}

/// Rotations about the world axes, x first, typed in degrees.
Quaternion turn(const TomlValue& value) {
  const Vector3 angles = kDegree * readNumbers(value, "three angles in degrees, [x, y, z]");
  // The rotation about x is applied first: it is on the right.
  return rotationFromVector({0, 0, angles.z()}) * rotationFromVector({0, angles.y(), 0}) *
         rotationFromVector({angles.x(), 0, 0});
}

// Faces of an OBJ file. They may be concave or bent, since contacts use each face separately.
void readMesh(const TomlValue& value, Obstacle& obstacle) {
  const std::string* name = value.text();
  if (!name || name->empty()) refuseValue(value, "the name of an OBJ file");
  const std::filesystem::path file = value.where.file.parent_path() / *name;
  std::vector<std::string> ignored;  // warnings that only concern sheets
  obstacle.mesh = formats::readObjPair(file, {}, ignored).tiles;
  obstacle.meshUnit = formats::unitInComments(file);
}

void readObstacleKey(const TomlEntry& entry, Obstacle& obstacle) {
  if (entry.key == "size") {
    obstacle.size = boxSize(entry.value);
  } else if (entry.key == "radius") {
    obstacle.radius =
        requireNumber(entry.value, 1e-15, kMaxNumber, "a positive length in the model's unit");
  } else if (entry.key == "file") {
    readMesh(entry.value, obstacle);
  } else if (entry.key == "position") {
    obstacle.pose.position = readPoint(entry.value);
  } else if (entry.key == "rotation") {
    obstacle.pose.rotation = turn(entry.value);
  } else if (entry.key == "friction") {
    obstacle.friction = requireNumber(entry.value, 0, 1e3, "a number from 0 to 1000");
  } else if (entry.key != "shape") {
    refuseKey(entry, "key of an obstacle", kObstacleKeys);
  }
}

/// Checks that the shape has its own measure and no other.
void requireMeasure(const TomlValue& obstacle, const std::string& shape) {
  for (const auto& [name, kind] : obstacleShapes()) {
    const bool isGiven = find(*obstacle.table(), kind.second) != nullptr;
    if (isGiven == (name == shape)) continue;
    throw inputErrorAt(obstacle.where,
                       fmt::format("a {} {} {}. A box has size, a sphere radius, a mesh file",
                                   shape, name == shape ? "needs" : "has no", kind.second));
  }
}

// Reads the shape first, since the other allowed keys depend on it.
Obstacle readObstacle(const TomlValue& value) {
  const TomlTable* table = value.table();
  if (!table) refuseValue(value, "tables, each under [[obstacle]]");
  const TomlValue* shape = find(*table, "shape");
  const std::string* name = shape ? shape->text() : nullptr;
  const auto found = obstacleShapes().find(name ? *name : "");
  if (found == obstacleShapes().end()) {
    throw inputErrorAt(shape ? shape->where : value.where,
                       "an obstacle needs shape = \"box\", \"sphere\" or \"mesh\"");
  }
  Obstacle obstacle;
  obstacle.shape = found->second.first;
  for (const TomlEntry& entry : *table) readObstacleKey(entry, obstacle);
  requireMeasure(value, found->first);
  return obstacle;
}

std::vector<Obstacle> readObstacles(const TomlValue& value) {
  const std::vector<TomlValue>* array = value.array();
  if (!array) refuseValue(value, "tables, each under [[obstacle]]");
  if (array->size() > kMaxObstacles) {
    throw inputErrorAt(
        value.where,
        fmt::format(
            "there are {} obstacles, but at most {} are allowed. Combine several in one mesh",
            array->size(), kMaxObstacles));
  }
  std::vector<Obstacle> obstacles;
  for (const TomlValue& entry : *array) obstacles.push_back(readObstacle(entry));
  return obstacles;
}

// ---- velocities

const std::vector<std::string> kVelocityKeys = {"tiles", "linear", "angular"};

InitialVelocity readVelocity(const TomlValue& value) {
  const TomlTable* table = value.table();
  if (!table) refuseValue(value, "tables, each under [[velocity]]");
  InitialVelocity velocity;
  velocity.where = value.where;
  for (const TomlEntry& entry : *table) {
    if (entry.key == "tiles") {
      velocity.tiles = readTiles(entry.value, "a list of tile numbers, [0, 1]");
    } else if (entry.key == "linear") {
      velocity.linear = readNumbers(entry.value, "three lengths per second, [x, y, z]");
    } else if (entry.key == "angular") {
      velocity.angular = readNumbers(entry.value, "three numbers in rad/s, [x, y, z]");
    } else {
      refuseKey(entry, "key of a velocity", kVelocityKeys);
    }
  }
  if (find(*table, "linear") || find(*table, "angular")) return velocity;
  throw inputErrorAt(
      value.where,
      "a velocity needs linear = [x, y, z] in lengths per second, angular in rad/s, or both");
}

std::vector<InitialVelocity> readVelocities(const TomlValue& value) {
  const std::vector<TomlValue>* array = value.array();
  if (!array) refuseValue(value, "tables, each under [[velocity]]");
  std::vector<InitialVelocity> velocities;
  for (const TomlValue& entry : *array) velocities.push_back(readVelocity(entry));
  return velocities;
}

}  // namespace

SceneSetting settingOf(const std::string& table, const TomlEntry& entry) {
  const TomlValue& value = entry.value;
  SceneSetting setting{table, entry.key, {}, value.truth() != nullptr, value.where};
  const std::vector<TomlValue>* array = value.array();
  // An array of numbers is one value, such as gravity. Any other array has several values.
  const bool several = array && !array->empty() && !array->front().number();
  if (!several) {
    setting.values = {typedText(value)};
  } else {
    for (const TomlValue& element : *array) setting.values.push_back(typedText(element));
  }
  return setting;
}

InputError locatedAt(const FileLocation& where, const InputError& error) {
  constexpr std::string_view kMark = "error: ";
  const std::string message = error.what();
  return message.starts_with(kMark) ? inputErrorAt(where, message.substr(kMark.size())) : error;
}

std::string entriesText(const SceneFile& file, bool withFileNames) {
  // Files of obstacles, and targets of timelines other than the model's own.
  const auto namesFile = [](const TomlEntry& entry) {
    const std::string* text = entry.value.text();
    return text && (entry.key == "file" || (entry.key == "target" && *text != kOwnTarget));
  };
  std::string text;
  for (const TomlEntry& list : file.entries) {
    // Only lists that were read without errors are stored, so their types are known.
    for (const TomlValue& element : *list.value.array()) {
      text += fmt::format("\n[[{}]]\n", list.key);
      for (const TomlEntry& entry : *element.table()) {
        const bool isShown = withFileNames || !namesFile(entry);
        text += fmt::format("{} = {}\n", entry.key, isShown ? tomlText(entry.value) : "\"\"");
      }
    }
  }
  return text;
}

namespace {

/// Returns whether the entry is one of the lists of tables.
bool readList(const TomlEntry& entry, SceneFile& file) {
  if (entry.key == "timeline") {
    file.timeline = readTimeline(entry.value);
  } else if (entry.key == "obstacle") {
    file.obstacles = readObstacles(entry.value);
  } else if (entry.key == "velocity") {
    file.velocities = readVelocities(entry.value);
  } else if (entry.key == "grip") {
    file.grips = readGrips(entry.value);
  } else {
    return false;
  }
  return true;
}

}  // namespace

SceneFile readSceneFile(const std::filesystem::path& path) {
  SceneFile file;
  file.path = path;
  for (const TomlEntry& entry : readTomlFile(path, "a scene file, like scene.toml")) {
    if (std::find(kTables.begin(), kTables.end(), entry.key) == kTables.end()) {
      if (entry.value.table() || entry.value.array()) refuseKey(entry, "table", kTables);
      throw inputErrorAt(entry.where,
                         fmt::format("{} is in no table; write it below its table, such as [{}]",
                                     shown(entry.key), kTables.front()));
    }
    if (readList(entry, file)) {
      file.entries.push_back(entry);
      continue;
    }
    const TomlTable* table = entry.value.table();
    if (!table) refuseValue(entry.value, fmt::format("a table, [{}]", entry.key));
    for (const TomlEntry& setting : *table) {
      file.settings.push_back(settingOf(entry.key, setting));
    }
  }
  return file;
}

}  // namespace kirireel::scene
