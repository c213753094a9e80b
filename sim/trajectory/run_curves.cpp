// Curves of a run. Measures of the shape come from the poses of each sample, energies and forces
// from the sample itself. The list of curves and its order are the same for all runs; missing
// values are NaN. Tables of different runs are therefore compatible.
#include "sim/trajectory/run_curves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "sim/model/convex_parts.h"
#include "sim/model/sheet_frame.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/union_area.h"

namespace kirireel::trajectory {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A curve that depends only on poses: its column in tables, in metres, and its channel.
struct ShapeCurve {
  const char* column;
  const char* channel;
  const char* unit;
  const char* description;
};
constexpr ShapeCurve kShapeCurves[] = {
    {"width_m", "width", "m", "of the box around the tiles along x"},
    {"height_m", "height", "m", "of the box around the tiles along y"},
    {"depth_m", "depth", "m", "of the box around the tiles along z"},
    {"hull_area_m2", "hull_area", "m^2", "within the convex outline of the tiles"},
    {"covered_area_m2", "covered_area", "m^2", "of tiles that lie in one plane"},
    {"hull_perimeter_m", "hull_perimeter", "m", "of the convex outline"},
    {"porosity", "porosity", "1", "1 - covered / hull"},
    {"poissons_ratio", "poissons_ratio", "1",
     "since the start, of logarithmic strains of the tiles' centres"},
    {"opening_least_deg", "opening_least", "degree", "least turn of joined tiles since the start"},
    {"opening_mean_deg", "opening_mean", "degree", "mean turn of joined tiles since the start"},
    {"opening_largest_deg", "opening_largest", "degree",
     "largest turn of joined tiles since the start"}};

/// Measures the shape of successive samples.
class ShapeMeter final : public SampleMeter {
 public:
  explicit ShapeMeter(const Subject& subject)
      : subject_(subject),
        frame_(model::viewFrame(subject.model)),
        tilesAtStart_(model::toFrame(frame_, subject.model.tiles)) {}

  std::vector<Channel> channels() const override {
    std::vector<Channel> channels;
    for (const ShapeCurve& curve : kShapeCurves) {
      channels.push_back({curve.channel, curve.unit, curve.description, 0});
    }
    const std::size_t joints = subject_.model.joints.size();
    if (joints > 0) {
      channels.push_back(
          {"opening", "degree", "turn of each joint's tiles since the start", joints});
    }
    return channels;
  }

  std::vector<double> measure(const Sample& sample) override {
    const std::vector<model::Tile> tiles = brick::bottomTiles(subject_.bricks, sample.poses);
    const Vector3 sides = boxSides(tiles);
    const std::vector<model::Tile> seen = model::toFrame(frame_, tiles);
    const HullSize hull = hullSize(seen);
    const double covered = coveredArea(seen).value_or(kNone);
    std::vector<double> values = {sides.x(),
                                  sides.y(),
                                  sides.z(),
                                  hull.area,
                                  covered,
                                  hull.perimeter,
                                  1 - covered / hull.area,
                                  poissonsRatio(tilesAtStart_, seen).value_or(kNone)};
    const std::vector<double> angles = openingAngles(subject_.model.joints, sample.poses);
    for (const double angle : spread(angles)) values.push_back(angle / kDegree);
    for (const double angle : angles) values.push_back(angle / kDegree);
    return values;
  }

 private:
  /// Least, mean and largest.
  static std::vector<double> spread(const std::vector<double>& values) {
    if (values.empty()) return {kNone, kNone, kNone};
    const auto [least, largest] = std::ranges::minmax_element(values);
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    return {*least, sum / static_cast<double>(values.size()), *largest};
  }

  const Subject& subject_;
  model::SheetFrame frame_;
  std::vector<model::Tile> tilesAtStart_;  // in the frame
};

/// Mean and largest force of the joints, and the largest of those that are indeterminate.
std::vector<double> jointForceValues(const Mechanics& mechanics) {
  // If forces do not balance, all are absent.
  if (mechanics.jointForces.empty() || mechanics.jointForces.front().hasNaN()) {
    return {kNone, kNone, kNone};
  }
  double sum = 0, largest = 0, uncertain = kNone;
  for (std::size_t j = 0; j < mechanics.jointForces.size(); ++j) {
    const double force = mechanics.jointForces[j].norm();
    sum += force;
    largest = std::max(largest, force);
    // fmax drops a NaN: the first force takes its place.
    if (mechanics.isIndeterminate[j]) uncertain = std::fmax(uncertain, force);
  }
  return {sum / static_cast<double>(mechanics.jointForces.size()), largest, uncertain};
}

/// The largest force of pins, of grips and of contacts.
std::vector<double> holdValues(const Mechanics& mechanics) {
  std::vector<double> largest(3, kNone);
  for (const Hold& hold : mechanics.holds) {
    double& value = largest[static_cast<std::size_t>(hold.kind)];
    value = std::fmax(value, hold.force.norm());
  }
  return largest;
}

/// The curves from energies to forces, in order; NaN where a run has none.
std::vector<double> mechanicsValues(const std::optional<Mechanics>& mechanics,
                                    bool havePairForces) {
  // 3 energies, the work, 3 losses, 3 of joint forces, 3 of holds.
  std::vector<double> values(13, kNone);
  if (!mechanics) return values;
  const Energies& energies = mechanics->energies;
  const double elastic = havePairForces ? energies.elastic : kNone;
  values = {energies.kinetic,  energies.spring,      elastic, energies.work, energies.damped,
            energies.impacted, energies.integrated()};
  for (const auto& more : {jointForceValues(*mechanics), holdValues(*mechanics)}) {
    values.insert(values.end(), more.begin(), more.end());
  }
  return values;
}

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
  for (const double opening : openings) (curve++)->values.push_back(opening);
  if (!mechanics) return;
  for (std::size_t j = 0; j < openings.size(); ++j) {
    (curve++)->values.push_back(mechanics->jointForces[j].norm());
    (curve++)->values.push_back(mechanics->isIndeterminate[j] ? 1 : 0);
  }
}

/// The mean distance of vertices from corresponding ones, metres.
double meanDistance(const std::vector<model::Tile>& tiles, const std::vector<model::Tile>& others) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    for (std::size_t k = 0; k < tiles[i].vertices.size(); ++k, ++count) {
      sum += (tiles[i].vertices[k] - others[i].vertices[k]).norm();
    }
  }
  return sum / count;
}

/// The largest distance of a vertex from the mean of all, metres.
double radiusOf(const std::vector<model::Tile>& tiles) {
  Vector3 mean = Vector3::Zero();
  double count = 0, radius = 0;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) mean += vertex;
    count += static_cast<double>(tile.vertices.size());
  }
  mean /= count;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) radius = std::max(radius, (vertex - mean).norm());
  }
  return radius;
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

// The shape's groups come first, in the order of their table. Names of metres are replaced by those
// of the unit at the end.
std::vector<CurveGroup> curveGroups(const LengthUnit& unit) {
  std::vector<CurveGroup> groups = {
      {"Size", "m", false, {{"width"}, {"height"}, {"depth"}}},
      {"Area", "m²", false, {{"hull"}, {"covered"}}},
      {"Hull perimeter", "m", false, {{"hull perimeter"}}},
      {"Porosity", "", false, {{"porosity"}}},
      {"Poisson's ratio", "", false, {{"Poisson's ratio"}}},
      {"Opening", "degrees", false, {{"least"}, {"mean"}, {"largest"}}}};
  // The names of columns come from the table above, in its order.
  const ShapeCurve* shape = kShapeCurves;
  for (CurveGroup& group : groups) {
    for (Curve& curve : group.curves) curve.column = (shape++)->column;
  }
  const std::vector<CurveGroup> more = {
      {"Energy",
       "J",
       false,
       {{"kinetic", "kinetic_energy_J"},
        {"springs", "spring_energy_J"},
        {"hinges", "elastic_energy_J"}}},
      {"Work of the drives", "J", false, {{"work of the drives", "work_J"}}},
      {"Lost energy",
       "J",
       false,
       {{"dampers", "damped_J"},
        {"contacts and pins", "impacted_J"},
        {"integrator", "integrated_J"}}},
      {"Joint force",
       "N",
       false,
       {{"mean", "joint_force_mean_N"},
        {"largest", "joint_force_largest_N"},
        {"largest indeterminate", "joint_force_indeterminate_N"}}},
      {"Force on held tiles",
       "N",
       false,
       {{"pins", "pin_force_N"}, {"grips", "grip_force_N"}, {"contacts", "contact_force_N"}}},
      {"Target error", "m", true, {{"largest", "target_error_m"}, {"mean", "target_error_mean_m"}}},
      {"Joint gap", "m", true, {{"joint gap", "joint_gap_m"}}},
      {"Overlap", "m", true, {{"overlap", "penetration_m"}}},
      {"Radius", "m", false, {{"radius", "radius_m"}}}};
  groups.insert(groups.end(), more.begin(), more.end());
  for (CurveGroup& group : groups) {
    group.lengthPower = group.unit == "m" ? 1 : group.unit == "m²" ? 2 : 0;
    if (group.lengthPower == 0) continue;
    group.unit.replace(0, 1, unit.name);
    for (Curve& curve : group.curves)
      curve.column.replace(curve.column.rfind("_m") + 1, 1, unit.name);
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
  ShapeMeter meter(subject);
  for (std::size_t k = 0; k < run.times().size(); ++k) {
    const Sample at = run.sample(k);
    const std::vector<double> shape = meter.measure(at);
    const auto joints = shape.begin() + std::size(kShapeCurves);
    std::vector<double> values(shape.begin(), joints);
    for (const double value : mechanicsValues(at.mechanics, !subject.pairForces.empty()))
      values.push_back(value);
    const std::vector<model::Tile> tiles = brick::bottomTiles(subject.bricks, at.poses);
    const std::optional<std::vector<model::Tile>>& target = subject.model.target;
    values.insert(
        values.end(),
        {target ? at.targetError : kNone, target ? meanDistance(tiles, *target) : kNone,
         subject.model.joints.empty() ? kNone : at.jointGap, at.penetration, radiusOf(tiles)});
    auto value = values.begin();
    for (CurveGroup& group : result.groups) {
      const LengthUnit power{"", std::pow(unit.metres, group.lengthPower)};
      for (Curve& curve : group.curves) curve.values.push_back(inUnit(*value++, power));
    }
    appendJoints({joints, shape.end()}, at.mechanics, result.joints);
  }
  return result;
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
// strains, which add up over successive deformations: it does not depend on the state that
// is taken for the start as long as the ratio itself is constant.

namespace {

/// Tolerance of flat tiles, as a fraction of the box's diagonal.
constexpr double kFlatOfBox = 1e-6;
/// Smaller strains give no meaningful ratio.
constexpr double kLeastStrain = 1e-3;
/// Centres of tiles in a narrower strip, over its length, count as on one line.
constexpr double kLeastWidth = 1e-6;

/// The corners of the convex outline seen along z. (outlineCorners() in model.h also keeps every
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
  Eigen::AlignedBox3d box;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) box.extend(vertex);
  }
  return box.isEmpty() ? Vector3(Vector3::Zero()) : box.sizes();
}

HullSize hullSize(const std::vector<model::Tile>& tiles) {
  const std::vector<Eigen::Vector2d> corners = outlineSeenAlongZ(tiles);
  HullSize size;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    // Relative to the first corner: a sheet far from the origin loses no digits.
    const Eigen::Vector2d from = corners[k] - corners[0];
    const Eigen::Vector2d to = corners[(k + 1) % corners.size()] - corners[0];
    size.area += 0.5 * (from.x() * to.y() - from.y() * to.x());
    size.perimeter += (to - from).norm();
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
  return unionArea(outlines);
}

std::optional<double> poissonsRatio(const std::vector<model::Tile>& before,
                                    const std::vector<model::Tile>& now) {
  const auto centresOf = [](const std::vector<model::Tile>& tiles) {
    Eigen::Matrix2Xd centres(2, tiles.size());
    for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
      Vector3 sum = Vector3::Zero();
      for (const Vector3& vertex : tiles[tile].vertices) sum += vertex;
      centres.col(static_cast<Eigen::Index>(tile)) =
          sum.head<2>() / static_cast<double>(tiles[tile].vertices.size());
    }
    return Eigen::Matrix2Xd(centres.colwise() - centres.rowwise().mean());
  };
  // Least squares: now = F before.
  const Eigen::Matrix2Xd from = centresOf(before), to = centresOf(now);
  const Eigen::FullPivLU<Eigen::Matrix2d> square(from * from.transpose());
  if (square.rcond() < kLeastWidth * kLeastWidth) return std::nullopt;
  const Eigen::Matrix2d F = square.solve(from * to.transpose()).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> stretch(F.transpose() * F);
  if (!(stretch.eigenvalues().minCoeff() > 0)) return std::nullopt;
  const Eigen::Matrix2d strain = stretch.eigenvectors() *
                                 (0.5 * stretch.eigenvalues().array().log()).matrix().asDiagonal() *
                                 stretch.eigenvectors().transpose();
  if (std::abs(strain(0, 0)) < kLeastStrain) return std::nullopt;
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
// counts for both of them as it is; energies are shared by halves. The sum over all bricks
// is the sum over all springs.

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
  const std::vector<brick::HingeSpring>& springs = brick::hingeSpringsOf(forces);
  const std::vector<std::array<double, 2>> moments =
      brick::endMoments(springs, brick::ligamentsOf(forces), poses);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const auto [onA, onB] = moments[s];
    double& a = largest[springs[s].hinge.brickA];
    double& b = largest[springs[s].hinge.brickB];
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
