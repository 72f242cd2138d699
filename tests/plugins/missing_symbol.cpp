// A shared library that is no plugin. It must not be run to find out: it would abort.
#include <cstdlib>

namespace {
struct Trap {
  Trap() { std::abort(); }
} trap;
}  // namespace

extern "C" int some_function() { return 42; }
