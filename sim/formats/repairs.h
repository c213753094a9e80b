/// Repairs of unusual but unambiguous input, and their messages.
#pragma once

#include <string>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::formats {

/// "file:line: repaired: what was found; what was done".
std::string toString(const model::Repair& repair);

/// Adds a repair to the model and its line to the warnings.
void noteRepair(model::Repair repair, model::Model& model, std::vector<std::string>& warnings);

/// Throws InputError for the first repair of the model, with advice how to correct the file.
void refuseRepairs(const model::Model& model);

/// Joints whose corners differ only by rounding, collected into one repair.
class RoundedCorners {
 public:
  /// `model`: its corners may be off by the last digits.
  explicit RoundedCorners(const model::Model& model);

  /// `gap` in metres, at most samePlaceTolerance(). `place`: the joint's position in its file.
  void add(const model::Joint& joint, double gap, const std::string& place);

  /// Adds one repair for all of them, if there are any.
  void note(model::Model& model, std::vector<std::string>& warnings);

 private:
  model::Repair repair_;
  double lastPlace_;
  double least_;  // of reported gaps: smaller gaps come from the design's precision
  double largest_ = 0;
};

}  // namespace kirireel::formats
