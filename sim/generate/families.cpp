// The list of families. Each has a name, parameters with ranges, and a function from values to a
// model. A generated model must pass stricter checks than a file. They reject designs that did not
// converge.
//
// Ranges cover the tested values with a reasonable computing time. Some combinations of values have
// no sheet. The check reports them.
#include "sim/generate/families.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/formats/joint_faces.h"
#include "sim/formats/tile_checks.h"
#include "sim/generate/lattice.h"
#include "sim/generate/lattice_designs.h"
#include "sim/generate/shells.h"
#include "sim/generate/tiling.h"
#include "sim/model/isometry.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::generate {
namespace {

// Allowed error of a generated model, as a fraction of a tile. Largest seen: 7e-15.
constexpr double kExactModel = 1e-9;
// Allowed overlap, as a fraction of a tile. Neighbours in a closed sheet touch up to rounding.
constexpr double kTouchingTiles = 1e-7;
// The smallest sine of a corner of a generated tile.
constexpr double kConvex = 1e-3;

using Parameters = std::vector<FamilyParameter>;

FamilyParameter count(const std::string& name, const std::string& help, double defaultValue,
                      double least, double most) {
  return {name, "COUNT", help, defaultValue, least, most, true};
}

// The range of coordinates in files: [1e-6, 1e6] m.
FamilyParameter length(const std::string& name, const std::string& help, double defaultValue) {
  return {name, "METRES", help, defaultValue, 1e-6, 1e6, false};
}

FamilyParameter angle(const std::string& name, const std::string& help, double defaultValue,
                      double least, double most) {
  return {name, "DEGREES", help, defaultValue, least, most, false};
}

FamilyParameter startAngle(double most = 180) {
  return angle("start-angle", "between neighbours at the start, 0 is closed", 0, 0, most);
}

FamilyParameter targetAngle(double defaultValue, double most = 180) {
  return angle("target-angle", "between neighbours at the target", defaultValue, 0, most);
}

Lattice latticeOf(const FamilyValues& values) {
  return {values.whole("columns"), values.whole("rows")};
}

// A sheet of quads in two states of its field.
model::Model fieldModel(const TurningField& field, const FamilyValues& values) {
  model::Model model;
  // Both states come from the same constants, so they are congruent up to rounding.
  model.tiles = field.tiles(values.angle("start-angle"));
  model.target = field.tiles(values.angle("target-angle"));
  model.joints = latticeJoints(field.lattice(), model::JointFace::Both);
  return model;
}

/// Squares.
TessellationShape squareShape(const FamilyValues& values) {
  TessellationShape shape;
  shape.columns = values.whole("columns");
  shape.rows = values.whole("rows");
  shape.length = shape.width = values.number("length");
  shape.startAngle = values.angle("start-angle");
  shape.targetAngle = values.angle("target-angle");
  return shape;
}

model::Model tessellationModel(const FamilyValues& values) {
  TessellationShape shape = squareShape(values);
  shape.width = values.number("width");
  shape.skew = values.angle("skew");
  return makeTessellation(shape);
}

model::Model fanModel(const FamilyValues& values) {
  FanShape shape;
  shape.lattice = latticeOf(values);
  shape.outerRadius = values.number("outer-radius");
  shape.innerRadius = values.number("inner-radius");
  shape.halfAngle = 0.5 * values.angle("angle");
  return fieldModel(fanField(shape), values);
}

RotorShape rotorShape(const FamilyValues& values) {
  return {values.whole("columns"), values.whole("rows"), values.angle("start-angle"),
          values.angle("target-angle")};
}

CapShape capShape(const FamilyValues& values) {
  CapShape shape;
  shape.size = 2 * values.whole("half-size");
  shape.radius = values.number("radius");
  return shape;
}

/// The tile rotated about the vertical axis through a point.
model::Tile turned(model::Tile tile, const Vector3& centre, double turn) {
  const Matrix3 rotation = Eigen::AngleAxisd(turn, Vector3::UnitZ()).toRotationMatrix();
  for (Vector3& vertex : tile.vertices) vertex = centre + rotation * (vertex - centre);
  return tile;
}

/// Four quads around a slit that is bent in the middle. In the plane the slit opens to a kite: its
/// upper side becomes the mirror image of its lower side.
model::Model nonrigidModel(const FamilyValues& values) {
  const double left = values.number("left"), right = values.number("right");
  const double depth = values.number("depth");
  // The quads reach beyond the slit on all sides.
  const double side = 1.5 * std::max({left, right, depth});
  const Vector3 leftTip(-left, 0, 0), rightTip(right, 0, 0), middle(0, -depth, 0);
  model::Model model;
  model.tiles = {{{{-side, -side, 0}, {0, -side, 0}, middle, leftTip}},
                 {{leftTip, middle, {0, side, 0}, {-side, side, 0}}},
                 {{{0, -side, 0}, {side, -side, 0}, rightTip, middle}},
                 {{middle, rightTip, {side, side, 0}, {0, side, 0}}}};
  model.target = model.tiles;
  // The slit's lower side falls from the left tip at the angle atan2(depth, left) and rises to the
  // right tip. The upper side opens to its mirror image when each upper quad turns by twice its
  // angle.
  (*model.target)[1] = turned(model.tiles[1], leftTip, 2 * std::atan2(depth, left));
  (*model.target)[3] = turned(model.tiles[3], rightTip, -2 * std::atan2(depth, right));
  model.joints = latticeJoints({2, 2}, model::JointFace::Both);
  return model;
}

/// A family that makes sheets from a tiling by one of the constructions.
Family tilingFamily(const std::string& name, const std::string& help, Tiling (*tiling)(int),
                    const std::string& construction, double defaultValue) {
  Family family;
  family.name = name + "-" + construction;
  family.help = help;
  family.parameters = {
      count("tiles", "of the tiling, at least; whole rings are used", defaultValue, 10, 5000)};
  if (construction == "chain") {
    family.make = [tiling](const FamilyValues& values) {
      return makeChain(tiling(values.whole("tiles")));
    };
  } else if (construction == "removal") {
    family.make = [tiling](const FamilyValues& values) {
      return makeThinned(tiling(values.whole("tiles")));
    };
  } else {
    family.parameters.push_back(startAngle());
    family.parameters.push_back(targetAngle(90));
    family.make = [tiling](const FamilyValues& values) {
      return makeExpanded(tiling(values.whole("tiles")), values.angle("start-angle"),
                          values.angle("target-angle"));
    };
  }
  return family;
}

// Three constructions of each tiling.
void appendTilings(std::vector<Family>& all) {
  const struct {
    std::string name;
    std::string what;
    Tiling (*tiling)(int);
    double chainTiles;
    double removalTiles;
  } tilings[] = {
      {"stampfli", "the twelvefold Stampfli tiling", stampfliTiling, 24, 132},
      {"penrose", "the fivefold Penrose tiling", penroseTiling, 30, 100},
      {"ammann-beenker", "the eightfold Ammann-Beenker tiling", ammannBeenkerTiling, 48, 100}};
  for (const auto& [name, what, tiling, chainTiles, removalTiles] : tilings) {
    all.push_back(tilingFamily(name, what + " as one closed chain (a Hamiltonian cycle)", tiling,
                               "chain", chainTiles));
    all.push_back(
        tilingFamily(name, what + " without its narrow rhombi", tiling, "removal", removalTiles));
    all.push_back(tilingFamily(name, what + " with the cells of its grids between its tiles",
                               tiling, "expansion", chainTiles));
  }
}

void appendLattices(std::vector<Family>& all) {
  const auto columns = [](double defaultValue, double least, double most) {
    return count("columns", "tiles along x", defaultValue, least, most);
  };
  const auto rows = [](double defaultValue, double least, double most) {
    return count("rows", "tiles along y", defaultValue, least, most);
  };
  all.push_back(
      {"tessellation",
       "rotating rectangles or parallelograms",
       {columns(4, 1, 1000), rows(4, 1, 1000), length("length", "of a tile along x when closed", 1),
        length("width", "of a tile's other side", 1),
        angle("skew", "of that side from the vertical, clockwise", 0, -80, 80), startAngle(),
        targetAngle(90)},
       tessellationModel});
  all.push_back({"quads",
                 "irregular quads, closed at 0 and at 180 degrees",
                 {columns(6, 2, 60),
                  rows(6, 2, 60),
                  {"irregularity", "SHARE", "of a tile, by which the sides move", 0.2, 0, 0.4},
                  count("seed", "of the random numbers", 1, 0, 1e9),
                  startAngle(),
                  targetAngle(180)},
                 [](const FamilyValues& values) {
                   const unsigned seed = static_cast<unsigned>(values.whole("seed"));
                   return fieldModel(
                       irregularField(latticeOf(values), values.number("irregularity"), seed),
                       values);
                 }});
  all.push_back({"fan",
                 "a rectangle that becomes a sector of a ring",
                 {columns(6, 2, 60), rows(6, 2, 60), length("outer-radius", "of the ring", 10),
                  length("inner-radius", "of the ring", 1),
                  angle("angle", "of the sector", 60, 5, 180), startAngle(), targetAngle(180)},
                 fanModel,
                 false,
                 "outer-radius"});
  all.push_back({"heart",
                 "a heart that becomes another shape",
                 {columns(4, 4, 60), rows(4, 4, 60), startAngle(), targetAngle(180)},
                 [](const FamilyValues& values) {
                   return fieldModel(heartField(latticeOf(values)), values);
                 }});
  all.push_back({"square-to-disk",
                 "a square that becomes a polygon inscribed in a circle",
                 {count("half-size", "tiles along a side are twice this and one more", 2, 1, 10),
                  startAngle(), targetAngle(180)},
                 [](const FamilyValues& values) {
                   return fieldModel(squareToDiskField(2 * values.whole("half-size") + 1), values);
                 }});
  all.push_back({"square-to-circle",
                 "a square whose tips form a circle",
                 {count("half-size", "tiles along a side are twice this", 3, 2, 20), startAngle(),
                  targetAngle(90)},
                 [](const FamilyValues& values) {
                   return fieldModel(squareToCircleField(2 * values.whole("half-size")), values);
                 }});
}

void appendRegular(std::vector<Family>& all) {
  const auto cells = [](const std::string& name, double least) {
    return count(name, "cells", 4, least, 300);
  };
  all.push_back(
      {"triangles",
       "rotating triangles (kagome), two per cell",
       {cells("columns", 1), cells("rows", 1), startAngle(240), targetAngle(60, 240)},
       [](const FamilyValues& values) { return makeRotatingTriangles(rotorShape(values)); }});
  all.push_back(
      {"hexagons",
       "hexagons and triangles that turn against each other",
       {cells("columns", 2), cells("rows", 2), startAngle(), targetAngle(60)},
       [](const FamilyValues& values) { return makeHexagonsAndTriangles(rotorShape(values)); }});
  all.push_back(
      {"nonrigid",
       "four quads that only bending lets out of their plane's lock",
       {length("left", "of the slit, from its bend", 1),
        length("right", "of the slit, from its bend", 1), length("depth", "of the bend", 0.3)},
       nonrigidModel});
}

/// A bulge with one tip in the middle of each side.
std::vector<SidePoint> pointedSide(double depth) {
  return {{0.5, depth}};
}

/// A bulge with a flat end, an arm of this width. Its flanks lean enough to leave the bay.
std::vector<SidePoint> armedSide(double width, double depth) {
  // The arm is in the middle of the side. Its flanks begin at `first` and end at `last`.
  const double first = 0.5 * (1 - width);
  const double last = 1 - first;
  // 1.5 times y / x at the arm's far end from the joint.
  const double lean = 1.5 * depth * depth / last;
  return {{first, 0}, {first + lean, depth}, {last - lean, depth}, {last, 0}};
}

/// Marks the tiles of a lattice that turn in the same direction as the first.
std::vector<bool> evenTiles(const Lattice& lattice) {
  std::vector<bool> even;
  for (int tile = 0; tile < lattice.tileCount(); ++tile) {
    even.push_back(isEven(lattice.cellOf(tile)));
  }
  return even;
}

/// Marks the tiles with the same number of corners as the first.
std::vector<bool> tilesLikeTheFirst(const model::Model& model) {
  std::vector<bool> alike;
  for (const model::Tile& tile : model.tiles) {
    alike.push_back(tile.vertices.size() == model.tiles.front().vertices.size());
  }
  return alike;
}

/// Marks every other tile. Rotating triangles of both kinds alternate.
std::vector<bool> everyOtherTile(const model::Model& model) {
  std::vector<bool> other(model.tiles.size());
  for (std::size_t i = 0; i < other.size(); i += 2) other[i] = true;
  return other;
}

FamilyParameter depth(double defaultValue, double least, double most) {
  return {"depth",      "SHARE", "of a side, by which it bulges on one tile and bays on the next",
          defaultValue, least,   most,
          false};
}

void appendConcave(std::vector<Family>& all) {
  const auto tiles = [](const std::string& name, const std::string& help, double defaultValue) {
    return count(name, help, defaultValue, 2, 200);
  };
  const Parameters ofSquares = {
      tiles("columns", "tiles along x", 4), tiles("rows", "tiles along y", 4),
      length("length", "of a side, from joint to joint", 1), startAngle(), targetAngle(60)};
  const auto add = [&all](Family family) {
    family.isConcave = true;
    all.push_back(std::move(family));
  };
  Family stars{"stars", "four-pointed stars between octagons, which turn against each other",
               ofSquares, [](const FamilyValues& values) {
                 return withBentSides(makeTessellation(squareShape(values)),
                                      evenTiles(latticeOf(values)),
                                      pointedSide(values.number("depth")));
               }};
  stars.parameters.push_back(depth(0.2, 0.01, 0.4));
  add(stars);
  Family crosses{"crosses", "crosses whose arms lie in bays of the tiles between them", ofSquares,
                 [](const FamilyValues& values) {
                   return withBentSides(makeTessellation(squareShape(values)),
                                        evenTiles(latticeOf(values)),
                                        armedSide(values.number("width"), values.number("depth")));
                 }};
  crosses.parameters.push_back(
      {"width", "SHARE", "of a side, that an arm takes", 0.4, 0.1, 0.8, false});
  crosses.parameters.push_back(depth(0.2, 0.01, 0.4));
  add(crosses);
  add({"islamic",
       "eighteen-cornered rosettes and the trefoils between them, as in Islamic patterns",
       {tiles("columns", "cells", 3), tiles("rows", "cells", 3), startAngle(), targetAngle(45, 180),
        depth(-0.15, -0.3, 0.3)},
       [](const FamilyValues& values) {
         const model::Model model = makeHexagonsAndTriangles(rotorShape(values));
         const double depth = values.number("depth");
         return withBentSides(model, tilesLikeTheFirst(model), {{0.35, depth}, {0.65, depth}});
       }});
  add({"trefoils",
       "three-pointed stars between hexagons with bent sides",
       {tiles("columns", "cells", 4), tiles("rows", "cells", 4), startAngle(240),
        targetAngle(60, 240), depth(0.12, 0.01, 0.25)},
       [](const FamilyValues& values) {
         const model::Model model = makeRotatingTriangles(rotorShape(values));
         return withBentSides(model, everyOtherTile(model), pointedSide(values.number("depth")));
       }});
}

void appendShells(std::vector<Family>& all) {
  const FamilyParameter radius = length("radius", "of the sphere", 3.4641016151377544);
  all.push_back({"cylinder",
                 "a tube that becomes a slimmer, longer one",
                 {count("half-columns", "tiles round the tube are twice this", 3, 2, 100),
                  count("rows", "tiles along the tube", 6, 1, 200),
                  length("length", "of a tile round the tube at the start", 2),
                  length("width", "of a tile along the tube at the start", 1)},
                 [](const FamilyValues& values) {
                   return makeCylinder({2 * values.whole("half-columns"), values.whole("rows"),
                                        values.number("length"), values.number("width")});
                 }});
  all.push_back({"cap",
                 "a flat square that becomes a cap of a sphere",
                 {count("half-size", "tiles along a side are twice this", 4, 1, 6), radius,
                  angle("angle", "from the sphere's pole to the middle of a side", 45, 10, 60)},
                 [](const FamilyValues& values) {
                   CapShape shape = capShape(values);
                   shape.halfAngle = values.angle("angle");
                   return makeSphericalCap(shape);
                 },
                 false,
                 "radius"});
  all.push_back({"cube-to-sphere",
                 "a cube that becomes a sphere",
                 {count("half-size", "tiles along a cube's edge are twice this", 3, 1, 5), radius},
                 [](const FamilyValues& values) { return makeCubeToSphere(capShape(values)); },
                 false,
                 "radius"});
  all.push_back({"moebius",
                 "a flat strip that becomes a twisted band",
                 {count("half-columns", "tiles along the strip are twice this", 6, 5, 30),
                  count("half-rows", "tiles across are twice this", 1, 1, 3),
                  count("half-twists", "0 for a plain band, 1 for Moebius's", 1, 0, 3),
                  length("radius", "of the band's middle line", 3)},
                 [](const FamilyValues& values) {
                   BandShape shape;
                   shape.columns = 2 * values.whole("half-columns");
                   shape.rows = 2 * values.whole("half-rows");
                   shape.halfTwists = values.whole("half-twists");
                   shape.radius = values.number("radius");
                   return makeMoebiusBand(shape);
                 },
                 false,
                 "radius"});
  all.push_back({"sphere-to-saddle",
                 "a cap of a sphere that becomes a saddle",
                 {count("half-columns", "tiles along x are twice this", 5, 2, 8),
                  count("half-rows", "tiles along y are twice this", 5, 2, 8),
                  length("radius", "of the sphere", 6.9),
                  {"curvature", "1/METRES", "c of the saddle z = c (x^2 - y^2)", 0.4, 0.01, 1},
                  length("width", "of the sheet's longer side", 6)},
                 [](const FamilyValues& values) {
                   return makeSphereToSaddle({2 * values.whole("half-columns"),
                                              2 * values.whole("half-rows"),
                                              values.number("radius"), values.number("curvature"),
                                              values.number("width")});
                 },
                 false,
                 "width"});
}

/// The value of a parameter, given or default.
double checkedValue(const Family& family, const FamilyParameter& parameter,
                    const std::map<std::string, double>& given) {
  const auto found = given.find(parameter.name);
  if (found == given.end()) return parameter.defaultValue;
  const double value = found->second;
  // False for NaN.
  const bool inRange = value >= parameter.least && value <= parameter.most;
  if (inRange && (!parameter.whole || value == std::floor(value))) return value;
  throw InputError(fmt::format("{}: error: {} is {:g}, but must be a {}number in [{:g}, {:g}]",
                               family.name, parameter.name, value, parameter.whole ? "whole " : "",
                               parameter.least, parameter.most));
}

std::vector<std::string> names(const auto& entries) {
  std::vector<std::string> names;
  for (const auto& entry : entries) names.push_back(entry.name);
  return names;
}

// Given values, with defaults for the other parameters.
FamilyValues checkedValues(const Family& family, const std::map<std::string, double>& given) {
  std::map<std::string, double> values;
  for (const FamilyParameter& parameter : family.parameters) {
    values[parameter.name] = checkedValue(family, parameter, given);
  }
  for (const auto& [name, value] : given) {
    if (values.contains(name)) continue;
    throw InputError(fmt::format("{}: error: there is no parameter {}. Available: {}", family.name,
                                 name, fmt::join(names(family.parameters), ", ")));
  }
  return FamilyValues(values);
}

/// The ratio of a fitted sheet's size to its default; 1 for other sheets.
double fitScale(const Family& family, const FamilyValues& values) {
  if (family.fittedSize.empty()) return 1;
  const FamilyParameter& size =
      *std::ranges::find(family.parameters, family.fittedSize, &FamilyParameter::name);
  return values.number(size.name) / size.defaultValue;
}

/// The values for a sheet that is larger by a factor.
FamilyValues scaledValues(const Family& family, const FamilyValues& values, double factor) {
  std::map<std::string, double> scaled;
  for (const FamilyParameter& parameter : family.parameters) {
    double& value = scaled[parameter.name] = values.number(parameter.name);
    if (parameter.unit == "METRES") value *= factor;
    if (parameter.unit == "1/METRES") value /= factor;
  }
  return FamilyValues(scaled);
}

/// Describes why a file with this tile would be rejected. Empty if it would not.
std::string tileFault(const model::Tile& tile) {
  // In the order of the reader's checks: each relies on the earlier ones.
  if (formats::repeatedVertices(tile)) return "has two corners at one position";
  if (!formats::hasArea(tile)) return "is too narrow";
  return formats::crossingSides(tile) ? "crosses or touches itself" : "";
}

/// Describes why the tiles of one state are not a valid sheet. Empty if they are.
std::string stateFault(const model::Model& model, const std::vector<model::Tile>& tiles,
                       bool isConcave) {
  // Cheap checks first. The last one compares pairs of tiles.
  const double size = model::tileSize(model);
  if (!(model::largestJointGap(model.joints, tiles) <= kExactModel * size))
    return "joints do not close";
  if (!(trajectory::largestUnevenness(tiles) <= kExactModel * size)) return "tiles are not flat";
  if (!isConcave && !(trajectory::smallestCornerSine(tiles) >= kConvex))
    return "tiles are not convex";
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const std::string fault = tileFault(tiles[i]);
    if (!fault.empty()) return fmt::format("tile {} {}", i, fault);
  }
  const std::vector<trajectory::TileOverlap> overlaps =
      trajectory::tileOverlaps(tiles, kTouchingTiles * size);
  if (overlaps.empty()) return "";
  return fmt::format("tiles {} and {} overlap by {:.2g} m", overlaps[0].tileA, overlaps[0].tileB,
                     overlaps[0].depth);
}

// Checks both states, and that tiles are congruent.
std::string modelFault(const model::Model& model, bool isConcave) {
  const std::string atStart = stateFault(model, model.tiles, isConcave);
  if (!atStart.empty()) return atStart + " at the start";
  if (!model.target) return "";
  if (!(trajectory::largestShapeChange(model.tiles, *model.target) <=
        kExactModel * model::tileSize(model))) {
    return "tiles change their shape";
  }
  const std::string atTarget = stateFault(model, *model.target, isConcave);
  return atTarget.empty() ? "" : atTarget + " at the target";
}

}  // namespace

double FamilyValues::angle(const std::string& name) const {
  return number(name) * kDegree;
}

const std::vector<Family>& families() {
  // Built once, at first use.
  static const std::vector<Family> all = [] {
    std::vector<Family> list;
    appendLattices(list);
    appendRegular(list);
    appendConcave(list);
    appendShells(list);
    appendTilings(list);
    return list;
  }();
  return all;
}

const Family& familyNamed(const std::string& name) {
  for (const Family& family : families()) {
    if (family.name == name) return family;
  }
  throw InputError(fmt::format("error: there is no family {}{}; give one of {}", name,
                               suggestion(name, names(families())),
                               fmt::join(names(families()), ", ")));
}

model::Model generateModel(const Family& family, const std::map<std::string, double>& given) {
  const FamilyValues values = checkedValues(family, given);
  const double scale = fitScale(family, values);
  model::Model model = family.make(scaledValues(family, values, 1 / scale));
  model::scaleLengths(model, scale);
  model.name = family.name;
  formats::chooseJointFaces(model, formats::FaceRule::Fold);
  model::symmetrise(model);  // a fit has the symmetries only within its own tolerance
  const std::string fault = modelFault(model, family.isConcave);
  if (fault.empty()) return model;
  throw InputError(fmt::format(
      "{}: error: no sheet with these parameters was found ({}). Use values nearer to the defaults",
      family.name, fault));
}

// ------------------------------------------------------------------------------------------------
// Bent sides: each side of a tile gets further corners at p + x s + y (s x n). p is the first
// corner of the side, s the side as a vector (m), n the tile's unit normal and (x, y) a point of
// the list, as fractions of the side's length. s x n points out of an anticlockwise tile and has
// the length of the side.
//
// Two tiles with a common side have opposite directions along it: x of one is 1 - x of the other.
// So lists that are the same from either end fit into each other.

namespace {

// Corners of a tile with the points of its sides between them.
model::Tile bent(const model::Tile& tile, bool bulges, const std::vector<SidePoint>& points) {
  const Vector3 normal = model::tileNormal(tile);
  model::Tile result;
  const std::size_t count = tile.vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3& from = tile.vertices[k];
    const Vector3 side = tile.vertices[(k + 1) % count] - from;
    const Vector3 outwards = side.cross(normal);  // as long as the side
    result.vertices.push_back(from);
    for (const SidePoint& point : points) {
      const double out = bulges ? point.out : -point.out;
      result.vertices.emplace_back(from + point.along * side + out * outwards);
    }
  }
  return result;
}

}  // namespace

model::Model withBentSides(const model::Model& model, const std::vector<bool>& bulges,
                           const std::vector<SidePoint>& points) {
  model::Model result = model;
  for (std::size_t i = 0; i < model.tiles.size(); ++i) {
    result.tiles[i] = bent(model.tiles[i], bulges[i], points);
    if (model.target) (*result.target)[i] = bent((*model.target)[i], bulges[i], points);
  }
  // Corner k of a tile is corner k (1 + points) of the bent one.
  const int corners = 1 + static_cast<int>(points.size());
  for (model::Joint& joint : result.joints) {
    joint.a.vertex *= corners;
    joint.b.vertex *= corners;
  }
  return result;
}

// ------------------------------------------------------------------------------------------------
// Sheets of regular polygons of two kinds, from one formula as for lattices of quads.
//
// Let c be the centre of a tile of kind 0 (complex, m), d the centre of a neighbour of another
// kind, and r a complex ratio that is the same for all pairs. Their common corner is at
// c + r (d - c) in the closed sheet, and at
//   v(theta) = (1 - r) c e^(i theta/2) + r d e^(-i theta/2)
// after neighbours have turned by theta (radians). The corners of a tile of kind 0 have the same c.
// They differ only by terms in d, which rotate by -theta/2, so the tile is rigid. Other tiles
// rotate by +theta/2. Both tiles at a corner use the same sum, so joints stay closed. r follows
// from one pair: e^(i pi/3) for triangles, sqrt(3)/2 e^(i pi/6) for hexagons and triangles.
//
// J. N. Grima, K. E. Evans, Auxetic behavior from rotating triangles, Journal of Materials Science
// 41, 2006.

namespace {

using Complex = std::complex<double>;

/// A position on the triangular lattice: cell numbers and the kind of tile in the cell.
struct RotorPlace {
  int column = 0;
  int row = 0;
  int kind = 0;

  auto operator<=>(const RotorPlace&) const = default;
};

/// An edge-to-edge pattern of tiles. Kind 0 has only neighbours of other kinds. Let c be the centre
/// of a tile of kind 0 and d the centre of a neighbour. Their common corner is c + ratio (d - c).
/// So
///   v(theta) = (1 - ratio) c e^(i theta / 2) + ratio d e^(-i theta / 2)
/// keeps all tiles rigid and all joints closed at every theta.
struct Pattern {
  Complex ratio;
  Complex (*centre)(const RotorPlace&);
  /// Anticlockwise; some may be outside the sheet.
  std::vector<RotorPlace> (*neighbours)(const RotorPlace&);
};

// All tiles at one angle, in the plane z = 0.
std::vector<model::Tile> tilesAt(const Pattern& pattern, const std::vector<RotorPlace>& places,
                                 double angle) {
  const Complex turn = std::polar(1.0, 0.5 * angle);
  std::vector<model::Tile> tiles;
  for (const RotorPlace& place : places) {
    model::Tile& tile = tiles.emplace_back();
    for (const RotorPlace& neighbour : pattern.neighbours(place)) {
      Complex first = pattern.centre(place);
      Complex second = pattern.centre(neighbour);
      // The formula needs the centre of kind 0 first.
      if (place.kind != 0) std::swap(first, second);
      const Complex corner =
          (1.0 - pattern.ratio) * first * turn + pattern.ratio * second * std::conj(turn);
      // Adding 0 makes a negative zero positive.
      tile.vertices.emplace_back(corner.real() + 0.0, corner.imag() + 0.0, 0);
    }
  }
  return tiles;
}

// Corner k of a tile is shared with neighbour k in the list.
std::vector<model::Joint> jointsOf(const Pattern& pattern, const std::vector<RotorPlace>& places) {
  std::map<RotorPlace, int> numbers;
  for (const RotorPlace& place : places) numbers.emplace(place, static_cast<int>(numbers.size()));
  const auto cornerTowards = [&](const RotorPlace& from, const RotorPlace& to) {
    const std::vector<RotorPlace> around = pattern.neighbours(from);
    int corner = 0;
    while (around[std::size_t(corner)] != to) ++corner;
    return corner;
  };
  std::vector<model::Joint> joints;
  for (const RotorPlace& place : places) {
    // Each joint is between kind 0 and another kind, so this finds it once.
    if (place.kind != 0) continue;
    for (const RotorPlace& neighbour : pattern.neighbours(place)) {
      const auto there = numbers.find(neighbour);
      if (there == numbers.end()) continue;
      joints.push_back({{numbers.at(place), cornerTowards(place, neighbour)},
                        {there->second, cornerTowards(neighbour, place)},
                        model::JointFace::Both});
    }
  }
  return joints;
}

model::Model makeSheet(const std::string& name, const Pattern& pattern,
                       const std::vector<RotorPlace>& places, const RotorShape& shape) {
  model::Model model;
  model.name = name;
  model.tiles = tilesAt(pattern, places, shape.startAngle);
  model.target = tilesAt(pattern, places, shape.targetAngle);
  model.joints = jointsOf(pattern, places);
  return model;
}

const double kRoot3 = std::sqrt(3.0);

/// Triangular lattice with unit edges.
Complex latticePoint(double column, double row) {
  return {column + 0.5 * row, 0.5 * kRoot3 * row};
}

/// Kind 0 points up from the cell's corner, kind 1 down.
constexpr Complex kTriangleRatio{0.5, 0.8660254037844386};

Complex triangleCentre(const RotorPlace& place) {
  const double third = (place.kind + 1) / 3.0;
  return latticePoint(place.column + third, place.row + third);
}

std::vector<RotorPlace> triangleNeighbours(const RotorPlace& place) {
  const auto [i, j, kind] = place;
  if (kind == 0) return {{i, j, 1}, {i - 1, j, 1}, {i, j - 1, 1}};
  return {{i, j + 1, 0}, {i, j, 0}, {i + 1, j, 0}};
}

/// Kind 0 is a hexagon on the cell's corner. Kinds 1 and 2 are the triangles in the cell, between
/// the hexagons of its first three and its last three corners.
constexpr Complex kHexagonRatio{0.75, 0.4330127018922193};

Complex hexagonPatternCentre(const RotorPlace& place) {
  const double third = place.kind / 3.0;
  return 2.0 * latticePoint(place.column + third, place.row + third);
}

std::vector<RotorPlace> hexagonPatternNeighbours(const RotorPlace& place) {
  const auto [i, j, kind] = place;
  if (kind == 0) {
    return {{i, j, 1},         {i - 1, j, 2}, {i - 1, j, 1},
            {i - 1, j - 1, 2}, {i, j - 1, 1}, {i, j - 1, 2}};
  }
  if (kind == 1) return {{i, j, 0}, {i + 1, j, 0}, {i, j + 1, 0}};
  return {{i + 1, j, 0}, {i + 1, j + 1, 0}, {i, j + 1, 0}};
}

}  // namespace

model::Model makeRotatingTriangles(const RotorShape& shape) {
  const Pattern pattern{kTriangleRatio, triangleCentre, triangleNeighbours};
  std::vector<RotorPlace> places;
  for (int i = 0; i < shape.columns; ++i) {
    for (int j = 0; j < shape.rows; ++j) {
      for (const int kind : {0, 1}) places.push_back({i, j, kind});
    }
  }
  return makeSheet("triangles", pattern, places, shape);
}

model::Model makeHexagonsAndTriangles(const RotorShape& shape) {
  const Pattern pattern{kHexagonRatio, hexagonPatternCentre, hexagonPatternNeighbours};
  std::vector<RotorPlace> places;
  for (int i = 0; i < shape.columns; ++i) {
    for (int j = 0; j < shape.rows; ++j) {
      places.push_back({i, j, 0});
      // These triangles would have corners without a hexagon.
      if (i + 1 == shape.columns || j + 1 == shape.rows) continue;
      for (const int kind : {1, 2}) places.push_back({i, j, kind});
    }
  }
  return makeSheet("hexagons", pattern, places, shape);
}

}  // namespace kirireel::generate
