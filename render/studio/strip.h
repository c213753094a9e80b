/// What a video says of its frames: on a strip under the picture, so that it never lies over the
/// bricks or their shadow.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/grid/label.h"
#include "render/grid/scale.h"
#include "render/picture/frame.h"
#include "render/picture/style.h"

namespace kirireel {

/// What stands on the strip of all frames of a video. Fixed for a whole video, since it decides the
/// height of the picture above.
struct StripParts {
  std::string longestCaption;  ///< a caption as wide as any will be; empty: there are none
  bool progressBar = false;    ///< a bar that fills from left to right
  bool scaleBar = false;       ///< a length; needs one scale all over the picture
  bool colours = false;        ///< what colours mean, where they stand for values
  bool legend = false;         ///< the same, where they stand for kinds of bricks
};

/// What it says under one frame.
struct StripText {
  std::string caption;  ///< one line, UTF-8
  double progress = 0;  ///< 0 to 1
};

/// A strip under pictures of one size. It is as high as its parts need, and its text as large as
/// the widest caption allows.
class Strip {
 public:
  /// whole: the frame with its strip. Throws OutputError when the font is missing.
  Strip(FrameSize whole, const StripParts& parts, const Style& style);

  /// The frame without its strip.
  FrameSize picture() const { return {whole_.width, whole_.height - height_}; }

  /// Puts the strip under a picture. colours: none where the bricks' colours stand for no values;
  /// legend: empty where they stand for no kinds; metresPerPixel: absent where no scale bar is
  /// asked for. The picture has the size of picture(); it gets that of the whole frame.
  void append(Frame& picture, const StripText& text, const std::optional<ColourScale>& colours,
              const std::vector<LegendEntry>& legend,
              const std::optional<double>& metresPerPixel) const;

 private:
  double scalesEms() const;
  void drawScales(Frame& frame, int upper, const std::optional<ColourScale>& colours,
                  const std::vector<LegendEntry>& legend,
                  const std::optional<double>& metresPerPixel) const;
  void drawProgress(Frame& frame, int upper, double progress) const;

  FrameSize whole_;
  StripParts parts_;
  Colour background_;
  Colour text_;
  int em_ = 0;      ///< of all text, pixels
  int height_ = 0;  ///< pixels
  int captionLeft_ = 0;
  std::optional<LabelWriter> writer_;  ///< absent where nothing is written
  std::optional<ScaleDrawer> scales_;
};

}  // namespace kirireel
