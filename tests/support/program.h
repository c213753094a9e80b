/// Runs other programs, for checks that share no code with ours.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

#include <fmt/format.h>

namespace kirireel::test {

/// The Python with Debian's packages.
inline constexpr const char* kPython = "/usr/bin/python3";

/// Whether the shell finds this program.
inline bool hasProgram(const std::string& name) {
  return std::system(fmt::format("command -v {} > /dev/null 2>&1", name).c_str()) == 0;
}

/// The standard output of a shell command without its error stream; empty if it fails.
inline std::string outputOf(const std::string& command) {
  std::FILE* pipe = ::popen((command + " 2> /dev/null < /dev/null").c_str(), "r");
  if (pipe == nullptr) return {};
  std::string output;
  char buffer[65536];
  while (const std::size_t count = std::fread(buffer, 1, sizeof buffer, pipe)) {
    output.append(buffer, count);
  }
  return ::pclose(pipe) == 0 ? output : std::string();
}

}  // namespace kirireel::test
