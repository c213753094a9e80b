/// The pictures of a run: snapshot grid, video, single frames.
#pragma once

#include "render/record/record.h"
#include "render/video/video.h"

namespace kirireel {

/// Throws InputError when the look or the grid asks for what the scene cannot give: seen from its
/// start and target, before anything is deployed.
void requirePaintable(const Scene& scene, const RecordSettings& settings);

/// How the run's video is encoded.
VideoSettings videoSettings(const RecordSettings& settings);

/// Paints and writes what the settings ask for, adding files and costs to the summary. One frame a
/// sample. When the observer asks for an end, the video ends with the frames so far and the summary
/// says that the run was interrupted. Makes no graphics context when nothing is to be painted.
void paintAlbum(const Scene& scene, const Trajectory& trajectory, const RecordSettings& settings,
                const ProgressObserver& observer, RunSummary& summary);

}  // namespace kirireel
