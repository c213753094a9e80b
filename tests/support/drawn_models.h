/// Random members of all families of models.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/generate/families.h"

namespace kirireel {

/// A member of a family, with its command.
struct DrawnModel {
  model::Model model;
  double thickness = 0;  ///< of its bricks, in tiles: 0.002 to 0.1
  std::string name;      ///< e.g. "cylinder rows=3 width=0.71"
};

/// Draws members of all families in turn, the same ones for a seed on any machine.
class DrawnModels {
 public:
  /// Members have at most so many tiles.
  DrawnModels(unsigned seed, std::size_t maxTiles) : random_(seed), maxTiles_(maxTiles) {}

  DrawnModel next() {
    const generate::Family& family = generate::families()[drawn_++ % generate::families().size()];
    for (;;) {
      std::map<std::string, double> values;
      std::string name = family.name;
      for (const generate::FamilyParameter& parameter : family.parameters) {
        const double value = draw(parameter);
        values[parameter.name] = value;
        name += fmt::format(" {}={:.3g}", parameter.name, value);
      }
      try {
        model::Model model = generate::generateModel(family, values);
        const double thickness = 0.002 * std::pow(50, share());
        if (model.tiles.size() <= maxTiles_) return {std::move(model), thickness, name};
      } catch (const InputError&) {
        // Parameters without a sheet: others are drawn.
      }
    }
  }

 private:
  /// From 0 to 1. Standard distributions differ from library to library, this does not.
  double share() { return random_() / 4294967296.0; }

  double draw(const generate::FamilyParameter& parameter) {
    if (parameter.name == "seed") return 1 + std::floor(1e6 * share());
    // Half of the sheets are closed at the start.
    if (parameter.name == "start-angle" && share() < 0.5) return parameter.defaultValue;
    if (parameter.unit == "DEGREES") return drawAngle(parameter);
    const double low = std::max(parameter.least, parameter.defaultValue / 3);
    const double high = std::min(parameter.most, parameter.defaultValue * 2);
    if (parameter.whole) return std::ceil(low) + std::floor((high - std::ceil(low) + 1) * share());
    return low * std::pow(high / low, share());
  }

  double drawAngle(const generate::FamilyParameter& parameter) {
    const double value = parameter.least + (parameter.most - parameter.least) * share();
    return std::round(10 * value) / 10;
  }

  std::mt19937 random_;
  std::size_t maxTiles_;
  std::size_t drawn_ = 0;
};

}  // namespace kirireel
