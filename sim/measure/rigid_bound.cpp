/// How near a rigid tile can come to its target: the minimax fit, bounded from below.
///
/// For residuals r_k of the vertices after a rigid motion and any weights w_k >= 0 with sum 1,
///     min over motions of max r_k  >=  sqrt(min over motions of sum w_k r_k^2),
/// since a weighted mean never exceeds the largest. The right side is the weighted Kabsch fit,
/// whose optimum over proper motions is global, so that every weighting gives a true bound of the
/// left. Lawson's iteration looks for the best weighting: w_k is multiplied by r_k and the weights
/// are scaled to sum 1 again. Vertices that hold the fit up gain weight, the others lose it, and
/// the two sides meet where the fit is the minimax one. Wherever the iteration ends, the bound is
/// true.
///
/// C. L. Lawson, "Contributions to the theory of linear least maximum approximation", 1961; C. L.
/// Lawson and R. J. Hanson, "Solving Least Squares Problems", 1974.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/base/interruption.h"
#include "sim/measure/measures.h"
#include "sim/model/alignment.h"

namespace kirireel {
namespace {

// The iteration ends once both sides agree to this part.
constexpr double kAgreement = 1e-12;
constexpr int kMostIterations = 1000;
// Of all tiles together: later tiles, which fit better, keep the bound that they have.
constexpr long kMostFits = 200'000;
// Residuals below this part of the tile's reach from the origin are rounding.
constexpr double kRounding = 1e-14;
// A vertex keeps at least this part of the largest factor: a weight of zero could never grow again.
constexpr double kLeastFactor = 1e-3;

/// A weighted fit of one tile, and what it says of the largest residual of any fit.
struct TileFit {
  std::vector<double> residuals;  ///< of the vertices, metres
  double largest = 0;             ///< of them
  double bound = 0;               ///< of the largest residual of all fits, from below
};

TileFit fitWith(const std::vector<double>& weights, const Tile& tile, const Tile& target) {
  const RigidMotion motion = bestRigidMotion(tile.vertices, target.vertices, weights);
  TileFit fit;
  double sum = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    fit.residuals.push_back((motion.apply(tile.vertices[k]) - target.vertices[k]).norm());
    sum += weights[k] * fit.residuals[k] * fit.residuals[k];
  }
  fit.largest = *std::ranges::max_element(fit.residuals);
  fit.bound = std::sqrt(sum);
  return fit;
}

std::vector<double> evenWeights(const Tile& tile) {
  return std::vector<double>(tile.vertices.size(), 1.0 / static_cast<double>(tile.vertices.size()));
}

double rounding(const Tile& target) {
  double reach = 0;
  for (const Vector3& vertex : target.vertices) reach = std::max(reach, vertex.norm());
  return kRounding * reach;
}

/// The best bound of one tile, or of what was known if no bound of this tile exceeds that. `fits`
/// counts the fits that were made.
double boundOf(const Tile& tile, const Tile& target, double known, long& fits) {
  std::vector<double> weights = evenWeights(tile);
  double bound = known;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMostIterations && fits < kMostFits; ++i) {
    checkInterruption();
    const TileFit fit = fitWith(weights, tile, target);
    ++fits;
    bound = std::max(bound, fit.bound);
    nearest = std::min(nearest, fit.largest);
    // The best motion found comes as near as the bound: no motion can come nearer.
    if (nearest <= (1 + kAgreement) * bound || nearest <= rounding(target)) break;
    double sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      // Lawson's step.
      weights[k] *= std::max(fit.residuals[k], kLeastFactor * fit.largest);
      sum += weights[k];
    }
    for (double& weight : weights) weight /= sum;
  }
  return bound;
}

}  // namespace

double rigidBound(const std::vector<Tile>& tiles, const std::vector<Tile>& target) {
  std::vector<TileFit> fits;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    checkInterruption();
    fits.push_back(fitWith(evenWeights(tiles[i]), tiles[i], target[i]));
  }
  // Tiles that fit worst come first: the others mostly need no iteration.
  std::vector<std::size_t> order(tiles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return fits[i].largest; });
  double bound = 0;
  long made = 0;
  for (const std::size_t i : order) {
    bound = std::max(bound, fits[i].bound);
    if (fits[i].largest > bound) bound = boundOf(tiles[i], target[i], bound, made);
  }
  return bound;
}

}  // namespace kirireel
