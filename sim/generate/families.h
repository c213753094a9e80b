/// Families of models generated from parameters.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::generate {

/// A parameter of a family's models. Lengths are in metres, angles in degrees.
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
  /// Values by name. Missing parameters have their defaults.
  explicit FamilyValues(std::map<std::string, double> values) : values_(std::move(values)) {}

  /// The value of an existing parameter, in its own unit.
  double number(const std::string& name) const { return values_.at(name); }
  /// The same for a whole number.
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
      make;                ///< makes a model; throws InputError for incompatible values
  bool isConcave = false;  ///< whether its tiles need not be convex
  std::string fittedSize;  ///< for fits, which work at the default size: the parameter of the
                           ///< size. The sheet is made at that size and scaled. Empty otherwise
};

/// All families, in the order of the help. The list has static lifetime.
const std::vector<Family>& families();

/// The family with this name. Throws InputError with the list of existing names.
const Family& familyNamed(const std::string& name);

/// Makes a model and checks it to 1e-9 of a tile. Tiles of start and target must be congruent,
/// joints closed in both, tiles flat, convex (unless the family is concave) and without overlap.
/// Missing parameters have their defaults. The faces of joints follow from the deployed shape
/// (FaceRule::Fold).
///
/// Throws InputError for unknown parameters, values out of range, and values for which no sheet was
/// found. Equal values give bitwise equal models. Fitted families cost one sparse factorisation per
/// round.
model::Model generateModel(const Family& family, const std::map<std::string, double>& given);

// ------------------------------------------------------------------------------------------------
// Concave tiles: sheets of tiles with interlocking bent sides.
//
// In a sheet of two kinds of tiles that turn against each other, only the joints determine the
// motion. A tile may have any outline between two joined corners. If one kind has bulges on its
// sides and the other has matching bays, the closed sheet stays closed. Two tiles turn about one
// end of their common side. Let (x, y) be a point of the bulge, x along the side from the joint and
// y out of it. The point leaves the bay without collision if the wall's normal n there fulfils n .
// (-y, x) >= 0. The generator checks whether the tiles of a state overlap.

/// A corner to insert into each side.
struct SidePoint {
  double along = 0.5;  ///< position as a fraction of the side, [0, 1], ascending
  double out = 0;      ///< outwards on tiles that bulge, as a fraction of the side's length
};

/// The sheet with these points in each side of each tile. They point outwards if `bulges` is true
/// for the tile, otherwise inwards. The points are the same from either end of a side. Joints stay
/// at their corners.
model::Model withBentSides(const model::Model& model, const std::vector<bool>& bulges,
                           const std::vector<SidePoint>& points);

// ------------------------------------------------------------------------------------------------
// Sheets of regular tiles of two kinds that turn against each other at their corners.

/// Size of a sheet and angles of its two states.
struct RotorShape {
  int columns = 4;         ///< cells along the first lattice direction, > 0
  int rows = 4;            ///< cells along the second, > 0
  double startAngle = 0;   ///< rotation of neighbours, radians; 0 is closed
  double targetAngle = 0;  ///< the same at the target
};

/// Rotating triangles with edges of 1 m, two per cell, pointing up and down. They form a kagome
/// lattice with hexagonal voids at 120 degrees and close again at 240.
model::Model makeRotatingTriangles(const RotorShape& shape);

/// Regular hexagons, one per cell, and triangles between them, with edges of 1 m. Widest at 90
/// degrees, closed again at 180. Needs at least 2 columns and 2 rows.
model::Model makeHexagonsAndTriangles(const RotorShape& shape);

}  // namespace kirireel::generate
