// Ends the process with status 0 as soon as it is loaded.
#include <stdlib.h>

#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("exits_when_loaded", exit(0));
