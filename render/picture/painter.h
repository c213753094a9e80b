/// Paints bricks into frames, off screen.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/picture/camera.h"
#include "render/picture/frame.h"
#include "render/picture/picture_geometry.h"
#include "render/picture/style.h"
#include "sim/brick/brick.h"

namespace kirireel::picture {

/// Number of samples whose mean is a pixel.
enum class Smoothness {
  Still,  ///< 2 x 3
  Film,   ///< 2 x 2: frames that follow each other, two thirds of the time
};

/// Draws bricks, those of one run at a time. Owns a graphics context, which belongs to one thread:
/// make, use and destroy a painter on the same thread. The same poses, camera and style give the
/// same bytes in every run, for any number of renderer threads.
///
/// Faces are flat: away from its outline each has exactly the colour of faceColour(). A pixel is
/// the mean of its samples (bytes of sRGB, weighted by alpha), which smooths the edges.
class Painter {
 public:
  /// Throws InputError for a size out of range, OutputError when no graphics context can be made.
  /// Samples of the part that is drawn take up to 100 MB (12.6 million of 8 bytes), for pictures of
  /// any size.
  Painter(FrameSize size, const std::vector<brick::Brick>& bricks, const Style& style,
          Smoothness smoothness = Smoothness::Still);
  ~Painter();
  Painter(const Painter&) = delete;
  Painter& operator=(const Painter&) = delete;

  /// Draws these bricks in this style from now on, in pictures of the same size. A graphics context
  /// takes longer to make than many small pictures to paint. What was painted before is not kept.
  void show(const std::vector<brick::Brick>& bricks, const Style& style);

  /// Paints the items. storage: a frame that is not needed any more, whose memory is used again.
  /// Throws OutputError. One entry of `poses` for each brick. Throws Interrupted when the user ends
  /// the program.
  Frame paint(const PictureItems& items, const Camera& camera, Frame storage = {});

  /// The picture of only the bricks at these poses, in the colours of the style.
  Frame paint(const Poses& poses, const Camera& camera);

  /// Size of its pictures, pixels.
  FrameSize size() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// ------------------------------------------------------------------------------------------------
// Pixels from samples: the last step of smoothing a picture.

/// Samples of a pixel, across and down: quicker and smoother here than 4 x multisampling. Against
/// 96 samples a pixel, pictures of 1280 x 720 have an SSIM of 0.998 with three down.
inline constexpr int kSamplesAcross = 2;
/// Rows of samples in a pixel, at most.
inline constexpr int kMostSamplesDown = 3;

/// Rows of samples as they are read back: RGBA bytes, alpha premultiplied.
struct SampleRows {
  const std::uint8_t* samples = nullptr;  ///< the first row of the first pixel
  int rowSamples = 0;                     ///< samples from one row's start to the next
  bool opaque = true;                     ///< whether all alphas are 255, which is quicker
  int samplesDown = kMostSamplesDown;     ///< of a pixel: 2 or 3
};

/// Writes one row of `count` pixels, straight alpha: the mean of each pixel's samples, in each
/// channel the nearest byte, halves up. Transparent samples do not count in the means of
/// the colours. `pixels` has room for 4 count bytes. Called for each row of a part that is read
/// back, so it decides a good part of the time of a picture.
void averageRow(const SampleRows& rows, int count, std::uint8_t* pixels);

}  // namespace kirireel::picture
