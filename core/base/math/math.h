// Bit-stable math: the same bits for double and every pack, at every instruction set and level of
// optimisation, on every x86-64 processor (with -ffp-contract=off and without fast-math). Nothing
// here calls libm. Error bounds are in units in the last place (ulp);
// tests/unit/base/math_test.cpp checks them.
#pragma once

#include "core/base/math/math_atan.h"    // IWYU pragma: export
#include "core/base/math/math_basic.h"   // IWYU pragma: export
#include "core/base/math/math_double.h"  // IWYU pragma: export
#include "core/base/math/math_exp.h"     // IWYU pragma: export
#include "core/base/math/math_trig.h"    // IWYU pragma: export
