/// The state of a running object as a list of numbers.
#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "sim/base/fields.h"
#include "sim/base/geometry.h"

namespace kirireel {

class StateTape;

/// A type with a state, whose parts it lists in transfer().
template <typename Value>
concept HasState = requires(Value& value, StateTape& tape) {
  value.transfer(tape);
};

/// Records a state, or plays it back: a class with a state lists its parts once, for both. Structs
/// that describe their fields (base/fields.h) are passed field by field.
///
///     void Clock::transfer(StateTape& tape) { tape.transfer(hours_, minutes_); }
///
/// Playback is exact to the last bit. Whole numbers must be below 2^53.
class StateTape {
 public:
  /// An empty tape for recording.
  StateTape() = default;
  /// A tape to play back.
  explicit StateTape(std::vector<double> numbers) : numbers_(std::move(numbers)), plays_(true) {}

  /// Whether values come from the tape; otherwise they are recorded.
  bool isPlaying() const { return plays_; }
  /// Whether everything has been played back.
  bool isOver() const { return next_ == numbers_.size(); }
  /// The recorded numbers.
  const std::vector<double>& numbers() const { return numbers_; }
  /// Empties the tape for a new recording.
  void clear() {
    numbers_.clear();
    next_ = 0;
    plays_ = false;
  }

  /// Records these values, or sets them to the values recorded at this position. Throws InputError
  /// if the tape holds another state.
  template <typename... Values>
  /// Memory: 8 bytes for each number or letter.
  void transfer(Values&... values) {
    (pass(values), ...);
  }

 private:
  void pass(double& number) { pass(&number, 1); }
  void pass(double* numbers, std::size_t count) {
    if (plays_) return play(numbers, count);
    numbers_.insert(numbers_.end(), numbers, numbers + count);
  }
  void pass(std::vector<double>& list) {
    list.resize(passSize(list.size()));
    pass(list.data(), list.size());
  }
  void pass(std::vector<bool>& flags);
  void pass(std::string& text);
  void pass(Quaternion& rotation) { pass(rotation.coeffs()); }

  template <typename Whole>
  requires std::integral<Whole> || std::is_enum_v<Whole>
  void pass(Whole& whole) {
    auto number = static_cast<double>(whole);
    pass(number);
    whole = static_cast<Whole>(number);
  }

  template <typename Derived>
  void pass(Eigen::PlainObjectBase<Derived>& matrix) {
    if constexpr (Derived::SizeAtCompileTime == Eigen::Dynamic) {
      matrix.resize(static_cast<Eigen::Index>(passSize(matrix.size())));
    }
    pass(matrix.data(), static_cast<std::size_t>(matrix.size()));
  }

  template <typename First, typename Second>
  void pass(std::pair<First, Second>& pair) {
    transfer(pair.first, pair.second);
  }

  template <typename Value>
  void pass(std::vector<Value>& list) {
    list.resize(passSize(list.size()));
    for (Value& value : list) pass(value);
  }

  /// A flag for the presence of the value comes first.
  template <typename Value>
  void pass(std::optional<Value>& optional) {
    bool isThere = optional.has_value();
    pass(isThere);
    if (!isThere) return optional.reset();
    if (!optional) optional.emplace();
    pass(*optional);
  }

  template <HasFields Struct>
  void pass(Struct& of) {
    forEachField(of, [this](const auto& /*field*/, auto& value) { this->pass(value); });
  }

  template <HasState Value>
  void pass(Value& value) {
    value.transfer(*this);
  }

  void play(double* numbers, std::size_t count);
  /// Records or plays back the length of a list. Each of its entries takes at least one number.
  std::size_t passSize(std::size_t size);

  std::vector<double> numbers_;
  std::size_t next_ = 0;  ///< next number to play
  bool plays_ = false;
};

}  // namespace kirireel
