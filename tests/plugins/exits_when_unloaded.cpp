// Ends the process when it is unloaded.
#include <stdlib.h>

#include "tests/plugins/broken.h"

namespace {
struct Leaver {
  ~Leaver() { _Exit(0); }
};
const Leaver leaver;
}  // namespace

SKYBODY_BROKEN_PLUGIN("exits_when_unloaded", );
