/// Ctrl-C and polite requests to end.
#pragma once

#include <optional>
#include <string>

namespace kirireel {

/// From now on SIGINT, SIGTERM and SIGHUP are noted instead of ending the program, and a full disk
/// quota is an error of the write instead of a signal. A SIGHUP that is ignored, as under nohup,
/// stays so. To be called once, before a run starts; commands that take seconds leave signals as
/// they are.
void noteSignals();

/// The name of the signal that came since the last call, such as "SIGTERM"; absent when none did.
/// Each signal ends one stage of a run. May be called from any thread; of two signals between two
/// calls the later one is told.
std::optional<std::string> takeInterrupt();

}  // namespace kirireel
