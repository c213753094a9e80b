/// Ctrl-C and polite requests to end.
#pragma once

#include <optional>
#include <string>

namespace kirireel {

/// From now on SIGINT, SIGTERM and SIGHUP are noted instead of ending the program, and a full disk
/// quota is an error of the write instead of a signal. A SIGHUP that is ignored, as under nohup,
/// stays so.
void noteSignals();

/// The name of the signal that came since the last call, such as "SIGTERM"; absent when none did.
/// Each signal ends one stage of a run.
std::optional<std::string> takeInterrupt();

}  // namespace kirireel
