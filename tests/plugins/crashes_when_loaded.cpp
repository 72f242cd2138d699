// Writes to address 0 as soon as it is loaded.
#include "tests/plugins/broken.h"

namespace {
int* volatile nowhere = nullptr;
}

SKYBODY_BROKEN_PLUGIN("crashes_when_loaded", *nowhere = 1);
