// Grid: run i of axes with n_0, n_1, ... values has on each axis the digit of i in the mixed base
// (n_0, n_1, ...), the last axis being the lowest digit. So no list of runs is kept.
//
// Latin hypercube (M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21, 1979): with n runs
// each range is cut into n equal parts, in share of the way; for each axis a random permutation p
// of 0 to n - 1 is drawn, and run i has the share
//
//     (p(i) + r) / n,    r uniform in 0 to 1.
//
// Each part of each range has one run, so that n runs tell about every parameter as n values, where
// a grid of n runs in d parameters has the d-th root of n.
//
// Random numbers come from std::mt19937_64, whose sequence the C++ standard fixes; distributions
// and shuffles of the library are not fixed, so they are written out here.
#include "render/sweep/sweep_plan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>

#include <fmt/format.h>

namespace kirireel {
namespace {

void sortAndDropRepeats(std::vector<SweepValue>& values) {
  std::stable_sort(values.begin(), values.end(), comesBefore);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

using Row = std::vector<SweepValue>;

void sortAndDropRepeats(std::vector<Row>& rows) {
  const auto rowComesBefore = [](const Row& a, const Row& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(), comesBefore);
  };
  std::stable_sort(rows.begin(), rows.end(), rowComesBefore);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
}

/// From 0 to below 1. Not std::uniform_real_distribution, which may differ between libraries.
double randomShare(std::mt19937_64& generator) {
  // The upper 53 bits of 64, as many as a double holds.
  return static_cast<double>(generator() >> 11) * 0x1p-53;
}

/// The numbers from 0 on, shuffled (Fisher, Yates); not std::shuffle, for the same reason.
std::vector<std::size_t> shuffledNumbers(std::size_t count, std::mt19937_64& generator) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  for (std::size_t left = count; left > 1; --left) {
    // The bias of the remainder is below left / 2^64, which nobody can see.
    std::swap(numbers[left - 1], numbers[generator() % left]);
  }
  return numbers;
}

}  // namespace

std::optional<double> numberIn(const std::string& text) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && next == end ? std::optional(number) : std::nullopt;
}

bool comesBefore(const SweepValue& a, const SweepValue& b) {
  const auto first = numberIn(a.text);
  const auto second = numberIn(b.text);
  if (first && second) return *first < *second;
  // A number comes before a text.
  if (first || second) return first.has_value();
  return a.text < b.text;
}

std::string SweepRange::at(double share) const {
  const double number =
      logarithmic ? from * std::pow(to / from, share) : from + (to - from) * share;
  // Nine digits are fewer than a double has: 0.1 + 0.2 shows as 0.3.
  return fmt::format("{:.9g}", whole ? std::round(number) : number);
}

SweepPlan SweepPlan::grid(std::vector<SweepAxis> axes) {
  SweepPlan plan;
  for (SweepAxis& axis : axes) {
    plan.keys_.push_back(axis.key);
    plan.axes_.push_back(std::move(axis.values));
    sortAndDropRepeats(plan.axes_.back());
  }
  return plan;
}

SweepPlan SweepPlan::list(const std::vector<SweepAxis>& axes) {
  SweepPlan plan;
  for (const SweepAxis& axis : axes) {
    plan.keys_.push_back(axis.key);
    plan.rows_.resize(axis.values.size());
    for (std::size_t i = 0; i < axis.values.size(); ++i) plan.rows_[i].push_back(axis.values[i]);
  }
  sortAndDropRepeats(plan.rows_);
  return plan;
}

SweepPlan SweepPlan::latinHypercube(const std::vector<SweepRangeAxis>& axes, std::size_t count,
                                    std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<SweepAxis> columns;
  for (const SweepRangeAxis& axis : axes) {
    columns.push_back({axis.key, axis.where, {}});
    for (const std::size_t part : shuffledNumbers(count, generator)) {
      const double share =
          (static_cast<double>(part) + randomShare(generator)) / static_cast<double>(count);
      columns.back().values.push_back({axis.range.at(share), false, axis.where});
    }
  }
  return list(columns);
}

std::uint64_t SweepPlan::size() const {
  if (axes_.empty()) return rows_.size();
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  // The product is capped where it would overflow.
  std::uint64_t size = 1;
  for (const auto& values : axes_) {
    if (values.empty()) return 0;
    size = size > kMost / values.size() ? kMost : size * values.size();
  }
  return size;
}

std::vector<SweepValue> SweepPlan::run(std::uint64_t index) const {
  if (axes_.empty()) return rows_.at(index);
  std::vector<SweepValue> values(axes_.size());
  // The last axis changes fastest.
  for (std::size_t k = axes_.size(); k-- > 0;) {
    values[k] = axes_[k][index % axes_[k].size()];
    index /= axes_[k].size();
  }
  return values;
}

}  // namespace kirireel
