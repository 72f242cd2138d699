// The probe compiled with contraction of a*b+c into FMA, for environment_test.cpp.
#pragma GCC optimize("O2", "fp-contract=fast")
#pragma GCC target("arch=x86-64-v3")
#include "core/base/simd/fp_environment.h"

namespace skybody {
std::uint64_t fp_probe_contracted() { return fp_probe(); }
}  // namespace skybody
