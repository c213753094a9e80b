/// Words for how a run of dynamics ends.
#pragma once

#include <string>

#include "sim/deploy/deployment.h"
#include "sim/deploy/rest.h"
#include "sim/deploy/run_drive.h"
#include "sim/deploy/run_motion.h"

namespace kirireel {

/// How a run ended, and why, in one line.
struct RunEnding {
  Outcome outcome = Outcome::OutOfTime;  ///< how it ends
  std::string reason;                    ///< one line, as the summary has it
};

/// Says how a run stands, for the reason of its end.
class RunReasons {
 public:
  /// The parts of a run at its end; all must outlive this.
  RunReasons(const SceneBricks& bricks, const CurrentTarget& target, const RunMotion& motion,
             const RestWatch& rest)
      : bricks_(bricks), target_(target), motion_(motion), rest_(rest) {}

  /// Of bricks that came to rest: settled, or locked short of the target. What holds them up is
  /// looked for, which costs up to a factorisation, unless this `isTrial`.
  RunEnding atRest(bool isTrial) const;
  /// Of a run whose time is up.
  RunEnding late() const;

 private:
  std::string holdup() const;
  bool isImmobile() const;

  const SceneBricks& bricks_;
  const CurrentTarget& target_;
  const RunMotion& motion_;
  const RestWatch& rest_;
};

}  // namespace kirireel
