// Equilibria along a load against closed forms: mechanisms of one angle, where the force is the
// slope of the energy.
#include "sim/mechanics/load_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "sim/statics/elastic_sheet.h"
#include "tests/support/pair_forces.h"

namespace kirireel {
namespace {

constexpr double kPi = std::numbers::pi;

/// Tiles and joints with springs at all hinges, and their supports.
struct Held {
  explicit Held(const model::Model& start, double stiffness)
      : model(start),
        bricks(brick::makeBricks(start.tiles, {0.02, brick::MassRule::Unit, 1})),
        pivots(brick::makePivots(start.joints, bricks)) {
    for (const brick::Hinge& hinge : brick::findHinges(bricks, pivots, true).hinges) {
      springs.push_back({hinge, stiffness, hinge.start, 0});
    }
  }
  statics::GripHandle vertex(int tile, int vertex) const {
    return {tile, bricks[static_cast<std::size_t>(tile)].bottom[static_cast<std::size_t>(vertex)]};
  }
  void hold(const statics::GripHandle& handle, const Vector3& direction) {
    grips.push_back({{handle}, direction, 0, false});
  }
  statics::ElasticSheet sheet() const {
    return statics::ElasticSheet(bricks, brick::startPoses(model.tiles, bricks),
                                 test::pairForces(springs), pivots, pinned, grips);
  }
  mechanics::LoadPath follow(std::size_t leading, double longestStep = 0.05) const {
    return mechanics::followLoad(sheet(), leading, {.longestStep = longestStep}, {});
  }

  model::Model model;
  std::vector<brick::Brick> bricks;
  std::vector<brick::Pivot> pivots;
  std::vector<brick::HingeSpring> springs;
  std::vector<int> pinned;
  std::vector<statics::Grip> grips;
};

const mechanics::Equilibrium& firstTurning(const mechanics::LoadPath& path,
                                           mechanics::Turning turning) {
  const auto found = std::ranges::find(path.states, turning, &mechanics::Equilibrium::turning);
  return found == path.states.end() ? path.states.front() : *found;
}

// A unit of four squares, one held and one turned by t, has four hinges that turn by t each:
// energy 2 k t^2, moment 4 k t.
TEST(LoadPath, OfARotatingSquareUnitIsItsClosedForm) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  shape.startAngle = 0.2;
  Held unit(generate::makeTessellation(shape), 3);
  unit.pinned = {0};
  unit.grips = {{{{.brick = 1, .isTurn = true}}, Vector3::UnitX(), 1.5, false}};
  const mechanics::LoadPath path = unit.follow(0);
  EXPECT_TRUE(path.arrives) << path.trouble;
  for (const mechanics::Equilibrium& state : path.states) {
    const double turn = state.displacements[0];
    EXPECT_NEAR(turn, 1.5 * state.load, 1e-12);
    EXPECT_NEAR(state.energy, 6 * turn * turn, 1e-10);
    EXPECT_NEAR(state.forces[0], 12 * turn, 1e-9);
    EXPECT_NEAR(state.stiffness, 12, 1e-8);
    EXPECT_EQ(state.unstableModes, 0);
  }
}

/// Unit diamonds in a row, corner to corner, the k-th turned by an angle.
model::Model chain(const std::vector<double>& angles) {
  model::Model model;
  Vector3 at = Vector3::Zero();
  for (const double angle : angles) {
    const Vector3 along(std::cos(angle), std::sin(angle), 0);
    const Vector3 across(-along.y(), along.x(), 0);
    model.tiles.push_back(
        {{at, at + 0.5 * along - 0.5 * across, at + along, at + 0.5 * along + 0.5 * across}});
    at += along;
  }
  for (int k = 0; k + 1 < static_cast<int>(angles.size()); ++k) {
    model.joints.push_back({{k, 2}, {k + 1, 0}, model::JointFace::Both});
  }
  return model;
}

/// A chain whose ends stay on the x axis, its last corner pushed or moved along it.
Held chainAlongX(const std::vector<double>& angles, double amount, bool isForce) {
  Held held(chain(angles), 2);
  const int last = static_cast<int>(angles.size()) - 1;
  held.hold(held.vertex(0, 0), Vector3::UnitX());
  held.hold(held.vertex(0, 0), Vector3::UnitY());
  held.hold(held.vertex(last, 2), Vector3::UnitY());
  held.grips.push_back({{held.vertex(last, 2)}, Vector3::UnitX(), amount, isForce});
  return held;
}

// Two squares as a roof of slope b: with k (2 a - 2 a0)^2 / 2 and the length 2 cos b the pull is
// F = 2 k (b0 - b) / sin b.
TEST(LoadPath, OfAChainUnderTensionIsItsClosedForm) {
  for (const bool isForce : {false, true}) {
    const double start = 0.9;
    const mechanics::LoadPath path =
        chainAlongX({start, -start}, isForce ? 20 : 2 * (std::cos(0.15) - std::cos(start)), isForce)
            .follow(3);
    EXPECT_TRUE(path.arrives) << path.trouble;
    EXPECT_GT(path.states.size(), 10u);
    for (const mechanics::Equilibrium& state : path.states) {
      const double slope = std::acos(0.5 * (2 * std::cos(start) + state.displacements[3]));
      const double force = 4 * (start - slope) / std::sin(slope);
      EXPECT_NEAR(state.forces[3], force, 1e-8);
      EXPECT_NEAR(state.energy, 4 * (start - slope) * (start - slope), 1e-9);
      EXPECT_EQ(state.unstableModes, 0);
    }
  }
}

// A straight chain of n rigid links with springs between them buckles at 2 k (1 - cos(pi / n)).
TEST(LoadPath, FindsTheBucklingLoadOfAChain) {
  for (const int count : {2, 3, 5, 12}) {
    const mechanics::LoadPath path =
        chainAlongX(std::vector<double>(static_cast<std::size_t>(count), 0.0), -5, true).follow(3);
    const mechanics::Equilibrium& critical = firstTurning(path, mechanics::Turning::Bifurcation);
    const double expected = 4 * (1 - std::cos(kPi / count));
    EXPECT_NEAR(-critical.forces[3], expected, 1e-7 * expected) << count;  // measured 6e-9 at most
  }
}

// A straight chain that is pressed far has a bifurcation at each load 2 k (1 - cos(j pi / n)), and
// one more unstable mode behind each. Short steps, and one step over all, find all of them.
TEST(LoadPath, FindsEachOfSeveralBifurcationsInOneStep) {
  const int count = 7;
  for (const double longestStep : {0.02, 0.3, 5.0}) {
    const mechanics::LoadPath path =
        chainAlongX(std::vector<double>(count, 0.0), -5, true).follow(3, longestStep);
    EXPECT_TRUE(path.arrives) << path.trouble;
    int found = 0;
    for (const mechanics::Equilibrium& state : path.states) {
      if (state.turning == mechanics::Turning::None) continue;
      EXPECT_EQ(state.turning, mechanics::Turning::Bifurcation);
      ++found;
      const double expected = 4 * (1 - std::cos(found * kPi / count));
      EXPECT_NEAR(-state.forces[3], expected, 1e-7 * expected) << longestStep;
    }
    EXPECT_EQ(found, 4);  // 4 (1 - cos(4 pi / 7)) = 4.89, the next is at 6.49
    EXPECT_EQ(path.states.back().unstableModes, 4);
  }
}

TEST(LoadPath, IsTheSameForAnyNumberOfStates) {
  std::vector<double> last;
  std::size_t turnings = 0;
  for (const int states : {1, 10, 300}) {
    const Held chain = chainAlongX({0.3, -0.1, 0.2, -0.4, 0.2}, -6, true);
    const mechanics::LoadPath path =
        mechanics::followLoad(chain.sheet(), 3, {.minStates = states}, {});
    ASSERT_TRUE(path.arrives) << path.trouble;
    EXPECT_GE(static_cast<int>(path.states.size()), states);
    const mechanics::Equilibrium& end = path.states.back();
    const std::vector<double> now = {end.energy, end.displacements[3], end.stiffness};
    const auto count = static_cast<std::size_t>(
        std::ranges::count_if(path.states, [](const mechanics::Equilibrium& state) {
          return state.turning != mechanics::Turning::None;
        }));
    if (states == 1) {
      last = now;
      turnings = count;
    }
    EXPECT_EQ(now, last);
    EXPECT_EQ(count, turnings);
  }
}

/// A four-bar linkage: a base of length d along x, a rocker of length a at its origin with a
/// spring, a crank of length c at its other end, and a coupler of length b between them.
struct FourBar {
  double a = 2, b = 2, c = 1, d = 2.2;

  /// The rocker's angle for that of the crank.
  double rocker(double crank) const {
    const Vector3 end(d + c * std::cos(crank), c * std::sin(crank), 0);
    const double reach = end.norm();
    return std::atan2(end.y(), end.x()) +
           std::acos((a * a + reach * reach - b * b) / (2 * a * reach));
  }
  Vector3 rockerEnd(double crank) const {
    return a * Vector3(std::cos(rocker(crank)), std::sin(rocker(crank)), 0);
  }
  Vector3 crankEnd(double crank) const { return {d + c * std::cos(crank), c * std::sin(crank), 0}; }
  /// Of k (rocker - rest)^2 / 2, by the crank's angle.
  double moment(double crank, double stiffness, double rest) const {
    // The coupler keeps its length: the ends' velocities along it are equal.
    const Vector3 coupler = crankEnd(crank) - rockerEnd(crank);
    const Vector3 crankMove(-c * std::sin(crank), c * std::cos(crank), 0);
    const Vector3 rockerMove = a * Vector3(-std::sin(rocker(crank)), std::cos(rocker(crank)), 0);
    return stiffness * (rocker(crank) - rest) * coupler.dot(crankMove) / coupler.dot(rockerMove);
  }
};

/// Triangles as bars. The only spring is at the rocker's foot.
Held fourBar(const FourBar& bars, double crank, double stiffness) {
  const Vector3 foot = Vector3::Zero(), base(bars.d, 0, 0);
  const Vector3 p = bars.rockerEnd(crank), q = bars.crankEnd(crank);
  const auto bar = [](const Vector3& from, const Vector3& to, double side) {
    const Vector3 along = to - from;
    const Vector3 across = 0.05 * Vector3(-along.y(), along.x(), 0);
    return side > 0 ? model::Tile{{from, to, 0.5 * (from + to) + across}}
                    : model::Tile{{to, from, 0.5 * (from + to) - across}};
  };
  model::Model model;
  model.tiles = {bar(foot, base, -1), bar(foot, p, 1), bar(base, q, -1), bar(p, q, 1)};
  model.joints = {{{0, 1}, {1, 0}, model::JointFace::Both},
                  {{0, 0}, {2, 1}, model::JointFace::Both},
                  {{1, 1}, {3, 0}, model::JointFace::Both},
                  {{2, 0}, {3, 1}, model::JointFace::Both}};
  Held held(model, stiffness);
  held.pinned = {0};
  for (brick::HingeSpring& spring : held.springs) {
    const bool isAtFoot = spring.hinge.brickA + spring.hinge.brickB == 1;
    if (!isAtFoot) spring.stiffness = 0;
  }
  return held;
}

/// The maximum of a function with one maximum between two points (golden section).
template <typename Function>
double maximum(const Function& f, double low, double high) {
  const double share = 0.5 * (std::sqrt(5.0) - 1);
  while (high - low > 1e-9) {
    const double left = high - share * (high - low), right = low + share * (high - low);
    (f(left) < f(right) ? low : high) = f(left) < f(right) ? left : right;
  }
  return 0.5 * (low + high);
}

// The rocker's angle rises and falls as the crank turns. Its spring is therefore at rest in two
// states, with a barrier between them.
TEST(LoadPath, FindsBothStatesOfABistableLinkageAndItsSnapThrough) {
  const FourBar bars;
  const double start = 1.6, stiffness = 5;
  const double rest = bars.rocker(start);
  const double top = maximum([&](double crank) { return bars.rocker(crank); }, start, start + 2);
  double low = top, high = top + 2;  // the other state is between them
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (bars.rocker(middle) > rest ? low : high) = middle;
  }
  const auto moment = [&](double crank) { return bars.moment(crank, stiffness, rest); };
  const double snap = moment(maximum(moment, start, top));
  for (const bool isForce : {false, true}) {
    Held held = fourBar(bars, start, stiffness);
    held.grips = {{{{.brick = 2, .isTurn = true}},
                   Vector3::UnitX(),
                   isForce ? 1.5 * snap : low - start,
                   isForce}};
    const mechanics::LoadPath path = held.follow(0);
    EXPECT_TRUE(path.arrives) << path.trouble;
    for (const mechanics::Equilibrium& state : path.states) {
      const double expected = moment(start + state.displacements[0]);
      EXPECT_NEAR(state.forces[0], expected, 1e-7) << state.displacements[0];
    }
    const mechanics::Equilibrium& limit = firstTurning(
        path, isForce ? mechanics::Turning::LoadLimit : mechanics::Turning::ForceLimit);
    EXPECT_NEAR(limit.forces[0], snap, 1e-8 * snap);  // measured 3e-13
    if (isForce) continue;
    EXPECT_NEAR(path.states.back().forces[0], 0, 1e-8);
    EXPECT_NEAR(path.states.back().energy, 0, 1e-8);
    EXPECT_GT(path.states.back().stiffness, 0);
  }
}

/// A triangle that turns in a frame, on three ligaments from its corners, a from the middle, to
/// points of the frame, b from it. All ligaments are shortest at the dead point, and at rest at the
/// angle `rest` on either side of it.
struct TurningTriangle {
  double a = 0.5, b = 1.2, rest = 0.4, stiffness = 30;

  double length(double angle) const {
    return std::sqrt(a * a + b * b - 2 * a * b * std::cos(angle));
  }
  double energy(double angle) const {
    const double stretch = length(angle) - length(rest);
    return 1.5 * stiffness * stretch * stretch;
  }
  double moment(double angle) const {
    return 3 * stiffness * (1 - length(rest) / length(angle)) * a * b * std::sin(angle);
  }
  /// The frame is a large triangle, whose corners have no joints; tile 1 turns in it.
  statics::ElasticSheet sheet(double amount, bool isForce) const {
    const auto corner = [](double radius, double angle) {
      return Vector3(radius * std::cos(angle), radius * std::sin(angle), 0);
    };
    model::Tile frame, inner;
    for (int k = 0; k < 3; ++k) {
      frame.vertices.push_back(corner(3, 2 * kPi * k / 3));
      inner.vertices.push_back(corner(a, 2 * kPi * k / 3 - rest));
    }
    const std::vector<brick::Brick> bricks =
        brick::makeBricks({frame, inner}, {0.02, brick::MassRule::Unit, 1});
    std::vector<brick::Ligament> ligaments;
    for (int k = 0; k < 3; ++k) {
      brick::Ligament ligament{.brickA = 1, .brickB = 0};
      ligament.pointA = inner.vertices[static_cast<std::size_t>(k)];
      ligament.pointB = corner(b, 2 * kPi * k / 3);
      ligament.start = ligament.pointB - ligament.pointA;
      ligament.stretchStiffness = stiffness;
      ligaments.push_back(ligament);
    }
    const statics::GripHandle middle{.brick = 1};
    return statics::ElasticSheet(
        bricks, brick::startPoses({frame, inner}, bricks), test::pairForces({}, ligaments), {}, {0},
        {{{{.brick = 1, .isTurn = true}}, Vector3::UnitX(), amount, isForce},
         {{middle}, Vector3::UnitX(), 0, false},
         {{middle}, Vector3::UnitY(), 0, false}});
  }
};

// The unit of bistable auxetic sheets of triangles: both states, the force along the whole path
// between them, and where it snaps, against E = 3 k (l - l0)^2 / 2 with the law of cosines.
TEST(LoadPath, FindsBothStatesOfABistableTriangleAndItsSnapThrough) {
  const TurningTriangle unit;
  const double peak = -maximum([&](double angle) { return unit.moment(-angle); }, 0, unit.rest);
  const double snap = unit.moment(peak);
  for (const bool isForce : {false, true}) {
    const mechanics::LoadPath path = mechanics::followLoad(
        unit.sheet(isForce ? 1.5 * snap : 2 * unit.rest, isForce), 0, {.longestStep = 0.05}, {});
    EXPECT_TRUE(path.arrives) << path.trouble;
    for (const mechanics::Equilibrium& state : path.states) {
      const double angle = state.displacements[0] - unit.rest;
      EXPECT_NEAR(state.forces[0], unit.moment(angle), 1e-7 * snap);  // measured 1.2e-8
      EXPECT_NEAR(state.energy, unit.energy(angle), 1e-9);
    }
    const mechanics::Equilibrium& limit = firstTurning(
        path, isForce ? mechanics::Turning::LoadLimit : mechanics::Turning::ForceLimit);
    EXPECT_NEAR(limit.forces[0], snap, 1e-9 * snap);
    EXPECT_NEAR(limit.displacements[0] - unit.rest, peak, 1e-6);
    if (isForce) continue;
    const mechanics::Equilibrium& other = path.states.back();
    EXPECT_NEAR(other.forces[0], 0, 1e-7 * snap);
    EXPECT_NEAR(other.energy, 0, 1e-12);
    EXPECT_GT(other.stiffness, 0);
    EXPECT_EQ(other.unstableModes, 0);
  }
}

// 4 x 4 squares that a force closes and pushes through: with the width 3 (cos(t/2) + sin(t/2)) and
// 24 springs the pull is 16 k (t - t0) / (cos(t/2) - sin(t/2)). Their constraints are redundant at
// t = 0, and nearly redundant around it.
TEST(LoadPath, LeadsThroughClosedSquares) {
  const double open = kPi / 6, stiffness = 0.02;
  generate::TessellationShape shape;
  shape.startAngle = open;
  Held held(generate::makeTessellation(shape), stiffness);
  const auto middles = [&](int column) {
    std::vector<statics::GripHandle> handles;
    for (int tile = 4 * column; tile < 4 * column + 4; ++tile) handles.push_back({.brick = tile});
    return handles;
  };
  held.grips = {{middles(0), Vector3::UnitX(), 0, false},
                {{{.brick = 0}}, Vector3::UnitY(), 0, false},
                {middles(3), Vector3::UnitX(), -0.4, true}};
  const mechanics::LoadPath path = held.follow(2);
  EXPECT_TRUE(path.arrives) << path.trouble;
  EXPECT_LT(path.states.back().displacements[2], -0.7);  // closed at -0.674
  for (const mechanics::Equilibrium& state : path.states) {
    // width = 3 sqrt(2) sin(t/2 + pi/4)
    const double width = 3 * (std::cos(open / 2) + std::sin(open / 2)) + state.displacements[2];
    const double angle = 2 * std::asin(width / std::sqrt(18.0)) - kPi / 2;
    const double force =
        16 * stiffness * (angle - open) / (std::cos(angle / 2) - std::sin(angle / 2));
    EXPECT_NEAR(state.forces[2], force, 1e-9) << angle;
    EXPECT_NEAR(state.energy, 12 * stiffness * (angle - open) * (angle - open), 1e-9);
    EXPECT_EQ(state.unstableModes, 0);
    EXPECT_EQ(state.turning, mechanics::Turning::None);
  }
}

// Squares are longest at 90 degrees, and can turn back to two sides.
TEST(LoadPath, ReportsWhyItDoesNotLeaveALimitOfTheMechanism) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  shape.startAngle = 0.5 * kPi;
  Held unit(generate::makeTessellation(shape), 3);
  const auto middle = [](int tile) { return statics::GripHandle{.brick = tile}; };
  for (const int tile : {0, 1}) unit.hold(middle(tile), Vector3::UnitX());
  unit.hold(middle(0), Vector3::UnitY());
  unit.grips.push_back({{middle(2), middle(3)}, Vector3::UnitX(), -0.2, false});
  const mechanics::LoadPath path = unit.follow(3);
  EXPECT_FALSE(path.arrives);
  EXPECT_EQ(path.trouble,
            "no equilibrium was found beyond the load 0; start slightly away from the point where "
            "the sheet may turn back");
}

TEST(LoadPath, IsRefusedWithoutStiffness) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  shape.startAngle = 0.2;
  Held unit(generate::makeTessellation(shape), 3);
  unit.grips = {{{{.brick = 1, .isTurn = true}}, Vector3::UnitX(), 1.5, false}};
  try {
    unit.follow(0);
    FAIL();
  } catch (const RunError& error) {
    EXPECT_STREQ(error.what(),
                 "error: the sheet can move without resistance. Hold it with grips or `pin`, and "
                 "add springs at its hinges (`hinge_stiffness`)");
  }
}

}  // namespace
}  // namespace kirireel
