/// Runs the real kirireel in tests.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/resource.h>
#include <sys/types.h>

#include "sim/base/files.h"
#include "tests/support/files.h"

namespace kirireel {

using test::TemporaryFolder;
using test::writeText;

/// Results of a finished program.
struct ProgramEnd {
  int exitCode = -1;  ///< minus the signal's number when a signal ended it
  std::string out;
  std::string err;
};

/// The exit code of a run that ends before its target because of its duration, as short runs do.
inline constexpr int kEndedShort = 3;

/// Settings for running a program.
struct ProgramSetting {
  std::filesystem::path folder = ".";         ///< its current folder
  std::optional<rlim_t> largestFile = {};     ///< bytes; more fails as on a full disk
  std::optional<rlim_t> maxMemory = {};       ///< bytes of its address space
  std::filesystem::path output = {};          ///< of standard output; empty: kept
  std::string executable = KIRIREEL_PROGRAM;  ///< or another program, found on the path
};

/// A program that runs in parallel with the test.
class RunningProgram {
 public:
  RunningProgram(const std::vector<std::string>& arguments, const ProgramSetting& setting);
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  void sendSignal(int signal) const;
  ProgramEnd wait();

 private:
  TemporaryFolder folder_;  ///< output of the program
  pid_t process_ = -1;
};

/// Runs kirireel to its end.
ProgramEnd runKirireel(const std::vector<std::string>& arguments,
                       const ProgramSetting& setting = {});

/// Runs another program to its end; its exit code is 127 when there is no such program.
ProgramEnd runTool(const std::string& name, const std::vector<std::string>& arguments);

/// Waits for this file for at most a minute. Returns whether it exists.
bool waitFor(const std::filesystem::path& file);

/// A run's summary without the parts that may differ between equal runs.
Json lastingSummary(const std::filesystem::path& folder);

/// The names of all files in a folder and below, sorted, relative to it.
std::vector<std::string> filesIn(const std::filesystem::path& folder);

/// The whole content of a file; "" when it cannot be read.
std::string readText(const std::filesystem::path& file);

/// A shipped model folder.
std::filesystem::path shippedModel(const std::string& name);

}  // namespace kirireel
