// Declares that it was built for plugin API 9.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("wrong_version", library.abi_version = 9);
