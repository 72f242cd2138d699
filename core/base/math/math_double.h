// Non-template overloads for double of the functions that libm also has. Without them, a call of
// exp(x) for a double under `using namespace skybody;` would silently select libm's version, with
// other bits on other processors: a non-template wins over a template. With them the call is
// ambiguous; write skybody::exp(x).
#pragma once

#include "core/base/math/math_atan.h"
#include "core/base/math/math_exp.h"
#include "core/base/math/math_trig.h"

namespace skybody {

SKYBODY_INLINE double exp(double x) { return exp<double>(x); }
SKYBODY_INLINE double expm1(double x) { return expm1<double>(x); }
SKYBODY_INLINE double log(double x) { return log<double>(x); }
SKYBODY_INLINE double sin(double x) { return sin<double>(x); }
SKYBODY_INLINE double cos(double x) { return cos<double>(x); }
SKYBODY_INLINE double tan(double x) { return tan<double>(x); }
SKYBODY_INLINE double asin(double x) { return asin<double>(x); }
SKYBODY_INLINE double acos(double x) { return acos<double>(x); }
SKYBODY_INLINE double atan2(double y, double x) { return atan2<double>(y, x); }

}  // namespace skybody
