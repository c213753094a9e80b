#include "tests/cli/run_program.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

namespace kirireel {
namespace {

namespace fs = std::filesystem;

void redirect(int stream, const fs::path& file) {
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(opened, stream);
}

/// The child between fork and exec.
[[noreturn]] void becomeProgram(std::vector<char*> words, const ProgramSetting& setting,
                                const fs::path& prints) {
  redirect(STDOUT_FILENO, setting.output.empty() ? prints / "out" : setting.output);
  redirect(STDERR_FILENO, prints / "err");
  if (setting.largestFile) {
    const rlimit limit = {*setting.largestFile, *setting.largestFile};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  if (setting.maxMemory) {
    const rlimit limit = {*setting.maxMemory, *setting.maxMemory};
    ::setrlimit(RLIMIT_AS, &limit);
  }
  if (::chdir(setting.folder.c_str()) == 0) ::execvp(words.front(), words.data());
  ::_exit(127);
}

}  // namespace

RunningProgram::RunningProgram(const std::vector<std::string>& arguments,
                               const ProgramSetting& setting) {
  std::vector<std::string> texts = {setting.executable};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& text : texts) words.push_back(text.data());
  words.push_back(nullptr);
  process_ = ::fork();
  if (process_ == 0) becomeProgram(words, setting, folder_.path());
}

RunningProgram::~RunningProgram() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
}

void RunningProgram::sendSignal(int signal) const {
  ::kill(process_, signal);
}

ProgramEnd RunningProgram::wait() {
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = -1;
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return {code, readText(folder_ / "out"), readText(folder_ / "err")};
}

ProgramEnd runKirireel(const std::vector<std::string>& arguments, const ProgramSetting& setting) {
  return RunningProgram(arguments, setting).wait();
}

ProgramEnd runTool(const std::string& name, const std::vector<std::string>& arguments) {
  ProgramSetting setting;
  setting.executable = name;
  return RunningProgram(arguments, setting).wait();
}

bool waitFor(const fs::path& file) {
  for (int i = 0; i < 6000; ++i) {
    if (fs::exists(file)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

Json lastingSummary(const fs::path& folder) {
  Json summary = Json::parse(readText(folder / "summary.json"));
  for (const char* key : {"cost", "sha256"}) summary.erase(key);
  return summary;
}

std::vector<std::string> filesIn(const fs::path& folder) {
  std::vector<std::string> names;
  // A running program may remove folders at the same time.
  std::error_code ignored;
  for (fs::recursive_directory_iterator entry(folder, ignored), end; entry != end;
       entry.increment(ignored)) {
    if (!entry->is_regular_file(ignored)) continue;
    names.push_back(entry->path().lexically_relative(folder).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string readText(const fs::path& file) {
  return test::bytesOf(file);
}

fs::path shippedModel(const std::string& name) {
  return fs::path(KIRIREEL_SOURCE_DIR) / "data" / name;
}

}  // namespace kirireel
