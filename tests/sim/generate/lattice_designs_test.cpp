#include "sim/generate/lattice_designs.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

using std::numbers::pi;

double area(const std::vector<model::Tile>& tiles) {
  double sum = 0;
  for (const model::Tile& tile : tiles) sum += model::tileArea(tile);
  return sum;
}

/// Area of the tiles' outline through the given corners.
double outlineArea(const generate::TurningField& field,
                   const std::vector<generate::LatticeCorner>& round, double angle) {
  double sum = 0;
  for (std::size_t k = 0; k < round.size(); ++k) {
    const generate::LatticeCorner& next = round[(k + 1) % round.size()];
    const generate::Complex a = field.corner(round[k].cell, round[k].corner, angle);
    const generate::Complex b = field.corner(next.cell, next.corner, angle);
    sum += 0.5 * (std::conj(a) * b).imag();
  }
  return sum;
}

/// Least and largest distance of the tips from the origin.
std::pair<double, double> tipDistances(const generate::TurningField& field, double angle) {
  std::vector<double> distances;
  for (const generate::LatticeCorner& tip : generate::tips(field.lattice())) {
    distances.push_back(std::abs(field.corner(tip.cell, tip.corner, angle)));
  }
  const auto [least, most] = std::minmax_element(distances.begin(), distances.end());
  return {*least, *most};
}

TEST(LatticeDesigns, ClosedSheetsHaveNoVoids) {
  for (const generate::TurningField& field :
       {generate::heartField({4, 4}), generate::fanField({}), generate::squareToDiskField(5),
        generate::irregularField({6, 4}, 0.2, 3)}) {
    const double tiles = area(field.tiles(0));
    EXPECT_NEAR(outlineArea(field, generate::closedBoundary(field.lattice()), 0), tiles,
                1e-12 * tiles);
    // At pi the tips follow the outline. Those that close half slits come twice.
    EXPECT_NEAR(area(field.tiles(pi)), tiles, 1e-12 * tiles);
  }
}

TEST(LatticeDesigns, SquareBecomesADisk) {
  const generate::TurningField field = generate::squareToDiskField(5);
  const auto [least, most] = tipDistances(field, pi);
  EXPECT_NEAR(least, most, 1e-12);  // measured 9e-16
  EXPECT_NEAR(most, 2.8998, 1e-4);  // an independent solution of the same equations
  EXPECT_NEAR(area(field.tiles(0)), 25, 1e-12);
}

TEST(LatticeDesigns, SquaresTipsLieOnACircle) {
  const auto [least, most] = tipDistances(generate::squareToCircleField(6), pi / 2);
  EXPECT_NEAR(least, most, 1e-12);  // measured 3e-15
  EXPECT_NEAR(most, 4.89, 0.05);    // 4.8915 by an independent solution with other soft weights
}

TEST(LatticeDesigns, OpenAsOneMechanism) {
  // v(theta) = cos(theta / 2) v(0) + sin(theta / 2) v(pi), corner by corner.
  const generate::TurningField field = generate::heartField({4, 4});
  const std::vector<model::Tile> start = field.tiles(0), end = field.tiles(pi),
                                 between = field.tiles(1);
  for (std::size_t tile = 0; tile < start.size(); ++tile) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector3 expected =
          std::cos(0.5) * start[tile].vertices[k] + std::sin(0.5) * end[tile].vertices[k];
      EXPECT_LT((between[tile].vertices[k] - expected).norm(), 1e-14);  // measured 2e-15
    }
  }
}

}  // namespace
}  // namespace kirireel
