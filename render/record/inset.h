/// A curve of a run in a corner of a video's frames, with a dot at the time of each frame.
#pragma once

#include <vector>

#include "render/picture/canvas.h"
#include "render/picture/frame.h"
#include "render/picture/state_painter.h"
#include "render/record/curves.h"
#include "render/record/job.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {

/// Throws InputError if no run has a curve with the name of settings.inset, or if the inset is too
/// large for the frames. No effect without a name.
void requireInset(const PictureSettings& settings);

/// The curve of the inset. Reads the trajectory twice. Throws InputError if the run lacks it, with
/// the list of those it has.
PlottedRun insetCurve(const trajectory::TrajectoryReader& run, const PictureSettings& settings);

/// The curve that settings.inset selects. Frames at other times share everything except the dots.
class Inset {
 public:
  /// For pictures with this setup. Throws InputError like requireInset() and insetCurve(),
  /// OutputError if the font is missing.
  Inset(const trajectory::TrajectoryReader& run, const PictureSettings& settings,
        const picture::PictureSetup& setup);

  /// Draws it on the picture of a state. `time`: simulated seconds.
  void draw(picture::Frame& picture, double time) const;

  /// Its part of the pictures, whole pixels.
  const picture::PageBox& box() const { return box_; }

  /// A dot on a curve.
  struct Dot {
    picture::Colour colour;
    Eigen::Vector2d place;  ///< pixels from the upper left of the picture
  };
  /// The dots at a time, one per curve with a value there.
  std::vector<Dot> dots(double time) const;

  /// Radius of a dot, pixels.
  double dotRadius() const;

 private:
  int em_;
  picture::Colour background_;
  std::vector<double> times_;  ///< of samples, seconds
  picture::PageBox box_;
  std::vector<DrawnCurve> curves_;
  picture::Frame plot_;  ///< without dots
};

}  // namespace kirireel::record
