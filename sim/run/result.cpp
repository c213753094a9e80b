#include "sim/run/result.h"

#include <fmt/format.h>

namespace kirireel::run {

std::string toString(Outcome outcome) {
  switch (outcome) {
    case Outcome::Settled:
      return "settled";
    case Outcome::Locked:
      return "locked";
    case Outcome::OutOfTime:
      return "out_of_time";
    case Outcome::Diverged:
      return "diverged";
    case Outcome::Interrupted:
      return "interrupted";
  }
  return "unknown";
}

std::string endText(Outcome outcome, const std::string& reason) {
  return fmt::format("{}: {}", toString(outcome), reason);
}

}  // namespace kirireel::run
