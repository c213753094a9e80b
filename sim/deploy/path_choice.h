/// Which path brings a model to its target.
#pragma once

#include <functional>
#include <string>

#include "sim/scene/scene.h"

namespace kirireel {

/// A path, and why it was taken.
struct PathChoice {
  PathSettings path;   ///< never Auto
  std::string reason;  ///< one short phrase for the summary
};

/// Called before each trial with what is tried; return false to stop looking.
using TrialObserver = std::function<bool(const std::string& what)>;

/// Chooses the scene's path where that is left to the program: tries paths without contacts, ground
/// and gravity (a path that joints forbid is no path with them either), from the simplest on, exact
/// joints before joints that give, stiff ones before soft ones, and takes the first that arrives
/// at `assembledFloor`. Where none does, the straight path is taken. A path that the scene names
/// is kept. `observer` may be empty.
PathChoice choosePath(const Scene& scene, double assembledFloor, const TrialObserver& observer);

}  // namespace kirireel
