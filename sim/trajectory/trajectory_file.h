/// trajectory.h5: a run as a file. Pictures and meshes can be made from it without another
/// simulation.
///
/// HDF5; h5py, MATLAB and h5dump read it. The attribute "unit" of every array is its unit.
///
///     /                       attributes format = "kirireel trajectory", format_version
///     settings                the run's settings, JSON (one text)
///     model/                  attributes name, unit (of its file; all arrays are in metres)
///       tile_sizes            tiles            vertices of each tile
///       vertices, target      vertices x 3     m; tile by tile; target only if there is one
///       waypoint_0, ...       vertices x 3     m; targets before the last, if there are some
///       joints                joints x 6       tile, vertex, tile, vertex, face, kind
///       joint_apart           joints x 3       m, corner b to a, of links and fixed joints
///       joints_within_tiles   rows of joints   between parts of one bending tile; only if
///                                              there are some
///       pulled_tiles          tiles             only if given
///     model/sheet/            vertices, edges and faces of the model's FOLD file, with its
///                             numbers; only if it has one. Attributes: see kSheetFlags
///       vertices              vertices x 3     m, at the start
///       edges                 edges x 3        two vertices, letter as ASCII code
///       fold_angles           edges            degrees; kNoAngle for edges without an angle
///       faces, outlines       list of vertices of each face and of each tile, one after the other;
///                             faces_sizes and outlines_sizes have their lengths
///       face_tiles            faces            tile of each face
///     bricks/                 attributes rule_thickness, rule_mass, rule_density
///       bottom, top           vertices x 3     m, brick axes
///       normal                bricks x 3
///       thickness, volume, mass                m, m^3, kg
///       inertia               bricks x 3 x 3   kg m^2, about the centre of mass
///     obstacles/face_sizes    faces            vertices of each face; only if there are some
///     obstacles/vertices      vertices x 3     m, world axes
///     GROUP/                  one group for each kind of force between pairs of bricks, see
///                             pairForceKinds(). All kinds have `bricks`; the rest differs:
///     hinges/                 springs at hinges
///       bricks                springs x 2      the two bricks of each hinge
///       axis                  springs x 3
///       start, least, most, rest   springs     rad
///       stiffness, damping    springs          N m/rad, N m s/rad
///     ligaments/              ligaments in place of joints; see Ligament
///       bricks                ligaments x 2    the two bricks of each ligament
///       joint                 ligaments        the joint that it replaces
///       point_a, point_b      ligaments x 3    m, in the axes of its bricks
///       start                 ligaments x 3    m, from point a to point b; 0 for a pin
///       across                ligaments x 3    direction, length 1; only for a pin
///       stretch, shear        ligaments        N/m, N m/rad (for a pin N/m)
///       opening_2, opening_3  ligaments        N m/rad^2, N m/rad^3
///     ground/                 attributes height, friction; only if there is one
///     time                    samples          s
///     position                samples x bricks x 3   m, of the centres of mass
///     rotation                samples x bricks x 4   unit quaternions w x y z, brick axes to world
///     measures/NAME           samples          m; joint_gap, target_error, penetration
///     steps/NAME              steps            the start and the end of each step: time (s),
///                                              joint_gap, joint_gap_mean, target_error (m), and
///                                              its cost: solver_steps, halved_steps, ...
///     energy/NAME             samples          J; kinetic, spring, elastic, work, damped,
///                                              impacted
///     forces/joint            samples x joints x 3   N, on tile a, world axes; NaN: not balanced
///     forces/joint_indeterminate   samples x joints  1 if other equilibrium forces exist
///     holds/time              holds            s, of the sample; one row per hold
///     holds/kind              holds            0 pin, 1 grip, 2 contact
///     holds/tiles             holds x 2        the tile; for a contact what it touches: a tile,
///                                              -1 the ground, -2 - k obstacle k
///     holds/force, moment     holds x 3        N, N m: on the tile, about the point
///     holds/point             holds x 3        m
///     curves/NAME             samples (x joints)   quantities requested for the run, with unit and
///                                              description as attributes; see makeCurveMeter()
///     load_curve/             equilibria under grips, see render/record/load_curve_file.h
///     panels/                 tiles that stretch and bend under grips, as bars and hinges; see
///                             LoadedPanels. States are those of load_curve
///       vertex_node           vertices         node of each vertex of model/vertices
///       bar_nodes             bars x 2
///       bar_length            bars             m, without force
///       bar_stiffness         bars             N/m
///       fold_nodes            folds x 4        the ends of the edge, the third node of the left
///                                              triangle, that of the right one (from above)
///       fold_tiles            folds x 2        left and right; equal if a tile bends there
///       fold_stiffness        folds            N m/rad
///       fold_rest             folds            rad
///       time                  states           s, at which the samples pass the state
///       nodes                 states x nodes x 3   m, world axes
///       bar_strain            states x bars    1; length over length without force, minus 1
///       fold_angle            states x folds   rad, (-pi, pi]; 0 flat, > 0 a valley
///     events/time, text       events           s
///     figures/name, time      figures          s; figures of summary.json that one state decides
///     figures/position        figures x bricks x 3   m, that state, as above
///     figures/rotation        figures x bricks x 4
///     findings                results about the scene, JSON (one text)
///
/// The energy of a state of panels is the sum of bar_stiffness (bar_strain bar_length)^2 / 2 over
/// bars and of fold_stiffness (fold_angle - fold_rest)^2 / 2 over folds.
///
/// energy, forces and holds exist only for runs with dynamics by the direct solver.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/brick/hinge.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::trajectory {

/// A quantity that is measured for each sample, in addition to its own numbers.
struct Channel {
  std::string name;         ///< of its array, such as "width"
  std::string unit;         ///< "m", "1", ...
  std::string description;  ///< one short phrase
  std::size_t width = 0;    ///< values in each sample's row; 0: one value without a row
};

/// Measures the channels of successive samples. Results may depend on earlier samples.
class SampleMeter {
 public:
  virtual ~SampleMeter() = default;
  /// Called once, before the first sample.
  virtual std::vector<Channel> channels() const = 0;
  /// The values of all channels, channel by channel. A channel without a row has one value; one of
  /// width w has w values.
  virtual std::vector<double> measure(const Sample& sample) = 0;
};

/// Writes a trajectory sample by sample. Memory does not grow with the number of samples. The file
/// gets its final name in finish(), complete after any number of samples. Without finish() the
/// writer leaves no file. Doubles are stored exactly, and the same run gives the same bytes. Throws
/// OutputError if the file cannot be written.
class TrajectoryWriter {
 public:
  /// `meter` may be null. Otherwise its channels become curves/NAME. Writes all constant data
  /// immediately.
  TrajectoryWriter(const std::filesystem::path& path, const Subject& subject,
                   std::unique_ptr<SampleMeter> meter = nullptr);
  ~TrajectoryWriter();
  TrajectoryWriter(const TrajectoryWriter&) = delete;
  TrajectoryWriter& operator=(const TrajectoryWriter&) = delete;

  /// Adds a sample later than those before, with a pose for each brick.
  void append(const Sample& sample);

  /// Writes the data of the run's end and renames the file to its final name. Call it once.
  void finish(const TrajectoryEnd& end);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

class SampleTable;

/// Reads any sample of a trajectory, from a file or from memory. Throws InputError with the file's
/// name and the item that is missing, damaged or contradictory.
class TrajectoryReader {
 public:
  /// Reads and checks everything except the poses.
  explicit TrajectoryReader(const std::filesystem::path& path);
  /// A run in memory, with at least one sample.
  TrajectoryReader(Subject subject, TrajectoryEnd end, std::shared_ptr<const SampleTable> samples);
  ~TrajectoryReader();
  TrajectoryReader(const TrajectoryReader&) = delete;
  TrajectoryReader& operator=(const TrajectoryReader&) = delete;

  /// The constant data of the run.
  const Subject& subject() const;
  const std::vector<double>& times() const;      ///< of samples, ascending, seconds; one or more
  const std::vector<StepRecord>& steps() const;  ///< of the whole run
  const TrajectoryEnd& end() const;              ///< of the whole run

  /// Whether samples have mechanics: energies and forces.
  bool hasMechanics() const;

  /// One sample with its steps, index in [0, times().size()). Files do not store which tiles were
  /// pinned. Reads only the chunks of a file that hold the row; HDF5 caches those that neighbours
  /// share. Throws InputError for a pose that is no rotation, not finite or too far away. Throws
  /// Interrupted if the scope allows interruption.
  Sample sample(std::size_t index) const;

 private:
  struct Internals;
  struct FileRun;
  struct MemoryRun;
  std::unique_ptr<Internals> internals_;
};

}  // namespace kirireel::trajectory

namespace kirireel::trajectory::layout {

// ------------------------------------------------------------------------------------------------
// Names in trajectory.h5, for its writer and its reader.

/// The attribute "format" of the file itself.
inline constexpr const char* kFormat = "kirireel trajectory";
inline constexpr double kFormatVersion = 5;  ///< the only version that can be read
/// Columns of model/joints: tile, vertex, tile, vertex, face, kind.
inline constexpr std::size_t kJointColumns = 6;

/// The array of a target before the last, index >= 0.
inline std::string waypoint(std::size_t index) {
  return "model/waypoint_" + std::to_string(index);
}
/// In model/sheet/fold_angles, for edges without an angle. Angles are in [-180, 180].
inline constexpr double kNoAngle = 999;
/// Attributes of model/sheet: 1 or 0.
inline constexpr std::array<std::pair<const char*, bool model::FoldSheet::*>, 4> kSheetFlags = {
    {{"has_letters", &model::FoldSheet::hasLetters},
     {"has_angles", &model::FoldSheet::hasAngles},
     {"is_folded", &model::FoldSheet::isFolded},
     {"gives_target", &model::FoldSheet::givesTarget}}};

/// The numbers of each sample, beginning with its time.
inline constexpr auto kSampleNumbers = fieldsOfType<double>(Sample::fields());
static_assert(kSampleNumbers.front().member == &Sample::time);
/// The same without the time.
inline constexpr std::span kMeasures = std::span(kSampleNumbers).subspan<1>();
/// The numbers of each step, without the figures of its report.
inline constexpr auto kStepColumns = fieldsOfType<double>(StepRecord::fields());
/// Energies of each sample in a run with dynamics.
inline constexpr auto kEnergies = fieldsOfType<double>(Energies::fields());
/// Vectors of a hold.
inline constexpr auto kHolds = fieldsOfType<Vector3>(Hold::fields());

/// The array of a figure of samples.
inline std::string arrayOf(const Field<Sample, double>& figure) {
  return std::string("measures/") + figure.name;
}
/// The array of a figure of steps.
inline std::string arrayOf(const Field<StepRecord, double>& column) {
  return std::string("steps/") + column.name;
}
/// The array of an energy.
inline std::string arrayOf(const Field<Energies, double>& energy) {
  return std::string("energy/") + energy.name;
}
/// The array of a vector of holds.
inline std::string arrayOf(const Field<Hold, Vector3>& vector) {
  return std::string("holds/") + vector.name;
}
/// The array of a figure of the steps' reports.
inline std::string arrayOf(const StepFigure& figure) {
  return std::string("steps/") + figure.name;
}

/// Forces of all joints, newtons, see Mechanics.
inline constexpr const char* kJointForces = "forces/joint";
/// Whether each is indeterminate.
inline constexpr const char* kIndeterminate = "forces/joint_indeterminate";
/// The times of samples with holds.
inline constexpr const char* kHoldTimes = "holds/time";
/// Type of the hold, as a number of HoldKind.
inline constexpr const char* kHoldKinds = "holds/kind";
/// The tile and the object that it touches.
inline constexpr const char* kHoldTiles = "holds/tiles";

/// Tiles that stretch and bend under grips, see LoadedPanels.
inline constexpr const char* kPanels = "panels";
inline constexpr const char* kVertexNodes = "panels/vertex_node";       ///< LoadedPanels::tileNodes
inline constexpr const char* kBarNodes = "panels/bar_nodes";            ///< ends of each bar
inline constexpr const char* kBarLengths = "panels/bar_length";         ///< Bar::rest
inline constexpr const char* kBarStiffness = "panels/bar_stiffness";    ///< Bar::stiffness
inline constexpr const char* kFoldNodes = "panels/fold_nodes";          ///< Fold::nodes
inline constexpr const char* kFoldTiles = "panels/fold_tiles";          ///< Fold::tiles
inline constexpr const char* kFoldStiffness = "panels/fold_stiffness";  ///< Fold::stiffness
inline constexpr const char* kFoldRests = "panels/fold_rest";           ///< Fold::rest
inline constexpr const char* kPanelTimes = "panels/time";               ///< PanelState::time
inline constexpr const char* kPanelNodes = "panels/nodes";              ///< PanelState::nodes
inline constexpr const char* kBarStrains = "panels/bar_strain";         ///< PanelState::strains
inline constexpr const char* kFoldAngles = "panels/fold_angle";         ///< PanelState::angles

}  // namespace kirireel::trajectory::layout

namespace kirireel::trajectory {

// ------------------------------------------------------------------------------------------------
// The samples of a run as consecutive arrays, for programs that use arrays without copying.

/// Grows by whole samples. The addresses of its arrays are valid until it grows.
class SampleTable {
 public:
  /// Adds a sample later than the others, with the same number of poses.
  void append(const Sample& sample);

  std::size_t size() const { return times_.size(); }  ///< samples
  /// The number of bricks.
  std::size_t brickCount() const { return brickCount_; }

  /// One sample, index in [0, size()).
  Sample sample(std::size_t index) const;

  const std::vector<double>& times() const { return times_; }  ///< samples; seconds
  /// samples x bricks x 3, metres, of the centres of mass.
  const std::vector<double>& positions() const { return positions_; }
  /// samples x bricks x 4, unit quaternions w x y z, brick axes to world.
  const std::vector<double>& rotations() const { return rotations_; }
  const std::vector<double>& jointGaps() const { return jointGaps_; }        ///< samples; metres
  const std::vector<double>& targetErrors() const { return targetErrors_; }  ///< samples; metres
  const std::vector<double>& penetrations() const { return penetrations_; }  ///< samples; metres

  /// samples x bricks x 6: velocity of the centre of mass in m/s, then angular velocity in rad/s,
  /// world axes. Computed from poses by central differences, and one-sided ones at both ends. Zeros
  /// if there is only one sample. Second order in the samples' interval.
  std::vector<double> velocities() const;

 private:
  Poses poses(std::size_t index) const;

  std::size_t brickCount_ = 0;
  std::vector<double> times_;
  std::vector<double> positions_;
  std::vector<double> rotations_;
  std::vector<double> jointGaps_;
  std::vector<double> targetErrors_;
  std::vector<double> penetrations_;
  std::vector<std::vector<int>> pinned_;
  std::vector<std::vector<StepRecord>> steps_;
  std::vector<std::optional<Mechanics>> mechanics_;
};

/// All samples of a trajectory. Throws InputError like the reader.
SampleTable readSamples(const TrajectoryReader& run);

}  // namespace kirireel::trajectory
