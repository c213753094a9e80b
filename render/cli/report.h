/// What a person reads while and after a run.
#pragma once

#include <string>

#include "render/record/record.h"

namespace kirireel {

/// Keeps one line on standard error up to date, when that is a terminal; silent otherwise.
class ProgressLine {
 public:
  ProgressLine();
  /// Ends the line.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Redraws the line when what it says has changed. Shows stage and per cent.
  void show(const Progress& progress);
  /// The text must be shorter than the terminal is wide, or the end of the line stays behind.
  void show(const std::string& line);

 private:
  bool isTerminal_;
  std::string shown_;
};

/// The summary in a few lines: outcome, accuracy, cost, files. Several lines, each with its line
/// feed.
std::string describeRun(const Scene& scene, const RecordSettings& settings,
                        const RunSummary& summary);

/// The same of pictures that were made of a recorded run. Frames, seconds, files.
std::string describePictures(const PictureSettings& settings, const PictureReport& report);

}  // namespace kirireel
