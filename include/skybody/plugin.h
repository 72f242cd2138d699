// The header for plugin authors.
#pragma once

#if __GNUC__ >= 13 && !defined(__clang__) && (!defined(__AVX__) || defined(__AVX512F__))
#define SKYBODY_SETTLES_COMPARISONS  // lanes::settle(), where kernels of 8 lanes have registers
#endif

#include "core/base/math/distribution.h"
#include "core/base/math/jet.h"
#include "core/base/math/math.h"
#include "plugins/api/export.h"
#include "plugins/api/plugin.h"
#include "plugins/api/reference_point.h"
