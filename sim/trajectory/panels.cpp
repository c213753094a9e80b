#include "sim/trajectory/panels.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace kirireel::trajectory {
namespace {

using Values = std::vector<double>;

/// The tiles at each bar: those that have both of its nodes.
std::vector<std::vector<std::size_t>> tilesOfBars(const LoadedPanels& sheet) {
  std::map<std::pair<int, int>, std::size_t> barOf;
  for (std::size_t b = 0; b < sheet.bars.size(); ++b) {
    barOf[std::minmax(sheet.bars[b].nodeA, sheet.bars[b].nodeB)] = b;
  }
  std::vector<std::vector<std::size_t>> tiles(sheet.bars.size());
  for (std::size_t t = 0; t < sheet.tileNodes.size(); ++t) {
    const std::vector<int>& nodes = sheet.tileNodes[t];
    for (std::size_t i = 1; i < nodes.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const auto found = barOf.find(std::minmax(nodes[i], nodes[j]));
        if (found != barOf.end()) tiles[found->second].push_back(t);
      }
    }
  }
  return tiles;
}

Values energiesOfTiles(const LoadedPanels& sheet, const PanelState& state) {
  Values energies(sheet.tileNodes.size(), 0);
  const std::vector<std::vector<std::size_t>> tiles = tilesOfBars(sheet);
  for (std::size_t b = 0; b < sheet.bars.size(); ++b) {
    const double whole = sheet.bars[b].energy(state.strains[b]);
    for (const std::size_t tile : tiles[b]) {
      energies[tile] += whole / static_cast<double>(tiles[b].size());
    }
  }
  for (std::size_t f = 0; f < sheet.folds.size(); ++f) {
    for (const int tile : sheet.folds[f].tiles) {
      energies[static_cast<std::size_t>(tile)] += 0.5 * sheet.folds[f].energy(state.angles[f]);
    }
  }
  return energies;
}

Values momentsOfTiles(const LoadedPanels& sheet, const PanelState& state) {
  Values moments(sheet.tileNodes.size(), 0);
  for (std::size_t f = 0; f < sheet.folds.size(); ++f) {
    const double moment = std::abs(sheet.folds[f].moment(state.angles[f]));
    for (const int tile : sheet.folds[f].tiles) {
      double& largest = moments[static_cast<std::size_t>(tile)];
      largest = std::max(largest, moment);
    }
  }
  return moments;
}

/// Values at a time, linear between those of the two states around it.
Values atTime(const LoadedPanels& sheet, double time,
              Values (*valuesOf)(const LoadedPanels&, const PanelState&)) {
  const auto after = std::ranges::upper_bound(sheet.states, time, {}, &PanelState::time);
  if (after == sheet.states.begin()) return valuesOf(sheet, *after);
  Values values = valuesOf(sheet, *(after - 1));
  if (after == sheet.states.end()) return values;
  const double begin = (after - 1)->time;
  const double share = (time - begin) / (after->time - begin);
  const Values next = valuesOf(sheet, *after);
  for (std::size_t t = 0; t < values.size(); ++t) {
    values[t] = (1 - share) * values[t] + share * next[t];
  }
  return values;
}

}  // namespace

double LoadedPanels::energy(const PanelState& state) const {
  double sum = 0;
  for (std::size_t b = 0; b < bars.size(); ++b) sum += bars[b].energy(state.strains[b]);
  for (std::size_t f = 0; f < folds.size(); ++f) sum += folds[f].energy(state.angles[f]);
  return sum;
}

Values LoadedPanels::tileEnergies(double time) const {
  return atTime(*this, time, energiesOfTiles);
}

Values LoadedPanels::tileMoments(double time) const {
  return atTime(*this, time, momentsOfTiles);
}

void setElasticity(const LoadedPanels& sheet, brick::Elasticity& elasticity) {
  elasticity.counts.emplace_back("bars", static_cast<int>(sheet.bars.size()));
  elasticity.counts.emplace_back("folds", static_cast<int>(sheet.folds.size()));
  elasticity.energyStart = sheet.energy(sheet.states.front());
  elasticity.energyEnd = sheet.energy(sheet.states.back());
  elasticity.momentEnd = 0;
  for (const double moment : momentsOfTiles(sheet, sheet.states.back())) {
    elasticity.momentEnd = std::max(elasticity.momentEnd, moment);
  }
}

}  // namespace kirireel::trajectory
