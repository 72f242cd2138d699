// The probe compiled with -ffast-math, for environment_test.cpp.
#pragma GCC optimize("fast-math")
#include "core/base/simd/fp_environment.h"

namespace skybody {
std::uint64_t fp_probe_with_fast_math() { return fp_probe(); }
}  // namespace skybody
