#include "tests/cli/run_program.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace kirireel {
namespace {

namespace fs = std::filesystem;

fs::path makeScratchFolder() {
  std::string pattern = (fs::temp_directory_path() / "kirireel_test_XXXXXX").string();
  if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no folder for scratch files");
  return pattern;
}

void redirect(int stream, const fs::path& file) {
  const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(opened, stream);
}

/// What the child does between fork and the program.
[[noreturn]] void becomeProgram(std::vector<char*> words, const ProgramSetting& setting,
                                const fs::path& prints) {
  redirect(STDOUT_FILENO, setting.output.empty() ? prints / "out" : setting.output);
  redirect(STDERR_FILENO, prints / "err");
  if (setting.largestFile) {
    const rlimit limit = {*setting.largestFile, *setting.largestFile};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  if (setting.mostMemory) {
    const rlimit limit = {*setting.mostMemory, *setting.mostMemory};
    ::setrlimit(RLIMIT_AS, &limit);
  }
  if (::chdir(setting.folder.c_str()) == 0) ::execvp(words.front(), words.data());
  ::_exit(127);
}

}  // namespace

RunningProgram::RunningProgram(const std::vector<std::string>& arguments,
                               const ProgramSetting& setting)
    : folder_(makeScratchFolder()) {
  std::vector<std::string> texts = {setting.executable};
  texts.insert(texts.end(), arguments.begin(), arguments.end());
  std::vector<char*> words;
  for (std::string& text : texts) words.push_back(text.data());
  words.push_back(nullptr);
  process_ = ::fork();
  if (process_ == 0) becomeProgram(words, setting, folder_);
}

RunningProgram::~RunningProgram() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  fs::remove_all(folder_);
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

ScratchFolder::ScratchFolder() : path_(makeScratchFolder()) {}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::vector<std::string> filesIn(const fs::path& folder) {
  std::vector<std::string> names;
  // A program that is still running may take folders away meanwhile.
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
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void writeText(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

fs::path shippedModel(const std::string& name) {
  return fs::path(KIRIREEL_SOURCE_DIR) / "data" / name;
}

}  // namespace kirireel
