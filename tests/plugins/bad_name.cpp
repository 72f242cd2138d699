// Has a name that no scenario could write.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("Bad-Name", );
