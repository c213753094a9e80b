#include "tests/render/fea/run_deck.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "sim/base/files.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

namespace kirireel::test {

JobEnd run(const std::string& meshText, const std::string& jobText) {
  const TemporaryFolder folder;
  writeTextFile(folder / "x_mesh.inp", meshText);
  writeTextFile(folder / "job.inp", jobText);
  JobEnd end;
  end.log = outputOf("cd '" + folder.path().string() + "' && OMP_NUM_THREADS=1 ccx -i job");
  end.data = bytesOf(folder / "job.dat");
  return end;
}

std::vector<Vector3> displacements(const std::string& data) {
  std::vector<Vector3> found;
  std::istringstream lines(data);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream row(line);
    int node = 0;
    Vector3 u;
    if (row >> node >> u.x() >> u.y() >> u.z()) found.push_back(u);
  }
  return found;
}

std::vector<Vector3> totalForces(const std::string& data, const std::string& set) {
  std::vector<Vector3> sums;
  std::istringstream lines(data);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("total force") == std::string::npos) continue;
    if (line.find("for set " + set + " ") == std::string::npos) continue;
    Vector3& sum = sums.emplace_back();
    lines >> sum.x() >> sum.y() >> sum.z();
  }
  return sums;
}

double largestStress(const std::string& data) {
  double largest = -1;
  bool isStress = false;
  std::istringstream lines(data);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("time") != std::string::npos) isStress = line.find("stresses") < line.size();
    std::istringstream row(line);
    int element = 0, point = 0;
    double value = 0;
    if (!isStress || !(row >> element >> point)) continue;
    while (row >> value) largest = std::max(largest, std::abs(value));
  }
  return largest;
}

std::string ownJob(const std::string& sets, const std::string& boundary, const std::string& load,
                   const std::string& printed) {
  return "*INCLUDE, INPUT=x_mesh.inp\n" + sets +
         "*MATERIAL, NAME=SHEET\n*ELASTIC\n1.e9, 0.3\n*DENSITY\n1000.\n"
         "*SOLID SECTION, ELSET=EALL, MATERIAL=SHEET\n*BOUNDARY\n" +
         boundary + "*STEP\n*STATIC\n" + load + "*NODE PRINT, NSET=" + printed + "\nU\n*END STEP\n";
}

}  // namespace kirireel::test
