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

/// While it lives, checkInterruption() on this thread calls `check`. It calls the checks of outer
/// scopes first. Scopes end in the reverse order of their beginning.
class InterruptionScope {
 public:
  /// Adds a check to its thread for the scope's lifetime. Scopes may be nested.
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

/// During its lifetime, an enclosing handler on this thread catches Interrupted and keeps the
/// results so far. Checks throw Interrupted only if such a catcher exists.
class InterruptionCatcher {
 public:
  /// Registers a catcher on this thread.
  InterruptionCatcher();
  ~InterruptionCatcher();
  InterruptionCatcher(const InterruptionCatcher&) = delete;
  InterruptionCatcher& operator=(const InterruptionCatcher&) = delete;

  /// Whether a catcher exists on this thread.
  static bool exists();
};

/// Long loops poll it. It runs the checks of this thread's scopes, at most every 10 ms. If it
/// throws, the caller must discard or restore its results.
void checkInterruption();

/// The checks that checkInterruption() calls on this thread now. A worker thread opens a scope with
/// them.
/// This thread's scopes must outlive that scope.
InterruptionCheck presentChecks();

// ------------------------------------------------------------------------------------------------
// CPU time.

/// CPU seconds that the calling thread has used so far.
double threadCpuSeconds();

/// The same for all threads of this process, including those of libraries.
double processCpuSeconds();

}  // namespace kirireel
