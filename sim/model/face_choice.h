/// Which face of its bricks each joint should lie on, from the shape that the sheet deploys to.
#pragma once

#include "sim/model/model.h"

namespace kirireel {

/// How faces are chosen. Both rules look at the target (the start, without one): a joint between
/// tiles that share an edge there is judged by the signed angle of that fold, a joint at a single
/// vertex by whether the normals of its tiles converge, and a sheet that is flat at the start and
/// at the target is joined on both faces.
enum class FaceRule {
  Fold,  ///< a valley (normals converge) is joined at the top, anything else at the bottom, so
         ///< that bricks open away from the fold and do not meet
  PyKirigami,  ///< what --auto_detect_connections assigns: the shared edge runs from the lower to
               ///< the higher vertex number of the first tile, and the joint lies at the top where
               ///< the fold about it is positive
};

/// Replaces the faces of all pivots of the model.
/// Costs O(joints). Links and fixed joints keep what they have. Tiles need to have an area.
void chooseJointFaces(Model& model, FaceRule rule);

}  // namespace kirireel
