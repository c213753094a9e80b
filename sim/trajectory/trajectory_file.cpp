// Samples as long arrays. Angular velocities come from the rotation vector between two samples:
// axis times angle of to * from^-1, divided by the time between them. This is exact for a rotation
// at constant speed about a fixed axis, and of second order otherwise.
#include "sim/trajectory/trajectory_file.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "sim/base/files.h"
#include "sim/base/interruption.h"
#include "sim/formats/text_table.h"
#include "sim/model/sheet_frame.h"
#include "sim/scene/scene_parts.h"
#include "sim/trajectory/array_file.h"

namespace kirireel::trajectory {

// Quaternions are stored as w, x, y, z; Eigen's own order is x, y, z, w.
void SampleTable::append(const Sample& sample) {
  brickCount_ = sample.poses.size();
  times_.push_back(sample.time);
  for (const Pose& pose : sample.poses) {
    const Vector3& at = pose.position;
    const Quaternion& turn = pose.rotation;
    positions_.insert(positions_.end(), {at.x(), at.y(), at.z()});
    rotations_.insert(rotations_.end(), {turn.w(), turn.x(), turn.y(), turn.z()});
  }
  jointGaps_.push_back(sample.jointGap);
  targetErrors_.push_back(sample.targetError);
  penetrations_.push_back(sample.penetration);
  pinned_.push_back(sample.pinned);
  steps_.push_back(sample.steps);
  mechanics_.push_back(sample.mechanics);
}

Poses SampleTable::poses(std::size_t index) const {
  Poses poses;
  poses.reserve(brickCount_);
  for (std::size_t row = index * brickCount_; row < (index + 1) * brickCount_; ++row) {
    const double* turn = &rotations_[4 * row];
    poses.push_back({Vector3(&positions_[3 * row]), {turn[0], turn[1], turn[2], turn[3]}});
  }
  return poses;
}

Sample SampleTable::sample(std::size_t index) const {
  return {times_[index],        poses(index),   jointGaps_[index], targetErrors_[index],
          penetrations_[index], pinned_[index], steps_[index],     mechanics_[index]};
}

std::vector<double> SampleTable::velocities() const {
  std::vector<double> velocities;
  velocities.reserve(size() * brickCount_ * 6);
  for (std::size_t i = 0; i < size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1;
    const std::size_t after = std::min(i + 1, size() - 1);
    const double seconds =
        std::max(times_[after] - times_[before], 1e-300);  // one sample: 0 / this
    const Poses from = poses(before);
    const Poses to = poses(after);
    for (std::size_t k = 0; k < brickCount_; ++k) {
      const Vector3 linear = (to[k].position - from[k].position) / seconds;
      const Vector3 angular = turnBetween(from[k].rotation, to[k].rotation) / seconds;
      velocities.insert(velocities.end(), linear.begin(), linear.end());
      velocities.insert(velocities.end(), angular.begin(), angular.end());
    }
  }
  return velocities;
}

SampleTable readSamples(const TrajectoryReader& run) {
  SampleTable table;
  for (std::size_t i = 0; i < run.times().size(); ++i) table.append(run.sample(i));
  return table;
}

// ------------------------------------------------------------------------------------------------
// Trajectories written sample by sample. All arrays that grow are created before the first sample,
// except those of mechanics: only the first sample shows whether a run has any. The file grows
// under a temporary name (files.h) and is renamed when it is complete.
//
// A file is self-contained: it includes the model, the bricks, the ground, obstacles and springs.
// Pictures need neither the scene nor the program that made it. Names and units are in
// trajectory_file.h, which the reader shares.

using layout::arrayOf;

namespace {

void append(std::vector<double>& numbers, const Vector3& vector) {
  numbers.insert(numbers.end(), vector.data(), vector.data() + 3);
}

// x, y and z of all vertices, tile by tile.
std::vector<double> flatten(const std::vector<model::Tile>& tiles) {
  std::vector<double> numbers;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) append(numbers, vertex);
  }
  return numbers;
}

/// One field of all bricks, point by point.
std::vector<double> flatten(const std::vector<brick::Brick>& bricks,
                            std::vector<Vector3> brick::Brick::*field) {
  std::vector<double> numbers;
  for (const brick::Brick& brick : bricks) {
    for (const Vector3& point : brick.*field) append(numbers, point);
  }
  return numbers;
}

std::vector<double> flatten(const std::vector<brick::Brick>& bricks, double brick::Brick::*field) {
  std::vector<double> numbers;
  for (const brick::Brick& brick : bricks) numbers.push_back(brick.*field);
  return numbers;
}

// Nine numbers per brick, kg m^2, about its centre of mass in its own axes.
std::vector<double> inertias(const std::vector<brick::Brick>& bricks) {
  std::vector<double> numbers;
  // The matrix is symmetric: rows and columns are equal.
  for (const brick::Brick& brick : bricks) {
    numbers.insert(numbers.end(), brick.inertia.data(), brick.inertia.data() + 9);
  }
  return numbers;
}

void writeArray(ArrayWriter& file, const std::string& name, const std::vector<double>& numbers,
                const Shape& shape, const char* unit) {
  file.write(name, std::span<const double>(numbers), shape);
  file.setAttribute(name, "unit", std::string(unit));
}

/// Points of all tiles, metres.
void writePoints(ArrayWriter& file, const std::string& name, const std::vector<double>& numbers) {
  writeArray(file, name, numbers, {numbers.size() / 3, 3}, "m");
}

void writeJoints(ArrayWriter& file, const std::vector<model::Joint>& joints) {
  std::vector<int> rows;
  std::vector<double> apart;
  for (const model::Joint& joint : joints) {
    rows.insert(rows.end(), {joint.a.tile, joint.a.vertex, joint.b.tile, joint.b.vertex,
                             static_cast<int>(joint.face), static_cast<int>(joint.kind)});
    append(apart, joint.apart);
  }
  file.write("model/joints", std::span<const int>(rows), {joints.size(), layout::kJointColumns});
  file.setAttribute("model/joints", "columns",
                    std::string("tile a, vertex a, tile b, vertex b, face (1 bottom, 2 top, 3 "
                                "both), kind (0 pivot, 1 link, 2 fixed)"));
  writePoints(file, "model/joint_apart", apart);
  std::vector<int> within;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    if (joints[k].isWithinTile) within.push_back(static_cast<int>(k));
  }
  if (!within.empty()) {
    file.write("model/joints_within_tiles", std::span<const int>(within), {within.size()});
  }
  std::vector<int> necked;
  std::vector<double> necks;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const model::Neck& neck = joints[k].neck;
    if (!neck) continue;
    necked.push_back(static_cast<int>(k));
    necks.insert(necks.end(), {neck.width, neck.length, neck.kerf});
  }
  if (necked.empty()) return;
  file.write("model/necked_joints", std::span<const int>(necked), {necked.size()});
  writeArray(file, "model/necks", necks, {necked.size(), 3}, "m");
  file.setAttribute("model/necks", "columns", std::string("width, length, kerf"));
}

// The vertex count of each tile, which splits the flat list of vertices into tiles.
std::vector<int> sizesOf(const std::vector<model::Tile>& tiles) {
  std::vector<int> sizes;
  for (const model::Tile& tile : tiles) sizes.push_back(static_cast<int>(tile.vertices.size()));
  return sizes;
}

/// The tiles whose vertices are in reversed order in the model's file.
std::vector<int> reversedTiles(const model::FileOrder& order) {
  std::vector<int> tiles;
  for (std::size_t i = 0; i < order.isReversed.size(); ++i) {
    if (order.isReversed[i]) tiles.push_back(static_cast<int>(i));
  }
  return tiles;
}

/// Vertices, edges and faces of the model's FOLD file. The targets' own angles are not needed: a
/// run has the targets themselves.
void writeSheet(ArrayWriter& file, const model::FoldSheet& sheet) {
  const auto writeLists = [&](const std::string& name, const std::vector<std::vector<int>>& lists) {
    std::vector<int> sizes, entries;
    for (const std::vector<int>& list : lists) {
      sizes.push_back(static_cast<int>(list.size()));
      entries.insert(entries.end(), list.begin(), list.end());
    }
    file.write(name + "_sizes", std::span<const int>(sizes), {sizes.size()});
    file.write(name, std::span<const int>(entries), {entries.size()});
  };
  std::vector<double> vertices, angles;
  for (const Vector3& vertex : sheet.vertices) append(vertices, vertex);
  std::vector<int> edges;
  for (const model::Crease& crease : sheet.creases) {
    edges.insert(edges.end(), {crease.from, crease.to, crease.assignment});
    angles.push_back(crease.foldAngle.value_or(layout::kNoAngle));
  }
  file.addGroup("model/sheet");
  writePoints(file, "model/sheet/vertices", vertices);
  file.write("model/sheet/edges", std::span<const int>(edges), {angles.size(), 3});
  file.setAttribute("model/sheet/edges", "columns",
                    std::string("two vertices, letter of FOLD as its ASCII code"));
  writeArray(file, "model/sheet/fold_angles", angles, {angles.size()}, "degrees");
  writeLists("model/sheet/faces", sheet.faces);
  writeLists("model/sheet/outlines", sheet.outlines);
  file.write("model/sheet/face_tiles", std::span<const int>(sheet.tileOf), {sheet.tileOf.size()});
  for (const auto& [name, flag] : layout::kSheetFlags) {
    file.setAttribute("model/sheet", name, sheet.*flag ? 1.0 : 0.0);
  }
}

// Everything that the reader needs to restore the model, including its file's order.
void writeModel(ArrayWriter& file, const model::Model& model) {
  file.addGroup("model");
  file.setAttribute("model", "name", model.name);
  // Unit of the model's files and of exports; arrays are in metres.
  file.setAttribute("model", "unit", model.unit.name);
  if (model.rounding > 0) file.setAttribute("model", "rounding", model.rounding);
  file.write("model/tile_sizes", std::span<const int>(sizesOf(model.tiles)), {model.tiles.size()});
  writePoints(file, "model/vertices", flatten(model.tiles));
  if (model.target) writePoints(file, "model/target", flatten(*model.target));
  for (std::size_t k = 0; k < model.waypoints.size(); ++k) {
    writePoints(file, layout::waypoint(k), flatten(model.waypoints[k]));
  }
  if (model.drawing) writeSheet(file, *model.drawing);
  writeJoints(file, model.joints);
  if (model.fileOrder.countsFrom != 0) {
    file.setAttribute("model", "counts_from", model.fileOrder.countsFrom);
  }
  if (const std::vector<int> reversed = reversedTiles(model.fileOrder); !reversed.empty()) {
    file.write("model/reversed_tiles", std::span<const int>(reversed), {reversed.size()});
  }
  if (!model.foldAngles.empty()) {
    std::vector<int> tiles;
    std::vector<double> angles;
    for (const auto& [pair, angle] : model.foldAngles) {
      tiles.insert(tiles.end(), {pair.first, pair.second});
      angles.push_back(angle);
    }
    file.write("model/fold_tiles", std::span<const int>(tiles), {angles.size(), 2});
    file.write("model/fold_angles", std::span<const double>(angles), {angles.size()});
  }
  if (model.pulledTiles) {
    file.write("model/pulled_tiles", std::span<const int>(*model.pulledTiles),
               {model.pulledTiles->size()});
  }
}

void writeBricks(ArrayWriter& file, const std::vector<brick::Brick>& bricks,
                 const brick::BrickRule& rule) {
  file.addGroup("bricks");
  file.setAttribute("bricks", "rule_thickness", rule.thickness);
  file.setAttribute("bricks", "rule_mass",
                    std::string(rule.mass == brick::MassRule::Unit ? "unit" : "prism"));
  file.setAttribute("bricks", "rule_density", rule.density);
  const std::size_t count = bricks.size();
  writePoints(file, "bricks/bottom", flatten(bricks, &brick::Brick::bottom));
  writePoints(file, "bricks/top", flatten(bricks, &brick::Brick::top));
  std::vector<double> normals;
  for (const brick::Brick& brick : bricks) append(normals, brick.normal);
  writeArray(file, "bricks/normal", normals, {count, 3}, "1");
  writeArray(file, "bricks/thickness", flatten(bricks, &brick::Brick::thickness), {count}, "m");
  writeArray(file, "bricks/volume", flatten(bricks, &brick::Brick::volume), {count}, "m^3");
  writeArray(file, "bricks/mass", flatten(bricks, &brick::Brick::mass), {count}, "kg");
  writeArray(file, "bricks/inertia", inertias(bricks), {count, 3, 3}, "kg m^2");
}

// Faces in the world's axes, metres. A run without obstacles has no such group.
void writeObstacles(ArrayWriter& file, const std::vector<model::Tile>& faces) {
  if (faces.empty()) return;
  file.addGroup("obstacles");
  file.write("obstacles/face_sizes", std::span<const int>(sizesOf(faces)), {faces.size()});
  writePoints(file, "obstacles/vertices", flatten(faces));
}

/// Each type is a group: the bricks of each pair, and the columns of the type.
void writePairForce(ArrayWriter& file, const brick::PairForce& force) {
  const std::string group = force.name().group;
  const std::size_t count = force.size();
  std::vector<int> bricks;
  for (std::size_t pair = 0; pair < count; ++pair) {
    const auto [brickA, brickB] = force.bricks(pair);
    bricks.insert(bricks.end(), {brickA, brickB});
  }
  file.addGroup(group);
  file.write(group + "/bricks", std::span<const int>(bricks), {count, 2});
  for (const brick::PairColumn& column : force.columns()) {
    const std::string name = group + "/" + column.name;
    const Shape shape = column.width == 1 ? Shape{count} : Shape{count, column.width};
    if (column.isWhole) {
      const std::vector<int> numbers(column.numbers.begin(), column.numbers.end());
      file.write(name, std::span<const int>(numbers), shape);
    } else {
      writeArray(file, name, column.numbers, shape, column.unit.c_str());
    }
  }
}

/// Appends poses to two lists of numbers.
void appendPoses(const Poses& poses, std::vector<double>& positions,
                 std::vector<double>& rotations) {
  for (const Pose& pose : poses) {
    append(positions, pose.position);
    const Quaternion& turn = pose.rotation;
    rotations.insert(rotations.end(), {turn.w(), turn.x(), turn.y(), turn.z()});
  }
}

// One time and one line of text per event. A run without events has empty arrays.
void writeEvents(ArrayWriter& file, const std::vector<Event>& events) {
  std::vector<double> times;
  std::vector<std::string> texts;
  for (const Event& event : events) {
    times.push_back(event.time);
    texts.push_back(event.text);
  }
  file.addGroup("events");
  writeArray(file, "events/time", times, {times.size()}, "s");
  file.write("events/text", texts);
}

void writeFigureStates(ArrayWriter& file, const std::vector<FigureState>& states,
                       std::size_t bricks) {
  std::vector<std::string> names;
  std::vector<double> times;
  std::vector<double> positions;
  std::vector<double> rotations;
  for (const FigureState& state : states) {
    names.push_back(state.figure);
    times.push_back(state.time);
    appendPoses(state.poses, positions, rotations);
  }
  file.addGroup("figures");
  file.write("figures/name", names);
  writeArray(file, "figures/time", times, {states.size()}, "s");
  writeArray(file, "figures/position", positions, {states.size(), bricks, 3}, "m");
  writeArray(file, "figures/rotation", rotations, {states.size(), bricks, 4}, "1");
}

void writePanels(ArrayWriter& file, const LoadedPanels& sheet) {
  std::vector<int> vertexNodes, barNodes, foldNodes, foldTiles;
  std::vector<double> lengths, barStiffness, foldStiffness, rests;
  for (const std::vector<int>& nodes : sheet.tileNodes) {
    vertexNodes.insert(vertexNodes.end(), nodes.begin(), nodes.end());
  }
  for (const Bar& bar : sheet.bars) {
    barNodes.insert(barNodes.end(), {bar.nodeA, bar.nodeB});
    lengths.push_back(bar.rest);
    barStiffness.push_back(bar.stiffness);
  }
  for (const Fold& fold : sheet.folds) {
    foldNodes.insert(foldNodes.end(), fold.nodes.begin(), fold.nodes.end());
    foldTiles.insert(foldTiles.end(), fold.tiles.begin(), fold.tiles.end());
    foldStiffness.push_back(fold.stiffness);
    rests.push_back(fold.rest);
  }
  std::vector<double> times, nodes, strains, angles;
  for (const PanelState& state : sheet.states) {
    times.push_back(state.time);
    for (const Vector3& node : state.nodes) append(nodes, node);
    strains.insert(strains.end(), state.strains.begin(), state.strains.end());
    angles.insert(angles.end(), state.angles.begin(), state.angles.end());
  }
  const std::size_t bars = sheet.bars.size(), folds = sheet.folds.size();
  const std::size_t states = sheet.states.size();
  file.addGroup(layout::kPanels);
  file.write(layout::kVertexNodes, std::span<const int>(vertexNodes), {vertexNodes.size()});
  file.write(layout::kBarNodes, std::span<const int>(barNodes), {bars, 2});
  writeArray(file, layout::kBarLengths, lengths, {bars}, "m");
  writeArray(file, layout::kBarStiffness, barStiffness, {bars}, "N/m");
  file.write(layout::kFoldNodes, std::span<const int>(foldNodes), {folds, 4});
  file.write(layout::kFoldTiles, std::span<const int>(foldTiles), {folds, 2});
  writeArray(file, layout::kFoldStiffness, foldStiffness, {folds}, "N m/rad");
  writeArray(file, layout::kFoldRests, rests, {folds}, "rad");
  writeArray(file, layout::kPanelTimes, times, {states}, "s");
  writeArray(file, layout::kPanelNodes, nodes, {states, nodes.size() / (3 * states), 3}, "m");
  writeArray(file, layout::kBarStrains, strains, {states, bars}, "1");
  writeArray(file, layout::kFoldAngles, angles, {states, folds}, "rad");
}

void addSeries(ArrayWriter& file, const std::string& name, const Shape& rowShape,
               const char* unit) {
  file.addSeries(name, rowShape);
  file.setAttribute(name, "unit", std::string(unit));
}

}  // namespace

struct TrajectoryWriter::Internals {
  Internals(const std::filesystem::path& path, const Subject& subject,
            std::unique_ptr<SampleMeter> measuring)
      : pending(path),
        file(pending.path(), path),
        brickCount(subject.bricks.size()),
        jointCount(subject.model.joints.size()),
        meter(std::move(measuring)) {
    if (meter) channels = meter->channels();
  }

  void addCurves();
  void addMechanics();
  void append(double time, const Mechanics& mechanics);
  void appendCurves(const Sample& sample);

  PendingFile pending;
  ArrayWriter file;
  std::size_t brickCount;
  std::size_t jointCount;
  std::unique_ptr<SampleMeter> meter;
  std::vector<Channel> channels;
  std::size_t samples = 0;
};

void TrajectoryWriter::Internals::addCurves() {
  if (channels.empty()) return;
  file.addGroup("curves");
  for (const Channel& channel : channels) {
    const std::string name = "curves/" + channel.name;
    addSeries(file, name, channel.width > 0 ? Shape{channel.width} : Shape{}, channel.unit.c_str());
    file.setAttribute(name, "description", channel.description);
  }
}

/// Created with the first sample that has mechanics.
void TrajectoryWriter::Internals::addMechanics() {
  file.addGroup("energy");
  for (const auto& energy : layout::kEnergies) {
    addSeries(file, arrayOf(energy), {}, energy.unit);
    file.setAttribute(arrayOf(energy), "description", std::string(energy.meaning));
  }
  if (jointCount > 0) {
    file.addGroup("forces");
    addSeries(file, layout::kJointForces, {jointCount, 3}, "N");
    file.setAttribute(layout::kJointForces, "description",
                      std::string("on tile a of each joint, of least norm"));
    addSeries(file, layout::kIndeterminate, {jointCount}, "1");
    file.setAttribute(layout::kIndeterminate, "description",
                      std::string("1 where other forces of the joint keep the balance too"));
  }
  file.addGroup("holds");
  addSeries(file, layout::kHoldTimes, {}, "s");
  addSeries(file, layout::kHoldKinds, {}, "1");
  file.setAttribute(layout::kHoldKinds, "description", std::string("0 pin, 1 grip, 2 contact"));
  addSeries(file, layout::kHoldTiles, {2}, "1");
  file.setAttribute(
      layout::kHoldTiles, "description",
      std::string("tile, and for a contact the other: a tile, -1 ground, -2 - k obstacle k"));
  for (const auto& vector : layout::kHolds) addSeries(file, arrayOf(vector), {3}, vector.unit);
}

// One row in each series of energies and forces, and one row per hold.
void TrajectoryWriter::Internals::append(double time, const Mechanics& mechanics) {
  for (const auto& energy : layout::kEnergies)
    file.append(arrayOf(energy), {&(mechanics.energies.*energy.member), 1});
  if (jointCount > 0) {
    std::vector<double> forces;
    for (const Vector3& force : mechanics.jointForces) trajectory::append(forces, force);
    file.append(layout::kJointForces, forces);
    const std::vector<double> marks(mechanics.isIndeterminate.begin(),
                                    mechanics.isIndeterminate.end());
    file.append(layout::kIndeterminate, marks);
  }
  std::vector<double> kinds, tiles;
  for (const Hold& hold : mechanics.holds) {
    kinds.push_back(static_cast<double>(hold.kind));
    tiles.insert(tiles.end(), {static_cast<double>(hold.tile), static_cast<double>(hold.other)});
  }
  // Holds are rows of their own, with the sample's time, because their number differs between
  // samples.
  file.append(layout::kHoldTimes, std::vector<double>(kinds.size(), time));
  file.append(layout::kHoldKinds, kinds);
  file.append(layout::kHoldTiles, tiles);
  for (const auto& vector : layout::kHolds) {
    std::vector<double> entries;
    for (const Hold& hold : mechanics.holds) trajectory::append(entries, hold.*vector.member);
    file.append(arrayOf(vector), entries);
  }
}

void TrajectoryWriter::Internals::appendCurves(const Sample& sample) {
  if (!meter) return;
  const std::vector<double> values = meter->measure(sample);
  const double* next = values.data();
  for (const Channel& channel : channels) {
    const std::size_t count = channel.width > 0 ? channel.width : 1;
    file.append("curves/" + channel.name, {next, count});
    next += count;
  }
}

TrajectoryWriter::TrajectoryWriter(const std::filesystem::path& path, const Subject& subject,
                                   std::unique_ptr<SampleMeter> meter)
    : internals_(std::make_unique<Internals>(path, subject, std::move(meter))) {
  ArrayWriter& file = internals_->file;
  file.setAttribute("/", "format", std::string(layout::kFormat));
  file.setAttribute("/", "format_version", layout::kFormatVersion);
  file.write("settings", {subject.settings});
  writeModel(file, subject.model);
  writeBricks(file, subject.bricks, subject.brickRule);
  if (subject.ground) {
    file.addGroup("ground");
    file.setAttribute("ground", "height", subject.ground->height);
    file.setAttribute("ground", "friction", subject.ground->friction);
  }
  writeObstacles(file, subject.obstacles);
  for (const std::shared_ptr<const brick::PairForce>& force : subject.pairForces) {
    writePairForce(file, *force);
  }
  addSeries(file, "time", {}, "s");
  addSeries(file, "position", {subject.bricks.size(), 3}, "m");
  addSeries(file, "rotation", {subject.bricks.size(), 4}, "1");
  file.setAttribute("rotation", "columns", std::string("w, x, y, z"));
  file.addGroup("measures");
  for (const auto& measure : layout::kMeasures) addSeries(file, arrayOf(measure), {}, measure.unit);
  file.addGroup("steps");
  for (const auto& column : layout::kStepColumns) addSeries(file, arrayOf(column), {}, column.unit);
  for (const StepFigure& figure : kStepFigures) addSeries(file, arrayOf(figure), {}, figure.unit);
  internals_->addCurves();
}

TrajectoryWriter::~TrajectoryWriter() = default;

// Steps are written with the sample that ends them.
void TrajectoryWriter::append(const Sample& sample) {
  ArrayWriter& file = internals_->file;
  std::vector<double> positions;
  std::vector<double> rotations;
  positions.reserve(3 * sample.poses.size());
  rotations.reserve(4 * sample.poses.size());
  appendPoses(sample.poses, positions, rotations);
  file.append("time", {&sample.time, 1});
  file.append("position", positions);
  file.append("rotation", rotations);
  for (const auto& measure : layout::kMeasures)
    file.append(arrayOf(measure), {&(sample.*measure.member), 1});
  for (const auto& column : layout::kStepColumns) {
    std::vector<double> entries;
    for (const StepRecord& step : sample.steps) entries.push_back(step.*column.member);
    file.append(arrayOf(column), entries);
  }
  for (const StepFigure& figure : kStepFigures) {
    std::vector<double> entries;
    for (const StepRecord& step : sample.steps) entries.push_back(figure.get(step.took));
    file.append(arrayOf(figure), entries);
  }
  if (sample.mechanics && internals_->samples == 0) internals_->addMechanics();
  if (sample.mechanics) internals_->append(sample.time, *sample.mechanics);
  internals_->appendCurves(sample);
  ++internals_->samples;
}

void TrajectoryWriter::finish(const TrajectoryEnd& end) {
  ArrayWriter& file = internals_->file;
  writeEvents(file, end.events);
  writeFigureStates(file, end.figureStates, internals_->brickCount);
  if (end.panels) writePanels(file, *end.panels);
  file.write("findings", {end.findings});
  // Before the file is renamed: a full disk is detected here.
  file.close();
  internals_->pending.commit();
}

// ------------------------------------------------------------------------------------------------
// Trajectories read as untrusted input. All assumptions of pictures, meshes and measures are
// checked here. A damaged file gives one message, not a wrong picture.
//
// Small data are read at once (the model, the bricks, times, measures, steps, holds). Poses and
// joint forces are read sample by sample, because they may not fit in memory. `FileRun` and
// `MemoryRun` give the same results for a file and for a run in memory.

namespace {

using layout::kEnergies;
using layout::kMeasures;
using layout::kStepColumns;

/// No brick farther away is drawn or meshed, metres. Runs end at a thousand model sizes, and models
/// extend up to kMaxCoordinate.
constexpr double kFarthest = 1e4 * formats::kMaxCoordinate;

/// All entries of an array that must have this shape and be finite.
std::vector<double> finiteNumbers(const ArrayReader& file, const std::string& name,
                                  const Shape& shape) {
  const Shape found = file.shape(name);
  if (found != shape) {
    file.refuse(fmt::format("the array {} has {} entries instead of {}, or another shape", name,
                            entryCount(found), entryCount(shape)));
  }
  std::vector<double> entries = file.doubles(name);
  if (!std::ranges::all_of(entries, [](double entry) { return std::isfinite(entry); })) {
    file.refuse(fmt::format("the array {} has a number that is not finite", name));
  }
  return entries;
}

/// Reads the subject of a trajectory. Each claim of the file is checked before it is used.
class SubjectReader {
 public:
  explicit SubjectReader(const ArrayReader& file) : file_(file) {}

  // The order matters: sizes of tiles first, then the data that refer to them.
  Subject read() {
    requireFormat();
    Subject subject;
    // Every later shape follows from these sizes.
    sizes_ = readSizes("model/tile_sizes");
    subject.settings = oneText("settings");
    subject.model = readModel();
    readBricks(subject);
    if (file_.has("ground")) {
      subject.ground = scene::Ground{file_.numberAttribute("ground", "height"),
                                     file_.numberAttribute("ground", "friction")};
    }
    if (file_.has("obstacles")) {
      subject.obstacles = tiles("obstacles/vertices", readSizes("obstacles/face_sizes"));
    }
    for (const scene::PairForceKind& kind : scene::pairForceKinds()) {
      if (!file_.has(kind.name.group)) continue;
      subject.pairForces.add(kind.read(PairGroup(*this, kind.name.group, subject.model)));
    }
    return subject;
  }

 private:
  void requireFormat() const {
    if (!file_.hasAttribute("/", "format") ||
        file_.textAttribute("/", "format") != layout::kFormat) {
      file_.refuse("this HDF5 file is not a trajectory");
    }
    const double version = file_.numberAttribute("/", "format_version");
    if (version != layout::kFormatVersion) {
      file_.refuse(fmt::format("the format's version is {:g}, but this program reads {:g}", version,
                               layout::kFormatVersion));
    }
  }

  // Vertex count of each polygon, >= 3.
  std::vector<std::size_t> readSizes(const std::string& name) const {
    std::vector<std::size_t> sizes;
    for (const int size : file_.integers(name)) {
      if (size < 3) file_.refuse(fmt::format("a tile in {} has {} vertices", name, size));
      sizes.push_back(static_cast<std::size_t>(size));
    }
    if (sizes.empty()) file_.refuse(fmt::format("{} has no tile", name));
    return sizes;
  }

  std::string oneText(const std::string& name) const {
    const std::vector<std::string> texts = file_.texts(name);
    return texts.empty() ? "" : texts.front();
  }

  std::vector<double> numbers(const std::string& name, const Shape& shape) const {
    return finiteNumbers(file_, name, shape);
  }

  /// An array of points, split into tiles.
  std::vector<std::vector<Vector3>> pointsOfTiles(const std::string& name,
                                                  const std::vector<std::size_t>& sizes) const {
    const std::size_t count = std::accumulate(sizes.begin(), sizes.end(), std::size_t{0});
    const std::vector<double> entries = numbers(name, {count, 3});
    std::vector<std::vector<Vector3>> tiles;
    const double* next = entries.data();
    for (const std::size_t size : sizes) {
      std::vector<Vector3>& points = tiles.emplace_back();
      for (std::size_t k = 0; k < size; ++k, next += 3) points.emplace_back(next);
    }
    return tiles;
  }

  std::vector<model::Tile> tiles(const std::string& name,
                                 const std::vector<std::size_t>& sizes) const {
    std::vector<model::Tile> tiles;
    for (std::vector<Vector3>& points : pointsOfTiles(name, sizes))
      tiles.push_back({std::move(points)});
    return tiles;
  }

  // A corner, checked to exist.
  model::Corner corner(int tile, int vertex) const {
    const bool exists = tile >= 0 && static_cast<std::size_t>(tile) < sizes_.size() &&
                        vertex >= 0 &&
                        static_cast<std::size_t>(vertex) < sizes_[static_cast<std::size_t>(tile)];
    if (!exists) {
      file_.refuse(fmt::format("model/joints names vertex {} of tile {}, which does not exist",
                               vertex, tile));
    }
    return {tile, vertex};
  }

  /// A value of model/joints, checked to be in a range.
  int within(int value, int least, int most, const char* column) const {
    if (value < least || value > most) {
      file_.refuse(fmt::format("model/joints has the {} {} instead of {} to {}", column, value,
                               least, most));
    }
    return value;
  }

  // Rows of six integers, and the vectors of links and fixed joints.
  std::vector<model::Joint> readJoints() const {
    constexpr int kKinds = static_cast<int>(model::kJointKinds.size());
    const std::vector<int> rows = file_.integers("model/joints");
    const std::size_t count = rows.size() / layout::kJointColumns;
    if (rows.size() != layout::kJointColumns * count) {
      file_.refuse(fmt::format("model/joints does not have {} columns", layout::kJointColumns));
    }
    const std::vector<double> apart = numbers("model/joint_apart", {count, 3});
    std::vector<model::Joint> joints;
    for (std::size_t k = 0; k < count; ++k) {
      const int* row = &rows[layout::kJointColumns * k];
      joints.push_back({corner(row[0], row[1]), corner(row[2], row[3]),
                        static_cast<model::JointFace>(within(row[4], 1, 3, "face")),
                        static_cast<model::JointKind>(within(row[5], 0, kKinds - 1, "kind")),
                        Vector3(&apart[3 * k])});
    }
    // Calls visit(k, joint) for each joint that an array names.
    const auto forEachNamed = [&](const char* name, const auto& visit) {
      if (!file_.has(name)) return;
      std::size_t k = 0;
      for (const int joint : file_.integers(name)) {
        if (joint < 0 || static_cast<std::size_t>(joint) >= count) {
          file_.refuse(fmt::format("{} names joint {}, which does not exist", name, joint));
        }
        visit(k++, joints[static_cast<std::size_t>(joint)]);
      }
    };
    forEachNamed("model/joints_within_tiles",
                 [](std::size_t, model::Joint& joint) { joint.isWithinTile = true; });
    if (!file_.has("model/necked_joints")) return joints;
    const std::size_t necked = file_.integers("model/necked_joints").size();
    const std::vector<double> necks = numbers("model/necks", {necked, 3});
    forEachNamed("model/necked_joints", [&](std::size_t k, model::Joint& joint) {
      joint.neck = {necks[3 * k], necks[3 * k + 1], necks[3 * k + 2]};
    });
    return joints;
  }

  std::vector<int> readTileNumbers(const char* name) const {
    std::vector<int> tiles = file_.integers(name);
    for (const int tile : tiles) static_cast<void>(corner(tile, 0));
    return tiles;
  }

  /// A group of pairs.
  class PairGroup : public brick::PairReader {
   public:
    PairGroup(const SubjectReader& reader, std::string group, const model::Model& model)
        : reader_(reader), group_(std::move(group)), model_(model) {}

    std::vector<std::pair<int, int>> bricks() const override {
      const std::vector<int> numbers = wholeNumbers("bricks");
      if (numbers.size() % 2 != 0) {
        refuse(fmt::format("{}/bricks does not have two bricks per pair", group_));
      }
      std::vector<std::pair<int, int>> pairs;
      for (std::size_t k = 0; k < numbers.size(); k += 2) {
        for (const int brick : {numbers[k], numbers[k + 1]}) {
          static_cast<void>(reader_.corner(brick, 0));
        }
        pairs.emplace_back(numbers[k], numbers[k + 1]);
      }
      return pairs;
    }

    std::vector<double> numbers(const std::string& column, std::size_t pairs,
                                std::size_t width) const override {
      return reader_.numbers(nameOf(column), width == 1 ? Shape{pairs} : Shape{pairs, width});
    }

    std::vector<int> wholeNumbers(const std::string& column) const override {
      return reader_.file_.integers(nameOf(column));
    }

    std::size_t joints() const override { return model_.joints.size(); }

    Vector3 normal() const override {
      return model::sheetFrame(model_).value_or(model::SheetFrame{}).normal;
    }

    [[noreturn]] void refuse(const std::string& what) const override { reader_.file_.refuse(what); }

   private:
    std::string nameOf(const std::string& column) const { return group_ + "/" + column; }

    const SubjectReader& reader_;
    std::string group_;
    const model::Model& model_;
  };

  model::FileOrder readFileOrder() const {
    model::FileOrder order;
    if (file_.hasAttribute("model", "counts_from")) {
      order.countsFrom = file_.numberAttribute("model", "counts_from") == 1 ? 1 : 0;
    }
    if (!file_.has("model/reversed_tiles")) return order;
    order.isReversed.resize(sizes_.size());
    for (const int tile : readTileNumbers("model/reversed_tiles")) order.isReversed[tile] = true;
    return order;
  }

  std::map<std::pair<int, int>, double> readFoldAngles() const {
    const std::vector<int> tiles = readTileNumbers("model/fold_tiles");
    const std::vector<double> angles = numbers("model/fold_angles", {tiles.size() / 2});
    std::map<std::pair<int, int>, double> folds;
    for (std::size_t k = 0; k < angles.size(); ++k) {
      folds[{tiles[2 * k], tiles[2 * k + 1]}] = angles[k];
    }
    return folds;
  }

  /// Whole numbers, checked to be in [0, count).
  std::vector<int> numbersBelow(const std::string& name, std::size_t count) const {
    std::vector<int> entries = file_.integers(name);
    for (const int entry : entries) {
      if (entry >= 0 && static_cast<std::size_t>(entry) < count) continue;
      file_.refuse(fmt::format("{} names {}, which does not exist", name, entry));
    }
    return entries;
  }

  model::FoldSheet readSheet() const {
    const auto lists = [&](const std::string& name, std::size_t vertices) {
      const std::vector<int> entries = numbersBelow(name, vertices);
      std::vector<std::vector<int>> result;
      auto next = entries.begin();
      for (const std::size_t size : readSizes(name + "_sizes")) {
        if (static_cast<std::size_t>(entries.end() - next) < size) {
          file_.refuse(fmt::format("{} ends early", name));
        }
        result.emplace_back(next, next + static_cast<std::ptrdiff_t>(size));
        next += static_cast<std::ptrdiff_t>(size);
      }
      return result;
    };
    model::FoldSheet sheet;
    const std::size_t count = file_.shape("model/sheet/vertices").at(0);
    const std::vector<double> places = numbers("model/sheet/vertices", {count, 3});
    for (std::size_t k = 0; k < count; ++k) sheet.vertices.emplace_back(&places[3 * k]);
    const std::vector<int> edges = file_.integers("model/sheet/edges");
    const std::vector<double> angles = numbers("model/sheet/fold_angles", {edges.size() / 3});
    for (std::size_t k = 0; k < angles.size(); ++k) {
      const int* row = &edges[3 * k];
      const bool isThere = std::min(row[0], row[1]) >= 0 &&
                           static_cast<std::size_t>(std::max(row[0], row[1])) < count;
      if (!isThere || !model::isFoldLetter(row[2])) {
        file_.refuse(fmt::format("edge {} of model/sheet has wrong ends or letters", k));
      }
      sheet.creases.push_back({row[0], row[1], static_cast<char>(row[2]), {}});
      if (angles[k] != layout::kNoAngle) sheet.creases.back().foldAngle = angles[k];
    }
    sheet.faces = lists("model/sheet/faces", count);
    sheet.outlines = lists("model/sheet/outlines", count);
    sheet.tileOf = numbersBelow("model/sheet/face_tiles", sheet.outlines.size());
    if (sheet.tileOf.size() != sheet.faces.size()) {
      file_.refuse("model/sheet/face_tiles does not have one tile per face");
    }
    for (const auto& [name, flag] : layout::kSheetFlags) {
      sheet.*flag = file_.numberAttribute("model/sheet", name) != 0;
    }
    return sheet;
  }

  LengthUnit readUnit() const {
    const std::string name = file_.textAttribute("model", "unit");
    const std::optional<LengthUnit> unit = findLengthUnit(name);
    if (!unit) file_.refuse(fmt::format("the model's unit {} is not known", name));
    return *unit;
  }

  model::Model readModel() const {
    model::Model model;
    model.name = file_.textAttribute("model", "name");
    model.unit = readUnit();
    if (file_.hasAttribute("model", "rounding")) {
      model.rounding = file_.numberAttribute("model", "rounding");
    }
    model.tiles = tiles("model/vertices", sizes_);
    if (file_.has("model/target")) model.target = tiles("model/target", sizes_);
    for (std::size_t k = 0; file_.has(layout::waypoint(k)); ++k) {
      model.waypoints.push_back(tiles(layout::waypoint(k), sizes_));
    }
    if (file_.has("model/sheet")) model.drawing = readSheet();
    model.joints = readJoints();
    if (file_.has("model/pulled_tiles")) {
      model.pulledTiles = readTileNumbers("model/pulled_tiles");
    }
    if (file_.has("model/fold_tiles")) model.foldAngles = readFoldAngles();
    model.fileOrder = readFileOrder();
    return model;
  }

  brick::BrickRule readBrickRule() const {
    brick::BrickRule rule;
    rule.thickness = file_.numberAttribute("bricks", "rule_thickness");
    rule.density = file_.numberAttribute("bricks", "rule_density");
    const std::string mass = file_.textAttribute("bricks", "rule_mass");
    if (mass != "unit" && mass != "prism") {
      file_.refuse(fmt::format("the attribute rule_mass is \"{}\" instead of unit or prism", mass));
    }
    rule.mass = mass == "unit" ? brick::MassRule::Unit : brick::MassRule::Prism;
    return rule;
  }

  // Bricks are stored completely: pictures show those of the run, independent of later rules for
  // tiles.
  void readBricks(Subject& subject) const {
    const std::size_t count = sizes_.size();
    subject.brickRule = readBrickRule();
    const std::vector<std::vector<Vector3>> bottoms = pointsOfTiles("bricks/bottom", sizes_);
    const std::vector<std::vector<Vector3>> tops = pointsOfTiles("bricks/top", sizes_);
    const std::vector<double> normals = numbers("bricks/normal", {count, 3});
    const std::vector<double> thicknesses = numbers("bricks/thickness", {count});
    const std::vector<double> volumes = numbers("bricks/volume", {count});
    const std::vector<double> masses = numbers("bricks/mass", {count});
    const std::vector<double> inertia = numbers("bricks/inertia", {count, 3, 3});
    for (std::size_t i = 0; i < count; ++i) {
      brick::Brick brick{bottoms[i], tops[i],   Vector3(&normals[3 * i]), thicknesses[i],
                         volumes[i], masses[i], Matrix3(&inertia[9 * i])};
      if (std::abs(brick.normal.norm() - 1) > kUnitTolerance) {
        file_.refuse(
            fmt::format("the normal of brick {} in bricks/normal is not a unit vector", i));
      }
      requireSolid(brick, i);
      // Convex parts follow from the outline and are not stored.
      brick.parts = brick::partsOfBottom(brick.bottom, brick.normal);
      subject.bricks.push_back(std::move(brick));
    }
  }

  /// In a solid brick the top is above the bottom everywhere, and the bottom is anticlockwise about
  /// the normal.
  void requireSolid(const brick::Brick& brick, std::size_t number) const {
    for (const auto& [value, name] : {std::pair{brick.thickness, "thickness"},
                                      {brick.volume, "volume"},
                                      {brick.mass, "mass"}}) {
      if (value > 0) continue;
      file_.refuse(fmt::format("the {0} of brick {1} in bricks/{0} is {2:g}, but must be positive",
                               name, number, value));
    }
    double lowest = std::numeric_limits<double>::infinity();
    Vector3 area = Vector3::Zero();
    for (std::size_t k = 0; k < brick.bottom.size(); ++k) {
      const Vector3& next = brick.bottom[(k + 1) % brick.bottom.size()];
      lowest = std::min(lowest, brick.normal.dot(brick.top[k] - brick.bottom[k]));
      // Newell's vector: along the normal if the bottom is anticlockwise about it.
      area += brick.bottom[k].cross(next);
    }
    if (lowest > 0 && brick.normal.dot(area) > 0) return;
    file_.refuse(fmt::format(
        "brick {} is inverted: bricks/bottom, bricks/top and bricks/normal are inconsistent",
        number));
  }

  const ArrayReader& file_;
  std::vector<std::size_t> sizes_;  ///< vertices of each tile
};

}  // namespace

/// Data of every run, in a file or in memory.
struct TrajectoryReader::Internals {
  virtual ~Internals() = default;
  virtual Sample sample(std::size_t index) const = 0;
  virtual bool hasMechanics() const = 0;

  Subject subject;
  std::vector<double> times;
  std::vector<StepRecord> steps;
  TrajectoryEnd end;
};

struct TrajectoryReader::FileRun final : Internals {
  explicit FileRun(const std::filesystem::path& path) : file(path) {
    subject = SubjectReader(file).read();
    readTimes();
    readMeasures();
    readEvents();
    if (file.has("energy")) readMechanics();
    readSteps();
    readFigureStates();
    if (file.has(layout::kPanels)) readPanels();
    const std::vector<std::string> texts = file.texts("findings");
    if (!texts.empty()) end.findings = texts.front();
  }

  void requireShape(const std::string& name, const Shape& shape) const {
    if (file.shape(name) == shape) return;
    file.refuse(fmt::format("the array {} does not have an entry for each sample and brick", name));
  }

  // Times, and the shapes that they require of the poses.
  void readTimes() {
    times = file.doubles("time");
    if (times.empty()) file.refuse("there are no samples");
    // Comparisons with NaN are false: NaN is rejected.
    const auto follows = [](double before, double after) { return before < after; };
    const bool rising = std::ranges::adjacent_find(times, std::not_fn(follows)) == times.end() &&
                        std::isfinite(times.front()) && std::isfinite(times.back());
    if (!rising) file.refuse("the times of the samples do not increase");
    requireShape("position", {times.size(), subject.bricks.size(), 3});
    requireShape("rotation", {times.size(), subject.bricks.size(), 4});
  }

  void readMeasures() {
    for (std::size_t k = 0; k < kMeasures.size(); ++k) {
      requireShape(arrayOf(kMeasures[k]), {times.size()});
      measures[k] = file.doubles(arrayOf(kMeasures[k]));
    }
  }

  /// Everything except the joints' forces, which are read with each sample.
  void readMechanics() {
    for (std::size_t k = 0; k < kEnergies.size(); ++k) {
      requireShape(arrayOf(kEnergies[k]), {times.size()});
      energies[k] = file.doubles(arrayOf(kEnergies[k]));
    }
    const std::size_t joints = subject.model.joints.size();
    if (joints > 0) {
      requireShape(layout::kJointForces, {times.size(), joints, 3});
      requireShape(layout::kIndeterminate, {times.size(), joints});
    }
    holdTimes = file.doubles(layout::kHoldTimes);
    if (!std::ranges::is_sorted(holdTimes)) file.refuse("the times of the holds decrease");
    const std::size_t count = holdTimes.size();
    const std::vector<double> kinds = file.doubles(layout::kHoldKinds);
    const std::vector<double> tiles = file.doubles(layout::kHoldTiles);
    std::array<std::vector<double>, layout::kHolds.size()> vectors;
    bool isWhole = kinds.size() == count && tiles.size() == 2 * count;
    for (std::size_t c = 0; c < vectors.size(); ++c) {
      vectors[c] = file.doubles(arrayOf(layout::kHolds[c]));
      isWhole = isWhole && vectors[c].size() == 3 * count;
    }
    if (!isWhole) file.refuse("the arrays in holds differ in length");
    for (std::size_t h = 0; h < count; ++h) {
      holds.push_back(hold(kinds[h], tiles[2 * h], tiles[2 * h + 1]));
      for (std::size_t c = 0; c < vectors.size(); ++c) {
        holds.back().*layout::kHolds[c].member = Vector3(&vectors[c][3 * h]);
      }
    }
  }

  // Types and indices are stored as doubles, as in all series.
  Hold hold(double kind, double tile, double other) const {
    const auto count = static_cast<double>(subject.bricks.size());
    // Comparisons with NaN are false: NaN is rejected.
    const bool makesSense = (kind == 0 || kind == 1 || kind == 2) && tile >= 0 && tile < count &&
                            other < count && other > -1e9;
    if (!makesSense) file.refuse("a row of holds has an unknown kind or tile");
    return {static_cast<HoldKind>(kind),
            static_cast<int>(tile),
            static_cast<int>(other),
            Vector3::Zero(),
            Vector3::Zero(),
            Vector3::Zero()};
  }

  bool hasMechanics() const override { return !energies.front().empty(); }

  // Energies from memory, joint forces from the file.
  Mechanics mechanics(std::size_t index) const {
    Mechanics result;
    for (std::size_t k = 0; k < kEnergies.size(); ++k) {
      result.energies.*kEnergies[k].member = energies[k][index];
    }
    const std::size_t joints = subject.model.joints.size();
    if (joints > 0) {
      const std::vector<double> forces = file.row(layout::kJointForces, index);
      for (std::size_t j = 0; j < joints; ++j) result.jointForces.emplace_back(&forces[3 * j]);
      for (const double mark : file.row(layout::kIndeterminate, index)) {
        result.isIndeterminate.push_back(mark != 0);
      }
    }
    // A hold belongs to the sample with exactly its time: the writer stores both from one number.
    const auto [first, last] = std::equal_range(holdTimes.begin(), holdTimes.end(), times[index]);
    result.holds.assign(holds.begin() + (first - holdTimes.begin()),
                        holds.begin() + (last - holdTimes.begin()));
    return result;
  }

  void readEvents() {
    const std::vector<double> eventTimes = file.doubles("events/time");
    const std::vector<std::string> texts = file.texts("events/text");
    if (eventTimes.size() != texts.size())
      file.refuse("events/time and events/text differ in length");
    for (std::size_t k = 0; k < texts.size(); ++k) end.events.push_back({eventTimes[k], texts[k]});
  }

  /// Entries of an array with one entry per step.
  std::vector<double> stepEntries(const std::string& name) const {
    std::vector<double> entries = file.doubles(name);
    if (entries.size() != steps.size()) {
      file.refuse(fmt::format("the array {} does not have an entry for each step", name));
    }
    return entries;
  }

  // All figures of all steps, a few numbers each.
  void readSteps() {
    steps.resize(file.doubles(arrayOf(kStepColumns.front())).size());
    for (const auto& column : kStepColumns) {
      const std::vector<double> entries = stepEntries(arrayOf(column));
      for (std::size_t k = 0; k < steps.size(); ++k) steps[k].*column.member = entries[k];
    }
    for (const StepFigure& figure : kStepFigures) {
      const std::vector<double> entries = stepEntries(arrayOf(figure));
      for (std::size_t k = 0; k < steps.size(); ++k) figure.set(steps[k].took, entries[k]);
    }
    const auto later = [](const StepRecord& one, const StepRecord& next) {
      return !(one.time < next.time);  // also if one is NaN
    };
    if (std::ranges::adjacent_find(steps, later) != steps.end()) {
      file.refuse("the times of the steps do not increase");
    }
  }

  void readFigureStates() {
    const std::vector<std::string> names = file.texts("figures/name");
    const std::vector<double> stateTimes = file.doubles("figures/time");
    if (stateTimes.size() != names.size())
      file.refuse("figures/name and figures/time differ in length");
    requireShape("figures/position", {names.size(), subject.bricks.size(), 3});
    requireShape("figures/rotation", {names.size(), subject.bricks.size(), 4});
    for (std::size_t k = 0; k < names.size(); ++k) {
      end.figureStates.push_back({names[k], stateTimes[k], poses("figures", k)});
    }
  }

  /// Indices in an array, checked to be in [0, count): `width` for each of its rows.
  std::vector<int> indices(const char* name, std::size_t width, std::size_t count) const {
    std::vector<int> found = file.integers(name);
    const bool areThere = std::ranges::all_of(
        found, [&](int index) { return index >= 0 && static_cast<std::size_t>(index) < count; });
    if (found.size() % width != 0 || !areThere) {
      file.refuse(
          fmt::format("{} does not have {} indices below {} in each row", name, width, count));
    }
    return found;
  }

  void readPanels() {
    LoadedPanels sheet;
    const Shape shape = file.shape(layout::kPanelNodes);
    if (shape.size() != 3 || shape[0] == 0 || shape[1] == 0 || shape[2] != 3) {
      file.refuse(fmt::format("the array {} does not have three numbers for each node",
                              layout::kPanelNodes));
    }
    const std::size_t states = shape[0], nodes = shape[1];
    const std::vector<int> vertexNodes = indices(layout::kVertexNodes, 1, nodes);
    auto next = vertexNodes.begin();
    for (const model::Tile& tile : subject.model.tiles) {
      const auto size = static_cast<std::ptrdiff_t>(tile.vertices.size());
      if (vertexNodes.end() - next < size) {
        file.refuse(fmt::format("{} does not have a node for each vertex", layout::kVertexNodes));
      }
      sheet.tileNodes.emplace_back(next, next + size);
      next += size;
    }
    const std::vector<int> barNodes = indices(layout::kBarNodes, 2, nodes);
    const std::vector<int> foldNodes = indices(layout::kFoldNodes, 4, nodes);
    const std::vector<int> foldTiles = indices(layout::kFoldTiles, 2, subject.model.tiles.size());
    const std::size_t bars = barNodes.size() / 2, folds = foldTiles.size() / 2;
    if (foldNodes.size() != 4 * folds) file.refuse("the folds in panels differ in number");
    const auto numbers = [&](const char* name, const Shape& of) {
      return finiteNumbers(file, name, of);
    };
    const std::vector<double> lengths = numbers(layout::kBarLengths, {bars});
    const std::vector<double> barStiffness = numbers(layout::kBarStiffness, {bars});
    for (std::size_t b = 0; b < bars; ++b) {
      sheet.bars.push_back({barNodes[2 * b], barNodes[2 * b + 1], lengths[b], barStiffness[b]});
    }
    const std::vector<double> foldStiffness = numbers(layout::kFoldStiffness, {folds});
    const std::vector<double> rests = numbers(layout::kFoldRests, {folds});
    for (std::size_t f = 0; f < folds; ++f) {
      const int* at = &foldNodes[4 * f];
      sheet.folds.push_back({{at[0], at[1], at[2], at[3]},
                             foldStiffness[f],
                             rests[f],
                             {foldTiles[2 * f], foldTiles[2 * f + 1]}});
    }
    const std::vector<double> stateTimes = numbers(layout::kPanelTimes, {states});
    if (!std::ranges::is_sorted(stateTimes)) file.refuse("the times of the panels decrease");
    const std::vector<double> places = numbers(layout::kPanelNodes, {states, nodes, 3});
    const std::vector<double> strains = numbers(layout::kBarStrains, {states, bars});
    const std::vector<double> angles = numbers(layout::kFoldAngles, {states, folds});
    const auto row = [](const std::vector<double>& entries, std::size_t k, std::size_t width) {
      const auto first = entries.begin() + static_cast<std::ptrdiff_t>(k * width);
      return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(width));
    };
    for (std::size_t k = 0; k < states; ++k) {
      PanelState state{stateTimes[k], {}, row(strains, k, bars), row(angles, k, folds)};
      for (std::size_t n = 0; n < nodes; ++n) {
        state.nodes.emplace_back(&places[3 * (k * nodes + n)]);
      }
      sheet.states.push_back(std::move(state));
    }
    end.panels = std::make_shared<const LoadedPanels>(std::move(sheet));
  }

  /// The poses in a row of a group's position and rotation; "" is the file itself.
  Poses poses(const std::string& group, std::size_t row) const {
    const std::string prefix = group.empty() ? "" : group + "/";
    const std::vector<double> positions = file.row(prefix + "position", row);
    const std::vector<double> rotations = file.row(prefix + "rotation", row);
    Poses poses;
    for (std::size_t i = 0; i < subject.bricks.size(); ++i) {
      poses.push_back(pose(&positions[3 * i], &rotations[4 * i]));
    }
    return poses;
  }

  /// The steps after the previous sample, up to the time of this one.
  std::vector<StepRecord> stepsOf(std::size_t sample) const {
    const auto upTo = [&](double time) {
      return std::partition_point(steps.begin(), steps.end(),
                                  [&](const StepRecord& step) { return step.time <= time; });
    };
    const auto first = sample == 0 ? steps.begin() : upTo(times[sample - 1]);
    return {first, upTo(times[sample])};
  }

  // A position and a unit quaternion, checked.
  Pose pose(const double* position, const double* turn) const {
    const Pose pose{Vector3(position), Quaternion(turn[0], turn[1], turn[2], turn[3])};
    // Comparisons with NaN are false: NaN is rejected.
    if (!pose.position.allFinite() || !(std::abs(pose.rotation.norm() - 1) <= kUnitTolerance)) {
      file.refuse("a pose in position or rotation is not finite, or not a rotation");
    }
    if (pose.position.cwiseAbs().maxCoeff() > kFarthest) {
      file.refuse(fmt::format("a brick in position is more than {:g} m away", kFarthest));
    }
    return pose;
  }

  Sample sample(std::size_t index) const override {
    Sample sample;
    sample.time = times.at(index);
    for (std::size_t k = 0; k < kMeasures.size(); ++k) {
      sample.*kMeasures[k].member = measures[k][index];
    }
    sample.poses = poses("", index);
    sample.steps = stepsOf(index);
    if (hasMechanics()) sample.mechanics = mechanics(index);
    return sample;
  }

  ArrayReader file;
  std::array<std::vector<double>, kMeasures.size()> measures;
  std::array<std::vector<double>, kEnergies.size()> energies;  // empty without mechanics
  std::vector<double> holdTimes;                               // one per hold
  std::vector<Hold> holds;
};

struct TrajectoryReader::MemoryRun final : Internals {
  MemoryRun(Subject shown, TrajectoryEnd known, std::shared_ptr<const SampleTable> table)
      : samples(std::move(table)) {
    subject = std::move(shown);
    end = std::move(known);
    times = samples->times();
    for (std::size_t i = 0; i < times.size(); ++i) {
      const std::vector<StepRecord> taken = samples->sample(i).steps;
      steps.insert(steps.end(), taken.begin(), taken.end());
    }
  }

  Sample sample(std::size_t index) const override { return samples->sample(index); }
  bool hasMechanics() const override { return sample(0).mechanics.has_value(); }

  std::shared_ptr<const SampleTable> samples;
};

TrajectoryReader::TrajectoryReader(const std::filesystem::path& path)
    : internals_(std::make_unique<FileRun>(path)) {}

TrajectoryReader::TrajectoryReader(Subject subject, TrajectoryEnd end,
                                   std::shared_ptr<const SampleTable> samples)
    : internals_(
          std::make_unique<MemoryRun>(std::move(subject), std::move(end), std::move(samples))) {}

TrajectoryReader::~TrajectoryReader() = default;

const Subject& TrajectoryReader::subject() const {
  return internals_->subject;
}

const std::vector<double>& TrajectoryReader::times() const {
  return internals_->times;
}

const std::vector<StepRecord>& TrajectoryReader::steps() const {
  return internals_->steps;
}

const TrajectoryEnd& TrajectoryReader::end() const {
  return internals_->end;
}

bool TrajectoryReader::hasMechanics() const {
  return internals_->hasMechanics();
}

Sample TrajectoryReader::sample(std::size_t index) const {
  checkInterruption();  // a loop over all samples takes long
  return internals_->sample(index);
}

}  // namespace kirireel::trajectory
