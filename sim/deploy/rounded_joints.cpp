// Numbers behind rounded_joints.h: d is the last digit of the coordinates over the mean edge, r =
// 10 / d the stiffness of joints over that of the pull. Softer joints are tried in steps of ten,
// down to r = 10.
#include "sim/deploy/rounded_joints.h"

#include <limits>

namespace kirireel {
namespace {

constexpr double kDigits = 10;
// Exact joints close to this part of a tile, so that finer digits make no difference.
constexpr double kFinest = 1e-9;
// Joints are softened by this factor down to this stiffness.
constexpr double kSofter = 10;
constexpr double kSoftest = 10;

}  // namespace

double roundedJointStiffness(const Model& model) {
  const double tile = tileSize(model);
  return model.rounding > kFinest * tile ? kDigits * tile / model.rounding
                                         : std::numeric_limits<double>::infinity();
}

double roundedReach(const Model& model) {
  return kDigits * model.rounding;
}

double roundedGap(const Model& model) {
  return 2 * model.rounding;
}

void softenWhileClosed(const Model& model, const std::function<bool(double stiffness)>& closes) {
  double stiffness = roundedJointStiffness(model);
  do {
    stiffness /= kSofter;
  } while (stiffness >= kSoftest && closes(stiffness));
}

}  // namespace kirireel
