/// The families of models that can be made from parameters.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// A number that shapes a family's models, as a person types it: lengths in metres, angles in
/// degrees.
struct FamilyParameter {
  std::string name;    ///< e.g. "columns"
  std::string unit;    ///< for the help, e.g. "METRES"
  std::string help;    ///< one phrase
  double usual = 0;    ///< the default
  double least = 0;    ///< allowed, ends included
  double most = 0;     ///< allowed
  bool whole = false;  ///< whether only whole numbers are allowed
};

/// The values of a family's parameters by name.
class FamilyValues {
 public:
  explicit FamilyValues(std::map<std::string, double> values) : values_(std::move(values)) {}

  double number(const std::string& name) const { return values_.at(name); }
  int whole(const std::string& name) const { return static_cast<int>(values_.at(name)); }
  /// A parameter in degrees, as radians.
  double angle(const std::string& name) const;

 private:
  std::map<std::string, double> values_;
};

/// One family.
struct Family {
  std::string name;  ///< e.g. "square-to-disk"
  std::string help;  ///< one phrase
  std::vector<FamilyParameter> parameters;
  std::function<Model(const FamilyValues&)> make;
  bool isConcave = false;  ///< whether its tiles need not be convex
};

/// All families, in the order in which help lists them.
/// The list lives as long as the program.
const std::vector<Family>& families();

/// The family of that name. Throws InputError listing those that there are.
const Family& familyNamed(const std::string& name);

/// Makes a model and checks it: start and target congruent tile by tile, joints closed in both,
/// tiles flat, convex (unless the family is concave) and not overlapping, all to 1e-9 of a tile.
/// Parameters that are not given have their usual values. Faces of joints are chosen from the
/// deployed shape (FaceRule::Fold).
///
/// Throws InputError for a parameter that the family does not have or that is out of range, and for
/// values with which no such sheet was found. The same values give the same model to the last bit.
/// Families that are fitted cost a sparse factorisation a round.
Model generateModel(const Family& family, const std::map<std::string, double>& given);

}  // namespace kirireel
