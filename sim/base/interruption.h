/// Interruption and CPU time of long operations.
#pragma once

#include <exception>
#include <functional>

namespace kirireel {

// ------------------------------------------------------------------------------------------------
// Stopping long operations from within: a large step, a search, a picture.

/// Thrown to stop an operation that the caller has cancelled. It is not an Error.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

/// Throws Interrupted or its own exception to stop the operation. Called from every thread of its
/// scope, possibly from several at once.
using InterruptionCheck = std::function<void()>;

/// While it lives, checkInterruption() on this thread calls `check`, after those of the scopes
/// around it. Scopes end in the reverse order of their beginning.
class InterruptionScope {
 public:
  /// Asks this check on its thread until it ends; scopes may lie within each other.
  explicit InterruptionScope(InterruptionCheck check);
  ~InterruptionScope();
  InterruptionScope(const InterruptionScope&) = delete;
  InterruptionScope& operator=(const InterruptionScope&) = delete;

  /// Calls the checks of all scopes of this thread, the outermost first.
  void callAll() const;

 private:
  InterruptionCheck check_;
  const InterruptionScope* outer_;  // of the same thread; null for the first
};

/// While it lives, Interrupted is caught around it on this thread, and what was done so far is
/// kept. A check that throws Interrupted does so only then.
class InterruptionCatcher {
 public:
  /// Catches SIGINT and SIGTERM from now on, to its end.
  InterruptionCatcher();
  ~InterruptionCatcher();
  InterruptionCatcher(const InterruptionCatcher&) = delete;
  InterruptionCatcher& operator=(const InterruptionCatcher&) = delete;

  /// Whether one lives on this thread.
  static bool isThere();
};

/// Long loops poll it. It runs the checks of this thread's scopes, at most every 10 ms. If it
/// throws, the caller must discard or restore its results.
void checkInterruption();

/// What checkInterruption() calls on this thread now, to be a scope of a thread that works for it.
/// This thread's scopes must outlive that.
InterruptionCheck presentChecks();

// ------------------------------------------------------------------------------------------------
// Time that the processor spent.

/// CPU seconds that the calling thread has used so far.
double threadCpuSeconds();

/// The same of all threads of this process, those that libraries started too.
double processCpuSeconds();

}  // namespace kirireel
