// Was compiled when a structure without a size of its own in the handshake was different.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("wrong_structures", library.structures ^= 1);
