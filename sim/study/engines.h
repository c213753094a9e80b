/// The solvers that studies compare.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/deploy/dynamics.h"

namespace kirireel {

/// What holds the joints.
enum class Engine {
  Direct,             ///< our direct solver
  SequentialImpulse,  ///< Bullet's usual solver
  Nncg,               ///< Bullet's conjugate gradients
  Dantzig,            ///< Bullet's pivoting
  MultiBody,          ///< Bullet's multibodies, as PyBullet has them; no contacts
  Chipmunk,           ///< in the plane alone; no contacts
  Box2d,              ///< likewise, in single precision
  Mujoco,             ///< in joint coordinates; no contacts
};

/// "direct", "sequential impulse", ...
std::string toString(Engine engine);

/// Whether this program was built with it.
bool isAvailable(Engine engine);

/// An engine with its settings.
struct Method {
  Engine engine = Engine::Direct;
  int rate = 240;                ///< steps a simulated second
  int substeps = 1;              ///< of the engine in each step
  int iterations = 0;            ///< in each substep, of the engines that iterate; Box2D has 3/8 of
                                 ///< them for positions, one at least
  double jointCorrection = 0.2;  ///< Bullet's; see BulletSettings
  /// Of ours in time, tiles, where steps are not fixed: then `rate` is that of the longest.
  double tolerance = 0;
};

/// The baseline as PyKirigami runs it: sequential impulses, 20 substeps of 50 iterations.
Method bulletBaseline();

/// E.g. "sequential impulse 20 x 50" (substeps x iterations) or "direct 1/60 s".
std::string toString(const Method& method);

/// Makes what advances a scene's bricks from their start.
using DynamicsMaker = std::function<std::unique_ptr<Dynamics>(
    const Scene&, const std::vector<Brick>& bricks, const Poses& start)>;

/// The maker of a method's dynamics. Its engine must be available.
/// The maker may be called often, also from several threads.
DynamicsMaker dynamicsMaker(const Method& method);

}  // namespace kirireel
