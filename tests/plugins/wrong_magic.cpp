// Exports the symbol, but with other data.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("wrong_magic", library.magic = 0x1234);
