/// Which path brings a model to its target.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/deploy/assembled_state.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// A path, and why it was taken.
struct PathChoice {
  PathSettings path;   ///< never Auto
  std::string reason;  ///< one short phrase for the summary
};

/// How a trial ended.
struct TrialEnd {
  bool arrives = false;  ///< at the assembled error
  bool jams = false;     ///< exact joints could not be held on the way
  /// No bricks overlap on the way more than at the start, or keep joints that gave from closing.
  bool keepsClear = false;
  double error = 0;    ///< target error at its end, metres
  double opening = 0;  ///< how far joints that give opened, metres

  void transfer(StateTape& tape) { tape.transfer(arrives, jams, keepsClear, error, opening); }
};

/// Called with what is tried, at each step of a trial; return false to stop looking.
using TrialObserver = std::function<bool(const std::string& what)>;

/// What is known of the target before the search.
struct TargetRoom {
  AssembledState nearest;  ///< see assembleAtTarget()
  bool isBlocked = false;  ///< bricks would overlap there; see blockingPairs()
};

/// Chooses the scene's path where that is left to the program. Tries paths without contacts, ground
/// and gravity first (a path that joints forbid is no path with them either), from the simplest on,
/// exact joints before joints that give, stiff ones before soft ones, and takes the first that
/// arrives at the assembled error. Where bricks run into each other on it, paths are tried with
/// contacts, joints opening by at most a hundredth of a tile; fewer where bricks have no room at
/// the target. Where none arrives, the one that comes nearest without overlaps is taken, and the
/// reason says whether wider joints or thinner bricks would arrive. A path that the scene names is
/// kept. Springs without stiffness pull to nothing. Where nothing pulls to a target and the tiles'
/// misfit makes exact joints jam, joints give throughout. Trials are as the run itself. `observer`
/// may be empty. `trials` holds how the first trials ended, which are not made again, and gets the
/// others, but not one that was stopped.
PathChoice choosePath(const Scene& scene, const TargetRoom& room, const TrialObserver& observer,
                      std::vector<TrialEnd>& trials);

}  // namespace kirireel
