#include "sim/study/closure_path.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/QR>
#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr double kClosed = 1e-12;  // metres
constexpr int kMostRounds = 50;

Vector3 meanOf(const Tile& tile) {
  Vector3 mean = Vector3::Zero();
  for (const Vector3& vertex : tile.vertices) mean += vertex;
  return mean / static_cast<double>(tile.vertices.size());
}

Vector3 turned(const Vector3& point, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * point.x() - s * point.y(), s * point.x() + c * point.y(), 0};
}

}  // namespace

double planarTurn(const Tile& from, const Tile& to) {
  const Vector3 meanFrom = meanOf(from);
  const Vector3 meanTo = meanOf(to);
  double along = 0;
  double across = 0;
  for (std::size_t k = 0; k < from.vertices.size(); ++k) {
    const Vector3 a = from.vertices[k] - meanFrom;
    const Vector3 b = to.vertices[k] - meanTo;
    along += a.x() * b.x() + a.y() * b.y();
    across += a.x() * b.y() - a.y() * b.x();
  }
  return std::atan2(across, along);
}

ClosurePath::ClosurePath(const std::vector<Tile>& tiles, const std::vector<Joint>& joints)
    : shapes_(tiles), joints_(joints) {
  for (Tile& shape : shapes_) {
    const Vector3 mean = meanOf(shape);
    for (Vector3& vertex : shape.vertices) vertex -= mean;
  }
}

PlanarState ClosurePath::stateOf(const std::vector<Tile>& placed) const {
  PlanarState state(3 * static_cast<Eigen::Index>(placed.size()));
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const Vector3 mean = meanOf(placed[i]);
    state.segment<3>(3 * static_cast<Eigen::Index>(i)) << mean.x(), mean.y(),
        planarTurn(shapes_[i], placed[i]);
  }
  return state;
}

Vector3 ClosurePath::vertex(const PlanarState& state, const Corner& corner) const {
  const auto first = 3 * static_cast<Eigen::Index>(corner.tile);
  const Vector3& point = shapes_[std::size_t(corner.tile)].vertices[std::size_t(corner.vertex)];
  return turned(point, state[first + 2]) + Vector3(state[first], state[first + 1], 0);
}

double ClosurePath::gap(const PlanarState& state) const {
  double largest = 0;
  for (const Joint& joint : joints_) {
    largest = std::max(largest, (vertex(state, joint.a) - vertex(state, joint.b)).norm());
  }
  return largest;
}

/// All joints closed, tile 0 held where it was and tile 1 turned as wanted, and what a state misses
/// of that.
ClosurePath::ClosureEquations ClosurePath::equations(const PlanarState& state, const Vector3& held,
                                                     double wanted) const {
  const auto last = 2 * static_cast<Eigen::Index>(joints_.size());
  ClosureEquations made{Eigen::MatrixXd::Zero(last + 4, state.size()),
                        Eigen::VectorXd::Zero(last + 4)};
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto row = 2 * static_cast<Eigen::Index>(j);
    const Joint& joint = joints_[j];
    made.missed.segment<2>(row) = (vertex(state, joint.a) - vertex(state, joint.b)).head<2>();
    for (const auto& [corner, sign] : {std::pair(joint.a, 1.0), std::pair(joint.b, -1.0)}) {
      const auto first = 3 * static_cast<Eigen::Index>(corner.tile);
      const Vector3 place = vertex(state, corner);
      made.slopes(row, first) += sign;
      made.slopes(row + 1, first + 1) += sign;
      made.slopes(row, first + 2) -= sign * (place.y() - state[first + 1]);
      made.slopes(row + 1, first + 2) += sign * (place.x() - state[first]);
    }
  }
  made.slopes.block<3, 3>(last, 0).setIdentity();
  made.missed.segment<3>(last) = state.head<3>() - held;
  made.slopes(last + 3, 5) = 1;
  made.slopes(last + 3, 2) = -1;
  made.missed[last + 3] = std::remainder(angle(state) - wanted, 2 * std::numbers::pi);
  return made;
}

PlanarState ClosurePath::close(PlanarState state, double wanted) const {
  const Vector3 held = state.head<3>();
  double before = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kMostRounds; ++round) {
    const ClosureEquations here = equations(state, held, wanted);
    const double worst = here.missed.lpNorm<Eigen::Infinity>();
    // On to rounding: a round that no longer halves what is missed is the last.
    if (worst < kClosed && worst > 0.5 * before) break;
    before = worst;
    state -= here.slopes.completeOrthogonalDecomposition().solve(here.missed);
  }
  if (gap(state) <= kClosed) return state;
  throw RunError(fmt::format("error: no closed state at {} radians: a gap of {:.2g} m is left",
                             wanted, gap(state)));
}

PlanarState ClosurePath::follow(PlanarState state, double wanted, double step) const {
  const double from = angle(state);
  const double way = std::remainder(wanted - from, 2 * std::numbers::pi);
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(way) / step)));
  for (int k = 1; k <= steps; ++k) state = close(std::move(state), from + way * k / steps);
  return state;
}

std::vector<Tile> ClosurePath::tiles(const PlanarState& state) const {
  std::vector<Tile> placed = shapes_;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (std::size_t k = 0; k < placed[i].vertices.size(); ++k) {
      placed[i].vertices[k] = vertex(state, {static_cast<int>(i), static_cast<int>(k)});
    }
  }
  return placed;
}

}  // namespace kirireel
