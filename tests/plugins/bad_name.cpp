// Has a name that no scenario can contain.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("Bad-Name", );
