// Has no functions for x86-64-v3.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("no_kernels", plugin.kernels[SKYBODY_NUMBER_REAL][1] = {});
