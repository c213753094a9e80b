// Constants for tests of motion.
#pragma once

namespace kirireel::test {

inline constexpr double kGravity = 9.81;    ///< m/s^2
inline constexpr double kStep = 1.0 / 240;  ///< s, one fixed step of a run
inline constexpr double kCall = 1.0 / 60;   ///< s, from one frame to the next

}  // namespace kirireel::test
