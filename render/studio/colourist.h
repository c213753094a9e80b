/// Chooses the colours of bricks by what they are or do.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "render/grid/scale.h"
#include "render/picture/sketch.h"
#include "render/studio/look.h"
#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/model/model.h"

namespace kirireel {

/// A run as a studio sees it. Made once for all pictures of a run. Lengths in metres; a motif of a
/// trajectory in another unit has all of them in that unit.
struct Motif {
  std::vector<Brick> bricks;
  Poses start;                              ///< one a brick
  std::vector<Pivot> pivots;                ///< of all joints
  std::vector<HingeSpring> hingeSprings;    ///< of the bricks' hinges
  std::optional<std::vector<Tile>> target;  ///< one tile a brick, world axes
  std::optional<double> groundHeight;       ///< z of the scene's ground, if it has one, metres
  std::vector<Tile> obstacles;              ///< faces of what stays where it is, world axes
  /// Of the model, metres; infinity where bricks are to be shown however far they are.
  double size = std::numeric_limits<double>::infinity();
  std::vector<Vector3> points;  ///< what cameras must hold in sight, world axes
  /// Of the run, one pose a brick: what colours stand for ranges over them; none before the run.
  std::vector<Poses> states;
};

/// Whether the colours stand for values.
bool isMeasure(Colouring colouring);

/// One colour on both faces, so that it means the same from both sides.
BrickColours evenShades(Colour colour);

/// The colours of bricks that have none of their own.
BrickColours plainColours(const Look& look);

/// Numbers the shapes of tiles: congruent tiles (mirror images too) have one number, from 0 in
/// order of appearance. More than seven shapes are numbered by their count of corners instead. One
/// a brick.
std::vector<int> shapeKinds(const std::vector<Brick>& bricks);

/// Decides the colours of all bricks in every picture of one run.
class Colourist {
 public:
  /// Throws InputError when the colouring needs a target or springs at hinges and there are none,
  /// when the scale's ends are in the wrong order, and when tiles get colours that are not there or
  /// whose colours stand for values.
  /// The motif must outlive the colourist.
  Colourist(const Look& look, const Motif& motif);

  /// One entry a brick; none when all bricks have the style's colours. `poses` has one pose a
  /// brick. Cheap beside painting.
  std::vector<BrickColours> colours(const Poses& poses) const;

  /// What the colours mean, when they are those of a measure. The same for the whole run.
  const std::optional<ColourScale>& scale() const { return scale_; }
  /// What they mean, when they are those of kinds of bricks: shapes or states.
  const std::vector<LegendEntry>& legend() const { return legend_; }
  /// As the look asks for.
  Colouring colouring() const { return colouring_; }

 private:
  std::vector<double> values(const Poses& poses) const;
  std::vector<BrickColours> stateColours(const Poses& poses) const;
  void colourShapes();
  void colourTiles(const Look& look);
  void makeScale(const Look& look);
  double largestExpected() const;
  double largestOfRun() const;

  Colouring colouring_;
  const Motif& motif_;
  std::vector<BrickColours> kinds_;  ///< one a brick, when coloured by shape or tile by tile
  std::vector<std::optional<BrickColours>> own_;  ///< of single tiles, one a brick; or none
  std::optional<ColourScale> scale_;
  std::vector<LegendEntry> legend_;
};

}  // namespace kirireel
