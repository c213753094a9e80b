/// Ctrl-C and polite requests to end.
#pragma once

namespace kirireel {

/// From now on SIGINT and SIGTERM are noted instead of ending the program, and a full disk quota is
/// an error of the write instead of a signal.
void noteSignals();

/// True when a signal came since the last call: each signal ends one stage of a run.
bool takeInterrupt();

}  // namespace kirireel
