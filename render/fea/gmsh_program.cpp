// Gmsh runs as `gmsh -2 sheet.geo -format msh22 -o sheet.msh -nt 1 -v 2 -nopopup`: -2 meshes
// surfaces, format 2.2 is the one that is simplest to read, -v 2 logs errors and warnings alone,
// and one thread keeps the mesh the same from run to run. It is run as a program and not linked, so
// that it has to be there for sheets with necks only.
#include "render/fea/gmsh_program.h"

#include <fmt/format.h>

#include "render/fea/outside_program.h"
#include "sim/base/error.h"
#include "sim/base/pending_file.h"

namespace kirireel {

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

}  // namespace kirireel
