// Several runs in one figure have to be comparable: all rows get one view, a parallel projection,
// one scale of length and one of colours. Each row's camera is fitted to its own model first; with
// h its picture's height in metres and H the largest of them, the zooms are multiplied by h / H.
// The scale of colours ends at the largest value of all rows.
#include "render/record/figure.h"

#include <algorithm>

#include <fmt/format.h>

#include "render/record/album.h"
#include "render/record/pace.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// The view that suits all runs where none is given: from above when all are flat.
ViewAngles sharedView(std::span<const TrajectoryReader* const> runs) {
  const bool isFlat = std::ranges::all_of(runs, [](const TrajectoryReader* run) {
    return defaultView(motifOf(run->subject()).points) == kTopView;
  });
  return isFlat ? kTopView : kIsometricView;
}

/// Throws InputError where a perspective or a moving camera was asked for.
Look sharedLook(std::span<const TrajectoryReader* const> runs, const PictureSettings& settings) {
  Look look = settings.look;
  CameraChoice& camera = look.camera;
  if (camera.orthographic == false || camera.orbit != 0 || !camera.keys.empty()) {
    throw InputError(
        "error: pictures of several runs share one scale, which needs a parallel projection and a "
        "camera that stands still; leave --projection perspective, --orbit and --camera-keys away");
  }
  camera.orthographic = true;
  if (!camera.view) camera.view = sharedView(runs);
  return look;
}

/// Which model a row shows stands before its first caption.
std::vector<std::string> captionsOf(const std::vector<FrameState>& states,
                                    const CaptionWriter& writer, const std::string& model) {
  std::vector<std::string> captions;
  for (const FrameState& state : states) captions.push_back(writer.of(state));
  std::string& first = captions.front();
  first = first.empty() ? model : fmt::format("{}: {}", model, first);
  return captions;
}

/// Reads the run for its motion, and for the states of its pictures.
PanelRow makeRow(const TrajectoryReader& run, const PictureSettings& settings) {
  PanelRow row{settings.look, motifOf(run, settings), {}, {}};
  const MotionCurve motion = motionOf(run);
  Replay replayed(run);
  for (const FrameMoment& moment : snapshotMoments(motion, settings, settings.grid.columns)) {
    row.states.push_back({moment, replayed.at(moment.time)});
  }
  row.captions = captionsOf(row.states, CaptionWriter(settings.captionParts(), row.motif),
                            run.subject().model.name);
  return row;
}

/// Cameras as far away, and scales of colours as long, as the largest of the rows needs.
void shareScales(FrameSize size, std::vector<PanelRow>& rows) {
  std::vector<double> heights;
  double most = 0;
  for (const PanelRow& row : rows) {
    const Stage stage(row.look, row.motif, size);
    heights.push_back(stage.metresPerPixel());
    if (stage.colourScale()) most = std::max(most, stage.colourScale()->most);
  }
  const double largest = *std::ranges::max_element(heights);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].look.camera.zoom *= heights[k] / largest;
    if (most > 0) rows[k].look.colourMost = most;
  }
}

}  // namespace

std::vector<PanelRow> figureRows(std::span<const TrajectoryReader* const> runs,
                                 const PictureSettings& asked) {
  PictureSettings settings = asked;
  settings.look = sharedLook(runs, asked);
  std::vector<PanelRow> rows;
  for (const TrajectoryReader* run : runs) rows.push_back(makeRow(*run, settings));
  shareScales(settings.size, rows);
  return rows;
}

}  // namespace kirireel
