#include "sim/measure/run_curves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "sim/measure/measures.h"
#include "sim/measure/shape.h"

namespace kirireel {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The groups with curves that have no values yet.
std::vector<CurveGroup> emptyGroups() {
  return {
      {"Size",
       "m",
       false,
       {{"width", "width_m", {}}, {"height", "height_m", {}}, {"depth", "depth_m", {}}}},
      {"Area", "m²", false, {{"hull", "hull_area_m2", {}}, {"covered", "covered_area_m2", {}}}},
      {"Hull perimeter", "m", false, {{"hull perimeter", "hull_perimeter_m", {}}}},
      {"Porosity", "", false, {{"porosity", "porosity", {}}}},
      {"Poisson's ratio", "", false, {{"Poisson's ratio", "poissons_ratio", {}}}},
      {"Opening",
       "degrees",
       false,
       {{"least", "opening_least_deg", {}},
        {"mean", "opening_mean_deg", {}},
        {"largest", "opening_largest_deg", {}}}},
      {"Kinetic energy", "J", false, {{"kinetic energy", "kinetic_energy_J", {}}}},
      {"Target error", "m", true, {{"target error", "target_error_m", {}}}},
      {"Joint gap", "m", true, {{"joint gap", "joint_gap_m", {}}}},
      {"Overlap", "m", true, {{"overlap", "penetration_m", {}}}},
  };
}

/// The kinetic energy of the way from one sample to a later one.
double kineticEnergyBetween(const std::vector<Brick>& bricks, const Sample& from, const Sample& at,
                            const Sample& to) {
  const double seconds = to.time - from.time;
  if (seconds <= 0) return 0;
  Motion motion{at.poses, {}};
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    motion.velocities.push_back(
        {(to.poses[i].position - from.poses[i].position) / seconds,
         turnBetween(from.poses[i].rotation, to.poses[i].rotation) / seconds});
  }
  return kineticEnergy(bricks, motion);
}

/// Measures one sample after the other.
class CurveMeter {
 public:
  explicit CurveMeter(const Subject& subject)
      : subject_(subject), sidesAtStart_(boxSides(subject.model.tiles)) {}

  /// The values of all curves, group by group.
  std::vector<double> at(const Sample& sample, double energy) const {
    const std::vector<Tile> tiles = bottomTiles(subject_.bricks, sample.poses);
    const Vector3 sides = boxSides(tiles);
    const HullSize hull = hullSize(tiles);
    const double covered = coveredArea(tiles).value_or(kNone);
    std::vector<double> values = {sides.x(),
                                  sides.y(),
                                  sides.z(),
                                  hull.area,
                                  covered,
                                  hull.perimeter,
                                  1 - covered / hull.area,
                                  poissonsRatio(sidesAtStart_, sides).value_or(kNone)};
    for (const double angle : openings(sample)) values.push_back(angle / kDegree);
    values.insert(values.end(),
                  {energy, subject_.model.target ? sample.targetError : kNone,
                   subject_.model.joints.empty() ? kNone : sample.jointGap, sample.penetration});
    return values;
  }

 private:
  /// Least, mean and largest, radians.
  std::vector<double> openings(const Sample& sample) const {
    const std::vector<double> angles = openingAngles(subject_.model.joints, sample.poses);
    if (angles.empty()) return {kNone, kNone, kNone};
    const auto [least, largest] = std::ranges::minmax_element(angles);
    const double sum = std::accumulate(angles.begin(), angles.end(), 0.0);
    return {*least, sum / static_cast<double>(angles.size()), *largest};
  }

  const Subject& subject_;
  Vector3 sidesAtStart_;
};

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

bool Curve::hasValues() const {
  return std::ranges::any_of(values, [](double value) { return !std::isnan(value); });
}

bool CurveGroup::hasValues() const {
  return std::ranges::any_of(curves, &Curve::hasValues);
}

RunCurves curvesOf(const TrajectoryReader& run) {
  RunCurves result{run.times(), emptyGroups()};
  const CurveMeter meter(run.subject());
  const std::size_t last = run.times().size() - 1;
  Sample before = run.sample(0), at = before;
  for (std::size_t k = 0; k <= last; ++k) {
    Sample after = k < last ? run.sample(k + 1) : at;
    const double energy = kineticEnergyBetween(run.subject().bricks, before, at, after);
    const std::vector<double> values = meter.at(at, energy);
    auto value = values.begin();
    for (CurveGroup& group : result.groups) {
      for (Curve& curve : group.curves) curve.values.push_back(*value++);
    }
    before = std::move(at);
    at = std::move(after);
  }
  return result;
}

RunCurves curvesAt(const RunCurves& curves, const std::vector<double>& times) {
  RunCurves result = curves;
  result.times = times;
  for (CurveGroup& group : result.groups) {
    for (Curve& curve : group.curves) {
      std::vector<double> values;
      for (const double time : times) values.push_back(valueAt(curves.times, curve.values, time));
      curve.values = std::move(values);
    }
  }
  return result;
}

}  // namespace kirireel
