// The strip stands below the picture and takes its height off it: the frame keeps its size. From
// the top: a line with the caption (1.5 em), a line with scales (1.8 em, more with ticks), the bar
// of progress (1.2 em). The em is 3.4% of the frame's height, at least 9 pixels, smaller where the
// longest caption would not fit; it is found once, so that text does not change its size in a
// video.
#include "render/studio/strip.h"

#include <algorithm>
#include <cmath>

namespace kirireel {
namespace {

/// Em of the text, in heights of the frame; and the smallest that can be read, pixels.
constexpr double kTextShare = 0.034;
constexpr int kLeastText = 9;
/// Heights in ems: of a line of text with its baseline in it, of a line of scales, of the bar of
/// progress with the room around it, and of that bar alone.
constexpr double kLineEms = 1.5;
constexpr double kLineBaselineEms = 1.1;
constexpr double kScalesEms = 1.8;
constexpr double kProgressEms = 1.2;
constexpr double kProgressBarEms = 0.35;
/// What captions, and a bar of progress, may take of the frame's width; and the longest length.
constexpr double kUsedWidth = 0.94;
constexpr double kLongestLength = 0.25;
/// How much of the text's colour shows in what is left of a bar of progress.
constexpr double kFaint = 0.2;

/// Half away from zero.
int rounded(double pixels) {
  return static_cast<int>(std::lround(pixels));
}

Colour between(Colour from, Colour to, double share) {
  const auto mix = [share](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + share * (b - a)));
  };
  return {mix(from.red, to.red), mix(from.green, to.green), mix(from.blue, to.blue),
          mix(from.alpha, to.alpha)};
}

/// The size at which the widest caption fits.
int textSize(FrameSize whole, const std::string& longest) {
  const int wanted = std::max(kLeastText, rounded(kTextShare * whole.height));
  if (longest.empty()) return wanted;
  const double width = LabelWriter(wanted).width(longest);
  const double fitting = wanted * std::min(1.0, kUsedWidth * whole.width / width);
  return std::max(kLeastText, static_cast<int>(fitting));
}

}  // namespace

Strip::Strip(FrameSize whole, const StripParts& parts, const Style& style)
    : whole_(whole), parts_(parts), background_(style.background), text_(style.text) {
  const bool hasCaption = !parts.longestCaption.empty();
  const bool hasScales = scalesEms() > 0;
  if (!hasCaption && !hasScales && !parts.progressBar) return;
  em_ = textSize(whole, parts.longestCaption);
  height_ = rounded(
      em_ * ((hasCaption ? kLineEms : 0) + scalesEms() + (parts.progressBar ? kProgressEms : 0)));
  height_ = std::min(height_, whole.height - 1);
  if (hasScales) scales_.emplace(em_, text_);
  if (!hasCaption) return;
  writer_.emplace(em_);
  captionLeft_ = std::max(0, (whole.width - writer_->width(parts.longestCaption)) / 2);
}

/// Height of the line of scales, ems.
double Strip::scalesEms() const {
  if (parts_.colours) return kScalesEms + kColourBarHeight - 1;
  return parts_.legend || parts_.scaleBar ? kScalesEms : 0;
}

void Strip::append(Frame& picture, const StripText& text, const std::optional<ColourScale>& colours,
                   const std::vector<LegendEntry>& legend,
                   const std::optional<double>& metresPerPixel) const {
  if (height_ == 0) return;
  int upper = picture.size.height;
  const Frame strip = makeFrame({whole_.width, height_}, background_);
  picture.pixels.insert(picture.pixels.end(), strip.pixels.begin(), strip.pixels.end());
  picture.size = whole_;
  if (writer_) {
    // From the same place in every frame, so that letters do not jump.
    writer_->draw(picture, text.caption, captionLeft_, upper + rounded(kLineBaselineEms * em_),
                  text_);
    upper += rounded(kLineEms * em_);
  }
  if (scales_) {
    drawScales(picture, upper, colours, legend, metresPerPixel);
    upper += rounded(scalesEms() * em_);
  }
  if (parts_.progressBar) drawProgress(picture, upper, text.progress);
}

/// One beside the other where there are both.
void Strip::drawScales(Frame& frame, int upper, const std::optional<ColourScale>& colours,
                       const std::vector<LegendEntry>& legend,
                       const std::optional<double>& metresPerPixel) const {
  FrameSurface surface(frame);
  const int y = upper + rounded(0.5 * scalesEms() * em_);
  const bool both = (parts_.colours || parts_.legend) && metresPerPixel;
  const int width = frame.size.width;
  const int middle = both ? width / 3 : width / 2, room = both ? 2 * width / 3 : width;
  if (parts_.colours && colours) scales_->drawColourBar(surface, *colours, middle, y, room);
  if (parts_.legend) {
    scales_->drawLegend(surface, legend, middle, y, static_cast<int>(kUsedWidth * room));
  }
  if (!metresPerPixel) return;
  const ScaleLength length = roundLength(kLongestLength * width * *metresPerPixel);
  scales_->drawScaleBar(surface, length.text, rounded(length.metres / *metresPerPixel),
                        both ? 5 * width / 6 : width / 2, y);
}

void Strip::drawProgress(Frame& frame, int upper, double progress) const {
  const int margin = rounded(0.5 * (1 - kUsedWidth) * frame.size.width);
  const int length = frame.size.width - 2 * margin;
  const int height = std::max(2, rounded(kProgressBarEms * em_));
  const int top = upper + (rounded(kProgressEms * em_) - height) / 2;
  const int done = margin + rounded(std::clamp(progress, 0.0, 1.0) * length);
  FrameSurface surface(frame);
  surface.box(margin, top, length, height, between(background_, text_, kFaint));
  surface.box(margin, top, done - margin, height, text_);
}

}  // namespace kirireel
