// Throws an exception from its start-up code.
#include <stdexcept>

#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("throws_when_loaded", throw std::runtime_error("no licence"));
