// Is refused for its API version, and ends the process when it is unloaded for that reason.
#include <stdlib.h>

#include "tests/plugins/broken.h"

namespace {
struct Leaver {
  ~Leaver() { _Exit(0); }
};
const Leaver leaver;
}  // namespace

SKYBODY_BROKEN_PLUGIN("exits_when_refused", library.abi_version = 7);
