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
#include "render/fea/calculix_program.h"

#include <sstream>

#include <fmt/format.h>

#include "render/fea/outside_program.h"
#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

/// The rows "node ux uy uz" that stand below "displacements ... for set NAME" in a .dat file.
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

}  // namespace kirireel
