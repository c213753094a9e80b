/// Figures of several runs: a row of pictures each.
#pragma once

#include <span>
#include <vector>

#include "render/record/panels.h"
#include "render/record/record.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// The rows of a figure, settings.grid.columns states of each run. All pictures share one camera's
/// view, one scale of length and one of colours. Throws InputError where no one scale holds: in
/// perspective or from a moving camera. At least one run. The readers must stay open while rows are
/// made.
std::vector<PanelRow> figureRows(std::span<const TrajectoryReader* const> runs,
                                 const PictureSettings& settings);

}  // namespace kirireel
