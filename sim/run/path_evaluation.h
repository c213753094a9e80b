/// Figures of a path. The selection of a path, its description and summary.json use these figures.
#pragma once

#include <string>

namespace kirireel::run {

/// Growth of overlap beyond the start, in tiles, up to which a path counts as collision-free.
inline constexpr double kAllowedOverlap = 1e-4;
/// Joints with larger gaps, in tiles, count as open. Data that are rounded to three digits have
/// such gaps.
inline constexpr double kAllowedOpening = 1e-3;

/// How a path ends.
enum class PathEnd {
  Arrived,      ///< no nearer state with closed joints is known
  Short,        ///< the path was followed to its end, which is farther from the target
  Stuck,        ///< the tiles no longer follow their guide
  WrongFolds,   ///< at the target, but folds of half a turn are on the wrong side on the path
  OutOfBudget,  ///< the budget or the caller ended it
};

/// "arrived", "short", "stuck", "wrong_folds", "out_of_budget".
std::string toString(PathEnd end);

/// One candidate and its figures. Lengths in metres.
struct PathEvaluation {
  std::string candidate;          ///< guide, contacts and joints, one short phrase
  bool hasContacts = false;       ///< whether bricks were kept apart
  PathEnd end = PathEnd::Short;   ///< how the path ends
  double error = 0;               ///< target error of its last state; 0 without a target
  double overlapGrowth = 0;       ///< deepest beyond the start, at states and between them
  double overlapGrowthAtEnd = 0;  ///< the same in the last state
  double opening = 0;             ///< largest of any joint, if joints are compliant
  int roughFrames = 0;            ///< of 360, in which the whole motion rotates by over 30 degrees
  double stepChange = 0;          ///< largest change of a vertex's step between frames, over the
                                  ///< typical step
  double largestTurn = 0;         ///< angle between the velocities of all tiles, radians per frame
  double length = 0;              ///< see pathDistance()
  double work = 0;                ///< see SearchBudget
};

}  // namespace kirireel::run
