// The plot is drawn once (PlotSheet). Each frame blends it and the dots.
//
// Text is 6 points high in a frame that is 160 mm wide, at least 9 pixels. All lengths follow from
// this em. At an even pace the horizontal axis is the share of the motion, at real pace the time,
// like captions.
//
// A dot is on the drawn line: between the points p_k and p_(k+1) of the samples before and after
// the time t of the frame, at
//
//     p_k + (t - t_k) / (t_(k+1) - t_k) (p_(k+1) - p_k).
//
// The inset is in the corner that bricks cover least. The faces of some states of the video are
// drawn in small, and the covered areas of the four corners are summed over the states. Corners
// with nearly the same sum are equally good. The first one of a fixed order is selected.
//
// The background of the plot has the colour of the picture's background and is opaque, also in
// transparent pictures: text over bricks would be unreadable.
#include "render/record/inset.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "render/record/pace.h"
#include "sim/base/error.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel::record {
namespace {

constexpr const char* kOption = "--inset";
/// Size of the text in print, points, and its smallest size, pixels.
constexpr double kPoints = 6;
constexpr int kMinEm = 9;
/// Sides of the inset, and its distance from the borders of the picture; em.
constexpr double kWidthEms = 20;
constexpr double kHeightEms = 14;
constexpr double kMarginEms = 0.5;
/// Radius of a dot, and of the ring around it; em.
constexpr double kDotEms = 0.3;
constexpr double kRingEms = 0.42;
/// The largest share of the frame's width and height. The highest strip, with text of 9 pixels or
/// 3.4% of the height, leaves enough room for the inset.
constexpr double kLargestWidth = 0.8;
constexpr double kLargestHeight = 0.55;
/// Number of states for the choice of the corner.
constexpr std::size_t kStates = 16;
/// Width of the small pictures for the choice of the corner, pixels.
constexpr int kSmallWidth = 320;
/// Sums within this fraction of the inset's area are nearly the same.
constexpr double kNearlySame = 0.005;

double pixelsPerInch(const PictureSettings& settings) {
  return settings.appearance.pixelsPerInch.value_or(picture::pixelsPerInchOf(settings.size));
}

int emOf(const PictureSettings& settings) {
  const double pixels = kPoints / picture::kPointsPerInch * pixelsPerInch(settings);
  return std::max(kMinEm, static_cast<int>(std::ceil(pixels)));
}

/// The corners of pictures of this size for an inset, in order of preference.
std::array<picture::PageBox, 4> cornersOf(picture::FrameSize size, int em) {
  const double width = std::ceil(kWidthEms * em), height = std::ceil(kHeightEms * em);
  const double margin = std::round(kMarginEms * em);
  const double left = margin, right = size.width - margin - width;
  const double upper = margin, lower = size.height - margin - height;
  return {{{right, upper, width, height},
           {left, upper, width, height},
           {right, lower, width, height},
           {left, lower, width, height}}};
}

void requireRoom(const PictureSettings& settings) {
  const auto [width, height] = settings.size;
  const double em = emOf(settings);
  const double minWidth = kWidthEms * em / kLargestWidth,
               minHeight = kHeightEms * em / kLargestHeight;
  if (width >= minWidth && height >= minHeight) return;
  throw InputError(fmt::format(
      "error: {} needs pictures of at least {:.0f} x {:.0f} pixels, here they have {} x {}; give a "
      "larger --size or remove {}",
      kOption, std::ceil(minWidth), std::ceil(minHeight), width, height, kOption));
}

/// Draws the faces of all bricks in black.
void drawBricks(const picture::PictureSetup& setup, const FrameState& state,
                picture::FrameSize small, picture::Canvas& canvas) {
  const picture::Camera camera =
      setup.camera({state.moment.time, state.sample.poses, {}, state.moment.turn});
  const Eigen::Matrix4d clip = picture::clipFromWorld(camera, setup.pictureSize().aspect());
  const std::vector<brick::Brick>& bricks = setup.content().bricks;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (const std::vector<Vector3>& face : brick::brickFaces(bricks[i])) {
      picture::Canvas::Points corners;
      for (const Vector3& corner : face) {
        const Eigen::Vector4d point = clip * state.sample.poses[i].apply(corner).homogeneous();
        corners.emplace_back(0.5 * (1 + point.x() / point.w()) * small.width,
                             0.5 * (1 - point.y() / point.w()) * small.height);
      }
      canvas.polygon(corners, {0, 0, 0});
    }
  }
}

/// The covered area of a part of a picture, pixels.
double coverOf(const picture::Frame& picture, const picture::PageBox& part) {
  double sum = 0;
  for (int y = std::max(0, static_cast<int>(part.upper));
       y < std::min<double>(part.lower(), picture.size.height); ++y) {
    for (int x = std::max(0, static_cast<int>(part.left));
         x < std::min<double>(part.right(), picture.size.width); ++x) {
      sum += picture.at(x, y).alpha / 255.0;
    }
  }
  return sum;
}

picture::PageBox chooseCorner(const trajectory::TrajectoryReader& run,
                              const PictureSettings& settings, const picture::PictureSetup& setup,
                              const std::array<picture::PageBox, 4>& corners) {
  const picture::FrameSize size = setup.pictureSize();
  const double scale = std::min(1.0, static_cast<double>(kSmallWidth) / size.width);
  const picture::FrameSize small{std::max(1, picture::wholePixels(scale * size.width)),
                                 std::max(1, picture::wholePixels(scale * size.height))};
  const std::vector<FrameMoment> moments = videoMoments(motionOf(run), settings);
  const std::size_t states = std::min(kStates, moments.size());
  std::array<double, 4> covers{};
  Replay replayed(run);
  for (std::size_t k = 0; k < states; ++k) {
    const std::size_t last = std::max<std::size_t>(1, states - 1);
    const FrameMoment& moment = moments[k * (moments.size() - 1) / last];
    const FrameState state{moment, replayed.at(moment.time)};
    const picture::Frame picture = picture::drawnPage(
        {.size = small, .background = {0, 0, 0, 0}},
        [&](picture::Canvas& canvas) { drawBricks(setup, state, small, canvas); });
    for (std::size_t corner = 0; corner < corners.size(); ++corner) {
      const auto& [left, upper, width, height] = corners[corner];
      covers[corner] +=
          coverOf(picture, {scale * left, scale * upper, scale * width, scale * height});
    }
  }
  const double area = scale * corners[0].width * scale * corners[0].height;
  const double most =
      *std::ranges::min_element(covers) + kNearlySame * area * static_cast<double>(states);
  const auto best = std::ranges::find_if(covers, [most](double cover) { return cover <= most; });
  return corners[best - covers.begin()];
}

}  // namespace

void requireInset(const PictureSettings& settings) {
  if (settings.inset.empty()) return;
  selectCurves(trajectory::curveGroups(), {settings.inset}, kOption);
  requireRoom(settings);
}

PlottedRun insetCurve(const trajectory::TrajectoryReader& run, const PictureSettings& settings) {
  return plottedCurve(run, settings.inset,
                      settings.pace == Pace::Even ? CurvesAgainst::Progress : CurvesAgainst::Time,
                      kOption);
}

Inset::Inset(const trajectory::TrajectoryReader& run, const PictureSettings& settings,
             const picture::PictureSetup& setup)
    : em_(emOf(settings)), background_(setup.style().background), times_(run.times()) {
  background_.alpha = 255;
  requireRoom(settings);
  const std::vector<PlottedRun> plotted = {insetCurve(run, settings)};
  box_ = chooseCorner(run, settings, setup, cornersOf(setup.pictureSize(), em_));
  const picture::PageSettings page{
      .size = {static_cast<int>(box_.width), static_cast<int>(box_.height)},
      .pixelsPerInch = pixelsPerInch(settings),
      .background = background_,
      .fontFamily = picture::fontFamily()};
  const PlotSheet sheet(plotted, em_, background_);
  const picture::PageBox whole{0, 0, box_.width, box_.height};
  plot_ = picture::drawnPage(
      page, [&](picture::Canvas& canvas) { sheet.draw(canvas, whole, 1, "inset_"); });
  curves_ = sheet.drawnCurves(whole, 1);
  for (DrawnCurve& curve : curves_) {
    for (std::optional<Eigen::Vector2d>& point : curve.points) {
      if (point) *point += Eigen::Vector2d(box_.left, box_.upper);
    }
  }
}

double Inset::dotRadius() const {
  return kDotEms * em_;
}

std::vector<Inset::Dot> Inset::dots(double time) const {
  const auto above = std::ranges::lower_bound(times_, time);
  const auto after = static_cast<std::size_t>(std::min(above, times_.end() - 1) - times_.begin());
  const std::size_t before = above == times_.begin() ? 0 : after - 1;
  const double share =
      after == before
          ? 0
          : std::clamp((time - times_[before]) / (times_[after] - times_[before]), 0.0, 1.0);
  std::vector<Dot> dots;
  for (const DrawnCurve& curve : curves_) {
    const auto &from = curve.points[before], &to = curve.points[after];
    if (from && to) {
      dots.push_back({curve.colour, *from + share * (*to - *from)});
    } else if (from && share == 0) {
      dots.push_back({curve.colour, *from});
    } else if (to && share == 1) {
      dots.push_back({curve.colour, *to});
    }
  }
  return dots;
}

void Inset::draw(picture::Frame& picture, double time) const {
  picture::blendFrame(picture, plot_, static_cast<int>(box_.left), static_cast<int>(box_.upper));
  for (const auto& [colour, place] : dots(time)) {
    picture::blendDisc(picture, place.x(), place.y(), kRingEms * em_, background_);
    picture::blendDisc(picture, place.x(), place.y(), dotRadius(), colour);
  }
}

}  // namespace kirireel::record
