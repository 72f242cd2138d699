// A shared library that is not a plugin. It must be rejected without running its code, which
// aborts.
#include <cstdlib>

namespace {
struct Trap {
  Trap() { std::abort(); }
} trap;
}  // namespace

extern "C" int some_function() { return 42; }
