#include "sim/generate/tiling.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

using std::numbers::pi;

/// The angles of the tiles around a vertex in order, as whole multiples of a unit. Of all
/// equivalent orders, the least.
using Figure = std::vector<int>;

Figure minReading(Figure figure) {
  Figure least = figure;
  for (int mirrored = 0; mirrored < 2; ++mirrored) {
    for (std::size_t k = 0; k < figure.size(); ++k) {
      std::rotate(figure.begin(), figure.begin() + 1, figure.end());
      least = std::min(least, figure);
    }
    std::reverse(figure.begin(), figure.end());
  }
  return least;
}

/// The angles at all vertices with tiles all around.
std::map<Figure, int> innerFigures(const generate::Tiling& tiling, double unit) {
  struct Wedge {
    double from;
    double angle;
  };
  std::vector<std::vector<Wedge>> wedges(tiling.vertices.size());
  for (const std::vector<int>& tile : tiling.tiles) {
    const std::size_t count = tile.size();
    for (std::size_t k = 0; k < count; ++k) {
      const auto place = tiling.vertices[tile[k]];
      const auto next = tiling.vertices[tile[(k + 1) % count]] - place;
      const auto before = tiling.vertices[tile[(k + count - 1) % count]] - place;
      wedges[tile[k]].push_back({std::arg(next), std::arg(before / next)});
    }
  }
  std::map<Figure, int> figures;
  for (std::vector<Wedge>& round : wedges) {
    std::sort(round.begin(), round.end(),
              [](const Wedge& a, const Wedge& b) { return a.from < b.from; });
    Figure figure;
    double sum = 0;
    for (const Wedge& wedge : round) {
      figure.push_back(static_cast<int>(std::lround(wedge.angle / unit)));
      sum += wedge.angle;
    }
    if (sum > 2 * pi - 1e-6) ++figures[minReading(figure)];
  }
  return figures;
}

std::set<std::size_t> sizes(const std::map<Figure, int>& figures) {
  std::set<std::size_t> found;
  for (const auto& [figure, count] : figures) found.insert(figure.size());
  return found;
}

double thinShare(const generate::Tiling& tiling) {
  const auto thin = std::count(tiling.isThin.begin(), tiling.isThin.end(), true);
  return static_cast<double>(thin) / static_cast<double>(tiling.tiles.size());
}

TEST(Tiling, StampfliHasThePublishedRings) {
  for (const int count : {12, 24, 48, 84, 132}) {
    EXPECT_EQ(generate::stampfliTiling(count).tiles.size(), std::size_t(count));
  }
  const generate::Tiling tiling = generate::stampfliTiling(132);
  std::map<std::size_t, int> byVertices;
  for (const auto& tile : tiling.tiles) ++byVertices[tile.size()];
  EXPECT_EQ(byVertices[3], 84);  // the published 84 triangles, 24 squares and 24 narrow rhombi
  EXPECT_EQ(byVertices[4], 48);
  EXPECT_EQ(std::count(tiling.isThin.begin(), tiling.isThin.end(), true), 24);
}

TEST(Tiling, PenroseHasItsSevenVertexFigures) {
  const generate::Tiling tiling = generate::penroseTiling(3000);
  const std::map<Figure, int> figures = innerFigures(tiling, pi / 5);
  // De Bruijn 1981: D, J, K, Q, S3, S4, and S and S5, which differ only by their arrows.
  EXPECT_EQ(figures.size(), 7U);
  EXPECT_EQ(sizes(figures), (std::set<std::size_t>{3, 4, 5, 6, 7}));
  // Wide over narrow rhombi: the golden ratio. Measured 0.3816.
  EXPECT_NEAR(thinShare(tiling), 1 / (1 + std::numbers::phi), 5e-3);
}

TEST(Tiling, AmmannBeenkerHasItsSixVertexFigures) {
  const generate::Tiling tiling = generate::ammannBeenkerTiling(3000);
  const std::map<Figure, int> figures = innerFigures(tiling, pi / 4);
  EXPECT_EQ(figures.size(), 6U);  // one each of 3 to 8 tiles
  EXPECT_EQ(sizes(figures), (std::set<std::size_t>{3, 4, 5, 6, 7, 8}));
  // Rhombi over squares: the root of 2. Measured 0.586.
  EXPECT_NEAR(thinShare(tiling), std::numbers::sqrt2 / (1 + std::numbers::sqrt2), 1e-2);
}

TEST(Tiling, CoversItsPatchOnce) {
  // All inner vertices have 360 degrees around them. The tiles' area is that of the disk in which
  // the patch is complete.
  for (const generate::Tiling& tiling :
       {generate::penroseTiling(1000), generate::ammannBeenkerTiling(1000),
        generate::stampfliTiling(1000)}) {
    double area = 0, reach = 0;
    for (const std::vector<int>& tile : tiling.tiles) {
      for (std::size_t k = 0; k < tile.size(); ++k) {
        const auto a = tiling.vertices[tile[k]];
        const auto b = tiling.vertices[tile[(k + 1) % tile.size()]];
        area += 0.5 * (std::conj(a) * b).imag();
        reach = std::max(reach, std::abs(a));
        EXPECT_NEAR(std::abs(a - b), 1, 1e-12);  // measured 1e-14
      }
    }
    EXPECT_NEAR(area / (pi * reach * reach), 1, 0.12);  // measured 0.92 to 0.95
  }
}

}  // namespace
}  // namespace kirireel
