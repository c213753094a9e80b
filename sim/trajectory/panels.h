/// Sheets with tiles that stretch and bend, as bars and hinges: their parts, and their equilibria
/// under grips.
#pragma once

#include <array>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/hinge.h"

namespace kirireel::trajectory {

/// A bar between two nodes: stiffness (length - rest)^2 / 2.
struct Bar {
  int nodeA = 0;         ///< index >= 0
  int nodeB = 0;         ///< index >= 0
  double rest = 0;       ///< length without force, metres, > 0
  double stiffness = 0;  ///< N/m

  /// Joules, at a strain.
  double energy(double strain) const { return 0.5 * stiffness * (strain * rest) * (strain * rest); }
};

/// A linear torsional spring between two triangles: stiffness (angle - rest)^2 / 2, see
/// statics::foldAngle().
struct Fold {
  /// The two ends of the edge, then the third node of the left triangle and that of the right one,
  /// seen from above.
  std::array<int, 4> nodes{};
  double stiffness = 0;  ///< N m/rad
  double rest = 0;       ///< radians
  /// Of the left triangle and of the right one. They are equal if a tile bends there.
  std::array<int, 2> tiles{};

  /// On both triangles about the edge, N m, at an angle.
  double moment(double angle) const { return stiffness * (angle - rest); }
  /// Joules, at an angle.
  double energy(double angle) const { return 0.5 * stiffness * (angle - rest) * (angle - rest); }
};

/// One equilibrium of a sheet of panels.
struct PanelState {
  double time = 0;              ///< at which a run shows it, seconds
  std::vector<Vector3> nodes;   ///< metres, world axes
  std::vector<double> strains;  ///< of each bar: length / rest - 1
  std::vector<double> angles;   ///< of each fold, radians, (-pi, pi]
};

/// A sheet of bars and hinges, and the equilibria that a run went through.
struct LoadedPanels {
  std::vector<std::vector<int>> tileNodes;  ///< the node of each vertex of each tile
  std::vector<Bar> bars;                    ///< edges and diagonals of tiles
  std::vector<Fold> folds;                  ///< between tiles, and within tiles that bend
  std::vector<PanelState> states;           ///< one or more, in their order along the path

  /// The energy of all bars and folds, joules.
  double energy(const PanelState& state) const;
  /// For each tile the energy of its bars and folds, joules. Tiles that share a bar or a fold count
  /// equal parts of it: the sum over all tiles is the energy of the sheet. `time` in seconds;
  /// linear between states.
  std::vector<double> tileEnergies(double time) const;
  /// For each tile the largest absolute moment of its folds, N m. `time` as above.
  std::vector<double> tileMoments(double time) const;
};

/// Sets the energies and the moment to those of the sheet's first and last state, and adds the
/// counts of bars and folds.
void setElasticity(const LoadedPanels& sheet, brick::Elasticity& elasticity);

}  // namespace kirireel::trajectory
