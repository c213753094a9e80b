// Shortcuts by a local planner, as sampled paths of robots are shortened: Geraerts, Overmars
// (2007), "Creating high-quality paths for motion planning", Int. J. Robotics Research 26.
//
// A few states at even distances along the path are its nodes. From the first node on, the way to
// the farthest later node is sought by following the mechanism along the tiles' own motions from
// the one to the other, then to the one before, and so on. A way that arrives, is clear and clearly
// shorter takes the place of the states between; the search goes on from its end. Nothing is drawn
// at random. Each round halves the pieces, as long as that still gains.
#include "sim/deploy/shortcuts.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "sim/measure/measures.h"

namespace kirireel {
namespace {

// The path is cut into so many pieces, then into twice as many.
constexpr int kPieces = 8;
constexpr int kRounds = 2;
// A way counts as shorter below this factor.
constexpr double kShorter = 0.9;
// It has arrived within this part of a tile: half of what lies between two states of a path.
constexpr double kArrived = 0.01;
// So many ways in a row that gain nothing: the mechanism has no shorter ones.
constexpr int kPatience = 12;
// A way that is stuck within this part of its guide cannot leave its start.
constexpr double kNoStart = 0.05;

class Shortening {
 public:
  Shortening(const Scene& scene, MechanismPath path, double mostGrown, SearchBudget& budget,
             const PathObserver& goesOn)
      : scene_(scene),
        path_(std::move(path)),
        mostGrown_(mostGrown),
        budget_(budget),
        goesOn_(goesOn),
        bricks_(makeBricks(scene.model.tiles, scene.brick)),
        pivots_(makePivots(scene.model.joints, bricks_)),
        meter_(bricks_, pivots_, scene.environment.pivotZone, path_.states.front(), 0) {}

  // Rounds go on while one makes the path clearly shorter; else the next, with shorter pieces,
  // would be work for nothing.
  MechanismPath find() {
    for (int round = 0, pieces = kPieces; round < kRounds; ++round, pieces *= 2) {
      const double before = path_.length();
      cutAmong(nodes(pieces));
      if (isOver() || !(path_.length() < kShorter * before)) break;
    }
    return std::move(path_);
  }

 private:
  bool isOver() const { return budget_.isSpent() || (goesOn_ && !goesOn_(1)); }

  /// States at even distances along the path.
  std::vector<std::size_t> nodes(int pieces) const {
    std::vector<std::size_t> found = {0};
    for (int k = 1; k <= pieces; ++k) {
      const double length = path_.length() * k / pieces;
      const auto there = std::ranges::lower_bound(path_.lengths, length);
      const auto state = std::min(static_cast<std::size_t>(there - path_.lengths.begin()),
                                  path_.states.size() - 1);
      if (state > found.back()) found.push_back(state);
    }
    return found;
  }

  // Greedy: from each node the farthest one that a shorter way leads to.
  void cutAmong(const std::vector<std::size_t>& nodes) {
    MechanismPath kept = path_;
    kept.states.resize(1);
    kept.lengths.resize(1);
    int inVain = 0;
    for (std::size_t from = 0; from + 1 < nodes.size();) {
      std::size_t to = nodes.size() - 1;
      std::vector<Poses> way;
      for (; to > from + 1 && inVain < kPatience && !isOver(); --to) {
        bool mayStart = true;
        way = shorterWay(nodes[from], nodes[to], mayStart);
        inVain = way.empty() ? inVain + 1 : 0;
        if (!way.empty() || !mayStart) break;
      }
      if (way.empty()) {
        to = from + 1;
        way.assign(path_.states.begin() + static_cast<long>(nodes[from]) + 1,
                   path_.states.begin() + static_cast<long>(nodes[to]) + 1);
      }
      for (Poses& state : way) append(kept, std::move(state));
      from = to;
    }
    if (kept.length() < path_.length()) path_ = std::move(kept);
  }

  void append(MechanismPath& path, Poses state) const {
    path.lengths.push_back(path.length() + pathDistance(bricks_, path.states.back(), state));
    path.states.push_back(std::move(state));
  }

  /// The states after `from` up to `to` on a way that is clear and shorter; none where there is no
  /// such way. `mayStart`: whether the mechanism moves from there at all.
  std::vector<Poses> shorterWay(std::size_t from, std::size_t to, bool& mayStart) {
    // No way is shorter than the straight distance between the states, so that the search is spared
    // where even this is not short enough.
    const double least = pathDistance(bricks_, path_.states[from], path_.states[to]);
    const double present = path_.lengths[to] - path_.lengths[from];
    if (least > kShorter * present) return {};
    const double most = kShorter * present;
    MechanismPath way = connect(scene_, {path_.states[from], path_.states[to]}, budget_,
                                [&](double) { return !isOver(); });
    mayStart = !way.isStuck || way.length() > kNoStart * way.guideLength;
    const double missing = pathDistance(bricks_, way.states.back(), path_.states[to]);
    const bool arrives =
        !way.isStuck && !way.isCutShort && missing <= kArrived * tileSize(scene_.model);
    if (!arrives || way.length() + missing > most) return {};
    way.states.push_back(path_.states[to]);
    way.states.erase(way.states.begin());
    // Overlaps are measured last, because they are the dearest test.
    const bool isClear = std::ranges::all_of(
        way.states, [&](const Poses& state) { return meter_.at(state).grown <= mostGrown_; });
    return isClear ? std::move(way.states) : std::vector<Poses>{};
  }

  const Scene& scene_;
  MechanismPath path_;
  double mostGrown_;  // metres
  SearchBudget& budget_;
  const PathObserver& goesOn_;
  std::vector<Brick> bricks_;
  std::vector<Pivot> pivots_;
  PenetrationMeter meter_;
};

}  // namespace

// Whether a path is longer than its ends' distance by a factor that leaves room for shortcuts.
bool isDetour(const Scene& scene, const MechanismPath& path) {
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  return path.length() > kDetour * pathDistance(bricks, path.states.front(), path.states.back());
}

MechanismPath withShortcuts(const Scene& scene, MechanismPath path, double mostGrown,
                            SearchBudget& budget, const PathObserver& goesOn) {
  return Shortening(scene, std::move(path), mostGrown, budget, goesOn).find();
}

}  // namespace kirireel
