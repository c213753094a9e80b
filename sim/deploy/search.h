/// What the search for a path reports.
#pragma once

#include <functional>
#include <string>

#include "sim/base/fields.h"

namespace kirireel::deploy {

/// How a trial ended.
struct TrialEnd {
  bool arrives = false;   ///< where the scene's springs come to rest near the target
  bool jams = false;      ///< exact joints could not be held on the way
  bool cutShort = false;  ///< the budget ended it: where it leads is not known
  /// No bricks overlap on the way more than at the start, or keep compliant joints from closing.
  bool keepsClear = false;
  double error = 0;    ///< target error at its end, metres
  double opening = 0;  ///< how far compliant joints opened, metres
  double work = 0;     ///< that it cost, see SearchBudget

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<TrialEnd>(
        field("arrives", &TrialEnd::arrives), field("jams", &TrialEnd::jams),
        field("cut_short", &TrialEnd::cutShort), field("keeps_clear", &TrialEnd::keepsClear),
        field("error", &TrialEnd::error, "m"), field("opening", &TrialEnd::opening, "m"),
        field("work", &TrialEnd::work));
  }
};

/// What a search tells as it goes on.
struct SearchNews {
  std::string what;          ///< that is being tried
  double share = 0;          ///< of the budget that is spent, 0 to 1
  std::string warning = {};  ///< about the target, to be told once; seldom there
};

/// Called as a search begins and at each step of a trial; return false to stop looking.
using TrialObserver = std::function<bool(const SearchNews&)>;

}  // namespace kirireel::deploy
