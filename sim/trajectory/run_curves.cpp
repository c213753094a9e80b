// Curves of a run. Measures of the shape come from the poses of each sample, energies and forces
// from the sample itself. The list of curves and its order are the same for all runs; missing
// values are NaN. Tables of different runs are therefore compatible.
#include "sim/trajectory/run_curves.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "sim/formats/union_area.h"
#include "sim/model/convex_parts.h"
#include "sim/model/sheet_frame.h"
#include "sim/trajectory/exact_motion.h"
#include "sim/trajectory/measures.h"

namespace kirireel::trajectory {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Data of a sample from which its curves follow.
struct Figures {
  const Subject& subject;
  const Sample& sample;
  std::vector<model::Tile> tiles;
  Vector3 sides;                        ///< of the box around the tiles, metres
  HullSize hull;                        ///< seen from above, as the two below
  double covered = kNone;               ///< area, square metres
  double poissonsRatio = kNone;         ///< since the start
  std::vector<double> openings;         ///< of the joints, radians
  std::vector<model::Tile> exact = {};  ///< at the mean opening, see ExactMotion; may be empty
};

/// A curve. Those that depend only on poses have a description: trajectory.h5 stores them.
struct CurveRow {
  const char* group;  ///< the diagram
  const char* unit;   ///< in metres
  const char* name;
  const char* column;
  double (*value)(const Figures&);
  const char* description = nullptr;
  bool isLogarithmic = false;
  bool isReference = false;
};

/// A value of runs with dynamics; NaN for others.
double energy(const Figures& figures, double Energies::*value) {
  return figures.sample.mechanics ? figures.sample.mechanics->energies.*value : kNone;
}

/// A figure of the forces of the joints; NaN if forces do not balance.
double jointForce(const Figures& figures, double (*value)(const std::vector<double>&)) {
  if (!figures.sample.mechanics) return kNone;
  std::vector<double> forces;
  for (const Vector3& force : figures.sample.mechanics->jointForces) forces.push_back(force.norm());
  return forces.empty() || std::isnan(forces.front()) ? kNone : value(forces);
}

double largestIndeterminate(const Figures& figures) {
  double largest = kNone;
  if (!figures.sample.mechanics) return largest;
  const auto& [energies, forces, isIndeterminate, holds] = *figures.sample.mechanics;
  for (std::size_t j = 0; j < forces.size(); ++j) {
    // fmax drops a NaN.
    if (isIndeterminate[j]) largest = std::fmax(largest, forces[j].norm());
  }
  return largest;
}

/// The largest force of pins, of grips or of contacts.
double largestHold(const Figures& figures, HoldKind kind) {
  double largest = kNone;
  if (!figures.sample.mechanics) return largest;
  for (const Hold& hold : figures.sample.mechanics->holds) {
    if (hold.kind == kind) largest = std::fmax(largest, hold.force.norm());
  }
  return largest;
}

/// Of the vertices.
double meanTargetError(const Figures& figures) {
  const std::optional<std::vector<model::Tile>>& target = figures.subject.model.target;
  return target ? vertexDistance(figures.tiles, *target).mean : kNone;
}

/// NaN if the sheet has no exact motion.
double shapeError(const Figures& figures, double VertexDistance::*value) {
  if (figures.exact.empty()) return kNone;
  return vertexDistance(figures.tiles, figures.exact).*value;
}

double least(const std::vector<double>& values) {
  return values.empty() ? kNone : std::ranges::min(values);
}

double mean(const std::vector<double>& values) {
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  return values.empty() ? kNone : sum / static_cast<double>(values.size());
}

double largest(const std::vector<double>& values) {
  return values.empty() ? kNone : std::ranges::max(values);
}

using F = const Figures&;
/// All curves of a run, except those of each joint. Rows of one diagram are consecutive.
constexpr CurveRow kCurves[] = {
    {"Size", "m", "width", "width_m", [](F f) { return f.sides.x(); },
     "of the box around the tiles along x"},
    {"Size", "m", "height", "height_m", [](F f) { return f.sides.y(); },
     "of the box around the tiles along y"},
    {"Size", "m", "depth", "depth_m", [](F f) { return f.sides.z(); },
     "of the box around the tiles along z"},
    {"Area", "m²", "hull", "hull_area_m2", [](F f) { return f.hull.area; },
     "within the convex outline of the tiles"},
    {"Area", "m²", "covered", "covered_area_m2", [](F f) { return f.covered; },
     "of tiles that lie in one plane"},
    {"Hull perimeter", "m", "hull perimeter", "hull_perimeter_m",
     [](F f) { return f.hull.perimeter; }, "of the convex outline"},
    {"Porosity", "", "porosity", "porosity", [](F f) { return 1 - f.covered / f.hull.area; },
     "1 - covered / hull"},
    {"Poisson's ratio", "", "Poisson's ratio", "poissons_ratio",
     [](F f) { return f.poissonsRatio; },
     "since the start, of logarithmic strains of the tiles' centres"},
    {"Opening", "degrees", "least", "opening_least_deg",
     [](F f) { return least(f.openings) / kDegree; },
     "smallest turn of joined tiles since the start"},
    {"Opening", "degrees", "mean", "opening_mean_deg",
     [](F f) { return mean(f.openings) / kDegree; }, "mean turn of joined tiles since the start"},
    {"Opening", "degrees", "largest", "opening_largest_deg",
     [](F f) { return largest(f.openings) / kDegree; },
     "largest turn of joined tiles since the start"},
    {"Energy", "J", "kinetic", "kinetic_energy_J",
     [](F f) { return energy(f, &Energies::kinetic); }},
    {"Energy", "J", "springs", "spring_energy_J", [](F f) { return energy(f, &Energies::spring); }},
    {"Energy", "J", "hinges", "elastic_energy_J",
     [](F f) { return f.subject.pairForces.empty() ? kNone : energy(f, &Energies::elastic); }},
    {"Work of the drives", "J", "work of the drives", "work_J",
     [](F f) { return energy(f, &Energies::work); }},
    {"Lost energy", "J", "dampers", "damped_J", [](F f) { return energy(f, &Energies::damped); }},
    {"Lost energy", "J", "contacts and pins", "impacted_J",
     [](F f) { return energy(f, &Energies::impacted); }},
    {"Lost energy", "J", "integrator", "integrated_J",
     [](F f) { return f.sample.mechanics ? f.sample.mechanics->energies.integrated() : kNone; }},
    {"Joint force", "N", "mean", "joint_force_mean_N", [](F f) { return jointForce(f, mean); }},
    {"Joint force", "N", "largest", "joint_force_largest_N",
     [](F f) { return jointForce(f, largest); }},
    {"Joint force", "N", "largest indeterminate", "joint_force_indeterminate_N",
     largestIndeterminate},
    {"Force on held tiles", "N", "pins", "pin_force_N",
     [](F f) { return largestHold(f, HoldKind::Pin); }},
    {"Force on held tiles", "N", "grips", "grip_force_N",
     [](F f) { return largestHold(f, HoldKind::Grip); }},
    {"Force on held tiles", "N", "contacts", "contact_force_N",
     [](F f) { return largestHold(f, HoldKind::Contact); }},
    {"Target error", "m", "largest", "target_error_m",
     [](F f) { return f.subject.model.target ? f.sample.targetError : kNone; }, nullptr, true},
    {"Target error", "m", "mean", "target_error_mean_m", meanTargetError, nullptr, true},
    {"Joint gap", "m", "joint gap", "joint_gap_m",
     [](F f) { return f.subject.model.joints.empty() ? kNone : f.sample.jointGap; }, nullptr, true},
    {"Overlap", "m", "overlap", "penetration_m", [](F f) { return f.sample.penetration; }, nullptr,
     true},
    {"Radius", "m", "radius", "radius_m", [](F f) { return largestRadius(f.tiles); }},
    {"Radius", "m", "exact", "radius_exact_m",
     [](F f) { return f.exact.empty() ? kNone : largestRadius(f.exact); }, nullptr, false, true},
    {"Shape error", "m", "largest", "shape_error_m",
     [](F f) { return shapeError(f, &VertexDistance::largest); }, nullptr, true},
    {"Shape error", "m", "mean", "shape_error_mean_m",
     [](F f) { return shapeError(f, &VertexDistance::mean); }, nullptr, true}};

/// The channel of a curve in trajectory.h5: its column without the unit.
Channel channelOf(const CurveRow& row) {
  static const std::map<std::string_view, std::pair<const char*, const char*>> kUnits = {
      {"m", {"m", "_m"}}, {"m²", {"m^2", "_m2"}}, {"", {"1", ""}}, {"degrees", {"degree", "_deg"}}};
  const auto& [unit, ending] = kUnits.at(row.unit);
  const std::string column = row.column;
  return {column.substr(0, column.size() - std::strlen(ending)), unit, row.description, 0};
}

/// Measures successive samples.
class ShapeMeter final : public SampleMeter {
 public:
  explicit ShapeMeter(const Subject& subject)
      : subject_(subject),
        frame_(model::viewFrame(subject.model)),
        tilesAtStart_(model::toFrame(frame_, subject.model.tiles)) {}

  std::vector<Channel> channels() const override {
    std::vector<Channel> channels;
    for (const CurveRow& row : kCurves) {
      if (row.description) channels.push_back(channelOf(row));
    }
    const std::size_t joints = subject_.model.joints.size();
    if (joints > 0) {
      channels.push_back(
          {"opening", "degree", "turn of each joint's tiles since the start", joints});
    }
    return channels;
  }

  std::vector<double> measure(const Sample& sample) override {
    const Figures figures = figuresOf(sample);
    std::vector<double> values;
    for (const CurveRow& row : kCurves) {
      if (row.description) values.push_back(row.value(figures));
    }
    for (const double opening : figures.openings) values.push_back(opening / kDegree);
    return values;
  }

  Figures figuresOf(const Sample& sample) const {
    Figures figures{subject_, sample, brick::bottomTiles(subject_.bricks, sample.poses)};
    figures.sides = boxSides(figures.tiles);
    const std::vector<model::Tile> seen = model::toFrame(frame_, figures.tiles);
    figures.hull = hullSize(seen);
    figures.covered = coveredArea(seen).value_or(kNone);
    figures.poissonsRatio = poissonsRatio(tilesAtStart_, seen).value_or(kNone);
    figures.openings = openingAngles(subject_.model.joints, sample.poses);
    return figures;
  }

 private:
  const Subject& subject_;
  model::SheetFrame frame_;
  std::vector<model::Tile> tilesAtStart_;  // in the frame
};

std::vector<Curve> emptyJointCurves(const model::Model& model, bool haveForces) {
  std::vector<Curve> curves;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const std::string number = std::to_string(model.fileOrder.countsFrom + static_cast<int>(j));
    curves.push_back({"opening of joint " + number, "opening_" + number + "_deg", {}});
  }
  for (std::size_t j = 0; haveForces && j < model.joints.size(); ++j) {
    const std::string number = std::to_string(model.fileOrder.countsFrom + static_cast<int>(j));
    curves.push_back({"force of joint " + number, "joint_force_" + number + "_N", {}});
    curves.push_back(
        {"whether that force is indeterminate", "joint_force_" + number + "_indeterminate", {}});
  }
  return curves;
}

/// Appends a sample's values to the curves of each joint: openings, then forces.
void appendJoints(std::span<const double> openings, const std::optional<Mechanics>& mechanics,
                  std::vector<Curve>& curves) {
  auto curve = curves.begin();
  for (const double opening : openings) (curve++)->values.push_back(opening / kDegree);
  if (!mechanics) return;
  for (std::size_t j = 0; j < openings.size(); ++j) {
    (curve++)->values.push_back(mechanics->jointForces[j].norm());
    (curve++)->values.push_back(mechanics->isIndeterminate[j] ? 1 : 0);
  }
}

}  // namespace

bool Curve::hasLine() const {
  if (values.size() == 1) return !std::isnan(values.front());
  return std::ranges::adjacent_find(values, [](double value, double next) {
           return !std::isnan(value) && !std::isnan(next);
         }) != values.end();
}

bool CurveGroup::hasLine() const {
  return std::ranges::any_of(curves, &Curve::hasLine);
}

std::vector<CurveGroup> curveGroups(const LengthUnit& unit) {
  std::vector<CurveGroup> groups;
  for (const CurveRow& row : kCurves) {
    if (groups.empty() || groups.back().name != row.group) {
      const int power = row.unit == std::string("m") ? 1 : row.unit == std::string("m²") ? 2 : 0;
      groups.push_back({row.group, row.unit, row.isLogarithmic, {}, power});
      if (power > 0) groups.back().unit.replace(0, 1, unit.name);
    }
    std::string column = row.column;
    if (groups.back().lengthPower > 0) column.replace(column.rfind("_m") + 1, 1, unit.name);
    groups.back().curves.push_back({row.name, column, {}, row.isReference});
  }
  return groups;
}

std::unique_ptr<SampleMeter> makeCurveMeter(const Subject& subject) {
  return std::make_unique<ShapeMeter>(subject);
}

RunCurves curvesOf(const TrajectoryReader& run) {
  const Subject& subject = run.subject();
  const LengthUnit& unit = subject.model.unit;
  RunCurves result{run.times(), curveGroups(unit),
                   emptyJointCurves(subject.model, run.hasMechanics())};
  const ShapeMeter meter(subject);
  const std::optional<ExactMotion> exact = ExactMotion::find(subject.model);
  for (std::size_t k = 0; k < run.times().size(); ++k) {
    const Sample sample = run.sample(k);
    Figures figures = meter.figuresOf(sample);
    if (exact) figures.exact = exact->nearest(mean(figures.openings), figures.tiles);
    const CurveRow* row = kCurves;
    for (CurveGroup& group : result.groups) {
      const LengthUnit power{"", std::pow(unit.metres, group.lengthPower)};
      for (Curve& curve : group.curves) {
        curve.values.push_back(inUnit((row++)->value(figures), power));
      }
    }
    appendJoints(figures.openings, sample.mechanics, result.joints);
  }
  return result;
}

double valueAt(const std::vector<double>& times, const std::vector<double>& values, double time) {
  const auto above = std::ranges::lower_bound(times, time);
  if (above == times.begin()) return values.front();
  if (above == times.end()) return values.back();
  const auto upper = static_cast<std::size_t>(above - times.begin());
  if (*above == time) return values[upper];
  const double share = (time - times[upper - 1]) / (times[upper] - times[upper - 1]);
  return values[upper - 1] + share * (values[upper] - values[upper - 1]);
}

std::size_t nearestIndex(const std::vector<double>& times, double time) {
  const auto nearest =
      std::ranges::min_element(times, {}, [time](double other) { return std::abs(other - time); });
  return static_cast<std::size_t>(nearest - times.begin());
}

RunCurves curvesAt(const RunCurves& curves, const std::vector<double>& times) {
  RunCurves result{times, curves.groups, {}};
  for (CurveGroup& group : result.groups) {
    for (Curve& curve : group.curves) {
      std::vector<double> values;
      for (const double time : times) values.push_back(valueAt(curves.times, curve.values, time));
      curve.values = std::move(values);
    }
  }
  return result;
}

// ------------------------------------------------------------------------------------------------
// Sizes of a whole state. The area within a closed outline p_0 ... p_(n-1) is the shoelace sum 1/2
// sum (x_k y_(k+1) - x_(k+1) y_k), taken about the first corner. Poisson's ratio uses logarithmic
// strains, which add up over successive deformations. A constant ratio therefore does not depend on
// the start.

namespace {

/// Tolerance of flat tiles, as a fraction of the box's diagonal.
constexpr double kFlatOfBox = 1e-6;
/// Smaller strains give no meaningful ratio.
constexpr double kMinStrain = 1e-3;
/// Centres of tiles in a narrower strip, over its length, count as on one line.
constexpr double kMinWidth = 1e-6;

/// The corners of the convex outline seen along z. (outlineCorners() also keeps every
/// vertex on it.)
std::vector<Eigen::Vector2d> outlineSeenAlongZ(const std::vector<model::Tile>& tiles) {
  std::vector<Eigen::Vector2d> points;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) points.emplace_back(vertex.head<2>());
  }
  return model::convexOutline(std::move(points));
}

}  // namespace

Vector3 boxSides(const std::vector<model::Tile>& tiles) {
  const Eigen::AlignedBox3d box = model::boxOf(tiles);
  return box.isEmpty() ? Vector3(Vector3::Zero()) : box.sizes();
}

HullSize hullSize(const std::vector<model::Tile>& tiles) {
  const std::vector<Eigen::Vector2d> corners = outlineSeenAlongZ(tiles);
  HullSize size;
  size.area = formats::ringArea(corners);
  for (std::size_t k = 0; k < corners.size(); ++k) {
    size.perimeter += (corners[(k + 1) % corners.size()] - corners[k]).norm();
  }
  return size;
}

std::optional<double> coveredArea(const std::vector<model::Tile>& tiles) {
  const Vector3 sides = boxSides(tiles);
  if (sides.z() > kFlatOfBox * sides.norm()) return std::nullopt;
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  for (const model::Tile& tile : tiles) {
    std::vector<Eigen::Vector2d>& outline = outlines.emplace_back();
    for (const Vector3& vertex : tile.vertices) outline.emplace_back(vertex.head<2>());
  }
  return formats::unionArea(outlines);
}

std::optional<double> poissonsRatio(const std::vector<model::Tile>& before,
                                    const std::vector<model::Tile>& now) {
  const auto centresOf = [](const std::vector<model::Tile>& tiles) {
    Eigen::Matrix2Xd centres(2, tiles.size());
    for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
      centres.col(static_cast<Eigen::Index>(tile)) = meanPoint(tiles[tile].vertices).head<2>();
    }
    return Eigen::Matrix2Xd(centres.colwise() - centres.rowwise().mean());
  };
  // Least squares: now = F before.
  const Eigen::Matrix2Xd from = centresOf(before), to = centresOf(now);
  const Eigen::FullPivLU<Eigen::Matrix2d> square(from * from.transpose());
  if (square.rcond() < kMinWidth * kMinWidth) return std::nullopt;
  const Eigen::Matrix2d F = square.solve(from * to.transpose()).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> stretch(F.transpose() * F);
  if (!(stretch.eigenvalues().minCoeff() > 0)) return std::nullopt;
  const Eigen::Matrix2d strain = stretch.eigenvectors() *
                                 (0.5 * stretch.eigenvalues().array().log()).matrix().asDiagonal() *
                                 stretch.eigenvectors().transpose();
  if (std::abs(strain(0, 0)) < kMinStrain) return std::nullopt;
  return -strain(1, 1) / strain(0, 0);
}

std::vector<double> openingAngles(const std::vector<model::Joint>& joints, const Poses& poses) {
  std::vector<double> angles;
  angles.reserve(joints.size());
  for (const model::Joint& joint : joints) {
    angles.push_back(
        turnBetween(poses[joint.a.tile].rotation, poses[joint.b.tile].rotation).norm());
  }
  return angles;
}

// ------------------------------------------------------------------------------------------------
// Figures of single bricks. A measure that belongs to two bricks (a joint's gap, a spring's moment)
// counts for both of them as it is; energies are shared by halves. The sum over all bricks is the
// sum over all springs.

std::vector<double> brickTargetErrors(const std::vector<model::Tile>& target,
                                      const std::vector<brick::Brick>& bricks, const Poses& poses) {
  std::vector<double> errors(bricks.size(), 0);
  for (std::size_t brick = 0; brick < bricks.size(); ++brick) {
    for (std::size_t k = 0; k < bricks[brick].bottom.size(); ++k) {
      const Vector3 point = poses[brick].apply(bricks[brick].bottom[k]);
      errors[brick] = std::max(errors[brick], (point - target[brick].vertices[k]).norm());
    }
  }
  return errors;
}

std::vector<double> brickDisplacements(const Poses& start, const Poses& poses) {
  std::vector<double> distances;
  for (std::size_t brick = 0; brick < poses.size(); ++brick) {
    distances.push_back((poses[brick].position - start[brick].position).norm());
  }
  return distances;
}

std::vector<double> brickRotations(const Poses& start, const Poses& poses) {
  std::vector<double> angles;
  for (std::size_t brick = 0; brick < poses.size(); ++brick) {
    // The angle of the shortest rotation: 2 acos |q . q'| for unit quaternions, [0, pi].
    angles.push_back(start[brick].rotation.angularDistance(poses[brick].rotation));
  }
  return angles;
}

std::vector<double> brickJointGaps(std::span<const brick::Pivot> pivots, const Poses& poses) {
  std::vector<double> gaps(poses.size(), 0);
  for (const brick::Pivot& pivot : pivots) {
    const double gap =
        (poses[pivot.brickA].apply(pivot.pointA) - poses[pivot.brickB].apply(pivot.pointB)).norm();
    for (const int brick : {pivot.brickA, pivot.brickB}) gaps[brick] = std::max(gaps[brick], gap);
  }
  return gaps;
}

std::vector<double> brickMoments(const brick::PairForces& forces, const Poses& poses) {
  std::vector<double> largest(poses.size(), 0);
  for (const auto& [brickA, brickB, onA, onB] : brick::endMoments(forces, poses)) {
    double& a = largest[static_cast<std::size_t>(brickA)];
    double& b = largest[static_cast<std::size_t>(brickB)];
    a = std::max(a, std::abs(onA));
    b = std::max(b, std::abs(onB));
  }
  return largest;
}

std::vector<double> brickElasticEnergies(const brick::PairForces& forces, const Poses& poses) {
  std::vector<double> energies(poses.size(), 0);
  for (const std::shared_ptr<const brick::PairForce>& force : forces) {
    for (std::size_t pair = 0; pair < force->size(); ++pair) {
      const auto [brickA, brickB] = force->bricks(pair);
      const double half = 0.5 * force->energy(pair, poses);
      energies[static_cast<std::size_t>(brickA)] += half;
      energies[static_cast<std::size_t>(brickB)] += half;
    }
  }
  return energies;
}

}  // namespace kirireel::trajectory
