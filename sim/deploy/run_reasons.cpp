// Words for how a run ends. What keeps a run from its target is named by the first of these that
// holds: contacts that carry load; steps that fail; joints that leave no freedom; a state that is
// the nearest with closed joints; springs at hinges; else the pull balances itself.
#include "sim/deploy/run_reasons.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/deploy/forces.h"
#include "sim/measure/measures.h"
#include "sim/measure/sheet.h"

namespace kirireel {
namespace {

// Joints with this multiple of the usual stiffness let tiles move that have no freedom.
constexpr double kGivingShare = 1e3;

// Of the contacts that hold a run up, so many are named.
constexpr std::size_t kPairsNamed = 3;

/// "contact stops tiles 3 and 4, tile 5 and the ground and 2 more".
std::string contactWords(std::vector<std::string> contacts) {
  const std::size_t count = contacts.size();
  contacts.resize(std::min(count, kPairsNamed));
  std::string text = fmt::format("contact stops {}", fmt::join(contacts, ", "));
  if (count > kPairsNamed) text += fmt::format(" and {} more", count - kPairsNamed);
  return text;
}

}  // namespace

RunEnding RunReasons::atRest(bool isTrial) const {
  if (!target_.isPulledTo()) {
    return {Outcome::Settled, target_.tiles()
                                  ? "everything came to rest; nothing pulls to the target"
                                  : "everything came to rest; there is no target"};
  }
  const double error = target_.error(motion_.poses());
  if (target_.hasArrived(motion_.poses())) {
    return {Outcome::Settled, fmt::format("came to rest {:.3g} from the target", error)};
  }
  return {Outcome::Locked, fmt::format("came to rest {:.3g} short of the target: {}", error,
                                       isTrial ? "" : holdup())};
}

RunEnding RunReasons::late() const {
  const StopRules& stop = bricks_.scene.stop;
  const double speed = fastestSpeed(motion_.now().velocities, bricks_.tileSize);
  const bool isSlow = speed < stop.settleSpeed * bricks_.size;
  std::string text = fmt::format(
      "{} after {:.4g} s", isSlow ? "not known to be at rest" : "still moving", stop.duration);
  text += fmt::format(", at {:.2g} m/s at most", speed);
  if (target_.isPulledTo()) {
    text += fmt::format(", {:.3g} from the target", target_.error(motion_.poses()));
  }
  return {Outcome::OutOfTime, text};
}

// Whether the joints leave the tiles no motion but that of the whole.
bool RunReasons::isImmobile() const {
  const Freedom freedom = bricks_.needs.planar.on ? Freedom::Plane : Freedom::Space;
  const Mobility found = mobility(bricks_.scene.model, bottomTiles(bricks_.bricks, motion_.poses()),
                                  freedom, bricks_.scene.brick.thickness);
  return found.isCounted && found.freedoms <= 0;
}

// What keeps a run from its target that has come to rest.
std::string RunReasons::holdup() const {
  if (bricks_.scene.solver.kind == SolverKind::Bullet) return "the baseline does not tell why";
  const std::vector<std::string> contacts = motion_.solver().loadedContacts();
  if (!contacts.empty()) return contactWords(contacts);
  if (rest_.isStuck(motion_.poses())) return "exact joints leave the tiles no way on";
  if (isImmobile()) {
    return fmt::format(
        "the joints leave the tiles no way to move (0 degrees of freedom); compliant joints would "
        "(--path guided --joint-stiffness {:.1g})",
        kGivingShare * usualStiffness(bricks_.scene.springs, bricks_.bricks));
  }
  if (target_.isReachedAt(target_.error(motion_.poses()))) {
    return "no state with closed joints was found nearer";
  }
  if (bricks_.scene.hinges.areOn()) return "the springs at the hinges hold them";
  return "a local minimum of the pull, no small move brings the tiles nearer";
}

}  // namespace kirireel
