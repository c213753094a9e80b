/// What the program's exit code says.
///
/// Scripts tell a wrong order (2) from a run that ended elsewhere than it was to (3) and from a
/// failure of the machine (1); numbers stay as they are, since scripts rely on them.
#pragma once

namespace kirireel {

inline constexpr int kExitDone = 0;         ///< also of a run: at its target, or without one
inline constexpr int kExitFailed = 1;       ///< diverged, could not write, does not verify
inline constexpr int kExitInputWrong = 2;   ///< the input or the command line is wrong
inline constexpr int kExitShort = 3;        ///< the run locked or ran out of time off its target
inline constexpr int kExitInterrupted = 4;  ///< by a signal

/// The same for people, at the end of a command's help.
inline constexpr const char* kExitCodesHelp =
    "Exit codes: 0 done, a run at its target or without one; 1 failed; 2 input or command line\n"
    "wrong; 3 the run ended short of its target; 4 interrupted.";

}  // namespace kirireel
