// Ends the process, as if all were well, as soon as it is loaded.
#include <stdlib.h>

#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("exits_when_loaded", exit(0));
