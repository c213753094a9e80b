/// Selects the face of each joint from the deployed shape of the sheet.
#pragma once

#include "sim/model/model.h"

namespace kirireel::formats {

/// Rules for the face of a joint. Both use the target, or the start if there is no target. If two
/// tiles have a common edge there, the signed angle of that fold decides. If they have only a
/// common vertex, it matters whether their normals converge. A sheet that is flat at the start and
/// at the target is joined on both faces.
enum class FaceRule {
  Fold,  ///< a valley (normals converge) is joined at the top, anything else at the bottom; bricks
         ///< then open away from the fold and do not collide
  PyKirigami,  ///< rule of --auto_detect_connections: the common edge points from the lower to the
               ///< higher vertex number of the first tile; the joint is at the top if the fold
               ///< about this direction is positive
};

/// Replaces the faces of all pivots of the model. Links and fixed joints stay unchanged. Costs
/// O(joints). Tiles must have an area.
void chooseJointFaces(model::Model& model, FaceRule rule);

}  // namespace kirireel::formats
