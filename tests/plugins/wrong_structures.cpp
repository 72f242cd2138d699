// Was compiled with a different version of a structure that the handshake does not list separately.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("wrong_structures", library.structures ^= 1);
