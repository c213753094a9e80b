/// Photographs a run: one look and one camera for all its pictures.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/grid/scale.h"
#include "render/picture/camera_path.h"
#include "render/picture/painter.h"
#include "render/picture/sketch.h"
#include "render/studio/colourist.h"
#include "render/studio/look.h"
#include "render/studio/strip.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Widths of lines in small pictures, pixels: between two flush tiles, and of lines laid over.
inline constexpr double kThinnestEdge = 2;
inline constexpr double kThinnestOverlay = 1.2;

/// One moment of a run.
struct Moment {
  double time = 0;          ///< simulated seconds
  const Poses& poses;       ///< one a brick
  std::vector<int> pinned;  ///< bricks that are held
  double turn = 0;          ///< share of the camera's orbit that is behind, 0 to 1
};

/// The motif of a model whose bricks are made by the rule, on the scene's ground if it has one.
/// Cameras hold the start and the target in sight; add to its points what else they should.
/// `ground`: of the scene; absent: none.
Motif makeMotif(const Model& model, const BrickRule& rule, const std::optional<Ground>& ground);

/// A brick farther from its start than this many model sizes is not held in sight: the others would
/// shrink to a dot.
inline constexpr double kFarthestShown = 20;

/// Whether a brick at a pose is near enough to be held in sight.
bool isShown(const Motif& motif, std::size_t brick, const Pose& pose);

/// Whether all bricks are near enough to be held in sight. `poses` has one pose a brick.
bool showsAllBricks(const Motif& motif, const Poses& poses);

/// The corners of the motif's bricks at these poses, metres, but for those too far away.
std::vector<Vector3> shownCorners(const Motif& motif, const Poses& poses);

/// Adds the same corners to what cameras must hold in sight.
void keepInSight(Motif& motif, const Poses& poses);

/// Everything that decides a picture but the painter: shots, style and cameras. Needs no graphics
/// context.
class Stage {
 public:
  /// Throws InputError when the look asks for what the motif lacks.
  Stage(const Look& look, Motif motif, FrameSize size);
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// What the picture of a moment shows. The poses are copied.
  Shot shot(const Moment& moment) const;

  /// The camera of a moment. Throws InputError when it stands within a brick.
  Camera camera(const Moment& moment) const;

  /// The same as polygons in space, for vector graphics. Throws as camera().
  Sketch sketch(const Moment& moment) const;

  const Motif& motif() const { return motif_; }
  const Style& style() const { return style_; }
  FrameSize pictureSize() const { return size_; }

  /// What the bricks' colours mean, when they are those of a measure.
  const std::optional<ColourScale>& colourScale() const { return colourist_.scale(); }
  /// The same where they are those of kinds of bricks; empty where they mean nothing.
  const std::vector<LegendEntry>& legend() const { return colourist_.legend(); }
  Colouring colouring() const { return colourist_.colouring(); }

  /// Height of every picture, metres, when one scale holds all over all of them: the camera stands
  /// still and projects in parallel. Absent in perspective and for cameras that move.
  std::optional<double> sharedHeight() const;

  /// The same for one pixel. Throws InputError when no one scale holds.
  double metresPerPixel() const;

 private:
  Motif motif_;
  Style style_;
  Colourist colourist_;
  FrameSize size_;
  CameraPath cameras_;
  bool jointMarks_;
  bool targetLines_;
};

/// A stage with a painter. Belongs to the thread that makes it.
class Studio {
 public:
  /// size: of the pictures, with a strip under them where there are parts of one; colours stand on
  /// it only where they are those of a measure. Throws as Stage and Painter do, and OutputError
  /// when the font is missing.
  Studio(FrameSize size, const Look& look, Motif motif, const StripParts& parts = {},
         Smoothness smoothness = Smoothness::Still);

  /// Another studio with the same stage, for the thread that makes it. A moment's picture is the
  /// same from both. Throws OutputError when no graphics context can be made.
  explicit Studio(const Studio& other) : Studio(other, other.smoothness_) {}
  /// The same with pictures of another smoothness.
  Studio(const Studio& other, Smoothness smoothness);
  Studio& operator=(const Studio&) = delete;

  /// Photographs this motif from now on, in pictures of the same size; quicker than a new studio.
  /// Throws as Stage does.
  void show(const Look& look, Motif motif);

  /// The picture of a moment with its strip. storage: a frame that is needed no more, whose memory
  /// the picture gets. Throws InputError when the camera stands within a brick. Throws as
  /// Painter::paint(), too.
  Frame take(const Moment& moment, const StripText& text = {}, Frame storage = {});

  const Stage& stage() const { return *stage_; }

 private:
  void makeStrip(const Style& style, Colouring colouring);
  void makePainter();

  FrameSize size_;
  StripParts parts_;
  Smoothness smoothness_;
  std::optional<Strip> strip_;  ///< made anew for each motif, as is the stage; always there
  std::shared_ptr<const Stage> stage_;
  std::optional<Painter> painter_;        ///< made anew when the strip's height changes
  std::optional<double> metresPerPixel_;  ///< where a bar of length is drawn
};

}  // namespace kirireel
