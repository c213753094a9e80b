// A library whose end function never returns, if the program is kirireel.
#include <cstring>

#include <errno.h>
#include <unistd.h>

namespace {

struct Waiter {
  ~Waiter() {
    while (std::strcmp(program_invocation_short_name, "kirireel") == 0) ::pause();
  }
};

const Waiter waiter;

}  // namespace
