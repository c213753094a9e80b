// States as numbers. Everything is a double: integers below 2^53 are exact, and a state can be
// stored as one array. The tape has no names. Values must be played back in the order of recording,
// which a single function for both directions guarantees. If a tape ends early or a length is
// impossible, it belongs to another run.
#include "sim/base/state_tape.h"

#include <algorithm>

#include "sim/base/error.h"

namespace kirireel {
namespace {

[[noreturn]] void refuseState() {
  throw InputError(
      "error: the checkpoint holds the state of another run; remove `resume` to start again");
}

}  // namespace

void StateTape::play(double* numbers, std::size_t count) {
  if (count > numbers_.size() - next_) refuseState();
  std::copy_n(numbers_.data() + next_, count, numbers);
  next_ += count;
}

void StateTape::pass(std::vector<bool>& flags) {
  std::vector<int> numbers(flags.begin(), flags.end());
  pass(numbers);
  flags.assign(numbers.begin(), numbers.end());
}

void StateTape::pass(std::string& text) {
  // When playing back, this sets the recorded length. When recording, it changes nothing.
  text.resize(passSize(text.size()));
  for (char& character : text) pass(character);
}

std::size_t StateTape::passSize(std::size_t size) {
  auto number = static_cast<double>(size);
  pass(number);
  const auto left = static_cast<double>(numbers_.size() - next_);
  // Comparisons with NaN are false: NaN is rejected.
  if (plays_ && !(number >= 0 && number <= left)) refuseState();
  return static_cast<std::size_t>(number);
}

}  // namespace kirireel
