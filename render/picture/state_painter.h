/// Paints states of a run: options of its pictures, their colours, the strip below them, and one
/// common camera.
#pragma once

#include <array>
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
#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/panels.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// Options of the pictures of a run.
//
// Plain values. PictureSetup checks them against a run.

/// Page for the pictures.
enum class Theme { Light, Dark };

/// Meaning of the bricks' colours.
enum class Colouring {
  Plain,         ///< none: one set of colours
  Shape,         ///< congruence of tiles; their number of corners if there are many shapes
  State,         ///< whether a brick is at its start, in motion, or at its target
  TargetError,   ///< largest distance of a vertex from its target
  Displacement,  ///< distance from the start
  Rotation,      ///< angle from the start
  JointGap,      ///< largest gap of the brick's joints
  Moment,        ///< largest moment of the springs at the brick's hinges and folds
  Energy,        ///< its part of the energy of these springs and of its bars
};

/// How options and summaries spell them. Measures of single bricks need a scale, "plain" and
/// "shape" do not.
inline constexpr std::array<std::pair<const char*, Colouring>, 9> kColourings{
    {{"plain", Colouring::Plain},
     {"shape", Colouring::Shape},
     {"state", Colouring::State},
     {"error", Colouring::TargetError},
     {"displacement", Colouring::Displacement},
     {"rotation", Colouring::Rotation},
     {"gap", Colouring::JointGap},
     {"moment", Colouring::Moment},
     {"energy", Colouring::Energy}}};

/// Ground under the bricks.
enum class GroundLook {
  Auto,    ///< a plate and a shadow if the scene has a ground, else nothing
  Plate,   ///< a plate and a shadow
  Shadow,  ///< a shadow on the page
  None,    ///< nothing
};

/// How options and summaries spell them.
inline constexpr std::array<std::pair<const char*, GroundLook>, 4> kGroundLooks{
    {{"auto", GroundLook::Auto},
     {"plate", GroundLook::Plate},
     {"shadow", GroundLook::Shadow},
     {"none", GroundLook::None}}};

/// The states that the camera keeps in view.
enum class FitScope {
  Auto,  ///< Ends, or Run if there is no target or Ends would cut something off
  Run,   ///< the start, the target and all states between them
  Ends,  ///< the start and the target; states outside them are cut off
};

/// A state that is drawn with every other one, as pale transparent bricks.
enum class Ghost { None, Target, Start };

/// How options and summaries spell them.
inline constexpr std::array<std::pair<const char*, Ghost>, 3> kGhosts{
    {{"none", Ghost::None}, {"target", Ghost::Target}, {"start", Ghost::Start}}};

/// A colour for some tiles.
struct TileColour {
  std::vector<int> tiles;  ///< zero-based numbers
  Colour colour;           ///< of these tiles
  std::string name;        ///< name of the group in the legend; empty: not in the legend
};

/// How opaque some tiles are.
struct TileOpacity {
  std::vector<int> tiles;  ///< zero-based numbers
  double opacity = 1;      ///< 0 (not drawn) to 1
};

/// A vertex of a tile, whose path during the run is drawn.
struct TracedVertex {
  int tile = 0;    ///< zero-based
  int vertex = 0;  ///< zero-based
};

/// Widths of lines on the edges of tiles in print, points (1/72 inch).
struct OutlineWidths {
  double slits = 0.5;         ///< between tiles
  double silhouettes = 0.75;  ///< on edges without a neighbour

  bool operator==(const OutlineWidths&) const = default;
};

/// Default print resolution of a picture: pictures are 160 mm wide.
double pixelsPerInchOf(FrameSize size);

/// The appearance of all pictures of a run. Defaults are those of a run without any picture
/// options.
struct Appearance {
  Theme theme = Theme::Light;              ///< colours without another setting
  bool transparent = false;                ///< no background
  Colouring colouring = Colouring::Plain;  ///< meaning of the bricks' colours
  ColourMap map = ColourMap::Viridis;      ///< for colours by a measure
  /// Values at the ends of the scale, in the unit of the measure; absent: 0, and the expected
  /// maximum.
  std::optional<double> colourLeast, colourMost;
  std::optional<Colour> brickColour;  ///< of all bricks, for Colouring::Plain
  std::optional<Colour> backColour;   ///< the same for the tile's face
  /// Colours of single tiles, if colours show no measure. The last entry of a tile counts.
  std::vector<TileColour> tileColours;
  double opacity = 1;  ///< of all bricks, 0 (not drawn) to 1
  /// Opacities of single tiles, with any colouring. The last entry of a tile counts.
  std::vector<TileOpacity> tileOpacities;
  std::optional<Colour> outlineColour;  ///< absent: the theme's
  std::optional<Colour> background;     ///< absent: the theme's
  bool outlines = true;                 ///< lines on the edges of tiles
  OutlineWidths outlineWidths;          ///< of these lines
  /// Print resolution; absent: see pixelsPerInchOf().
  std::optional<double> pixelsPerInch;
  /// Brightness loss of a face that other bricks fully occlude, [0, 1]; absent: the style's.
  std::optional<double> occlusion;
  bool jointMarks = false;           ///< a dot on each joint
  bool targetLines = false;          ///< the target's tiles as lines, dashed where bricks hide them
  std::vector<TracedVertex> trails;  ///< their paths until each picture, as lines
  Ghost ghost = Ghost::None;         ///< state drawn as pale transparent bricks
  /// Share of the background's colour in the farthest faces of the run, [0, 1]; see DepthCue.
  double depthCue = 0;
  GroundLook ground = GroundLook::Auto;  ///< display of the ground
  CameraChoice camera;                   ///< position of the camera
  FitScope fit = FitScope::Auto;         ///< part of the motion that stays in view
};

// ------------------------------------------------------------------------------------------------
// The strip under the picture of a video, with information about its frames. It never covers the
// bricks or their shadow.

/// Parts of the strip of all frames of a video. Constant for a video, since they determine the
/// height of the picture above.
struct StripParts {
  std::string name;            ///< above everything else, UTF-8; empty: none
  std::string longestName;     ///< the widest one of pictures side by side; `name` by default
  std::string longestCaption;  ///< a caption with the maximum width; empty: no captions
  bool progressBar = false;    ///< a bar that fills from left to right
  bool scaleBar = false;       ///< a length; requires the same scale in the whole picture
  bool colours = false;        ///< scale of the colours, if they show values
  bool legend = false;         ///< legend of the colours, if they show kinds of bricks
};

/// Text of the strip under one frame.
struct StripText {
  std::string caption;  ///< one line, UTF-8
  double progress = 0;  ///< 0 to 1
};

/// A strip under pictures of one size. Its parts determine its height. The widest caption
/// determines the size of its text.
class Strip {
 public:
  /// whole: the frame with its strip. Throws OutputError if the font is missing.
  Strip(FrameSize whole, const StripParts& parts, const Style& style);

  /// The frame without its strip.
  FrameSize picture() const { return {whole_.width, whole_.height - height_}; }

  /// Appends the strip to a picture, which has the size of picture() and gets that of the whole
  /// frame. colours: absent if the bricks' colours show no values; legend: empty if they show no
  /// kinds; scale: absent if no scale bar was requested.
  void append(Frame& picture, const StripText& text, const std::optional<ColourScale>& colours,
              const std::vector<LegendEntry>& legend,
              const std::optional<PictureScale>& scale) const;

 private:
  double scalesEms() const;
  void drawScales(Frame& frame, int upper, const std::optional<ColourScale>& colours,
                  const std::vector<LegendEntry>& legend,
                  const std::optional<PictureScale>& scale) const;
  void drawProgress(Frame& frame, int upper, double progress) const;

  FrameSize whole_;
  StripParts parts_;
  Colour background_;
  Colour text_;
  int em_ = 0;      ///< of all text, pixels
  int height_ = 0;  ///< pixels
  int nameLeft_ = 0;
  int captionLeft_ = 0;
  std::optional<LabelWriter> writer_;  ///< absent if there is no text
  std::optional<ScaleDrawer> scales_;
};

// ------------------------------------------------------------------------------------------------
// Selects the colours of bricks.

/// A path in time.
struct TimedPath {
  std::vector<double> times;    ///< simulated seconds, increasing
  std::vector<Vector3> points;  ///< one per time, world axes, metres
};

/// Contents of the pictures of a run, made once for all pictures. Lengths are in metres.
struct PictureContent {
  std::vector<brick::Brick> bricks;  ///< one per tile
  LengthUnit unit;                   ///< of the model, for texts
  Poses start;                       ///< one per brick
  std::vector<brick::Pivot> pivots;  ///< of all joints
  brick::PairForces pairForces;      ///< springs at hinges, ligaments, ...
  /// Tiles that stretch and bend, with their states; null without them and before the run.
  std::shared_ptr<const trajectory::LoadedPanels> panels;
  std::optional<std::vector<model::Tile>> target;  ///< one tile per brick, world axes
  std::optional<double> groundHeight;  ///< z of the scene's ground, if it has one, metres
  std::vector<model::Tile> obstacles;  ///< faces of fixed obstacles, world axes
  /// Size of the model, metres; infinity if bricks are shown at any distance.
  double size = std::numeric_limits<double>::infinity();
  std::vector<Vector3> points;  ///< points that cameras keep in view, world axes
  /// Selected for the motion if the appearance has an automatic view; absent: by the points.
  std::optional<AutomaticView> view;
  /// The paths of the appearance's trails, in their order; empty before the run.
  std::vector<TimedPath> paths;
  /// Of the run, one pose per brick. They determine the ranges of the colours' values and of the
  /// depth cue. Empty before the run.
  std::vector<Poses> states;
};

/// Whether the colours show values.
bool isMeasure(Colouring colouring);

/// One colour on both faces, with the same meaning from both sides.
BrickColours evenShades(Colour colour);

/// The colours of bricks without their own colours.
BrickColours plainColours(const Appearance& appearance);

/// Zero-based numbers of the shapes of tiles, one per brick, in order of appearance. Congruent
/// tiles and mirror images have the same number. With more than seven shapes, the numbers depend
/// only on the count of corners.
std::vector<int> shapeKinds(const std::vector<brick::Brick>& bricks);

/// Selects the colours of all bricks in every picture of one run.
class BrickPalette {
 public:
  /// Throws InputError if the colouring needs a missing target or springs at hinges, if the ends of
  /// the scale are in the wrong order, if tiles with a colour or an opacity do not exist, and if
  /// tiles have colours although colours show values. The content must outlive the palette.
  BrickPalette(const Appearance& appearance, const PictureContent& content);

  /// One entry per brick; empty if all bricks have the style's colours. `poses` has one pose per
  /// brick. `time` of the poses in simulated seconds: poses of panels show neither energy nor
  /// moments. Fast relative to painting.
  std::vector<BrickColours> colours(const Poses& poses, double time = 0) const;

  /// All colours that the tops of bricks can have during the run, unlit. At least one.
  std::vector<Colour> hues() const;

  /// The scale of the colours of a measure. The same for the whole run.
  const std::optional<ColourScale>& scale() const { return scale_; }
  /// The legend of colours of kinds of bricks: shapes, states, named groups. Unlit, with the
  /// opacity of the kind's first brick.
  const std::vector<LegendEntry>& legend() const { return legend_; }
  /// The appearance's colouring.
  Colouring colouring() const { return colouring_; }

 private:
  std::vector<double> values(const Poses& poses, double time) const;
  std::vector<BrickColours> stateColours(const Poses& poses) const;
  void colourShapes();
  void colourTiles(const Appearance& appearance);
  void findOpacities(const Appearance& appearance);
  void addToLegend(Colour colour, double opacity, std::string text);
  double opacityOf(std::size_t brick) const;
  void makeScale(const Appearance& appearance);
  double largestExpected() const;
  double largestOfRun() const;

  Colouring colouring_;
  const PictureContent& content_;
  BrickColours plain_;               ///< of bricks without their own colours
  std::vector<BrickColours> kinds_;  ///< one per brick, for colours by shape or tile by tile
  std::vector<std::optional<BrickColours>> own_;  ///< of single tiles, one per brick; or empty
  std::vector<double> opacities_;                 ///< one per brick; empty if all are opaque
  std::optional<ColourScale> scale_;
  std::vector<LegendEntry> legend_;
};

// ------------------------------------------------------------------------------------------------
// Paints states of a run with one appearance and one camera for all its pictures.

/// Minimum width of lines over a picture, pixels.
inline constexpr double kThinnestOverlay = 1.2;

/// A state of a run in one picture.
struct ShownState {
  double time = 0;          ///< simulated seconds
  const Poses& poses;       ///< one per brick
  std::vector<int> pinned;  ///< pinned bricks
  double turn = 0;          ///< completed fraction of the camera's orbit, [0, 1]
};

/// The content of a model whose bricks are made by the rule, on the scene's ground if it has one.
/// Cameras keep the start and the target in view; the caller can add more points. `ground`: of the
/// scene; absent: none.
PictureContent makeContent(const model::Model& model, const brick::BrickRule& rule,
                           const std::optional<scene::Ground>& ground);

/// A brick farther from its start than this many model sizes is not kept in view. Otherwise the
/// others would shrink to a dot.
inline constexpr double kFarthestShown = 20;

/// Whether a brick at this pose is near enough to be kept in view.
bool isShown(const PictureContent& content, std::size_t brick, const Pose& pose);

/// Whether all bricks are near enough to be kept in view. `poses` has one pose per brick.
bool showsAllBricks(const PictureContent& content, const Poses& poses);

/// The corners of the content's bricks at these poses, metres, without bricks too far away.
std::vector<Vector3> shownCorners(const PictureContent& content, const Poses& poses);

/// Adds the same corners to the points that cameras keep in view.
void keepInView(PictureContent& content, const Poses& poses);

/// Whether the appearance requests an automatic camera direction.
bool needsView(const Appearance& appearance);

/// Throws InputError for a vertex that no brick has.
void requireVertices(const std::vector<TracedVertex>& trails,
                     const std::vector<brick::Brick>& bricks);

/// The position of a vertex of a brick: the middle between its bottom and its top.
Vector3 vertexPosition(const PictureContent& content, const Poses& poses,
                       const TracedVertex& vertex);

/// Selects the view of a motion from some of its states. The first state is its start.
void setView(const Appearance& appearance, std::span<const Poses> states, PictureContent& content);

/// All inputs of a picture except the painter: items, style and cameras. Needs no graphics context.
class PictureSetup {
 public:
  /// Throws InputError if the appearance requires something that the content lacks.
  PictureSetup(const Appearance& appearance, PictureContent content, FrameSize size);
  PictureSetup(const PictureSetup&) = delete;
  PictureSetup& operator=(const PictureSetup&) = delete;

  /// The items in the picture of a state. Copies the poses.
  PictureItems items(const ShownState& state) const;

  /// The camera of a state. Throws InputError if it is inside a brick.
  Camera camera(const ShownState& state) const;

  /// The items as polygons in space, for vector graphics. Throws like camera().
  PictureGeometry geometry(const ShownState& state) const;

  /// The content of the pictures.
  const PictureContent& content() const { return content_; }
  /// The style of the pictures.
  const Style& style() const { return style_; }
  /// Size of each picture without the strip below it, pixels.
  FrameSize pictureSize() const { return size_; }

  /// The scale of the bricks' colours if they show a measure.
  const std::optional<ColourScale>& colourScale() const { return palette_.scale(); }
  /// The legend if they show kinds of bricks; otherwise empty. With the colours of bricks that are
  /// seen face on.
  const std::vector<LegendEntry>& legend() const { return legend_; }
  /// Meaning of the bricks' colours.
  Colouring colouring() const { return palette_.colouring(); }

  /// Height of every picture, metres, if all have the same scale: a fixed camera with parallel
  /// projection. Absent for perspective and moving cameras.
  std::optional<double> sharedHeight() const;

  /// The size of one pixel, metres. Throws InputError if pictures have no common scale.
  double metresPerPixel() const;

  /// The same with the unit of the model. Throws like metresPerPixel().
  PictureScale scale() const { return {metresPerPixel(), content_.unit}; }

 private:
  DepthCue depthCueFrom(const Camera& camera) const;

  PictureContent content_;
  Style style_;
  BrickPalette palette_;
  FrameSize size_;
  CameraPath cameras_;
  bool jointMarks_;
  bool targetLines_;
  std::vector<TracedVertex> trails_;
  std::vector<std::vector<std::vector<Vector3>>> ghosts_;  ///< see PictureItems
  double cueShare_;                                        ///< of a depth cue
  std::optional<DepthCue> stillCue_;                       ///< of a fixed camera
  std::vector<LegendEntry> legend_;
};

/// A setup with a painter. Use it only in the thread that makes it.
class StatePainter {
 public:
  /// size: of the pictures, with the strip below them if it has parts. The strip explains colours
  /// only if they show a measure. Throws like PictureSetup and Painter, and OutputError if the font
  /// is missing.
  StatePainter(FrameSize size, const Appearance& appearance, PictureContent content,
               const StripParts& parts = {}, Smoothness smoothness = Smoothness::Still);

  /// Pictures of this setup without a strip. Throws OutputError if there is no graphics context.
  explicit StatePainter(std::shared_ptr<const PictureSetup> setup);

  /// Another painter with the same setup, for the thread that makes it. Both give equal pictures of
  /// a state. Throws OutputError if there is no graphics context.
  explicit StatePainter(const StatePainter& other) : StatePainter(other, other.smoothness_) {}
  /// The same with another smoothness.
  StatePainter(const StatePainter& other, Smoothness smoothness);
  StatePainter& operator=(const StatePainter&) = delete;

  /// Sets new content for pictures of the same size; faster than a new painter. Throws like
  /// PictureSetup.
  void show(const Appearance& appearance, PictureContent content);

  /// The picture of a state with its strip. storage: an unused frame, whose memory the picture
  /// reuses. Throws InputError if the camera is inside a brick, and like Painter::paint().
  Frame paint(const ShownState& state, const StripText& text = {}, Frame storage = {});

  /// The camera and the style of its pictures.
  const PictureSetup& setup() const { return *setup_; }

 private:
  void makeStrip(const Style& style, Colouring colouring);
  void makePainter();

  FrameSize size_;
  StripParts parts_;
  Smoothness smoothness_;
  std::optional<Strip> strip_;  ///< made for each content, like the setup; always present
  std::shared_ptr<const PictureSetup> setup_;
  std::optional<Painter> painter_;     ///< made again when the strip's height changes
  std::optional<PictureScale> scale_;  ///< present if there is a scale bar
};

}  // namespace kirireel::picture
