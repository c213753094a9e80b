// Repairs of unusual but unambiguous input.
//
// A repair requires that no other reading of the file makes sense. The program reports its place,
// and `--strict` refuses it. A repair is a `Repair` of the model and one line among the warnings.
#include "sim/formats/repairs.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/words.h"
#include "sim/formats/written_digits.h"

namespace kirireel::formats {

std::string toString(const model::Repair& repair) {
  return fmt::format("{}: repaired: {}; {}", repair.place, repair.found, repair.done);
}

void noteRepair(model::Repair repair, model::Model& model, std::vector<std::string>& warnings) {
  warnings.push_back(toString(repair));
  model.repairs.push_back(std::move(repair));
}

void refuseRepairs(const model::Model& model) {
  if (model.repairs.empty()) return;
  const model::Repair& repair = model.repairs.front();
  throw InputError(fmt::format("{}: error: {}; {}, or remove `strict` to have it repaired",
                               repair.place, repair.found, repair.advice));
}

RoundedCorners::RoundedCorners(const model::Model& model)
    : lastPlace_(lastPlace(model.tiles)), least_(0.5 * lastPlace_) {}

// Reports only the first place and counts the others.
void RoundedCorners::add(const model::Joint& joint, double gap, const std::string& place) {
  // Gaps below half a last digit do not come from rounding in the file.
  if (lastPlace_ == 0 || gap < least_) return;
  if (repair_.corners.empty()) repair_.place = place;
  repair_.corners.push_back(joint.a);
  largest_ = std::max(largest_, gap);
}

void RoundedCorners::note(model::Model& model, std::vector<std::string>& warnings) {
  if (repair_.corners.empty()) return;
  const std::size_t count = repair_.corners.size();
  repair_.found =
      fmt::format("the corners of {} are {}{:.2g} apart, by rounding to {:g}",
                  counted(count, "joint"), count == 1 ? "" : "up to ", largest_, lastPlace_);
  repair_.done = count == 1 ? "joined at one corner" : "joined at one corner each";
  repair_.advice = "write the same numbers for both corners";
  noteRepair(std::move(repair_), model, warnings);
}

}  // namespace kirireel::formats
