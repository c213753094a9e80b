/// Guides to goals with folds of half a turn.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/model/model.h"

namespace kirireel::path {

/// A fold of a model with an angle in its file.
struct SignedFold {
  brick::Hinge hinge;
  double angle = 0;         ///< at the goal, with the sign in Model::foldAngles, radians
  bool isHalfTurn = false;  ///< the poses at the goal do not define the sign
};

/// Folds of half a turn at a goal. Without any, guides have no states between start and goal, and
/// no fold is on the wrong side.
class FoldGuide {
 public:
  /// `bricks` are the model's at the start. Joints are closed at the goal.
  FoldGuide(Poses goal, const model::Model& model, const std::vector<brick::Brick>& bricks,
            const std::vector<brick::Pivot>& pivots);

  /// A guide from a start to the goal. In the states between them all folds are open by the same
  /// part of their angle, on the side in Model::foldAngles. Joints are nearly closed there.
  std::vector<Poses> from(const Poses& start) const;

  /// Whether a fold of half a turn is on the other side in this state, halfway along a path.
  bool isOnWrongSide(const Poses& halfway) const;

 private:
  Poses opened(const Poses& poses) const;
  void takeBackRigidMotion(const Poses& start, std::vector<Poses>& states) const;

  Poses goal_;
  const std::vector<brick::Brick>& bricks_;
  const std::vector<brick::Pivot>& pivots_;
  double tile_;                    // metres
  std::vector<SignedFold> folds_;  // empty if none is half a turn
};

}  // namespace kirireel::path
