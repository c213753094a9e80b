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

/// What a finished program leaves.
struct ProgramEnd {
  int exitCode = -1;  ///< minus the signal's number when a signal ended it
  std::string out;
  std::string err;
};

/// The exit code of a run whose time is up before it is at its target, as short runs' is.
inline constexpr int kEndedShort = 3;

/// How a program is run.
struct ProgramSetting {
  std::filesystem::path folder = ".";         ///< its current folder
  std::optional<rlim_t> largestFile = {};     ///< bytes; writes beyond fail as on a full disk
  std::optional<rlim_t> mostMemory = {};      ///< bytes of its address space
  std::filesystem::path output = {};          ///< where standard output goes; empty: kept
  std::string executable = KIRIREEL_PROGRAM;  ///< or another program, found on the path
};

/// A program that runs at the same time as the test.
class RunningProgram {
 public:
  RunningProgram(const std::vector<std::string>& arguments, const ProgramSetting& setting);
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  void sendSignal(int signal) const;
  ProgramEnd wait();

 private:
  TemporaryFolder folder_;  ///< holds what the program prints
  pid_t process_ = -1;
};

/// Runs kirireel to its end.
ProgramEnd runKirireel(const std::vector<std::string>& arguments,
                       const ProgramSetting& setting = {});

/// Runs another program to its end; its exit code is 127 when there is no such program.
ProgramEnd runTool(const std::string& name, const std::vector<std::string>& arguments);

/// Waits until this file exists, a minute at most; false if it then does not.
bool waitFor(const std::filesystem::path& file);

/// A run's summary without what may differ between equal runs.
Json lastingSummary(const std::filesystem::path& folder);

/// The names of all files in a folder and below, sorted, relative to it.
std::vector<std::string> filesIn(const std::filesystem::path& folder);

/// The whole content of a file; "" when it cannot be read.
std::string readText(const std::filesystem::path& file);

/// A model folder that ships with the program.
std::filesystem::path shippedModel(const std::string& name);

}  // namespace kirireel
