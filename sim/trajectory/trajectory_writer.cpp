// Trajectories written sample by sample. All arrays that grow are made before the first sample, but
// those of mechanics, as only the first sample shows whether a run has any. The file grows under a
// temporary name (pending_file.h) and gets its own when it is whole.
//
// A file is self-contained: it repeats the model, the bricks, the ground, obstacles and springs, so
// that pictures need neither the scene nor the program that made it. Names and units stand in
// trajectory_layout.h, which the reader shares.
#include "sim/base/pending_file.h"
#include "sim/trajectory/array_file.h"
#include "sim/trajectory/trajectory_file.h"
#include "sim/trajectory/trajectory_layout.h"

namespace kirireel {
namespace {

void append(std::vector<double>& numbers, const Vector3& vector) {
  numbers.insert(numbers.end(), vector.data(), vector.data() + 3);
}

// x, y and z of all vertices one after the other, tile by tile.
std::vector<double> flatten(const std::vector<Tile>& tiles) {
  std::vector<double> numbers;
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) append(numbers, vertex);
  }
  return numbers;
}

/// One field of all bricks, point by point.
std::vector<double> flatten(const std::vector<Brick>& bricks, std::vector<Vector3> Brick::*field) {
  std::vector<double> numbers;
  for (const Brick& brick : bricks) {
    for (const Vector3& point : brick.*field) append(numbers, point);
  }
  return numbers;
}

std::vector<double> flatten(const std::vector<Brick>& bricks, double Brick::*field) {
  std::vector<double> numbers;
  for (const Brick& brick : bricks) numbers.push_back(brick.*field);
  return numbers;
}

// Nine numbers a brick, kg m^2, about its centre of mass in its own axes.
std::vector<double> inertias(const std::vector<Brick>& bricks) {
  std::vector<double> numbers;
  // Symmetric: rows and columns are alike.
  for (const Brick& brick : bricks) {
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

void writeJoints(ArrayWriter& file, const std::vector<Joint>& joints) {
  std::vector<int> rows;
  std::vector<double> apart;
  for (const Joint& joint : joints) {
    rows.insert(rows.end(), {joint.a.tile, joint.a.vertex, joint.b.tile, joint.b.vertex,
                             static_cast<int>(joint.face), static_cast<int>(joint.kind)});
    append(apart, joint.apart);
  }
  file.write("model/joints", std::span<const int>(rows), {joints.size(), layout::kJointColumns});
  file.setAttribute("model/joints", "columns",
                    std::string("tile a, vertex a, tile b, vertex b, face (1 bottom, 2 top, 3 "
                                "both), kind (0 pivot, 1 link, 2 fixed)"));
  writePoints(file, "model/joint_apart", apart);
}

// How many vertices each tile has: what splits the flat list of vertices into tiles again.
std::vector<int> sizesOf(const std::vector<Tile>& tiles) {
  std::vector<int> sizes;
  for (const Tile& tile : tiles) sizes.push_back(static_cast<int>(tile.vertices.size()));
  return sizes;
}

/// The tiles whose vertices the model's file has the other way round.
std::vector<int> reversedTiles(const FileOrder& order) {
  std::vector<int> tiles;
  for (std::size_t i = 0; i < order.isReversed.size(); ++i) {
    if (order.isReversed[i]) tiles.push_back(static_cast<int>(i));
  }
  return tiles;
}

// What the reader needs to make the model again, its file's order included.
void writeModel(ArrayWriter& file, const Model& model) {
  file.addGroup("model");
  file.setAttribute("model", "name", model.name);
  file.write("model/tile_sizes", std::span<const int>(sizesOf(model.tiles)), {model.tiles.size()});
  writePoints(file, "model/vertices", flatten(model.tiles));
  if (model.target) writePoints(file, "model/target", flatten(*model.target));
  writeJoints(file, model.joints);
  if (model.fileOrder.countsFrom != 0) {
    file.setAttribute("model", "counts_from", model.fileOrder.countsFrom);
  }
  if (const std::vector<int> reversed = reversedTiles(model.fileOrder); !reversed.empty()) {
    file.write("model/reversed_tiles", std::span<const int>(reversed), {reversed.size()});
  }
  if (model.pulledTiles) {
    file.write("model/pulled_tiles", std::span<const int>(*model.pulledTiles),
               {model.pulledTiles->size()});
  }
}

void writeBricks(ArrayWriter& file, const std::vector<Brick>& bricks, const BrickRule& rule) {
  file.addGroup("bricks");
  file.setAttribute("bricks", "rule_thickness", rule.thickness);
  file.setAttribute("bricks", "rule_mass",
                    std::string(rule.mass == MassRule::Unit ? "unit" : "prism"));
  file.setAttribute("bricks", "rule_density", rule.density);
  const std::size_t count = bricks.size();
  writePoints(file, "bricks/bottom", flatten(bricks, &Brick::bottom));
  writePoints(file, "bricks/top", flatten(bricks, &Brick::top));
  std::vector<double> normals;
  for (const Brick& brick : bricks) append(normals, brick.normal);
  writeArray(file, "bricks/normal", normals, {count, 3}, "1");
  writeArray(file, "bricks/thickness", flatten(bricks, &Brick::thickness), {count}, "m");
  writeArray(file, "bricks/volume", flatten(bricks, &Brick::volume), {count}, "m^3");
  writeArray(file, "bricks/mass", flatten(bricks, &Brick::mass), {count}, "kg");
  writeArray(file, "bricks/inertia", inertias(bricks), {count, 3, 3}, "kg m^2");
}

// Faces in the world's axes, metres. A run without obstacles has no such group.
void writeObstacles(ArrayWriter& file, const std::vector<Tile>& faces) {
  if (faces.empty()) return;
  file.addGroup("obstacles");
  file.write("obstacles/face_sizes", std::span<const int>(sizesOf(faces)), {faces.size()});
  writePoints(file, "obstacles/vertices", flatten(faces));
}

// By value, since the columns reach fields through references that are not const.
void writeHingeSprings(ArrayWriter& file, std::vector<HingeSpring> springs) {
  if (springs.empty()) return;
  const std::size_t count = springs.size();
  std::vector<int> bricks;
  std::vector<double> axes;
  for (const HingeSpring& spring : springs) {
    bricks.insert(bricks.end(), {spring.hinge.brickA, spring.hinge.brickB});
    append(axes, spring.hinge.axis);
  }
  file.addGroup("hinges");
  file.write("hinges/bricks", std::span<const int>(bricks), {count, 2});
  writeArray(file, "hinges/axis", axes, {count, 3}, "1");
  for (const layout::SpringColumn& column : layout::kSpringColumns) {
    std::vector<double> numbers;
    for (HingeSpring& spring : springs) numbers.push_back(column.field(spring));
    writeArray(file, column.name, numbers, {count}, column.unit);
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

// One time and one line of text an event. A run without any has empty arrays.
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

/// Made with the first sample that has mechanics: whether a run has any shows there.
void TrajectoryWriter::Internals::addMechanics() {
  file.addGroup("energy");
  for (const layout::EnergyChannel& channel : layout::kEnergies) {
    addSeries(file, channel.name, {}, "J");
    file.setAttribute(channel.name, "description", std::string(channel.description));
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
  for (const layout::HoldChannel& channel : layout::kHolds)
    addSeries(file, channel.name, {3}, channel.unit);
}

// One row in each series of energies and forces, and a row for each hold.
void TrajectoryWriter::Internals::append(double time, const Mechanics& mechanics) {
  for (const layout::EnergyChannel& channel : layout::kEnergies)
    file.append(channel.name, {&(mechanics.energies.*channel.field), 1});
  if (jointCount > 0) {
    std::vector<double> forces;
    for (const Vector3& force : mechanics.jointForces) kirireel::append(forces, force);
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
  // Holds are rows of their own, with the sample's time, since their number differs from sample to
  // sample.
  file.append(layout::kHoldTimes, std::vector<double>(kinds.size(), time));
  file.append(layout::kHoldKinds, kinds);
  file.append(layout::kHoldTiles, tiles);
  for (const layout::HoldChannel& channel : layout::kHolds) {
    std::vector<double> entries;
    for (const Hold& hold : mechanics.holds) kirireel::append(entries, hold.*channel.field);
    file.append(channel.name, entries);
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
  writeHingeSprings(file, subject.hingeSprings);
  addSeries(file, "time", {}, "s");
  addSeries(file, "position", {subject.bricks.size(), 3}, "m");
  addSeries(file, "rotation", {subject.bricks.size(), 4}, "1");
  file.setAttribute("rotation", "columns", std::string("w, x, y, z"));
  file.addGroup("measures");
  for (const layout::Measure& measure : layout::kMeasures) addSeries(file, measure.name, {}, "m");
  file.addGroup("steps");
  for (const layout::StepColumn& column : layout::kStepColumns)
    addSeries(file, column.name, {}, column.unit);
  for (const StepFigure& figure : kStepFigures)
    addSeries(file, layout::arrayOf(figure), {}, figure.unit);
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
  for (const layout::Measure& measure : layout::kMeasures)
    file.append(measure.name, {&(sample.*measure.field), 1});
  for (const layout::StepColumn& column : layout::kStepColumns) {
    std::vector<double> entries;
    for (const StepRecord& step : sample.steps) entries.push_back(step.*column.field);
    file.append(column.name, entries);
  }
  for (const StepFigure& figure : kStepFigures) {
    std::vector<double> entries;
    for (const StepRecord& step : sample.steps) entries.push_back(figure.get(step.took));
    file.append(layout::arrayOf(figure), entries);
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
  file.write("findings", {end.findings});
  // Before the file gets its name, so that a full disk shows here.
  file.close();
  internals_->pending.commit();
}

void writeTrajectory(const Trajectory& trajectory, const std::filesystem::path& path) {
  TrajectoryWriter writer(path, trajectory);
  for (const Sample& sample : trajectory.samples) writer.append(sample);
  writer.finish(trajectory);
}

}  // namespace kirireel
