// Starts programs by posix_spawnp (POSIX.1-2008) and not by a shell: arguments are passed
// unchanged, and no name can be read as a command. Input is /dev/null: a program that asks a
// question ends instead of waiting. Output and errors go to one log, in order.
#include "render/fea/outside_program.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/base/files.h"
#include "sim/base/geometry.h"

extern char** environ;

namespace kirireel::fea {

WorkFolder::WorkFolder() {
  // mkdtemp replaces the six X and makes the folder accessible only to its user (mode 0700).
  std::string name = (std::filesystem::temp_directory_path() / "kirireel-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw OutputError(fmt::format("{}: error: cannot be made ({})", name,
                                  std::generic_category().message(errno)));
  }
  path_ = name;
}

WorkFolder::~WorkFolder() {
  // A destructor must not throw; files that cannot be removed stay in the temporary folder.
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string writtenText(const std::string& file) {
  // Results of large meshes have gigabytes; more than four are not read into memory.
  constexpr std::uintmax_t kMaxBytes = std::uintmax_t{4} << 30;
  if (!isFile(file)) return {};
  return readTextFile(file, "", kMaxBytes);
}

int runProgram(std::vector<std::string> words, const std::string& log, const std::string& advice) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  // The list of arguments ends with a null pointer, as execvp requires.
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, 1, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::posix_spawn_file_actions_adddup2(&actions, 1, 2);
  const std::string folder = std::filesystem::path(log).parent_path().string();
  // The "np" means that it is not in POSIX.1-2008; glibc has it from 2.29 on.
  ::posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  pid_t process = 0;
  const int failure =
      ::posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    throw InputError(fmt::format("error: the program {} cannot be run ({}); {}", words[0],
                                 std::generic_category().message(failure), advice));
  }
  int end = 0;
  // A signal that the caller handles ends the wait early; the program still runs.
  while (::waitpid(process, &end, 0) < 0 && errno == EINTR) {
  }
  return end;
}

// ------------------------------------------------------------------------------------------------
// Gmsh runs as `gmsh -2 sheet.geo -format msh22 -o sheet.msh -nt 1 -v 2 -nopopup`. -2 meshes
// surfaces, format 2.2 is the simplest to read, -v 2 logs only errors and warnings, and one thread
// gives the same mesh in every run. It is an external program and not a library, so only sheets
// with necks require it.

namespace {

/// The file with this name that Gmsh writes for a geometry. `words` are its arguments.
std::string writtenByGmsh(const std::string& geometry, const std::string& name,
                          const std::vector<std::string>& words, const char* use,
                          const char* failure) {
  const WorkFolder folder;
  const std::string input = folder / "sheet.geo";
  const std::string output = folder / name;
  const std::string log = folder / "log";
  writeTextFile(input, geometry);
  std::vector<std::string> all = {"gmsh", input, "-o", output, "-nt", "1", "-v", "2", "-nopopup"};
  all.insert(all.end(), words.begin(), words.end());
  const int end =
      runProgram(all, log,
                 fmt::format("{}: install it (Debian: apt-get install gmsh) or choose {}", use,
                             name.ends_with(".msh") ? "other --joints" : "another format"));
  std::string text = writtenText(output);
  if (end == 0 && !text.empty()) return text;
  // The first error is the cause of later ones.
  const std::string messages = writtenText(log);
  std::size_t first = messages.find("Error");
  if (first == std::string::npos) first = 0;
  throw RunError(fmt::format("error: gmsh cannot {} ({})", failure,
                             messages.substr(first, messages.find('\n', first) - first)));
}

}  // namespace

std::string meshedByGmsh(const std::string& geometry) {
  return writtenByGmsh(geometry, "sheet.msh", {"-2", "-format", "msh22"},
                       "it meshes sheets with necks", "mesh this sheet");
}

std::string stepByGmsh(const std::string& geometry) {
  std::string text = writtenByGmsh(geometry, "sheet.step", {"-0"}, "it writes STEP files",
                                   "make a solid of this sheet");
  // Only the date of writing changes between runs.
  const std::string before = "FILE_NAME('Open CASCADE Shape Model','";
  const std::size_t name = text.find(before);
  if (name != std::string::npos) {
    const std::size_t date = name + before.size();
    text.replace(date, text.find('\'', date) - date, "1970-01-01T00:00:00");
  }
  return text;
}

// ------------------------------------------------------------------------------------------------
// Use of `ccx`: the job is one file check.inp with the mesh in place of its *INCLUDE card. `ccx -i
// check` writes the results of *NODE PRINT to check.dat as text:
//
//     displacements (vx,vy,vz) for set GRIP_XMIN and time  0.1000000E+01
//
//              1  1.000000E-05  2.000000E-06 -3.000000E-09
//
// A row is a node (one-based) and its displacement in the deck's unit of length. The table ends at
// the first row that is not numeric.
//
// The opening is the work of the forces, sum f u. They are 1 N at each end, so it is the
// relative displacement of the ends, weighted by the forces. It is the compliance of the sheet
// in m/N (or mm/N), and twice the strain energy per newton. It therefore serves to compare
// meshes.

namespace {

/// Adds the rows "node ux uy uz" below "displacements ... for set NAME" in a .dat file.
void readDisplacements(const std::string& data, const std::string& set,
                       std::map<int, Vector3>& found) {
  const std::size_t title = data.find("for set " + set + " ");
  if (title == std::string::npos) return;
  std::istringstream rows(data.substr(data.find('\n', title)));
  int node = 0;
  for (Vector3 u; rows >> node >> u.x() >> u.y() >> u.z();) found[node] = u;
}

/// The work of the rows "node, axis, force" in the job's first *CLOAD; absent if a displacement is
/// missing.
std::optional<double> workOfForces(const std::string& jobText,
                                   const std::map<int, Vector3>& displacements) {
  std::istringstream rows(jobText.substr(jobText.find('\n', jobText.find("*CLOAD")) + 1));
  double work = 0;
  int node = 0, axis = 0;
  char comma = 0;
  for (double force = 0; rows >> node >> comma >> axis >> comma >> force;) {
    const auto found = displacements.find(node);
    if (found == displacements.end()) return std::nullopt;
    work += force * found->second[axis - 1];
  }
  return work;
}

/// Runs CalculiX with its output in `log`. Returns its status.
int runCalculix(std::vector<std::string> words, const std::string& log) {
  words.insert(words.begin(), "ccx");
  return runProgram(
      std::move(words), log,
      "it checks decks: install it (Debian: apt-get install calculix-ccx) or remove --check");
}

}  // namespace

void requireCalculix() {
  const WorkFolder folder;
  runCalculix({"-v"}, folder / "log");
}

double openingByCalculix(const std::string& meshText, std::string jobText) {
  const WorkFolder folder;
  std::vector<std::string> sets;
  std::string requests;
  constexpr std::string_view kSet = "*NSET, NSET=GRIP_";
  for (std::size_t at = meshText.find(kSet); at != std::string::npos;
       at = meshText.find(kSet, at + 1)) {
    const std::size_t name = at + kSet.find("GRIP_");
    sets.push_back(meshText.substr(name, meshText.find('\n', name) - name));
    requests += fmt::format("*NODE PRINT, NSET={}\nU\n", sets.back());
  }
  jobText.insert(jobText.find("*END STEP"), requests);
  // CalculiX searches included files in its working folder.
  const std::size_t include = jobText.find("*INCLUDE");
  jobText.replace(include, jobText.find('\n', include) + 1 - include, meshText);
  writeTextFile(folder / "check.inp", jobText);
  const std::string log = folder / "log";
  const int end = runCalculix({"-i", folder / "check"}, log);
  const std::string data = writtenText(folder / "check.dat");
  std::map<int, Vector3> displacements;
  for (const std::string& set : sets) readDisplacements(data, set, displacements);
  const std::optional<double> opening = workOfForces(jobText, displacements);
  if (end != 0 || displacements.empty() || !opening) {
    std::string words = writtenText(log);
    while (!words.empty() && words.back() == '\n') words.pop_back();
    throw RunError(
        fmt::format("error: ccx cannot solve this job ({})", words.substr(words.rfind('\n') + 1)));
  }
  return *opening;
}

}  // namespace kirireel::fea
