/// Runs decks in CalculiX and reads the results.
#pragma once

#include <string>
#include <vector>

#include "render/fea/deck.h"
#include "sim/base/geometry.h"

namespace kirireel::test {

inline const fea::DeckOrigin kOrigin = {"squares", "final", 0.5, 0.02, 0, "Kirireel", "a run"};

/// The output of ccx and its job.dat.
struct JobEnd {
  std::string log;
  std::string data;
};

/// The lines of a node set.
inline std::string setOf(const std::string& name, const std::vector<int>& nodes) {
  std::string text;
  fea::appendNodeSet(text, name, nodes);
  return text;
}

/// Runs a job whose mesh is x_mesh.inp.
JobEnd run(const std::string& meshText, const std::string& jobText);

/// The displacements in the rows "node ux uy uz" of job.dat.
std::vector<Vector3> displacements(const std::string& data);

/// The sums that job.dat prints below "total force ... for set NAME", one per step or increment.
std::vector<Vector3> totalForces(const std::string& data, const std::string& set);

/// The largest number among the stresses that job.dat prints, absolute; -1 for none.
double largestStress(const std::string& data);

/// A job on its own mesh: supports and load, printed displacements of one set. A material of 1 GPa
/// and Poisson's ratio 0.3.
std::string ownJob(const std::string& sets, const std::string& boundary, const std::string& load,
                   const std::string& printed);

}  // namespace kirireel::test
