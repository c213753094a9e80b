/// The families of models that are generated from parameters.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::generate {

/// A parameter of a family's models, in the user's units: lengths in metres, angles in
/// degrees.
struct FamilyParameter {
  std::string name;         ///< e.g. "columns"
  std::string unit;         ///< for the help, e.g. "METRES"
  std::string help;         ///< one phrase
  double defaultValue = 0;  ///< the default
  double least = 0;         ///< minimum, inclusive
  double most = 0;          ///< maximum, inclusive
  bool whole = false;       ///< whether only whole numbers are allowed
};

/// The values of a family's parameters by name.
class FamilyValues {
 public:
  /// By name; missing ones have their defaults.
  explicit FamilyValues(std::map<std::string, double> values) : values_(std::move(values)) {}

  /// Of an existing parameter, in its own unit.
  double number(const std::string& name) const { return values_.at(name); }
  /// The same of a whole number.
  int whole(const std::string& name) const { return static_cast<int>(values_.at(name)); }
  /// A parameter in degrees, as radians.
  double angle(const std::string& name) const;

 private:
  std::map<std::string, double> values_;
};

/// One family.
struct Family {
  std::string name;                         ///< e.g. "square-to-disk"
  std::string help;                         ///< one phrase
  std::vector<FamilyParameter> parameters;  ///< in the order of the help
  std::function<model::Model(const FamilyValues&)>
      make;                ///< makes a model; throws InputError for values that do not go together
  bool isConcave = false;  ///< whether its tiles need not be convex
};

/// All families, in the order of the help.
/// The list has static lifetime.
const std::vector<Family>& families();

/// The family with this name. Throws InputError with the list of existing names.
const Family& familyNamed(const std::string& name);

/// Makes a model and checks it: start and target congruent tile by tile, joints closed in both,
/// tiles flat, convex (unless the family is concave) and without overlap, all to 1e-9 of a tile.
/// Missing parameters have their defaults. The faces of joints follow from the deployed shape
/// (FaceRule::Fold).
///
/// Throws InputError for a parameter that the family does not have or that is out of range, and for
/// values without such a sheet. Equal values give bitwise equal models. Fitted families cost a
/// sparse factorisation per round.
model::Model generateModel(const Family& family, const std::map<std::string, double>& given);

// ------------------------------------------------------------------------------------------------
// Concave tiles: sheets of tiles with bent sides that fit into each other.
//
// In a sheet of two kinds of tiles that turn against each other, only the joints determine the
// motion. A tile may have any outline between two joined corners. Bulges on the sides of one kind,
// and the same outline as bays in the other, keep the closed sheet closed. While two tiles turn
// about one end of their common side, a point at (x, y) of the bulge (x along the side from the
// joint, y out of it) leaves the bay at once if the wall's normal n there has n . (-y, x) >= 0.
// Such walls lean towards the joint by more than y / x. The generator checks whether the tiles of a
// state overlap.

/// A corner that is inserted into each side.
struct SidePoint {
  double along = 0.5;  ///< position as a fraction of the side, [0, 1], ascending
  double out = 0;      ///< outwards on tiles that bulge, as a fraction of the side's length
};

/// The sheet with these points in each side of each tile: outwards where `bulges` is true for the
/// tile, else inwards. The points are the same from either end of a side. Joints stay at their
/// corners.
model::Model withBentSides(const model::Model& model, const std::vector<bool>& bulges,
                           const std::vector<SidePoint>& points);

// ------------------------------------------------------------------------------------------------
// Sheets of regular tiles of two kinds that turn against each other at their corners.

/// How large a sheet is and how far it opens.
struct RotorShape {
  int columns = 4;         ///< cells along the first lattice direction, > 0
  int rows = 4;            ///< cells along the second
  double startAngle = 0;   ///< rotation of neighbours, radians; 0 is closed
  double targetAngle = 0;  ///< the same at the target
};

/// Rotating triangles with edges of 1 m: two per cell, pointing up and down; a kagome lattice of
/// hexagonal voids at 120 degrees, closed again at 240.
model::Model makeRotatingTriangles(const RotorShape& shape);

/// Regular hexagons, one per cell, and the triangles between them, edges of 1 m; widest at 90
/// degrees, closed again at 180. At least 2 columns and 2 rows.
model::Model makeHexagonsAndTriangles(const RotorShape& shape);

}  // namespace kirireel::generate
