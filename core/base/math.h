// Bit-stable math: the same bits for double and for every pack, at every instruction set and
// optimisation level, on every x86-64 (given -ffp-contract=off and no fast-math). Nothing here
// calls libm. Error bounds are in units in the last place (ulp) and checked by
// tests/unit/base/math_test.cpp.
#pragma once

#include "core/base/math_atan.h"    // IWYU pragma: export
#include "core/base/math_basic.h"   // IWYU pragma: export
#include "core/base/math_double.h"  // IWYU pragma: export
#include "core/base/math_exp.h"     // IWYU pragma: export
#include "core/base/math_trig.h"    // IWYU pragma: export
