// Tests of plugins without the engine: an instance of a plugin, groups of environments for its
// kernels, and the comparison of its instruction sets.
#pragma once

#include "tests/unit/plugin_group.h"      // IWYU pragma: export
#include "tests/unit/plugin_instance.h"   // IWYU pragma: export
#include "tests/unit/plugin_same_bits.h"  // IWYU pragma: export
