/// The names in trajectory.h5 that its writer and its reader share.
#pragma once

#include <array>
#include <cstddef>

#include "sim/trajectory/trajectory.h"

namespace kirireel::layout {

inline constexpr const char* kFormat = "kirireel trajectory";
inline constexpr double kFormatVersion = 1;
inline constexpr std::size_t kJointColumns = 6;

/// A figure that each sample has.
struct Measure {
  const char* name;  ///< of its array
  double Sample::*field;
};
inline constexpr std::array kMeasures = {Measure{"measures/joint_gap", &Sample::jointGap},
                                         Measure{"measures/target_error", &Sample::targetError},
                                         Measure{"measures/penetration", &Sample::penetration}};

}  // namespace kirireel::layout
