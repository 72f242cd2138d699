// A valid plugin, but linked with -Ofast: its start-up code makes the loading thread flush
// denormals to zero.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("flush_to_zero", );
