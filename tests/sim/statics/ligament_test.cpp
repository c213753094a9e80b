// Ligaments: derivatives, large turns, beam theory, and sheets of them.
#include <array>
#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "sim/brick/hinge.h"
#include "sim/generate/lattice.h"
#include "sim/mechanics/load_path.h"
#include "sim/statics/elastic_sheet.h"
#include "tests/support/pair_forces.h"

namespace kirireel {
namespace {

using Complex = std::complex<double>;

/// A ligament between two bricks at given positions and rotations.
struct Two {
  brick::Ligament ligament{
      .pointA = {0.3, 0.1, 0}, .pointB = {-0.2, 0.25, 0}, .start = {0.4, 0.2, 0}};
  Two() {
    ligament.stretchStiffness = 3;
    ligament.shearStiffness = 0.7;
  }
  brick::PlanarEnergy at(const Vector6& u) const {
    const Vector3 armA = rotationFromVector({0, 0, u[2]}) * ligament.pointA;
    const Vector3 armB = rotationFromVector({0, 0, u[5]}) * ligament.pointB;
    return brick::ligamentEnergy(ligament, Vector3(u[3] - u[0], u[4] - u[1], 0), armA, armB, u[2],
                                 u[5]);
  }
  /// The state of rest of the ligament.
  Vector6 rest() const {
    Vector6 u = Vector6::Zero();
    u.segment<2>(3) = (ligament.pointA + ligament.start - ligament.pointB).head<2>();
    return u;
  }
};

TEST(Ligaments, HaveTheDerivativesOfTheirEnergy) {
  const Two two;
  const double h = 1e-5;
  for (const double size : {0.1, 0.5, 1.2}) {
    Vector6 u = two.rest();
    u += size * (Vector6() << 0.2, -0.3, 0.6, 0.25, 0.35, -0.5).finished();
    const brick::PlanarEnergy found = two.at(u);
    for (int k = 0; k < 6; ++k) {
      Vector6 more = u, less = u;
      more[k] += h;
      less[k] -= h;
      const brick::PlanarEnergy above = two.at(more), below = two.at(less);
      EXPECT_NEAR(found.gradient[k], (above.energy - below.energy) / (2 * h), 1e-8);
      EXPECT_LT((found.hessian.col(k) - (above.gradient - below.gradient) / (2 * h)).norm(), 1e-7);
    }
  }
}

/// A compliant pin, closed at the start.
Two twoPinned() {
  Two two;
  two.ligament.start.setZero();
  two.ligament.across = Vector3(0.6, 0.8, 0);
  two.ligament.opening = {0.9, -0.4};
  return two;
}

TEST(Ligaments, WithoutLengthHaveTheDerivativesOfTheirEnergy) {
  const Two two = twoPinned();
  const double h = 1e-5;
  for (const double size : {0.0, 0.1, 0.5, 1.2}) {
    Vector6 u = two.rest();
    u += size * (Vector6() << 0.2, -0.3, 0.6, 0.25, 0.35, -0.5).finished();
    const brick::PlanarEnergy found = two.at(u);
    for (int k = 0; k < 6; ++k) {
      Vector6 more = u, less = u;
      more[k] += h;
      less[k] -= h;
      const brick::PlanarEnergy above = two.at(more), below = two.at(less);
      EXPECT_NEAR(found.gradient[k], (above.energy - below.energy) / (2 * h), 1e-8);
      EXPECT_LT((found.hessian.col(k) - (above.gradient - below.gradient) / (2 * h)).norm(), 1e-7);
    }
  }
}

TEST(Ligaments, WithoutLengthOpenAndSlide) {
  const Two two = twoPinned();
  Vector6 u = two.rest();
  u.segment<2>(3) += 0.1 * Vector3(0.6, 0.8, 0).head<2>();
  EXPECT_NEAR(two.at(u).energy, 0.5 * 3 * 0.01, 1e-15);
  u = two.rest();
  u.segment<2>(3) += 0.1 * Vector3(-0.8, 0.6, 0).head<2>();
  EXPECT_NEAR(two.at(u).energy, 0.5 * 0.7 * 0.01, 1e-15);
}

TEST(Ligaments, HaveNoEnergyFromRigidRotations) {
  const Two two;
  const Vector6 rest = two.rest();
  for (const double turn : {0.5, 3.0, 7.0}) {
    const Complex by = std::polar(1.0, turn);
    const Complex b = by * Complex(rest[3], rest[4]);
    Vector6 u;
    u << 5, 6, turn, 5 + b.real(), 6 + b.imag(), turn;
    EXPECT_NEAR(two.at(u).energy, 0, 1e-25);
    EXPECT_LT(two.at(u).gradient.norm(), 1e-12);
  }
}

// Up to a full turn between the bricks, however far both are turned.
TEST(Ligaments, TakeTheTurnsOfTheirBricksFromThePoses) {
  Two two;
  two.ligament.brickB = 1;
  for (const double turnA : {-9.0, -3.0, 0.0, 5.0}) {
    for (const double between : {-6.2, -3.2, -1.0, 3.1, 3.2, 6.2}) {
      Vector6 u = two.rest();
      u[2] = turnA;
      u[5] = turnA + between;
      const auto poseOf = [&](int first) {
        return Pose{Vector3(u[first], u[first + 1], 0),
                    Quaternion(Eigen::AngleAxisd(u[first + 2], Vector3::UnitZ()))};
      };
      const double stated = brick::ligamentEnergy(two.ligament, {poseOf(0), poseOf(3)}).energy;
      EXPECT_NEAR(stated, two.at(u).energy, 1e-12) << turnA << ' ' << between;  // measured 2e-15
    }
  }
}

// A slender neck that is clamped at one end. At the other end a force displaces it by F L^3 / (3 E
// I), and a moment turns it by M L / (E I).
TEST(Ligaments, WithTheirBendingAreBeams) {
  const double youngs = 2e6, width = 0.01, length = 1, thickness = 0.02;
  const double bending = youngs * thickness * width * width * width / 12;
  brick::Ligament ligament;
  ligament.pointA = ligament.pointB = Vector3::Zero();
  ligament.start = Vector3(length, 0, 0);
  brick::setNeckStiffness(youngs, 0.3, thickness, width, length, ligament);
  EXPECT_NEAR(ligament.stretchStiffness, youngs * width * thickness / length, 1e-9);
  Matrix6 hessian =
      brick::ligamentEnergy(ligament, ligament.start, Vector3::Zero(), Vector3::Zero(), 0, 0)
          .hessian;
  hessian(5, 5) += bending / length;  // of the hinge's spring
  const Matrix3 free = hessian.bottomRightCorner<3, 3>();
  const Vector3 byForce = free.inverse() * Vector3(0, 1, 0);
  const Vector3 byMoment = free.inverse() * Vector3(0, 0, 1);
  // Shear adds E w^2 / (4 * 5/6 G L^2) = 0.8e-4 to the former.
  EXPECT_NEAR(byForce.y(), length * length * length / (3 * bending), 1e-4 * byForce.y());
  EXPECT_NEAR(byForce.z(), length * length / (2 * bending), 1e-9 * byForce.z());
  EXPECT_NEAR(byMoment.z(), length / bending, 1e-9 * byMoment.z());
  EXPECT_NEAR(byMoment.y(), length * length / (2 * bending), 1e-9 * byMoment.y());
}

/// A slender neck along x between two points, as a ligament and the spring at its hinge.
struct ClampedBeam {
  brick::Ligament ligament;
  brick::HingeSpring spring{{0, 1, Vector3::UnitZ(), 0, -4, 4}};
  double bending = 0;  // E I
  static constexpr double kLength = 0.5;

  ClampedBeam() {
    const double youngs = 2e6, width = 1e-4, thickness = 0.02;
    bending = youngs * thickness * width * width * width / 12;
    ligament.brickB = 1;
    ligament.start = Vector3(kLength, 0, 0);
    ligament.pointA = Vector3(0.3, 0.2, 0);
    ligament.pointB = Vector3(-0.1, 0.4, 0);
    brick::setNeckStiffness(youngs, 0.3, thickness, width, kLength, ligament);
    spring.stiffness = bending / kLength;
  }
  /// Brick A as at the start; the neck's end at brick B moved, and that brick turned about it.
  Poses posesAt(const Vector3& moved, double turned) const {
    const Quaternion turn = rotationFromVector({0, 0, turned});
    const Vector3 end = ligament.pointA + ligament.start + moved;
    return {Pose{}, {end - turn * ligament.pointB, turn}};
  }
  std::array<double, 2> momentsAt(const Vector3& moved, double turned) const {
    const brick::EndMoments found =
        brick::endMoments(test::pairForces({spring}, {ligament}), posesAt(moved, turned)).at(0);
    return {found.onA, found.onB};
  }
};

// The end moments of a clamped beam: 6 E I d / L^2 at both ends for a displacement d across; 4 E I
// a / L at an end that turns by a, and half of that at the other.
TEST(Ligaments, PutTheMomentsOfABeamOnTheirEnds) {
  ClampedBeam beam;
  const double length = ClampedBeam::kLength, small = 1e-4;
  const double moved = 6 * beam.bending * small / (length * length);
  const double turned = 4 * beam.bending * small / length;
  for (const double sign : {1.0, -1.0}) {
    beam.spring.hinge.axis = Vector3(0, 0, sign);
    const auto [acrossA, acrossB] = beam.momentsAt({0, small, 0}, 0);
    EXPECT_NEAR(acrossA, sign * moved, 1e-6 * moved);  // measured 1.2e-7, of the shear
    EXPECT_NEAR(acrossB, sign * moved, 1e-6 * moved);
    const auto [turnA, turnB] = beam.momentsAt({0, 0, 0}, small);
    EXPECT_NEAR(turnA, -sign * 0.5 * turned, 1e-6 * turned);
    EXPECT_NEAR(turnB, -sign * turned, 1e-6 * turned);
  }
}

// The moments of a pin: of the spring, and of its opening.
TEST(Ligaments, WithoutLengthAddTheEnergyOfTheirOpening) {
  ClampedBeam pin;
  pin.ligament.start.setZero();
  pin.ligament.opening = {0.9, -0.4};
  const double a = 0.3, moment = pin.spring.stiffness * a + 0.9 * a * a - 0.4 * a * a * a;
  const auto [onA, onB] = pin.momentsAt({0, 0, 0}, a);
  EXPECT_NEAR(onA, moment, 1e-12);
  EXPECT_NEAR(onB, -moment, 1e-12);
}

TEST(Ligaments, CountInTheEnergyOfARun) {
  const ClampedBeam beam;
  const Poses start = beam.posesAt({0, 0, 0}, 0), end = beam.posesAt({0, 1e-4, 0}, 0);
  const brick::Elasticity found =
      brick::elasticityOf(test::pairForces({beam.spring}, {beam.ligament}), start, end);
  EXPECT_EQ(found.count("springs"), 1);
  EXPECT_EQ(found.count("ligaments"), 1);
  EXPECT_NEAR(found.energyStart, 0, 1e-25);
  EXPECT_EQ(found.energyEnd, brick::ligamentEnergy(beam.ligament, end).energy);
  EXPECT_NEAR(found.momentEnd, 6e-4 * beam.bending / 0.25, 1e-9 * beam.bending);
}

/// A sheet of squares whose hinges are ligaments of a length, along x.
struct LigamentSheet {
  LigamentSheet(int side, double angle, double stretch, double shear, double length) {
    generate::TessellationShape shape;
    shape.columns = shape.rows = side;
    shape.startAngle = angle;
    model = generate::makeTessellation(shape);
    bricks = brick::makeBricks(model.tiles, {0.02, brick::MassRule::Unit, 1});
    pivots = brick::makePivots(model.joints, bricks);
    for (const brick::Hinge& hinge : brick::findHinges(bricks, pivots, true).hinges) {
      springs.push_back({hinge, 1, hinge.start, 0});
    }
    for (const brick::Pivot& pivot : pivots) {
      if (pivot.isUpper) continue;
      brick::Ligament ligament{pivot.brickA, pivot.brickB};
      ligament.start = Vector3(length, 0, 0);
      ligament.pointA = pivot.pointA - 0.5 * ligament.start;
      ligament.pointB = pivot.pointB + 0.5 * ligament.start;
      ligament.stretchStiffness = stretch;
      ligament.shearStiffness = shear;
      ligaments.push_back(ligament);
    }
  }
  Poses start() const { return brick::startPoses(model.tiles, bricks); }

  model::Model model;
  std::vector<brick::Brick> bricks;
  std::vector<brick::Pivot> pivots;
  std::vector<brick::HingeSpring> springs;
  std::vector<brick::Ligament> ligaments;
};

/// Holds the left column's middles and moves those of the right.
std::vector<statics::Grip> squeeze(const LigamentSheet& sheet, int side, double amount) {
  std::vector<statics::Grip> grips(3);
  const auto middle = [&](int tile) {
    return statics::GripHandle{tile,
                               meanPoint(sheet.bricks[static_cast<std::size_t>(tile)].bottom)};
  };
  for (int k = 0; k < side; ++k) {
    grips[0].handles.push_back(middle(k));
    grips[2].handles.push_back(middle(side * (side - 1) + k));
  }
  grips[1].handles = {middle(0)};
  grips[1].direction = Vector3::UnitY();
  grips[2].amount = amount;
  return grips;
}

// An independent form of the energy in complex numbers: tiles are (z, phi), a point is z + r e^(i
// phi).
double complexEnergy(const LigamentSheet& sheet, const std::vector<Complex>& places,
                     const std::vector<double>& turns) {
  double sum = 0;
  for (const brick::Ligament& ligament : sheet.ligaments) {
    const auto point = [&](int brick, const Vector3& r) {
      const auto i = static_cast<std::size_t>(brick);
      return places[i] + Complex(r.x(), r.y()) * std::polar(1.0, turns[i]);
    };
    const Complex l =
        point(ligament.brickB, ligament.pointB) - point(ligament.brickA, ligament.pointA);
    const Complex l0(ligament.start.x(), ligament.start.y());
    const double mean = 0.5 * (turns[static_cast<std::size_t>(ligament.brickA)] +
                               turns[static_cast<std::size_t>(ligament.brickB)]);
    const double shear = std::arg(l / l0 * std::polar(1.0, -mean));
    const double stretch = std::abs(l) - std::abs(l0);
    sum += 0.5 * (ligament.stretchStiffness * stretch * stretch +
                  ligament.shearStiffness * shear * shear);
  }
  for (const brick::HingeSpring& spring : sheet.springs) {
    const double turn = turns[static_cast<std::size_t>(spring.hinge.brickB)] -
                        turns[static_cast<std::size_t>(spring.hinge.brickA)];
    sum += 0.5 * spring.stiffness * turn * turn;
  }
  return sum;
}

// Each state of 8 x 8 quads under compression is an equilibrium of the complex energy: its
// derivative by every free coordinate is 0.
TEST(Ligaments, BalanceInASheetUnderCompression) {
  const int side = 8;
  const LigamentSheet sheet(side, 0.5, 50, 2, 0.1);
  const statics::ElasticSheet elastic(sheet.bricks, sheet.start(),
                                      test::pairForces(sheet.springs, sheet.ligaments), {}, {},
                                      squeeze(sheet, side, -0.6));
  const mechanics::LoadPath path = mechanics::followLoad(elastic, 2, {}, {});
  ASSERT_TRUE(path.arrives) << path.trouble;
  const mechanics::Equilibrium& state = path.states.back();
  std::vector<Complex> places;
  std::vector<double> turns;
  for (const Pose& pose : state.poses) {
    places.emplace_back(pose.position.x(), pose.position.y());
    turns.push_back(2 * std::atan2(pose.rotation.z(), pose.rotation.w()));
  }
  EXPECT_NEAR(complexEnergy(sheet, places, turns), state.energy, 1e-10);
  const double h = 1e-6;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto slope = [&](const Complex& move, double turn) {
      const auto shifted = [&](double by) {
        std::vector<Complex> p = places;
        std::vector<double> t = turns;
        p[i] += by * move;
        t[i] += by * turn;
        return complexEnergy(sheet, p, t);
      };
      return (shifted(h) - shifted(-h)) / (2 * h);
    };
    const bool isGripped = i < 8 || i >= 56;
    EXPECT_NEAR(slope(0, 1), 0, 1e-7) << i;
    EXPECT_NEAR(i == 0 ? 0 : slope(Complex(0, 1), 0), 0, 1e-7) << i;
    EXPECT_NEAR(isGripped ? 0 : slope(1, 0), 0, 1e-7) << i;
  }
  EXPECT_LT(state.forces[2], 0);
}

// Stiff and short ligaments are nearly exact joints: the force differs by their compliance.
TEST(Ligaments, ThatAreStiffAreExactJoints) {
  const int side = 4;
  double before = 1;
  for (const double stiffness : {1e3, 1e4, 1e5}) {
    const double length = 10 / stiffness;
    const LigamentSheet sheet(side, 0.3, stiffness, stiffness * length * length, length);
    const std::vector<statics::Grip> grips = squeeze(sheet, side, 0.4);
    const statics::ElasticSheet soft(sheet.bricks, sheet.start(),
                                     test::pairForces(sheet.springs, sheet.ligaments), {}, {},
                                     grips);
    const statics::ElasticSheet exact(sheet.bricks, sheet.start(), test::pairForces(sheet.springs),
                                      sheet.pivots, {}, grips);
    const mechanics::LoadPath path = mechanics::followLoad(soft, 2, {}, {}),
                              expected = mechanics::followLoad(exact, 2, {}, {});
    ASSERT_TRUE(path.arrives && expected.arrives) << path.trouble << expected.trouble;
    const double off =
        std::abs(path.states.back().forces[2] / expected.states.back().forces[2] - 1);
    EXPECT_LT(off, before);
    before = 0.2 * off;
  }
}

}  // namespace
}  // namespace kirireel
