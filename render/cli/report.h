/// Text about a run, exit codes, and how signals stop a run.
#pragma once

#include <optional>
#include <string>

#include "render/record/record.h"

namespace kirireel::cli {

// ------------------------------------------------------------------------------------------------
// Output for the user during and after a run.

/// Updates one line on standard error if that is a terminal; silent otherwise.
class ProgressLine {
 public:
  /// Begins a progress line on standard error if that is a terminal.
  ProgressLine();
  /// Ends the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Redraws the line if its text has changed. Shows stage and per cent.
  void show(const record::Progress& progress);
  /// The text must be shorter than the terminal's width, else the end of the line remains.
  void show(const std::string& line);

 private:
  bool isTerminal_;
  std::string shown_;
};

/// At most six lines: the outcome with its error or shortfall, the model and the path, the joints,
/// the worst overlap if there is one, the files and the time.
std::string describeRunBriefly(const scene::Scene& scene, const record::RecordSettings& settings,
                               const record::RunSummary& summary);

/// All findings of a run, with its warnings, for --verbose.
std::string describeRun(const scene::Scene& scene, const record::RecordSettings& settings,
                        const record::RunSummary& summary);

/// The report of pictures made from a recorded run: frames, seconds, files.
std::string describePictures(const record::PictureSettings& settings,
                             const record::PictureReport& report);

// ------------------------------------------------------------------------------------------------
// The program's exit codes.
//
// Scripts distinguish wrong input (2), a run that missed its goal (3) and a failure of the machine
// (1). The numbers never change.

inline constexpr int kExitDone = 0;         ///< also of a run: at its target, or without one
inline constexpr int kExitFailed = 1;       ///< diverged, could not write, does not verify
inline constexpr int kExitInputWrong = 2;   ///< the input or the command line is wrong
inline constexpr int kExitShort = 3;        ///< the run has a shortfall: see DeploymentResult
inline constexpr int kExitInterrupted = 4;  ///< by a signal

/// The exit codes as text, at the end of a command's help.
inline constexpr const char* kExitCodesHelp =
    "Exit codes: 0 done, at the target or without one; 1 failed; 2 wrong input or\n"
    "command line; 3 the target was missed, bricks overlapped, or the search used up\n"
    "its budget; 4 interrupted.";

// ------------------------------------------------------------------------------------------------
// Ctrl-C and termination signals.

/// From now on SIGINT, SIGTERM and SIGHUP are recorded instead of ending the program, and a full
/// disk quota is a write error instead of a signal. An ignored SIGHUP, as under nohup, stays
/// ignored. Call it once before a run starts. Commands of a few seconds keep the default signal
/// handling.
void noteSignals();

/// The name of the last signal since the previous call, such as "SIGTERM"; absent if there was
/// none. Each signal ends one stage of a run. Any thread may call it. Of two signals between two
/// calls it returns the later one.
std::optional<std::string> takeInterrupt();

}  // namespace kirireel::cli
