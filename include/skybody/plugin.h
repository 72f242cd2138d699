// The header for plugin authors.
#pragma once

#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 13
#define SKYBODY_SETTLES_COMPARISONS  // core/base/simd/pack.h
#endif

#include "core/base/math/distribution.h"
#include "core/base/math/jet.h"
#include "core/base/math/math.h"
#include "plugins/api/export.h"
#include "plugins/api/plugin.h"
#include "plugins/api/reference_point.h"
