/// Reports of the path search.
#pragma once

#include <functional>
#include <string>

#include "sim/base/fields.h"

namespace kirireel::run {

/// How a trial ended.
struct TrialEnd {
  bool arrives = false;          ///< reaches the equilibrium of the scene's springs near the target
  bool jams = false;             ///< exact joints could not be held along the path
  bool isCollisionFree = false;  ///< no overlap grows beyond the start
  double work = 0;               ///< cost of the trial, see SearchBudget

  static constexpr auto fields() {
    return describeFields<TrialEnd>(
        field("arrives", &TrialEnd::arrives), field("jams", &TrialEnd::jams),
        field("keeps_clear", &TrialEnd::isCollisionFree), field("work", &TrialEnd::work));
  }
};

/// Progress report of a search.
struct SearchNews {
  std::string what;          ///< what is being tried
  double share = 0;          ///< spent share of the budget, [0, 1]
  std::string warning = {};  ///< about the target, to be shown once; usually empty
};

/// Called at the start of a search and at each step of a trial. Return false to end the search.
using TrialObserver = std::function<bool(const SearchNews&)>;

}  // namespace kirireel::run
