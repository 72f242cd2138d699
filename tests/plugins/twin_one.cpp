// One of two files with a plugin called `twin`.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("twin", );
