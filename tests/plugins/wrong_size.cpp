// Was compiled when SkybodyLanes had two fewer pointers.
#include "tests/plugins/broken.h"

SKYBODY_BROKEN_PLUGIN("wrong_size", library.lanes_size -= 16);
