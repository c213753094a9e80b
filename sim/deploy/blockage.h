/// Which bricks are in each other's way at the target.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/deploy/search_budget.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Two bricks that would overlap at the target: contact stops the deployment before it gets there.
struct BlockingPair {
  int tileA = 0;
  int tileB = 0;            ///< above tileA
  double overlap = 0;       ///< the shortest move that would separate them there, metres
  bool isExplained = true;  ///< false: the budget was spent before it was looked what frees them
  /// The face on which joints between the two would have to lie for them not to overlap there.
  std::optional<JointFace> freeingFace;
  /// The largest thickness (metres, to a few percent) at which they do not overlap there; 0 when
  /// the tiles themselves do.
  double freeingThickness = 0;
};

/// What blocks a scene, the deepest overlap first. Empty without contacts or a target. `atTarget`:
/// the state of rest, see assembleAtTarget(); overlaps that the contacts do not look at (of pairs
/// that are left out, of the corners at shared pivots) and overlaps below 1e-4 of a tile do not
/// count. What frees a pair is looked for as long as the budget lasts.
std::vector<BlockingPair> blockingPairs(const Scene& scene, const Poses& atTarget,
                                        SearchBudget& budget);

/// "tiles 3 and 4 by 0.012 (free with joints on the top)"; lengths in metres. `countsFrom`: the
/// first tile's number.
std::string describe(const BlockingPair& pair, int countsFrom);

}  // namespace kirireel
