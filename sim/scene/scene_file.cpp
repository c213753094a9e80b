#include "sim/scene/scene_file.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "sim/base/spelling.h"
#include "sim/model/obj_pair.h"

namespace kirireel {
namespace {

const std::vector<std::string> kTables = {"model",    "environment", "actuation", "solver",
                                          "stop",     "camera",      "style",     "recording",
                                          "timeline", "obstacle"};

/// Reads nodes of one file; every message knows its place.
class Reader {
 public:
  explicit Reader(std::filesystem::path file) : file_(std::move(file)) {}

  FileLocation at(const toml::source_region& region) const {
    return {file_, static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
  }
  FileLocation at(const toml::node& node) const { return at(node.source()); }

  [[noreturn]] void refuse(const toml::node& node, const std::string& wanted) const {
    throw inputErrorAt(at(node), fmt::format("this value is not allowed; give {}", wanted));
  }

  double number(const toml::node& node, double least, double most,
                const std::string& wanted) const {
    const std::optional<double> value = node.value<double>();
    if (!node.is_number() || !(*value >= least && *value <= most)) refuse(node, wanted);
    return *value;
  }

  /// Tile and vertex numbers are checked against the model later.
  int index(const toml::node& node, const std::string& wanted) const {
    const std::optional<std::int64_t> value = node.value_exact<std::int64_t>();
    if (!value || *value < 0 || *value > std::numeric_limits<int>::max()) refuse(node, wanted);
    return static_cast<int>(*value);
  }

  std::vector<int> tiles(const toml::node& node, const std::string& wanted) const {
    const toml::array* array = node.as_array();
    if (!array || array->empty()) refuse(node, wanted);
    std::vector<int> numbers;
    for (const toml::node& element : *array) numbers.push_back(index(element, "a tile number"));
    return numbers;
  }

  Vector3 point(const toml::node& node) const {
    const toml::array* array = node.as_array();
    if (!array || array->size() != 3) refuse(node, "a point [x, y, z]");
    Vector3 result;
    for (int k = 0; k < 3; ++k) {
      result[k] = number((*array)[k], -1e6, 1e6, "a coordinate in metres, at most 1e6 in size");
    }
    return result;
  }

  [[noreturn]] void refuseKey(const toml::key& key, const std::string& what,
                              const std::vector<std::string>& known) const {
    const std::string name(key.str());
    throw inputErrorAt(at(key.source()),
                       fmt::format("unknown {} {}{}; there are {}", what, name,
                                   suggestion(name, known), fmt::join(known, ", ")));
  }

 private:
  std::filesystem::path file_;
};

// ---- settings

/// An array of numbers is one value, "0,0,-9.81".
std::string elementText(const Reader& reader, const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* whole = node.as_integer()) return fmt::format("{}", whole->get());
  if (const auto* real = node.as_floating_point()) return fmt::format("{}", real->get());
  if (const auto* truth = node.as_boolean()) return truth->get() ? "true" : "false";
  const toml::array* array = node.as_array();
  if (!array) reader.refuse(node, "a number, a text, true, false or an array");
  std::vector<std::string> parts;
  for (const toml::node& element : *array) {
    if (!element.is_number()) reader.refuse(element, "a number");
    parts.push_back(elementText(reader, element));
  }
  return fmt::format("{}", fmt::join(parts, ","));
}

SceneSetting readSetting(const Reader& reader, const std::string& table, const toml::key& key,
                         const toml::node& node) {
  SceneSetting setting{table, std::string(key.str()), {}, node.is_boolean(), reader.at(node)};
  const toml::array* array = node.as_array();
  const bool several = array && !array->empty() && !array->front().is_number();
  if (!several) {
    setting.values = {elementText(reader, node)};
  } else {
    for (const toml::node& element : *array) {
      setting.values.push_back(elementText(reader, element));
    }
  }
  return setting;
}

// ---- timeline

using namespace timeline;

/// One entry in work: what was found so far.
struct EntryParts {
  std::vector<Occasion> moments;
  std::vector<Action> actions;
};

using PartReader = std::function<void(const Reader&, const toml::node&, EntryParts&)>;

constexpr double kLongest = 1e6;  // seconds
const std::string kSeconds = "a number of seconds, from 0 to 1e6";
const std::string kPositiveSeconds = "a positive number of seconds, at most 1e6";

void readAt(const Reader& reader, const toml::node& node, EntryParts& parts) {
  const std::string wanted = kSeconds + ", \"rest\" or \"target\"";
  Occasion moment;
  const auto* text = node.as_string();
  if (!text) {
    moment = {Occasion::Kind::AtTime, reader.number(node, 0, kLongest, wanted)};
  } else if (text->get() == "rest") {
    moment.kind = Occasion::Kind::AtRest;
  } else if (text->get() == "target") {
    moment.kind = Occasion::Kind::AtTarget;
  } else {
    reader.refuse(node, wanted);
  }
  parts.moments.push_back(moment);
}

/// A moment that is one number.
PartReader numberMoment(Occasion::Kind kind, double most, const std::string& wanted) {
  return [=](const Reader& reader, const toml::node& node, EntryParts& parts) {
    parts.moments.push_back({kind, reader.number(node, 0, most, wanted)});
  };
}

void readPin(const Reader& reader, const toml::node& node, EntryParts& parts) {
  parts.actions.emplace_back(Pin{reader.tiles(node, "a list of tile numbers, [0, 1]")});
}

void readUnpin(const Reader& reader, const toml::node& node, EntryParts& parts) {
  const auto* text = node.as_string();
  if (text && text->get() == "all") {
    parts.actions.emplace_back(Unpin{});
  } else {
    parts.actions.emplace_back(Unpin{reader.tiles(node, "a list of tile numbers, or \"all\"")});
  }
}

std::vector<Vector3> readPath(const Reader& reader, const toml::node& node) {
  const toml::array* array = node.as_array();
  if (!array || array->empty()) reader.refuse(node, "a list of points, [[x, y, z]]");
  std::vector<Vector3> path;
  for (const toml::node& element : *array) path.push_back(reader.point(element));
  return path;
}

void readDragKey(const Reader& reader, const toml::key& key, const toml::node& node, Drag& drag) {
  const double most = 1e12;
  static const std::vector<std::string> kKeys = {"tile",    "vertex",    "path",
                                                 "seconds", "stiffness", "damping"};
  if (key == "tile") {
    drag.tile = reader.index(node, "a tile number");
  } else if (key == "vertex") {
    drag.vertex = reader.index(node, "a vertex number");
  } else if (key == "path") {
    drag.path = readPath(reader, node);
  } else if (key == "seconds") {
    drag.seconds = reader.number(node, 1e-6, kLongest, kPositiveSeconds);
  } else if (key == "stiffness") {
    drag.stiffness = reader.number(node, 0, most, "a number from 0 to 1e12, N/m");
  } else if (key == "damping") {
    drag.damping = reader.number(node, 0, most, "a number from 0 to 1e12, N s/m");
  } else {
    reader.refuseKey(key, "key of a drag", kKeys);
  }
}

void readDrag(const Reader& reader, const toml::node& node, EntryParts& parts) {
  const std::string wanted = "a table, {tile = 3, path = [[0, 0, 1]], seconds = 2}";
  const toml::table* table = node.as_table();
  if (!table || !table->contains("tile") || !table->contains("path")) reader.refuse(node, wanted);
  Drag drag;
  for (const auto& [key, value] : *table) readDragKey(reader, key, value, drag);
  parts.actions.emplace_back(std::move(drag));
}

void readForces(const Reader& reader, const toml::node& node, EntryParts& parts) {
  const auto* text = node.as_string();
  const bool on = text && text->get() == "on";
  if (!on && !(text && text->get() == "off")) reader.refuse(node, "\"on\" or \"off\"");
  parts.actions.emplace_back(Forces{on});
}

void readPause(const Reader& reader, const toml::node& node, EntryParts& parts) {
  parts.actions.emplace_back(Pause{reader.number(node, 1e-6, kLongest, kPositiveSeconds)});
}

void readTarget(const Reader& reader, const toml::node& node, EntryParts& parts) {
  const auto* text = node.as_string();
  if (!text || text->get().empty()) reader.refuse(node, "the name of a file, or \"model\"");
  if (text->get() == "model") {
    parts.actions.emplace_back(GoTo{});
  } else {
    const std::filesystem::path folder = reader.at(node).file.parent_path();
    parts.actions.emplace_back(GoTo{folder / text->get(), {}});
  }
}

/// An action without anything to say but that it happens.
template <typename T>
void readPlain(const Reader& reader, const toml::node& node, EntryParts& parts) {
  if (node.value_exact<bool>() != true) reader.refuse(node, "true");
  parts.actions.emplace_back(T{});
}

const std::map<std::string, PartReader>& entryKeys() {
  static const std::map<std::string, PartReader> keys = {
      {"at", readAt},
      {"after", numberMoment(Occasion::Kind::After, kLongest, kSeconds)},
      {"error_below",
       numberMoment(Occasion::Kind::ErrorBelow, 1e6, "a number of metres, from 0 to 1e6")},
      {"progress", numberMoment(Occasion::Kind::ProgressAbove, 1, "a share from 0 to 1")},
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

TimelineEntry readEntry(const Reader& reader, const toml::node& node) {
  const toml::table* table = node.as_table();
  if (!table) reader.refuse(node, "tables, each under [[timeline]]");
  EntryParts parts;
  for (const auto& [key, value] : *table) {
    const auto found = entryKeys().find(std::string(key.str()));
    if (found == entryKeys().end()) {
      std::vector<std::string> known;
      for (const auto& entry : entryKeys()) known.push_back(entry.first);
      reader.refuseKey(key, "key of a timeline entry", known);
    }
    found->second(reader, value, parts);
  }
  if (parts.actions.size() != 1 || parts.moments.size() > 1) {
    throw inputErrorAt(
        reader.at(node),
        fmt::format("this entry says {} times when and {} times what; give one of at, after, "
                    "error_below, progress (or none: at once), and one of pin, unpin, drag, "
                    "forces, pause, target, snapshot, export, reset, quit",
                    parts.moments.size(), parts.actions.size()));
  }
  return {parts.moments.empty() ? Occasion{} : parts.moments.front(), parts.actions.front(),
          reader.at(node)};
}

Timeline readTimeline(const Reader& reader, const toml::node& node) {
  const toml::array* array = node.as_array();
  if (!array) reader.refuse(node, "tables, each under [[timeline]]");
  Timeline timeline;
  for (const toml::node& entry : *array) timeline.push_back(readEntry(reader, entry));
  return timeline;
}

// ---- obstacles

constexpr double kFarthest = 1e6;  // metres

const std::vector<std::string> kObstacleKeys = {"shape",    "size",     "radius",  "file",
                                                "position", "rotation", "friction"};

/// What an obstacle of each shape must give.
const std::map<std::string, std::pair<Obstacle::Shape, std::string>>& obstacleShapes() {
  static const std::map<std::string, std::pair<Obstacle::Shape, std::string>> shapes = {
      {"box", {Obstacle::Shape::Box, "size"}},
      {"sphere", {Obstacle::Shape::Sphere, "radius"}},
      {"mesh", {Obstacle::Shape::Mesh, "file"}},
  };
  return shapes;
}

Vector3 boxSize(const Reader& reader, const toml::node& node) {
  const Vector3 size = reader.point(node);
  if (!(size.minCoeff() > 0)) reader.refuse(node, "three positive lengths in metres");
  return size;
}

/// Turns about the axes of the world, x first, as they are typed in degrees.
Quaternion turn(const Reader& reader, const toml::node& node) {
  const Vector3 angles = M_PI / 180 * reader.point(node);
  return rotationFromVector({0, 0, angles.z()}) * rotationFromVector({0, angles.y(), 0}) *
         rotationFromVector({angles.x(), 0, 0});
}

std::vector<Tile> meshFaces(const Reader& reader, const toml::node& node) {
  const auto* text = node.as_string();
  if (!text || text->get().empty()) reader.refuse(node, "the name of an OBJ file");
  std::vector<std::string> ignored;  // what a sheet should rather not be
  return readObjPair(reader.at(node).file.parent_path() / text->get(), {}, ignored).tiles;
}

void readObstacleKey(const Reader& reader, const toml::key& key, const toml::node& node,
                     Obstacle& obstacle) {
  if (key == "size") {
    obstacle.size = boxSize(reader, node);
  } else if (key == "radius") {
    obstacle.radius = reader.number(node, 1e-9, kFarthest, "a positive length in metres");
  } else if (key == "file") {
    obstacle.mesh = meshFaces(reader, node);
  } else if (key == "position") {
    obstacle.pose.position = reader.point(node);
  } else if (key == "rotation") {
    obstacle.pose.rotation = turn(reader, node);
  } else if (key == "friction") {
    obstacle.friction = reader.number(node, 0, 1e3, "a number from 0 to 1000");
  } else if (key != "shape") {
    reader.refuseKey(key, "key of an obstacle", kObstacleKeys);
  }
}

/// The shape must bring its own measure and no other's.
void requireMeasure(const Reader& reader, const toml::table& table, const std::string& shape) {
  for (const auto& [name, kind] : obstacleShapes()) {
    if (table.contains(kind.second) == (name == shape)) continue;
    throw inputErrorAt(reader.at(table),
                       fmt::format("a {} {} {}; box has size, sphere has radius, mesh has file",
                                   shape, name == shape ? "needs" : "has no", kind.second));
  }
}

Obstacle readObstacle(const Reader& reader, const toml::node& node) {
  const toml::table* table = node.as_table();
  if (!table) reader.refuse(node, "tables, each under [[obstacle]]");
  const toml::node* shape = table->get("shape");
  const auto* name = shape ? shape->as_string() : nullptr;
  const auto found = obstacleShapes().find(name ? name->get() : "");
  if (found == obstacleShapes().end()) {
    throw inputErrorAt(reader.at(shape ? *shape : node),
                       "an obstacle needs shape = \"box\", \"sphere\" or \"mesh\"");
  }
  Obstacle obstacle;
  obstacle.shape = found->second.first;
  for (const auto& [key, value] : *table) readObstacleKey(reader, key, value, obstacle);
  requireMeasure(reader, *table, found->first);
  return obstacle;
}

std::vector<Obstacle> readObstacles(const Reader& reader, const toml::node& node) {
  const toml::array* array = node.as_array();
  if (!array) reader.refuse(node, "tables, each under [[obstacle]]");
  std::vector<Obstacle> obstacles;
  for (const toml::node& entry : *array) obstacles.push_back(readObstacle(reader, entry));
  return obstacles;
}

// ---- the file

toml::table parse(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw inputErrorAt({path}, "there is no such file; name a scene file, like scene.toml");
  }
  try {
    return toml::parse_file(path.string());
  } catch (const toml::parse_error& error) {
    throw inputErrorAt(Reader(path).at(error.source()),
                       fmt::format("this is no TOML: {}", error.description()));
  }
}

}  // namespace

SceneFile readSceneFile(const std::filesystem::path& path) {
  const Reader reader(path);
  const toml::table root = parse(path);
  SceneFile file;
  file.path = path;
  for (const auto& [name, node] : root) {
    if (std::find(kTables.begin(), kTables.end(), name.str()) == kTables.end()) {
      reader.refuseKey(name, "table", kTables);
    }
    if (name == "timeline") {
      file.timeline = readTimeline(reader, node);
      continue;
    }
    if (name == "obstacle") {
      file.obstacles = readObstacles(reader, node);
      continue;
    }
    const toml::table* table = node.as_table();
    if (!table) reader.refuse(node, fmt::format("a table, [{}]", name.str()));
    for (const auto& [key, value] : *table) {
      file.settings.push_back(readSetting(reader, std::string(name.str()), key, value));
    }
  }
  return file;
}

}  // namespace kirireel
