/// Scenes that are hard on joint solvers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim/study/stepped_scene.h"

namespace kirireel {

/// One hard case, as a scene that is stepped and judged.
struct HardTrial {
  std::string name;           ///< of the case, as tables have it
  std::string tried;          ///< one phrase: what is hard
  Scene scene;                ///< to be run
  std::vector<Brick> bricks;  ///< empty: as the scene's rule makes them
  int rate = 240;             ///< steps a simulated second
  double seconds = 1;         ///< simulated
  std::string errorMeaning;   ///< what `error` measures
  std::function<double(const SteppedScene&, double time)> error;  ///< metres
};

/// All trials that are stepped; the largest sheets only in the full study.
std::vector<HardTrial> hardTrials(bool quick);

/// An input that is to be refused.
struct Refusal {
  std::string name;           ///< of the case
  std::string tried;          ///< one phrase
  std::function<void()> run;  ///< throws InputError
};

/// Inputs that no run can make sense of.
std::vector<Refusal> refusals();

}  // namespace kirireel
