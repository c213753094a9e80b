/// Ligaments as a part of a step's matrices.
#pragma once

#include <vector>

#include "sim/brick/ligament.h"

namespace kirireel {

/// The energy E of ligaments in the plane along a step of h seconds from poses q with velocities x,
/// as a quadratic function of x,
///   E(q + h x) ~ E + h g^T (x - x0) + h^2 (x - x0)^T K (x - x0) / 2,
/// about velocities x0. All of pairs of bricks, in their six coordinates.
class LigamentBlocks {
 public:
  using Vector = Eigen::VectorXd;

  /// K: the second derivative, or that without what is negative of it. With the latter each minimum
  /// is one, and Newton's steps lead downhill; but it has kinks where a ligament buckles, on which
  /// the orders of extrapolated steps are lost.
  enum class Curvature { Whole, Convex };

  /// What one ligament adds to a step.
  struct LigamentBlock {
    Vector6 force = Vector6::Zero();   ///< to f: -h g + h^2 K x0, N s and N m s
    Matrix6 weight = Matrix6::Zero();  ///< to A: h^2 K
  };

  LigamentBlocks() = default;
  /// `lengthScale` in metres makes turning and moving comparable.
  LigamentBlocks(std::vector<Ligament> ligaments, double lengthScale)
      : ligaments_(std::move(ligaments)), lengthScale_(lengthScale), blocks_(ligaments_.size()) {}

  bool empty() const { return ligaments_.empty(); }
  std::size_t size() const { return ligaments_.size(); }
  const Ligament& ligament(std::size_t k) const { return ligaments_[k]; }
  const LigamentBlock& block(std::size_t k) const { return blocks_[k]; }

  /// Begins a step at these poses, whose blocks are to be set. One entry a brick: those that are
  /// held take no part.
  /// `step` in seconds.
  void begin(const Poses& poses, double step, const std::vector<bool>& held);
  /// Sets the blocks about velocities x0.
  void setAbout(const Vector& x0, Curvature curvature);
  /// Takes all blocks away.
  void clear() { blocks_.assign(ligaments_.size(), {}); }

  /// E after a displacement since begin(), joules.
  double energyAfter(const Vector& displacement) const;
  /// Adds the blocks' force to f.
  void addForce(Vector& f) const;
  /// Adds the product of the blocks' weights with x.
  void addProduct(const Vector& x, Vector& to) const;

 private:
  Poses posesAfter(const Vector& displacement) const;

  std::vector<Ligament> ligaments_;
  double lengthScale_ = 1;
  std::vector<LigamentBlock> blocks_;
  Poses start_;
  double step_ = 0;
  std::vector<bool> held_;
};

}  // namespace kirireel
