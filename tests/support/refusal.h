/// The messages of errors, for tests.
#pragma once

#include <string>

#include "sim/base/error.h"

namespace kirireel::test {

/// The message of the Expected error that an action throws; "accepted" if it throws nothing.
template <typename Expected = InputError, typename Action>
std::string refusalOf(const Action& action) {
  try {
    action();
  } catch (const Expected& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace kirireel::test
