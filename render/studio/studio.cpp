// A Stage decides what a picture shows (style, colours, camera, shot) and needs no graphics; a
// Studio adds a painter and the strip. Several studios share one stage, each with a painter on its
// own thread.
//
// Where colours stand for values, lights are weakened: ambient 0.84 and 38% of the directed lights,
// so that a colour can be found on the scale from every face and faces still stand apart.
//
// Bricks that fly off (a joint that gives, a bad step) would shrink all others to a dot if the
// camera held them in sight: those farther from their start than 20 model sizes are left out of the
// fit.
#include "render/studio/studio.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

/// Light where colours stand for values: brightness of a face in the dark, and the part of the
/// usual lights that is left.
constexpr double kMeasureAmbient = 0.84;
constexpr double kMeasureShade = 0.38;

void append(std::vector<Vector3>& points, const std::vector<Vector3>& more) {
  points.insert(points.end(), more.begin(), more.end());
}

/// Where a ground that the scene does not have is drawn: under everything in sight.
double groundHeight(const Motif& motif) {
  if (motif.groundHeight) return *motif.groundHeight;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vector3& point : motif.points) lowest = std::min(lowest, point.z());
  return lowest;
}

/// None where nothing is to be seen, either.
std::optional<GroundPlate> plateFor(const Look& look, const Motif& motif) {
  const bool wanted = look.ground == GroundLook::Auto ? motif.groundHeight.has_value()
                                                      : look.ground != GroundLook::None;
  if (!wanted || motif.points.empty()) return std::nullopt;
  GroundPlate plate = groundUnder(motif.points, groundHeight(motif));
  plate.visible = look.ground != GroundLook::Shadow;
  return plate;
}

/// The colours of a page.
Style pageStyle(const Look& look) {
  Style style = look.theme == Theme::Dark ? darkStyle() : Style();
  if (look.background) style.background = *look.background;
  if (look.transparent) {
    style.background.alpha = 0;
    style.shadow = {0, 0, 0, 56};
  }
  return style;
}

/// The size decides how thin lines may become.
Style styleFor(const Look& look, const Motif& motif, FrameSize size) {
  Style style = pageStyle(look);
  style.brick = plainColours(look);
  if (look.outlineColour) style.edge = style.paleEdge = *look.outlineColour;
  if (look.occlusion) style.occlusion = *look.occlusion;
  // Thinner lines would break up into dashes.
  style.edgeWidth = look.outlines
                        ? std::max(look.outlineWidth * style.edgeWidth, kThinnestEdge / size.height)
                        : 0;
  style.overlayWidth = std::max(style.overlayWidth, kThinnestOverlay / size.height);
  if (isMeasure(look.colouring)) {
    // Hardly any shade, so that colours can be read off the scale from every face.
    style.ambient = kMeasureAmbient;
    style.key.strength *= kMeasureShade;
    style.fill.strength *= kMeasureShade;
    style.occlusion *= kMeasureShade;
  }
  style.plate = plateFor(look, motif);
  return style;
}

/// What cameras must hold in sight: the motif's points and, where they cast one, their shadow.
/// Twice as many with a shadow.
std::vector<Vector3> pointsInSight(const Motif& motif, const Style& style) {
  std::vector<Vector3> points = motif.points;
  if (!style.plate || !style.plate->shadow) return points;
  for (const Vector3& point : motif.points) points.push_back(shadowOf(point, style));
  return points;
}

/// Refuses a bad size before anything is made of it.
FrameSize validated(FrameSize size) {
  requireValidSize(size);
  return size;
}

}  // namespace

/// Cameras hold the start and, where there is one, the target in sight.
Motif makeMotif(const Model& model, const BrickRule& rule, const std::optional<Ground>& ground) {
  Motif motif;
  motif.size = modelSize(model);
  motif.bricks = makeBricks(model.tiles, rule);
  motif.start = startPoses(model.tiles, motif.bricks);
  motif.pivots = makePivots(model.joints, motif.bricks);
  motif.target = model.target;
  if (ground) motif.groundHeight = ground->height;
  keepInSight(motif, motif.start);
  if (motif.target) {
    const std::vector<Brick> atTarget = makeBricks(*motif.target, rule);
    append(motif.points, brickCorners(atTarget, startPoses(*motif.target, atTarget)));
  }
  return motif;
}

void keepInSight(Motif& motif, const Poses& poses) {
  append(motif.points, shownCorners(motif, poses));
}

bool isShown(const Motif& motif, std::size_t brick, const Pose& pose) {
  const double moved = (pose.position - motif.start[brick].position).norm();
  return moved <= kFarthestShown * motif.size;
}

bool showsAllBricks(const Motif& motif, const Poses& poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!isShown(motif, i, poses[i])) return false;
  }
  return true;
}

std::vector<Vector3> shownCorners(const Motif& motif, const Poses& poses) {
  std::vector<Vector3> corners;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!isShown(motif, i, poses[i])) continue;
    for (const Vector3& point : motif.bricks[i].bottom) corners.push_back(poses[i].apply(point));
    for (const Vector3& point : motif.bricks[i].top) corners.push_back(poses[i].apply(point));
  }
  return corners;
}

Stage::Stage(const Look& look, Motif motif, FrameSize size)
    : motif_(std::move(motif)),
      style_(styleFor(look, motif_, validated(size))),
      colourist_(look, motif_),
      size_(size),
      cameras_(look.camera, pointsInSight(motif_, style_), size.aspect()),
      jointMarks_(look.jointMarks),
      targetLines_(look.targetLines) {
  if (!targetLines_ || motif_.target) return;
  throw InputError(
      "error: the model has no target to draw; leave --target-lines away or add target.txt");
}

Shot Stage::shot(const Moment& moment) const {
  Shot shot{moment.poses, colourist_.colours(moment.poses), moment.pinned, {}, {}, {}};
  if (jointMarks_) {
    for (const Pivot& pivot : motif_.pivots) {
      shot.marks.push_back(moment.poses[pivot.brickA].apply(pivot.pointA));
    }
  }
  if (targetLines_) shot.overlay = *motif_.target;
  shot.scenery = motif_.obstacles;
  return shot;
}

/// From within a brick a picture shows nothing but its inside.
Camera Stage::camera(const Moment& moment) const {
  const Camera camera = cameras_.at(moment.time, moment.turn);
  if (camera.orthographic) return camera;
  if (const auto brick = brickAround(motif_.bricks, moment.poses, camera.eye)) {
    throw InputError(
        fmt::format("error: at {:.4g} s the camera stands within brick {}; move it away with "
                    "--distance, or choose --projection parallel",
                    moment.time, *brick));
  }
  return camera;
}

Sketch Stage::sketch(const Moment& moment) const {
  Sketch sketch;
  Sketcher(motif_.bricks, style_).draw(shot(moment), camera(moment), sketch);
  return sketch;
}

std::optional<double> Stage::sharedHeight() const {
  const Camera camera = cameras_.at(0, 0);
  if (!cameras_.isStill() || !camera.orthographic) return std::nullopt;
  return camera.viewHeight;
}

/// For scale bars.
double Stage::metresPerPixel() const {
  const std::optional<double> height = sharedHeight();
  if (height) return *height / size_.height;
  throw InputError(
      "error: one scale bar cannot hold all over a picture in perspective or from a moving camera; "
      "add --projection parallel, or leave --scale-bar away");
}

Studio::Studio(FrameSize size, const Look& look, Motif motif, const StripParts& parts,
               Smoothness smoothness)
    : size_(size), parts_(parts), smoothness_(smoothness) {
  show(look, std::move(motif));
}

Studio::Studio(const Studio& other, Smoothness smoothness)
    : size_(other.size_),
      parts_(other.parts_),
      smoothness_(smoothness),
      stage_(other.stage_),
      metresPerPixel_(other.metresPerPixel_) {
  makeStrip(stage_->style(), stage_->colouring());
  makePainter();
}

/// A legend and a colour bar exclude each other: colours stand for kinds or for values.
void Studio::makeStrip(const Style& style, Colouring colouring) {
  StripParts parts = parts_;
  parts.colours = parts.colours && isMeasure(colouring);
  parts.legend = parts_.colours && !isMeasure(colouring) && colouring != Colouring::Plain;
  strip_.emplace(validated(size_), parts, style);
}

/// Keeps the graphics context where the picture's size stays.
void Studio::makePainter() {
  if (painter_ && painter_->size() == strip_->picture()) {
    painter_->show(stage_->motif().bricks, stage_->style());
  } else {
    painter_.reset();
    painter_.emplace(strip_->picture(), stage_->motif().bricks, stage_->style(), smoothness_);
  }
}

void Studio::show(const Look& look, Motif motif) {
  makeStrip(pageStyle(look), look.colouring);
  stage_ = std::make_shared<const Stage>(look, std::move(motif), strip_->picture());
  metresPerPixel_.reset();
  if (parts_.scaleBar) metresPerPixel_ = stage_->metresPerPixel();
  makePainter();
}

Frame Studio::take(const Moment& moment, const StripText& text, Frame storage) {
  const Camera camera = stage_->camera(moment);
  Frame frame = painter_->paint(stage_->shot(moment), camera, std::move(storage));
  strip_->append(frame, text, stage_->colourScale(), stage_->legend(), metresPerPixel_);
  return frame;
}

}  // namespace kirireel
