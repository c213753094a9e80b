// Starts programs by posix_spawnp (POSIX.1-2008) and not by a shell: arguments are passed as they
// are. No name can be read as a command. Input is /dev/null: a program that asks a
// question ends instead of waiting; output and errors go to one log, in the order in which they
// came.
#include "render/fea/outside_program.h"

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/base/geometry.h"

extern char** environ;

namespace kirireel::fea {

WorkFolder::WorkFolder() {
  // mkdtemp replaces the six X and makes the folder only for its user (mode 0700).
  std::string name = (std::filesystem::temp_directory_path() / "kirireel-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    throw OutputError(fmt::format("{}: error: cannot be made ({})", name,
                                  std::generic_category().message(errno)));
  }
  path_ = name;
}

WorkFolder::~WorkFolder() {
  // A destructor must not throw; what cannot be removed stays in the temporary folder.
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string writtenText(const std::string& file) {
  // Results of large meshes have gigabytes; more than four are not read into memory.
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{4} << 30;
  if (!std::filesystem::is_regular_file(file)) return {};
  return readTextFile(file, "", kMostBytes);
}

int runProgram(std::vector<std::string> words, const std::string& log, const std::string& advice) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  // The list of arguments ends with a null pointer, as execvp has it.
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
// Gmsh runs as `gmsh -2 sheet.geo -format msh22 -o sheet.msh -nt 1 -v 2 -nopopup`: -2 meshes
// surfaces, format 2.2 is the one that is simplest to read, -v 2 logs only errors and warnings,
// and one thread keeps the mesh the same from run to run. It is run as a program and not linked, so
// that it has to be there for sheets with necks only.

std::string meshedByGmsh(const std::string& geometry) {
  const WorkFolder folder;
  const std::string input = folder / "sheet.geo";
  const std::string output = folder / "sheet.msh";
  const std::string log = folder / "log";
  writeTextFile(input, geometry);
  const int end = runProgram(
      {"gmsh", "-2", input, "-format", "msh22", "-o", output, "-nt", "1", "-v", "2", "-nopopup"},
      log,
      "sheets with necks are meshed by it: install it (Debian: apt-get install gmsh) or choose "
      "other "
      "--joints");
  std::string mesh = writtenText(output);
  if (end == 0 && !mesh.empty()) return mesh;
  // The last line of the log is what failed; line breaks behind it are cut off first.
  std::string words = writtenText(log);
  while (!words.empty() && words.back() == '\n') words.pop_back();
  throw RunError(
      fmt::format("error: gmsh cannot mesh this sheet ({})", words.substr(words.rfind('\n') + 1)));
}

// ------------------------------------------------------------------------------------------------
// How `ccx` is used: the job is written as one file check.inp with the mesh in place of its
// *INCLUDE card; `ccx -i check` writes what *NODE PRINT asks for to check.dat, as text:
//
//     displacements (vx,vy,vz) for set GRIP_XMIN and time  0.1000000E+01
//
//              1  1.000000E-05  2.000000E-06 -3.000000E-09
//
// A row is a node (from 1) and its displacement in the deck's unit of length. The table ends where
// a row cannot be read.
//
// The opening is the mean of u over the nodes of GRIP_?MAX less that over GRIP_?MIN, along the axis
// of the force. With 1 N at each end it is the compliance of the sheet in m/N (or mm/N), and twice
// the strain energy per newton; that makes it a figure to compare meshes by.

namespace {

/// The rows "node ux uy uz" below "displacements ... for set NAME" in a .dat file.
std::vector<Vector3> displacementsOf(const std::string& data, const std::string& set) {
  std::vector<Vector3> found;
  const std::size_t title = data.find("for set " + set + " ");
  if (title == std::string::npos) return found;
  std::istringstream rows(data.substr(data.find('\n', title)));
  int node = 0;
  for (Vector3 u; rows >> node >> u.x() >> u.y() >> u.z();) found.push_back(u);
  return found;
}

double meanOf(const std::vector<Vector3>& displacements, int axis) {
  double sum = 0;
  for (const Vector3& u : displacements) sum += u[axis];
  return sum / static_cast<double>(displacements.size());
}

}  // namespace

double openingByCalculix(const std::string& meshText, std::string jobText, int axis) {
  const WorkFolder folder;
  std::string requests;
  const char letter = "XYZ"[axis];
  const std::string sets[] = {fmt::format("GRIP_{}MIN", letter), fmt::format("GRIP_{}MAX", letter)};
  for (const std::string& set : sets) requests += fmt::format("*NODE PRINT, NSET={}\nU\n", set);
  jobText.insert(jobText.find("*END STEP"), requests);
  // CalculiX looks for included files where it was started.
  const std::size_t include = jobText.find("*INCLUDE");
  jobText.replace(include, jobText.find('\n', include) + 1 - include, meshText);
  writeTextFile(folder / "check.inp", jobText);
  const std::string log = folder / "log";
  const int end = runProgram({"ccx", "-i", folder / "check"}, log,
                             "decks are checked by it: install it (Debian: apt-get install "
                             "calculix-ccx) or leave --check out");
  const std::string data = writtenText(folder / "check.dat");
  const std::vector<Vector3> low = displacementsOf(data, sets[0]);
  const std::vector<Vector3> high = displacementsOf(data, sets[1]);
  if (end != 0 || low.empty() || high.empty()) {
    std::string words = writtenText(log);
    while (!words.empty() && words.back() == '\n') words.pop_back();
    throw RunError(
        fmt::format("error: ccx cannot solve this job ({})", words.substr(words.rfind('\n') + 1)));
  }
  return meanOf(high, axis) - meanOf(low, axis);
}

}  // namespace kirireel::fea
