/// What is known of a path that was found: the choice among paths, the words about the one that is
/// taken, and summary.json use these figures.
#pragma once

#include <string>

namespace kirireel::deploy {

/// Overlap beyond that of the start, in tiles, up to which bricks count as clear of each other.
inline constexpr double kClearShare = 1e-4;
/// Joints that are open by more, in tiles, count as open: data that are rounded to three digits
/// leave such gaps.
inline constexpr double kOpenJoints = 1e-3;

/// How a path ends.
enum class PathEnd {
  Arrived,      ///< no state with closed joints is known that is nearer to the target
  Short,        ///< the path was followed to its end, which is farther from the target
  Stuck,        ///< the tiles stopped to follow their guide
  OutOfBudget,  ///< the budget or the caller ended it
};

/// "arrived", "short", "stuck", "out_of_budget".
std::string toString(PathEnd end);

/// One candidate and its figures. Lengths in metres.
struct PathEvaluation {
  std::string candidate;          ///< guide, contacts and joints, one short phrase
  bool hasContacts = false;       ///< whether bricks were kept apart
  PathEnd end = PathEnd::Short;   ///< how it ends
  double error = 0;               ///< target error of its last state; 0 without a target
  double overlapGrowth = 0;       ///< deepest beyond the start, at and half way between states
  double overlapGrowthAtEnd = 0;  ///< the same in the last state
  double opening = 0;             ///< largest of any joint, where joints are compliant
  int roughFrames = 0;            ///< of 360, in which the whole motion turns by over 30 degrees
  double stepChange = 0;          ///< largest change of a vertex's step from frame to frame, over
                                  ///< the usual step
  double largestTurn = 0;         ///< of the velocities of all tiles together, radians per frame
  double length = 0;              ///< see pathDistance()
  double work = 0;                ///< see SearchBudget
};

}  // namespace kirireel::deploy
