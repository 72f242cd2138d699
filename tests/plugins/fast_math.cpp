// Built with -Ofast -march=x86-64-v3 -ffp-contract=fast (CMakeLists.txt): gives other bits.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("fast_math", );
