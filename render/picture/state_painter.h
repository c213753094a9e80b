/// Paints states of a run: what is asked of its pictures, their colours, the strip under them, and
/// one camera for them all.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/picture/automatic_view.h"
#include "render/picture/camera.h"
#include "render/picture/frame.h"
#include "render/picture/label.h"
#include "render/picture/painter.h"
#include "render/picture/picture_geometry.h"
#include "render/picture/style.h"
#include "sim/model/brick.h"
#include "sim/model/hinge.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// What is asked of the pictures of a run.
//
// Plain values; what each needs of a run is checked by PictureSetup.

/// Page that the pictures are meant for.
enum class Theme { Light, Dark };

/// What the colours of the bricks say.
enum class Colouring {
  Plain,         ///< nothing: one set of colours
  Shape,         ///< which tiles are congruent; by their number of corners when many shapes differ
  State,         ///< whether a brick is at its start, on its way, or at its target
  TargetError,   ///< largest distance of a vertex from its target
  Displacement,  ///< distance from the start
  Rotation,      ///< angle from the start
  JointGap,      ///< largest gap of the brick's joints
  Moment,        ///< largest moment of the springs at the brick's hinges
  Energy,        ///< half of what these springs hold
};

/// What lies under the bricks.
enum class GroundLook {
  Auto,    ///< a plate and a shadow when the scene has a ground, else nothing
  Plate,   ///< a plate and a shadow
  Shadow,  ///< a shadow on the page
  None,    ///< nothing
};

/// What the camera must hold in sight.
enum class FitScope {
  Auto,  ///< as Ends; as Run when there is no target or something would be cut off
  Run,   ///< the start, the target and everything in between
  Ends,  ///< the start and the target; what leaves them on the way is cut off
};

/// A colour for some tiles.
struct TileColour {
  std::vector<int> tiles;  ///< numbers, from 0
  Colour colour;           ///< of these tiles
  std::string name;        ///< of the group that they are, in the legend; empty: not in the legend
};

/// How opaque some tiles are.
struct TileOpacity {
  std::vector<int> tiles;  ///< numbers, from 0
  double opacity = 1;      ///< 0 (not drawn) to 1
};

/// Widths of lines on the edges of tiles in print, points of 1/72 inch.
struct OutlineWidths {
  double slits = 0.5;         ///< between tiles
  double silhouettes = 0.75;  ///< on edges with nothing beyond

  bool operator==(const OutlineWidths&) const = default;
};

/// Resolution in print of a picture where none is given: pictures are 160 mm wide.
double pixelsPerInchOf(FrameSize size);

/// The look of all pictures of a run. Defaults give the pictures that a run leaves without any
/// option.
struct Look {
  Theme theme = Theme::Light;              ///< colours of all that is not said otherwise
  bool transparent = false;                ///< no background
  Colouring colouring = Colouring::Plain;  ///< what the colours of bricks say
  ColourMap map = ColourMap::Viridis;      ///< of colours by a measure
  /// Values at the ends of the scale, in the unit of the measure; absent: 0, and the largest to be
  /// expected.
  std::optional<double> colourLeast, colourMost;
  std::optional<Colour> brickColour;  ///< of all bricks, where the colouring is plain
  std::optional<Colour> backColour;   ///< the same for the tile's own side
  /// Of single tiles, if colours show no measure; of two for one tile the later counts.
  std::vector<TileColour> tileColours;
  double opacity = 1;  ///< of all bricks, 0 (not drawn) to 1
  /// Of single tiles, with any colours; of two for one tile the later counts.
  std::vector<TileOpacity> tileOpacities;
  std::optional<Colour> outlineColour;  ///< absent: the theme's, as is the next
  std::optional<Colour> background;     ///< absent: as the theme has it
  bool outlines = true;                 ///< lines on the edges of tiles
  OutlineWidths outlineWidths;          ///< of these lines
  /// Resolution in print; absent: see pixelsPerInchOf().
  std::optional<double> pixelsPerInch;
  /// Brightness that a face loses from which other bricks keep all light away, 0 to 1; absent: the
  /// style's.
  std::optional<double> occlusion;
  bool jointMarks = false;   ///< a dot on each joint
  bool targetLines = false;  ///< the target's tiles as lines, dashed where bricks hide them
  GroundLook ground = GroundLook::Auto;  ///< how the ground is shown
  CameraChoice camera;                   ///< the place of the camera
  FitScope fit = FitScope::Auto;         ///< what the camera holds in sight
};

// ------------------------------------------------------------------------------------------------
// What a video says of its frames, on a strip under the picture. It never covers the bricks or
// their shadow.

/// What the strip of all frames of a video shows. Fixed for a whole video, since it decides the
/// height of the picture above.
struct StripParts {
  std::string longestCaption;  ///< a caption as wide as any will be; empty: there are none
  bool progressBar = false;    ///< a bar that fills from left to right
  bool scaleBar = false;       ///< a length; needs one scale all over the picture
  bool colours = false;        ///< what colours mean, if they show values
  bool legend = false;         ///< the same, if they show kinds of bricks
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

  /// Puts the strip under a picture. colours: absent if the bricks' colours show no values; legend:
  /// empty if they show no kinds; metresPerPixel: absent if no scale bar was requested. The picture
  /// has the size of picture(); it gets that of the whole frame.
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

// ------------------------------------------------------------------------------------------------
// Chooses the colours of bricks by what they are or do.

/// What pictures of a run show. Made once for all pictures of a run. Lengths in metres; a content
/// of a trajectory in another unit has all of them in that unit.
struct PictureContent {
  std::vector<model::Brick> bricks;                ///< one a tile
  Poses start;                                     ///< one a brick
  std::vector<model::Pivot> pivots;                ///< of all joints
  model::PairForces pairForces;                    ///< springs at hinges, ligaments, ...
  std::optional<std::vector<model::Tile>> target;  ///< one tile a brick, world axes
  std::optional<double> groundHeight;  ///< z of the scene's ground, if it has one, metres
  std::vector<model::Tile> obstacles;  ///< faces of what stays where it is, world axes
  /// Of the model, metres; infinity where bricks are to be shown however far they are.
  double size = std::numeric_limits<double>::infinity();
  std::vector<Vector3> points;  ///< what cameras must hold in sight, world axes
  /// Chosen for the motion, where the look leaves it to the program; absent: by the points.
  std::optional<AutomaticView> view;
  /// Of the run, one pose per brick: the range of the colours' values is that of these states.
  /// Empty before the run.
  std::vector<Poses> states;
};

/// Whether the colours show values.
bool isMeasure(Colouring colouring);

/// One colour on both faces: it means the same from both sides.
BrickColours evenShades(Colour colour);

/// The colours of bricks that have none of their own.
BrickColours plainColours(const Look& look);

/// Numbers the shapes of tiles: congruent tiles (mirror images too) have one number, from 0 in
/// order of appearance. More than seven shapes are numbered by their count of corners instead. One
/// a brick.
std::vector<int> shapeKinds(const std::vector<model::Brick>& bricks);

/// Decides the colours of all bricks in every picture of one run.
class BrickPalette {
 public:
  /// Throws InputError when the colouring needs a target or springs at hinges and there are none,
  /// when the scale's ends are in the wrong order, when tiles that are not there get a colour or an
  /// opacity, and when tiles get colours although colours show values.
  /// The content must outlive the palette.
  BrickPalette(const Look& look, const PictureContent& content);

  /// One entry per brick; empty if all bricks have the style's colours. `poses` has one pose per
  /// brick. Cheap next to painting.
  std::vector<BrickColours> colours(const Poses& poses) const;

  /// What the colours mean, when they are those of a measure. The same for the whole run.
  const std::optional<ColourScale>& scale() const { return scale_; }
  /// What they mean, when they are those of kinds of bricks: shapes, states, named groups.
  const std::vector<LegendEntry>& legend() const { return legend_; }
  /// As the look asks for.
  Colouring colouring() const { return colouring_; }

 private:
  std::vector<double> values(const Poses& poses) const;
  std::vector<BrickColours> stateColours(const Poses& poses) const;
  void colourShapes();
  void colourTiles(const Look& look);
  void findOpacities(const Look& look);
  void makeScale(const Look& look);
  double largestExpected() const;
  double largestOfRun() const;

  Colouring colouring_;
  const PictureContent& content_;
  std::vector<BrickColours> kinds_;  ///< one a brick, when coloured by shape or tile by tile
  std::vector<std::optional<BrickColours>> own_;  ///< of single tiles, one a brick; or none
  std::vector<double> opacities_;                 ///< one a brick; or none where all are opaque
  std::optional<ColourScale> scale_;
  std::vector<LegendEntry> legend_;
};

// ------------------------------------------------------------------------------------------------
// Paints states of a run: one look and one camera for all its pictures.

/// The thinnest that lines over a picture are drawn, pixels.
inline constexpr double kThinnestOverlay = 1.2;

/// A state of a run, as one picture shows it.
struct ShownState {
  double time = 0;          ///< simulated seconds
  const Poses& poses;       ///< one a brick
  std::vector<int> pinned;  ///< bricks that are held
  double turn = 0;          ///< share of the camera's orbit that is behind, 0 to 1
};

/// The content of a model whose bricks are made by the rule, on the scene's ground if it has one.
/// Cameras hold the start and the target in sight; add to its points what else they should.
/// `ground`: of the scene; absent: none.
PictureContent makeContent(const model::Model& model, const model::BrickRule& rule,
                           const std::optional<scene::Ground>& ground);

/// A brick farther from its start than this many model sizes is not held in sight: the others would
/// shrink to a dot.
inline constexpr double kFarthestShown = 20;

/// Whether a brick at a pose is near enough to be held in sight.
bool isShown(const PictureContent& content, std::size_t brick, const Pose& pose);

/// Whether all bricks are near enough to be held in sight. `poses` has one pose a brick.
bool showsAllBricks(const PictureContent& content, const Poses& poses);

/// The corners of the content's bricks at these poses, metres, but for those too far away.
std::vector<Vector3> shownCorners(const PictureContent& content, const Poses& poses);

/// Adds the same corners to what cameras must hold in sight.
void keepInSight(PictureContent& content, const Poses& poses);

/// Whether the look leaves the direction of the camera to the program.
bool needsView(const Look& look);

/// Chooses the view of a motion by some of its states, the first of which is its start.
void setView(const Look& look, std::span<const Poses> states, PictureContent& content);

/// Everything that decides a picture but the painter: items, style and cameras. Needs no graphics
/// context.
class PictureSetup {
 public:
  /// Throws InputError when the look asks for what the content lacks.
  PictureSetup(const Look& look, PictureContent content, FrameSize size);
  PictureSetup(const PictureSetup&) = delete;
  PictureSetup& operator=(const PictureSetup&) = delete;

  /// What the picture of a state shows. The poses are copied.
  PictureItems items(const ShownState& state) const;

  /// The camera of a state. Throws InputError if it is within a brick.
  Camera camera(const ShownState& state) const;

  /// The same as polygons in space, for vector graphics. Throws as camera().
  PictureGeometry geometry(const ShownState& state) const;

  /// What is shown.
  const PictureContent& content() const { return content_; }
  /// How it is shown.
  const Style& style() const { return style_; }
  /// Of each picture, without the strip under it, pixels.
  FrameSize pictureSize() const { return size_; }

  /// What the bricks' colours mean, when they are those of a measure.
  const std::optional<ColourScale>& colourScale() const { return palette_.scale(); }
  /// The same where they are those of kinds of bricks; empty where they mean nothing.
  const std::vector<LegendEntry>& legend() const { return palette_.legend(); }
  /// What the colours of bricks say.
  Colouring colouring() const { return palette_.colouring(); }

  /// Height of every picture, metres, if one scale holds for all of them: the camera does not move
  /// and projects in parallel. Absent in perspective and for cameras that move.
  std::optional<double> sharedHeight() const;

  /// The same for one pixel. Throws InputError when no one scale holds.
  double metresPerPixel() const;

 private:
  PictureContent content_;
  Style style_;
  BrickPalette palette_;
  FrameSize size_;
  CameraPath cameras_;
  bool jointMarks_;
  bool targetLines_;
};

/// A setup with a painter. Belongs to the thread that makes it.
class StatePainter {
 public:
  /// size: of the pictures, with a strip under them if it has parts. The strip explains colours
  /// only if they show a measure. Throws as PictureSetup and Painter do, and
  /// OutputError when the font is missing.
  StatePainter(FrameSize size, const Look& look, PictureContent content,
               const StripParts& parts = {}, Smoothness smoothness = Smoothness::Still);

  /// Another painter with the same setup, for the thread that makes it. A state's picture is the
  /// same from both. Throws OutputError when no graphics context can be made.
  explicit StatePainter(const StatePainter& other) : StatePainter(other, other.smoothness_) {}
  /// The same with pictures of another smoothness.
  StatePainter(const StatePainter& other, Smoothness smoothness);
  StatePainter& operator=(const StatePainter&) = delete;

  /// Paints this content from now on, in pictures of the same size; quicker than a new painter.
  /// Throws as PictureSetup does.
  void show(const Look& look, PictureContent content);

  /// The picture of a state with its strip. storage: an unused frame, whose memory the picture
  /// gets. Throws InputError if the camera is within a brick, and as Painter::paint().
  Frame paint(const ShownState& state, const StripText& text = {}, Frame storage = {});

  /// The camera and the style of its pictures.
  const PictureSetup& setup() const { return *setup_; }

 private:
  void makeStrip(const Style& style, Colouring colouring);
  void makePainter();

  FrameSize size_;
  StripParts parts_;
  Smoothness smoothness_;
  std::optional<Strip> strip_;  ///< made for each content, as is the setup; always present
  std::shared_ptr<const PictureSetup> setup_;
  std::optional<Painter> painter_;        ///< made again when the strip's height changes
  std::optional<double> metresPerPixel_;  ///< if a bar of length is drawn
};

}  // namespace kirireel::picture
