// A PictureSetup defines a picture (style, colours, camera, items) without graphics. A StatePainter
// adds a painter and the strip. Several painters, each on its own thread, can share one setup.
//
// If colours show values, lights are weaker: ambient 0.84 and 38% of the directed lights. Every
// face's colour can then be found on the scale, and faces remain distinct.
//
// If the camera kept in view bricks that fly off (a yielding joint, a bad step), all others would
// shrink to a dot. The fit therefore ignores bricks farther than 20 model sizes from their start.
#include "render/picture/state_painter.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "render/picture/canvas.h"
#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/base/words.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel::picture {
namespace {

/// Lights if colours show values: brightness of an unlit face, and the remaining fraction of the
/// default lights.
constexpr double kMeasureAmbient = 0.84;
constexpr double kMeasureShade = 0.38;

void append(std::vector<Vector3>& points, const std::vector<Vector3>& more) {
  points.insert(points.end(), more.begin(), more.end());
}

/// Height for drawing a ground that is not in the scene: below everything in view.
double groundHeight(const PictureContent& content) {
  if (content.groundHeight) return *content.groundHeight;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vector3& point : content.points) lowest = std::min(lowest, point.z());
  return lowest;
}

/// Absent if it would show nothing.
std::optional<GroundPlate> plateFor(const Appearance& appearance, const PictureContent& content) {
  const bool requested = appearance.ground == GroundLook::Auto
                             ? content.groundHeight.has_value()
                             : appearance.ground != GroundLook::None;
  if (!requested || content.points.empty()) return std::nullopt;
  GroundPlate plate = groundUnder(content.points, groundHeight(content));
  plate.visible = appearance.ground != GroundLook::Shadow;
  return plate;
}

/// The colours of a page.
Style pageStyle(const Appearance& appearance) {
  Style style = appearance.theme == Theme::Dark ? darkStyle() : Style();
  if (appearance.background) style.background = *appearance.background;
  style.text = readableText(style.text, style.background);
  if (appearance.transparent) style.background.alpha = 0;
  return style;
}

/// The colour behind the bricks.
Colour groundColour(const Appearance& appearance, const PictureContent& content) {
  const std::optional<GroundPlate> plate = plateFor(appearance, content);
  const Style style = pageStyle(appearance);
  Colour colour = plate && plate->visible ? style.ground : style.background;
  colour.alpha = 255;
  return colour;
}

/// The colour in a picture of a face that is seen face on. On a transparent page it keeps its
/// alpha.
Colour shownFaceOn(Colour base, const Style& style, Colour behind) {
  const Colour lit = faceColour(Vector3::UnitZ(), base, style);
  return style.background.alpha < 255 ? lit : blended(behind, lit);
}

/// In heights of the picture, from points in print.
void setOutlineWidths(const Appearance& appearance, FrameSize size, Style& style) {
  const double dots = appearance.pixelsPerInch.value_or(pixelsPerInchOf(size));
  const double points = appearance.outlines ? dots / kPointsPerInch / size.height : 0;
  style.slitWidth = points * appearance.outlineWidths.slits;
  style.silhouetteWidth = points * appearance.outlineWidths.silhouettes;
}

/// The size limits how thin lines may be.
Style styleFor(const Appearance& appearance, const PictureContent& content, FrameSize size) {
  Style style = pageStyle(appearance);
  style.brick = plainColours(appearance);
  if (appearance.outlineColour) style.edge = *appearance.outlineColour;
  if (appearance.occlusion) style.occlusion = *appearance.occlusion;
  setOutlineWidths(appearance, size, style);
  style.overlayWidth = std::max(style.overlayWidth, kThinnestOverlay / size.height);
  if (isMeasure(appearance.colouring)) {
    // Little shading: every face's colour can be found on the scale.
    style.ambient = kMeasureAmbient;
    style.key.strength *= kMeasureShade;
    style.fill.strength *= kMeasureShade;
    style.occlusion *= kMeasureShade;
  }
  style.plate = plateFor(appearance, content);
  // On a plate a shadow hides nothing. On a transparent page it darkens what is under it.
  if (appearance.transparent && style.plate && !style.plate->visible) style.shadow = {0, 0, 0, 56};
  return style;
}

/// Points that cameras keep in view: the content's points and their shadows, if any, with soft
/// edges. A shadow multiplies their number by five.
std::vector<Vector3> pointsInView(const PictureContent& content, const Style& style) {
  std::vector<Vector3> points = content.points;
  if (!style.plate || !style.plate->shadow) return points;
  for (const Vector3& point : content.points) {
    const Vector3 shadow = shadowOf(point, style);
    const double reach = style.shadowSoftness * std::max(0.0, point.z() - style.plate->height);
    for (const Vector3& side : {Vector3::UnitX().eval(), Vector3::UnitY().eval()}) {
      points.push_back(shadow + reach * side);
      points.push_back(shadow - reach * side);
    }
  }
  return points;
}

/// The camera in metres. A flat motion has parallel projection.
CameraChoice cameraFor(const Appearance& appearance, const PictureContent& content) {
  CameraChoice camera = appearance.camera;
  if (camera.distance) *camera.distance *= content.unit.metres;
  if (camera.view || !content.view) return camera;
  camera.view = content.view->angles;
  const bool isStill = camera.keys.empty() && camera.orbit == 0;
  if (!camera.orthographic && isStill) camera.orthographic = content.view->isFlat;
  return camera;
}

/// The bricks of the target with the thicknesses of the content's bricks.
std::vector<brick::Brick> targetBricks(const PictureContent& content) {
  std::vector<brick::Brick> bricks;
  for (std::size_t i = 0; i < content.target->size(); ++i) {
    brick::BrickRule rule;
    rule.thickness = content.bricks[i].thickness;
    bricks.push_back(brick::makeBrick((*content.target)[i], rule));
  }
  return bricks;
}

/// The faces of the ghost's bricks, world axes.
std::vector<std::vector<std::vector<Vector3>>> ghostFaces(Ghost ghost,
                                                          const PictureContent& content) {
  if (ghost == Ghost::None) return {};
  const bool isStart = ghost == Ghost::Start;
  const std::vector<brick::Brick> bricks = isStart ? content.bricks : targetBricks(content);
  const Poses poses = isStart ? content.start : brick::startPoses(*content.target, bricks);
  std::vector<std::vector<std::vector<Vector3>>> ghosts;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    ghosts.push_back(brick::brickFaces(bricks[i]));
    for (std::vector<Vector3>& face : ghosts.back()) {
      for (Vector3& corner : face) corner = poses[i].apply(corner);
    }
  }
  return ghosts;
}

/// Throws InputError if an option refers to tiles that do not exist.
void requireTiles(const char* option, const std::vector<int>& tiles, std::size_t count) {
  for (const int tile : tiles) {
    if (tile < static_cast<int>(count)) continue;
    throw InputError(fmt::format("error: {}: the model has no tile {}. Give tiles from 0 to {}",
                                 option, tile, static_cast<long>(count) - 1));
  }
}

void requireTarget(const PictureContent& content, const char* option) {
  if (content.target) return;
  throw InputError(
      fmt::format("error: the model has no target to draw; remove {} or add target.txt", option));
}

}  // namespace

double pixelsPerInchOf(FrameSize size) {
  constexpr double kMillimetres = 160;
  return size.width / kMillimetres * kMillimetresPerInch;
}

bool needsView(const Appearance& appearance) {
  return !appearance.camera.view && appearance.camera.keys.empty();
}

void setView(const Appearance& appearance, std::span<const Poses> states, PictureContent& content) {
  const bool zIsUp = appearance.camera.orbit != 0 || (appearance.ground == GroundLook::Auto
                                                          ? content.groundHeight.has_value()
                                                          : appearance.ground != GroundLook::None);
  std::vector<std::vector<model::Tile>> shown;
  for (const Poses& poses : states) {
    const std::vector<model::Tile> tiles = brick::bottomTiles(content.bricks, poses);
    std::vector<model::Tile>& near = shown.emplace_back();
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      if (isShown(content, i, poses[i])) near.push_back(tiles[i]);
    }
    if (near.empty()) shown.pop_back();
  }
  content.view = chooseView(shown, zIsUp);
}

PictureContent makeContent(const model::Model& model, const brick::BrickRule& rule,
                           const std::optional<scene::Ground>& ground) {
  PictureContent content;
  content.unit = model.unit;
  content.size = model::modelSize(model);
  content.bricks = brick::makeBricks(model.tiles, rule);
  content.start = brick::startPoses(model.tiles, content.bricks);
  content.pivots = brick::makePivots(model.joints, content.bricks);
  content.target = model.target;
  if (ground) content.groundHeight = ground->height;
  keepInView(content, content.start);
  if (content.target) {
    const std::vector<brick::Brick> atTarget = brick::makeBricks(*content.target, rule);
    append(content.points, brickCorners(atTarget, brick::startPoses(*content.target, atTarget)));
  }
  return content;
}

void keepInView(PictureContent& content, const Poses& poses) {
  append(content.points, shownCorners(content, poses));
}

bool isShown(const PictureContent& content, std::size_t brick, const Pose& pose) {
  const double moved = (pose.position - content.start[brick].position).norm();
  return moved <= kFarthestShown * content.size;
}

bool showsAllBricks(const PictureContent& content, const Poses& poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!isShown(content, i, poses[i])) return false;
  }
  return true;
}

std::vector<Vector3> shownCorners(const PictureContent& content, const Poses& poses) {
  std::vector<Vector3> corners;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!isShown(content, i, poses[i])) continue;
    for (const Vector3& point : content.bricks[i].bottom) corners.push_back(poses[i].apply(point));
    for (const Vector3& point : content.bricks[i].top) corners.push_back(poses[i].apply(point));
  }
  return corners;
}

void requireVertices(const std::vector<TracedVertex>& trails,
                     const std::vector<brick::Brick>& bricks) {
  for (const auto& [tile, vertex] : trails) {
    requireTiles("--trail", {tile}, bricks.size());
    const long last = static_cast<long>(bricks[tile].bottom.size()) - 1;
    if (vertex > last) {
      throw InputError(
          fmt::format("error: --trail: tile {} has no vertex {}. Give vertices from 0 to {}", tile,
                      vertex, last));
    }
  }
}

Vector3 vertexPosition(const PictureContent& content, const Poses& poses,
                       const TracedVertex& vertex) {
  const brick::Brick& brick = content.bricks[vertex.tile];
  return poses[vertex.tile].apply(0.5 * (brick.bottom[vertex.vertex] + brick.top[vertex.vertex]));
}

PictureSetup::PictureSetup(const Appearance& appearance, PictureContent content, FrameSize size)
    : content_(std::move(content)),
      style_(styleFor(appearance, content_, requireValidSize(size))),
      palette_(appearance, content_),
      size_(size),
      cameras_(cameraFor(appearance, content_), pointsInView(content_, style_), size.aspect()),
      jointMarks_(appearance.jointMarks),
      targetLines_(appearance.targetLines),
      trails_(appearance.trails),
      cueShare_(appearance.depthCue),
      legend_(palette_.legend()) {
  if (!appearance.outlineColour) style_.edge = outlineOn(style_.edge, palette_.hues());
  for (LegendEntry& entry : legend_) {
    entry.colour = shownFaceOn(entry.colour, style_, groundColour(appearance, content_));
  }
  if (targetLines_) requireTarget(content_, "--target-lines");
  requireVertices(trails_, content_.bricks);
  if (appearance.ghost == Ghost::Target) requireTarget(content_, "--ghost target");
  ghosts_ = ghostFaces(appearance.ghost, content_);
  if (cueShare_ > 0 && cameras_.isStill()) stillCue_ = depthCueFrom(cameras_.at(0, 0));
}

/// Its range includes the bricks at the start, at the target and in the run.
DepthCue PictureSetup::depthCueFrom(const Camera& camera) const {
  DepthCue cue{cueShare_, std::numeric_limits<double>::infinity(),
               -std::numeric_limits<double>::infinity()};
  const auto include = [&](const std::vector<Vector3>& corners) {
    for (const Vector3& corner : corners) {
      const double distance = distanceAlongView(camera, corner);
      cue.nearest = std::min(cue.nearest, distance);
      cue.farthest = std::max(cue.farthest, distance);
    }
  };
  include(shownCorners(content_, content_.start));
  for (const Poses& poses : content_.states) include(shownCorners(content_, poses));
  if (content_.target) {
    const std::vector<brick::Brick> bricks = targetBricks(content_);
    include(brickCorners(bricks, brick::startPoses(*content_.target, bricks)));
  }
  return cue;
}

PictureItems PictureSetup::items(const ShownState& state) const {
  PictureItems items{
      state.poses, palette_.colours(state.poses, state.time), state.pinned, {}, {}, {}, {}, {}, {}};
  if (jointMarks_) {
    for (const brick::Pivot& pivot : content_.pivots) {
      items.marks.push_back(state.poses[pivot.brickA].apply(pivot.pointA));
    }
  }
  if (targetLines_) items.overlay = *content_.target;
  for (std::size_t k = 0; k < content_.paths.size(); ++k) {
    const auto& [times, points] = content_.paths[k];
    const auto end = std::ranges::lower_bound(times, state.time) - times.begin();
    items.trails.emplace_back(points.begin(), points.begin() + end);
    items.trails.back().push_back(vertexPosition(content_, state.poses, trails_[k]));
  }
  items.scenery = content_.obstacles;
  items.ghosts = ghosts_;
  if (cueShare_ > 0) {
    items.depthCue = stillCue_ ? *stillCue_ : depthCueFrom(cameras_.at(state.time, state.turn));
  }
  return items;
}

/// A camera inside a brick would show only its inside.
Camera PictureSetup::camera(const ShownState& state) const {
  const Camera camera = cameras_.at(state.time, state.turn);
  if (camera.orthographic) return camera;
  if (const auto brick = brickAround(content_.bricks, state.poses, camera.eye)) {
    throw InputError(
        fmt::format("error: at {:.4g} s the camera is within brick {}; move it away with "
                    "--distance, or choose --projection parallel",
                    state.time, *brick));
  }
  return camera;
}

PictureGeometry PictureSetup::geometry(const ShownState& state) const {
  PictureGeometry geometry;
  GeometryBuilder(content_.bricks, style_).draw(items(state), camera(state), geometry);
  return geometry;
}

std::optional<double> PictureSetup::sharedHeight() const {
  const Camera camera = cameras_.at(0, 0);
  if (!cameras_.isStill() || !camera.orthographic) return std::nullopt;
  return camera.viewHeight;
}

double PictureSetup::metresPerPixel() const {
  const std::optional<double> height = sharedHeight();
  if (height) return *height / size_.height;
  throw InputError(
      "error: a scale bar needs a parallel projection and a fixed camera; add --projection "
      "parallel, or remove --scale-bar");
}

StatePainter::StatePainter(FrameSize size, const Appearance& appearance, PictureContent content,
                           const StripParts& parts, Smoothness smoothness)
    : size_(size), parts_(parts), smoothness_(smoothness) {
  show(appearance, std::move(content));
}

StatePainter::StatePainter(std::shared_ptr<const PictureSetup> setup)
    : size_(setup->pictureSize()), smoothness_(Smoothness::Still), setup_(std::move(setup)) {
  makeStrip(setup_->style(), setup_->colouring());
  makePainter();
}

StatePainter::StatePainter(const StatePainter& other, Smoothness smoothness)
    : size_(other.size_),
      parts_(other.parts_),
      smoothness_(smoothness),
      setup_(other.setup_),
      scale_(other.scale_) {
  makeStrip(setup_->style(), setup_->colouring());
  makePainter();
}

/// A legend and a colour bar exclude each other: colours show kinds or values.
void StatePainter::makeStrip(const Style& style, Colouring colouring) {
  StripParts parts = parts_;
  parts.colours = parts.colours && isMeasure(colouring);
  parts.legend = parts_.colours && !isMeasure(colouring) && colouring != Colouring::Plain;
  strip_.emplace(requireValidSize(size_), parts, style);
}

/// Keeps the graphics context if the picture's size stays the same.
void StatePainter::makePainter() {
  if (painter_ && painter_->size() == strip_->picture()) {
    painter_->show(setup_->content().bricks, setup_->style());
  } else {
    painter_.reset();
    painter_.emplace(strip_->picture(), setup_->content().bricks, setup_->style(), smoothness_);
  }
}

void StatePainter::show(const Appearance& appearance, PictureContent content) {
  makeStrip(pageStyle(appearance), appearance.colouring);
  setup_ = std::make_shared<const PictureSetup>(appearance, std::move(content), strip_->picture());
  scale_.reset();
  if (parts_.scaleBar) scale_ = setup_->scale();
  makePainter();
}

Frame StatePainter::paint(const ShownState& state, const StripText& text, Frame storage) {
  const Camera camera = setup_->camera(state);
  Frame frame = painter_->paint(setup_->items(state), camera, std::move(storage));
  strip_->append(frame, text, setup_->colourScale(), setup_->legend(), scale_);
  return frame;
}

// ------------------------------------------------------------------------------------------------
// The strip is below the picture and reduces its height, so the frame keeps its size. From the top:
// a line with a name (1.5 em), a line with the caption (1.5 em), a line with scales (1.8 em, more
// with ticks), the progress bar (1.2 em). The em is 3.4% of the frame's height, at least 9 pixels,
// smaller if the longest caption would not fit. It is computed once, so text does not change its
// size in a video.

namespace {

/// Em of the text, in heights of the frame, and the smallest legible em, pixels.
constexpr double kTextShare = 0.034;
constexpr int kMinText = 9;
/// Heights in ems: of a text line with its baseline, of a line of scales, of the progress bar with
/// the space around it, and of the bar only.
constexpr double kStripLineEms = 1.5;
constexpr double kLineBaselineEms = 1.1;
constexpr double kScalesEms = 1.8;
constexpr double kProgressEms = 1.2;
constexpr double kProgressBarEms = 0.35;
/// Maximum fractions of the frame's width for captions or a progress bar, and for a length.
constexpr double kUsedWidth = 0.94;
constexpr double kLongestLength = 0.25;
/// Opacity of the remaining part of a progress bar.
constexpr double kFaint = 0.2;

Colour between(Colour from, Colour to, double share) {
  const auto mix = [share](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + share * (b - a)));
  };
  return {mix(from.red, to.red), mix(from.green, to.green), mix(from.blue, to.blue),
          mix(from.alpha, to.alpha)};
}

/// Text size at which the widest line fits.
int textSize(FrameSize whole, std::span<const std::string> lines) {
  const int requested = std::max(kMinText, wholePixels(kTextShare * whole.height));
  const LabelWriter writer(requested);
  double fitting = requested;
  for (const std::string& line : lines) {
    if (line.empty()) continue;
    fitting = std::min(fitting, requested * kUsedWidth * whole.width / writer.width(line));
  }
  return std::max(kMinText, static_cast<int>(fitting));
}

}  // namespace

Strip::Strip(FrameSize whole, const StripParts& parts, const Style& style)
    : whole_(whole), parts_(parts), background_(style.background), text_(style.text) {
  const bool hasName = !parts.name.empty(), hasCaption = !parts.longestCaption.empty();
  const bool hasScales = scalesEms() > 0;
  if (!hasName && !hasCaption && !hasScales && !parts.progressBar) return;
  em_ = textSize(whole, std::array{parts.name, parts.longestName, parts.longestCaption});
  height_ = wholePixels(em_ * ((hasName ? kStripLineEms : 0) + (hasCaption ? kStripLineEms : 0) +
                               scalesEms() + (parts.progressBar ? kProgressEms : 0)));
  height_ = std::min(height_, whole.height - 1);
  if (hasScales) scales_.emplace(em_, text_);
  if (!hasName && !hasCaption) return;
  writer_.emplace(em_);
  const auto leftOf = [this](const std::string& line) {
    return std::max(0, (whole_.width - writer_->width(line)) / 2);
  };
  nameLeft_ = leftOf(parts.name);
  captionLeft_ = leftOf(parts.longestCaption);
}

/// Height of the line of scales, ems.
double Strip::scalesEms() const {
  if (parts_.colours) return kScalesEms + kColourBarHeight - 1;
  return parts_.legend || parts_.scaleBar ? kScalesEms : 0;
}

void Strip::append(Frame& picture, const StripText& text, const std::optional<ColourScale>& colours,
                   const std::vector<LegendEntry>& legend,
                   const std::optional<PictureScale>& scale) const {
  if (height_ == 0) return;
  int upper = picture.size.height;
  const Frame strip = makeFrame({whole_.width, height_}, background_);
  picture.pixels.insert(picture.pixels.end(), strip.pixels.begin(), strip.pixels.end());
  picture.size = whole_;
  const auto write = [&](const std::string& line, int left) {
    writer_->draw(picture, line, left, upper + wholePixels(kLineBaselineEms * em_), text_);
    upper += wholePixels(kStripLineEms * em_);
  };
  if (!parts_.name.empty()) write(parts_.name, nameLeft_);
  // At the same position in every frame, so letters do not jump.
  if (!parts_.longestCaption.empty()) write(text.caption, captionLeft_);
  if (scales_) {
    drawScales(picture, upper, colours, legend, scale);
    upper += wholePixels(scalesEms() * em_);
  }
  if (parts_.progressBar) drawProgress(picture, upper, text.progress);
}

/// A scale of colours and a scale bar are next to each other.
void Strip::drawScales(Frame& frame, int upper, const std::optional<ColourScale>& colours,
                       const std::vector<LegendEntry>& legend,
                       const std::optional<PictureScale>& scale) const {
  FrameSurface surface(frame);
  const int y = upper + wholePixels(0.5 * scalesEms() * em_);
  const bool both = (parts_.colours || parts_.legend) && scale;
  const int width = frame.size.width;
  const int middle = both ? width / 3 : width / 2, room = both ? 2 * width / 3 : width;
  if (parts_.colours && colours) scales_->drawColourBar(surface, *colours, middle, y, room);
  if (parts_.legend) {
    scales_->drawLegend(surface, legend, middle, y, static_cast<int>(kUsedWidth * room));
  }
  if (!scale) return;
  const ScaleLength length =
      roundLength(kLongestLength * width * scale->metresPerPixel, scale->unit);
  scales_->drawScaleBar(surface, length.text, wholePixels(length.metres / scale->metresPerPixel),
                        both ? 5 * width / 6 : width / 2, y);
}

void Strip::drawProgress(Frame& frame, int upper, double progress) const {
  const int margin = wholePixels(0.5 * (1 - kUsedWidth) * frame.size.width);
  const int length = frame.size.width - 2 * margin;
  const int height = std::max(2, wholePixels(kProgressBarEms * em_));
  const int top = upper + (wholePixels(kProgressEms * em_) - height) / 2;
  const int done = margin + wholePixels(std::clamp(progress, 0.0, 1.0) * length);
  FrameSurface surface(frame);
  surface.box(margin, top, length, height, between(background_, text_, kFaint));
  surface.box(margin, top, done - margin, height, text_);
}

// ------------------------------------------------------------------------------------------------
// Three kinds of colourings:
//
// - kinds: a number for each shape of tile. Two tiles are congruent if their sorted sides and
//   sorted shortest diagonals agree to 1e-4. Mirror images have the same lengths. (Different
//   polygons of many corners may agree by chance, which does not matter for colours.)
// - states: at its start, in motion, at its target, within 1% of a tile's mean edge.
// - measures: a value for each brick and a scale from 0 to the maximum of the run, the same for all
//   pictures. Before a run, for example for the first live frame, the maximum is estimated.

namespace {

/// Relative tolerance of the lengths of congruent tiles.
constexpr double kCongruence = 1e-4;

/// Maximum number of distinct colours of shapes.
constexpr int kMaxKinds = 7;

/// A brick is at its start or its target within this fraction of a tile's mean edge.
constexpr double kArrival = 0.01;

constexpr Colour kAtStart = {168, 178, 192};
constexpr Colour kMoving = {246, 184, 96};
constexpr Colour kAtTarget = {110, 186, 150};

/// Sides and shortest diagonals by length, metres: equal for congruent polygons. Twice as many
/// numbers as corners.
std::vector<double> signature(const std::vector<Vector3>& corners) {
  const std::size_t count = corners.size();
  std::vector<double> sides, diagonals;
  for (std::size_t k = 0; k < count; ++k) {
    sides.push_back((corners[(k + 1) % count] - corners[k]).norm());
    diagonals.push_back((corners[(k + 2) % count] - corners[k]).norm());
  }
  std::sort(sides.begin(), sides.end());
  std::sort(diagonals.begin(), diagonals.end());
  sides.insert(sides.end(), diagonals.begin(), diagonals.end());
  return sides;
}

bool alike(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](double x, double y) {
    return std::abs(x - y) <= kCongruence * std::max(x, y);
  });
}

/// The number of each entry in the list of distinct entries, in order of appearance. Compares each
/// entry with all distinct ones, which are few.
template <typename T, typename Same>
std::vector<int> numbered(const std::vector<T>& entries, const Same& same) {
  std::vector<T> known;
  std::vector<int> numbers;
  for (const T& entry : entries) {
    const auto found = std::find_if(known.begin(), known.end(),
                                    [&](const T& other) { return same(entry, other); });
    numbers.push_back(static_cast<int>(found - known.begin()));
    if (found == known.end()) known.push_back(entry);
  }
  return numbers;
}

/// The mean edge of the tiles, metres.
double tileSize(const PictureContent& content) {
  model::Model start;
  start.tiles = brick::bottomTiles(content.bricks, content.start);
  return model::tileSize(start);
}

/// For the legend: "concave hexagon", "12-gon".
std::string shapeName(const brick::Brick& brick) {
  const std::size_t corners = brick.bottom.size();
  const std::string concave = brick.parts.empty() ? "" : "concave ";
  constexpr std::array<const char*, 6> kNames = {"triangle", "quadrilateral", "pentagon",
                                                 "hexagon",  "heptagon",      "octagon"};
  if (corners >= 3 && corners - 3 < kNames.size()) return concave + kNames[corners - 3];
  return fmt::format("{}{}-gon", concave, corners);
}

std::string titleOf(Colouring colouring, const LengthUnit& unit) {
  switch (colouring) {
    case Colouring::TargetError:
      return "target error, " + unitSymbol(unit);
    case Colouring::Displacement:
      return "displacement, " + unitSymbol(unit);
    case Colouring::Rotation:
      return "rotation, degrees";
    case Colouring::Moment:
      return "moment, N m";
    case Colouring::Energy:
      return "energy, J";
    default:
      return "joint gap, " + unitSymbol(unit);
  }
}

/// 0 for an empty list.
double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

bool isMeasure(Colouring colouring) {
  return colouring != Colouring::Plain && colouring != Colouring::Shape &&
         colouring != Colouring::State;
}

BrickColours evenShades(Colour colour) {
  BrickColours shades = shadesOf(colour);
  shades.bottom = colour;
  return shades;
}

BrickColours plainColours(const Appearance& appearance) {
  BrickColours colours =
      appearance.brickColour ? shadesOf(*appearance.brickColour) : BrickColours();
  if (appearance.backColour) colours.bottom = *appearance.backColour;
  return colours;
}

std::vector<int> shapeKinds(const std::vector<brick::Brick>& bricks) {
  std::vector<std::vector<double>> signatures;
  std::vector<std::size_t> corners;
  for (const brick::Brick& brick : bricks) {
    signatures.push_back(signature(brick.bottom));
    corners.push_back(brick.bottom.size());
  }
  std::vector<int> kinds = numbered(signatures, alike);
  const bool many = std::any_of(kinds.begin(), kinds.end(), [](int k) { return k >= kMaxKinds; });
  return many ? numbered(corners, std::equal_to<>()) : kinds;
}

BrickPalette::BrickPalette(const Appearance& appearance, const PictureContent& content)
    : colouring_(appearance.colouring), content_(content), plain_(plainColours(appearance)) {
  if (colouring_ == Colouring::TargetError && !content.target) {
    throw InputError(
        "error: the model has no target, so there is no target error to show; give another "
        "--colour or add target.txt");
  }
  const bool isPulled = content.panels || (colouring_ == Colouring::Moment
                                               ? !brick::hingeSpringsOf(content.pairForces).empty()
                                               : !content.pairForces.empty());
  if ((colouring_ == Colouring::Moment || colouring_ == Colouring::Energy) && !isPulled) {
    throw InputError(
        "error: the hinges have no springs, so there is no moment or energy to show; give another "
        "--colour or add --hinge-stiffness or --hinge-neck");
  }
  if (appearance.opacity < 1 || !appearance.tileOpacities.empty()) findOpacities(appearance);
  if (colouring_ == Colouring::Shape) colourShapes();
  if (colouring_ == Colouring::State) {
    addToLegend(kAtStart, appearance.opacity, "at its start");
    addToLegend(kMoving, appearance.opacity, "on its way");
    if (content.target) addToLegend(kAtTarget, appearance.opacity, "at its target");
  }
  if (!appearance.tileColours.empty()) colourTiles(appearance);
  const bool hasOwn = !own_.empty() || !opacities_.empty();
  if (kinds_.empty() && hasOwn) kinds_.assign(content.bricks.size(), plain_);
  if (isMeasure(colouring_)) makeScale(appearance);
}

void BrickPalette::makeScale(const Appearance& appearance) {
  const double found = largestOfRun();
  const double most = appearance.colourMost.value_or(found > 0 ? found : largestExpected());
  const double least = appearance.colourLeast.value_or(0);
  if (least >= most) {
    throw InputError(
        fmt::format("error: --colour-least {:g} is not below {:g}, the scale's other end; give a "
                    "smaller one, or a larger --colour-most",
                    least, most));
  }
  scale_ = ColourScale{appearance.map, least, most, titleOf(colouring_, content_.unit),
                       groundColour(appearance, content_)};
}

void BrickPalette::addToLegend(Colour colour, double opacity, std::string text) {
  legend_.push_back({withOpacity(shadesOf(colour), opacity).top, std::move(text)});
}

double BrickPalette::opacityOf(std::size_t brick) const {
  return opacities_.empty() ? 1 : opacities_[brick];
}

void BrickPalette::findOpacities(const Appearance& appearance) {
  opacities_.assign(content_.bricks.size(), appearance.opacity);
  for (const auto& [tiles, opacity] : appearance.tileOpacities) {
    requireTiles("--tile-opacity", tiles, opacities_.size());
    for (const int tile : tiles) opacities_[tile] = opacity;
  }
}

void BrickPalette::colourTiles(const Appearance& appearance) {
  if (isMeasure(colouring_)) {
    throw InputError(
        "error: --tile-colour works only with --colour plain, shape or state: other colours show "
        "values. Give one of these, or remove --tile-colour");
  }
  own_.resize(content_.bricks.size());
  for (const auto& [tiles, colour, name] : appearance.tileColours) {
    requireTiles("--tile-colour", tiles, own_.size());
    for (const int tile : tiles) own_[tile] = evenShades(colour);
    if (!name.empty()) addToLegend(colour, opacityOf(tiles.front()), name);
  }
}

/// Fills colours and legend. Kinds are in order of appearance, so a new kind always has the next
/// number.
void BrickPalette::colourShapes() {
  const std::vector<int> kinds = shapeKinds(content_.bricks);
  std::vector<int> counts;
  std::vector<std::string> names;
  std::vector<double> opacities;
  for (std::size_t brick = 0; brick < kinds.size(); ++brick) {
    const int kind = kinds[brick];
    kinds_.push_back(shadesOf(kindColour(kind)));
    if (kind == static_cast<int>(counts.size())) {
      counts.push_back(0);
      names.push_back(shapeName(content_.bricks[brick]));
      opacities.push_back(opacityOf(brick));
    }
    ++counts[kind];
  }
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    addToLegend(kindColour(static_cast<int>(kind)), opacities[kind],
                counted(counts[kind], names[kind]));
  }
}

/// The maximum in the states of the run; 0 before it.
double BrickPalette::largestOfRun() const {
  double most = 0;
  if (content_.panels && (colouring_ == Colouring::Moment || colouring_ == Colouring::Energy)) {
    for (const trajectory::PanelState& state : content_.panels->states) {
      most = std::max(most, largest(values({}, state.time)));
    }
    return most;
  }
  for (const Poses& poses : content_.states) most = std::max(most, largest(values(poses, 0)));
  return most;
}

/// The expected maximum before the run, in the scale's unit.
double BrickPalette::largestExpected() const {
  switch (colouring_) {
    case Colouring::TargetError:
    case Colouring::Displacement:
      // The whole distance to the target, or without a target half the size of the view.
      return (content_.target ? largest(trajectory::brickTargetErrors(
                                    *content_.target, content_.bricks, content_.start))
                              : 0.5 * boundingBox(content_.points).diagonal().norm()) /
             content_.unit.metres;
    case Colouring::Rotation:
      return 90;
    case Colouring::Moment:
    case Colouring::Energy:
      return 1;
    default:
      // Exact joints stay far below this, those of the baseline solver do not.
      return 1e-6 * tileSize(content_) / content_.unit.metres;
  }
}

/// One per brick, in the unit of titleOf().
std::vector<double> BrickPalette::values(const Poses& poses, double time) const {
  const auto inUnits = [&](std::vector<double> lengths) {
    for (double& length : lengths) length /= content_.unit.metres;
    return lengths;
  };
  switch (colouring_) {
    case Colouring::TargetError:
      return inUnits(trajectory::brickTargetErrors(*content_.target, content_.bricks, poses));
    case Colouring::Displacement:
      return inUnits(trajectory::brickDisplacements(content_.start, poses));
    case Colouring::Rotation: {
      std::vector<double> degrees = trajectory::brickRotations(content_.start, poses);
      for (double& angle : degrees) angle /= kDegree;
      return degrees;
    }
    case Colouring::Moment:
      return content_.panels ? content_.panels->tileMoments(time)
                             : trajectory::brickMoments(content_.pairForces, poses);
    case Colouring::Energy:
      return content_.panels ? content_.panels->tileEnergies(time)
                             : trajectory::brickElasticEnergies(content_.pairForces, poses);
    default:
      return inUnits(trajectory::brickJointGaps(content_.pivots, poses));
  }
}

/// The target has priority over the start: a sheet whose target is its start has arrived.
std::vector<BrickColours> BrickPalette::stateColours(const Poses& poses) const {
  const double near = kArrival * tileSize(content_);
  const std::vector<double> moved = trajectory::brickDisplacements(content_.start, poses);
  const std::vector<double> turned = trajectory::brickRotations(content_.start, poses);
  std::vector<double> away(poses.size(), near + 1);
  if (content_.target)
    away = trajectory::brickTargetErrors(*content_.target, content_.bricks, poses);
  std::vector<BrickColours> colours;
  for (std::size_t brick = 0; brick < poses.size(); ++brick) {
    const bool atStart = moved[brick] < near && turned[brick] < kArrival;
    const Colour colour = away[brick] < near ? kAtTarget : atStart ? kAtStart : kMoving;
    colours.push_back(shadesOf(colour));
  }
  return colours;
}

std::vector<Colour> BrickPalette::hues() const {
  std::vector<Colour> hues;
  if (scale_) {
    constexpr int kSteps = 16;
    for (int k = 0; k <= kSteps; ++k) hues.push_back(colourAt(*scale_, k / double{kSteps}));
  } else if (colouring_ == Colouring::State) {
    hues = {kAtStart, kMoving, kAtTarget};
  }
  for (std::size_t brick = 0; brick < kinds_.size(); ++brick) {
    hues.push_back((own_.empty() ? kinds_[brick] : own_[brick].value_or(kinds_[brick])).top);
  }
  if (hues.empty()) hues.push_back(plain_.top);
  return hues;
}

std::vector<BrickColours> BrickPalette::colours(const Poses& poses, double time) const {
  std::vector<BrickColours> colours;
  if (!scale_) {
    colours = colouring_ == Colouring::State ? stateColours(poses) : kinds_;
    for (std::size_t brick = 0; brick < own_.size(); ++brick) {
      colours[brick] = own_[brick].value_or(colours[brick]);
    }
  } else {
    for (const double value : values(poses, time)) {
      colours.push_back(evenShades(colourAt(*scale_, shareOf(*scale_, value))));
    }
  }
  for (std::size_t brick = 0; brick < opacities_.size(); ++brick) {
    colours[brick] = withOpacity(colours[brick], opacities_[brick]);
  }
  return colours;
}

}  // namespace kirireel::picture
