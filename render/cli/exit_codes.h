/// What the program's exit code says.
#pragma once

namespace kirireel {

inline constexpr int kExitDone = 0;
inline constexpr int kExitRunFailed = 1;   ///< diverged, locked, interrupted, or could not write
inline constexpr int kExitInputWrong = 2;  ///< the input or the command line is wrong

}  // namespace kirireel
