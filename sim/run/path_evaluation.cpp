#include "sim/run/path_evaluation.h"

namespace kirireel::run {

std::string toString(PathEnd end) {
  switch (end) {
    case PathEnd::Arrived:
      return "arrived";
    case PathEnd::Short:
      return "short";
    case PathEnd::Stuck:
      return "stuck";
    case PathEnd::WrongFolds:
      return "wrong_folds";
    case PathEnd::OutOfBudget:
      return "out_of_budget";
  }
  return "unknown";
}

}  // namespace kirireel::run
