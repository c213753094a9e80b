/// Sheets with elastic, bending tiles as bars and hinges; the angle of a fold.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "sim/base/geometry.h"
#include "sim/mechanics/load_path.h"
#include "sim/trajectory/panels.h"

namespace kirireel::statics {

// ------------------------------------------------------------------------------------------------
// The angle between two triangles with a common edge, and its derivatives.

/// The two ends of the edge, then the third corner of the left triangle and that of the right one,
/// seen from above, metres.
using FoldPoints = std::array<Vector3, 4>;

/// The fold angle in radians, (-pi, pi], as in FOLD. 0 if the triangles are flat, positive if their
/// upper sides face each other (a valley).
double foldAngle(const FoldPoints& points);

/// The derivative of the angle with respect to the points' coordinates, point by point, rad/m.
Vector12 foldSlope(const FoldPoints& points);

/// The second derivative, rad/m^2.
Matrix12 foldBend(const FoldPoints& points);

// ------------------------------------------------------------------------------------------------
// The energy of a sheet in space with elastic, bending tiles, by bars and hinges. The edges of
// triangles are bars. The sheet folds, or a tile bends, at their common edges.

using trajectory::Bar;
using trajectory::Fold;

/// A move of, or a force on, parts of the sheet; see Grip.
struct NodeGrip {
  /// One or more handles; each is the mean of its nodes.
  std::vector<std::vector<int>> handles;
  Vector3 direction = Vector3::UnitX();  ///< unit
  double amount = 0;                     ///< at load 1, metres or newtons
  bool isForce = false;                  ///< true: a force, false: a move
};

/// The parts of a sheet of bars and hinges.
struct BarHingeModel {
  std::vector<Vector3> nodes;  ///< at the start, metres
  std::vector<Bar> bars;       ///< between nodes
  std::vector<Fold>
      folds;  ///< between triangles that may rotate, including the tiles' own diagonals
  std::vector<int> fixed;               ///< nodes with a fixed position
  std::vector<std::vector<int>> tiles;  ///< the nodes of each tile whose pose is reported
  Poses start;                          ///< of the tiles
};

/// A sheet of bars and hinges. Its coordinates are the positions of its nodes from the start of the
/// first one in length scales.
class BarHingeSheet : public mechanics::LoadedSheet {
 public:
  /// The length scale is the mean length of the bars. Node indices in bars, folds and grips must be
  /// valid.
  BarHingeSheet(BarHingeModel model, std::vector<NodeGrip> grips);

  int unknowns() const override { return 3 * static_cast<int>(model_.nodes.size()); }
  int rows() const override { return static_cast<int>(motion_.size()); }
  std::size_t grips() const override { return grips_.size(); }
  mechanics::RowRange rowsOf(std::size_t grip) const override;
  Vector startCoordinates() const override;
  /// The pose of each tile that fits its nodes best.
  Poses posesAt(const Vector& q) const override;
  double energy(const Vector& q) const override;
  double stiffnessScale() const override { return stiffness_; }
  Vector gradient(const Vector& q, double load) const override;
  Vector pull(const Vector& q) const override;
  Vector residual(const Vector& q, double load) const override;
  Matrix jacobian(const Vector&) const override { return jacobian_; }
  const mechanics::LinearRows* linearRows() const override { return &linearRows_; }
  Vector motion() const override { return motion_; }
  Matrix hessian(const Vector& q, double load, const Vector& multipliers) const override;
  double unit(std::size_t) const override { return scale_; }
  double displacement(std::size_t grip, const Vector& q) const override;
  double displacementSlope(std::size_t grip, const Vector& q, const Vector& along) const override;
  double force(std::size_t grip, double load, const Vector& multipliers) const override;

  /// The parts of the sheet, without states.
  trajectory::LoadedPanels panels() const;
  /// The nodes, strains and fold angles at coordinates, at time 0.
  trajectory::PanelState panelState(const Vector& q) const;

 private:
  /// The position of a node from the origin, metres.
  Vector3 place(int node, const Vector& q) const { return scale_ * q.segment<3>(3 * node); }
  FoldPoints pointsOf(const Fold& fold, const Vector& q) const;
  double strainOf(const Bar& bar, const Vector& q) const;
  void addRows();

  BarHingeModel model_;
  std::vector<NodeGrip> grips_;
  Vector3 origin_ = Vector3::Zero();  // the first node at the start, metres
  double scale_ = 1;                  // metres
  double stiffness_ = 0;              // joules
  Matrix jacobian_;
  mechanics::LinearRows linearRows_;
  Vector motion_;
  std::vector<Eigen::Index> firstRow_;  // of each grip
};

}  // namespace kirireel::statics
