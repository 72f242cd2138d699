// Every function of core/base/math/math.h gives the same bits for double and for packs of 2, 4 and
// 8, in code compiled for x86-64-v2, v3 and v4 within one file. This file is compiled for the
// baseline.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/base/math/hash.h"
#include "core/base/math/math.h"
#include "core/base/math/quat.h"
#include "core/base/simd/isa.h"

namespace skybody {
namespace {

constexpr int kCount = 100000;  // a multiple of eight

/// f(x, y) over arrays in lanes of Real, compiled for the instruction set of the calling function.
template <class Function, class Real>
SKYBODY_INLINE void evaluate(const double* x, const double* y, double* result) {
  for (int i = 0; i < kCount; i += kLanesOf<Real>) {
    store_lanes(result + i, Function::call(load_lanes<Real>(x + i), load_lanes<Real>(y + i)));
  }
}

template <class Function, class Real>
__attribute__((flatten, noinline)) void evaluate_here(const double* x, const double* y, double* r) {
  evaluate<Function, Real>(x, y, r);
}
template <class Function, class Real>
__attribute__((target("arch=x86-64-v3"), flatten, noinline)) void evaluate_v3(const double* x,
                                                                              const double* y,
                                                                              double* r) {
  evaluate<Function, Real>(x, y, r);
}
template <class Function, class Real>
__attribute__((target("arch=x86-64-v4"), flatten, noinline)) void evaluate_v4(const double* x,
                                                                              const double* y,
                                                                              double* r) {
  evaluate<Function, Real>(x, y, r);
}

/// Half ordinary values, half random bit patterns, some special values.
std::vector<double> inputs(std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  const double special[] = {0.0,     -0.0,      1.0,        -1.0, 5e-324,
                            -1e-310, kInfinity, -kInfinity, kNan, 1e308};
  std::vector<double> all(kCount);
  for (int i = 0; i < kCount; ++i) {
    const std::uint64_t word = bits();
    const double scale = (i & 2) ? 3.0 : 1000.0;
    if (i % 64 == 63) {
      all[i] = special[word % 10];
    } else if (i & 1) {
      all[i] = bit_cast_real(word);
    } else {
      all[i] = (static_cast<double>(word >> 11) * 0x1p-52 - 1.0) * scale;
    }
  }
  return all;
}

/// Equal bits; all NaN count as equal.
bool same(double a, double b) { return bit_cast_word(a) == bit_cast_word(b) || (a != a && b != b); }

void expect_same(const std::vector<double>& expected, const std::vector<double>& got,
                 const char* what, int width) {
  int different = 0, first = -1;
  for (int i = 0; i < kCount; ++i) {
    if (same(expected[i], got[i])) continue;
    if (different++ == 0) first = i;
  }
  EXPECT_EQ(different, 0) << what << " x " << width << ", first at " << first;
}

template <class Function, class Real>
void compare(const std::vector<double>& x, const std::vector<double>& y,
             const std::vector<double>& expected) {
  const int width = kLanesOf<Real>;
  std::vector<double> got(kCount);
  evaluate_here<Function, Real>(x.data(), y.data(), got.data());
  expect_same(expected, got, "baseline", width);
#if SKYBODY_HAS_LEVELS
  if (machine_has(Isa::v3)) {
    evaluate_v3<Function, Real>(x.data(), y.data(), got.data());
    expect_same(expected, got, "v3", width);
  }
  if (machine_has(Isa::v4)) {
    evaluate_v4<Function, Real>(x.data(), y.data(), got.data());
    expect_same(expected, got, "v4", width);
  }
#endif
}

template <class Function>
class SameBits : public ::testing::Test {};

#define FUNCTION(name, expression)                                  \
  struct name {                                                     \
    template <class Real>                                           \
    static SKYBODY_INLINE Real call(const Real& x, const Real& y) { \
      static_cast<void>(x), static_cast<void>(y);                   \
      return expression;                                            \
    }                                                               \
  };
FUNCTION(Arithmetic, (x + 3.0 * y) - x * y / (x - y) + (-x))
FUNCTION(Select, select((x < y && x > -y) || !(y >= 0.5), x, y))
FUNCTION(MinMaxClamp, min(x, y) + max(x, 0.5) + clamp(x, -1.0, 2.0))
FUNCTION(Rounding, floor(x) + 0.5 * round_half_even(y) + copysign(abs(y), x))
FUNCTION(SquareRoot, sqrt(x) + pow_3_2(y))
FUNCTION(Exp, exp(x))
FUNCTION(Expm1, expm1(x))
FUNCTION(Log, log(x))
FUNCTION(Sin, sin(x))
FUNCTION(Cos, cos(x))
FUNCTION(Tan, tan(x))
FUNCTION(Atan2, atan2(x, y))
FUNCTION(Asin, asin(x * 0.001))
FUNCTION(Acos, acos(y))
FUNCTION(WrapAngle, wrap_angle(x))
FUNCTION(Norm, norm(x, y) + norm(x, y, x))
FUNCTION(Rotation, rotate(from_rpy(x, y, Real(0.3)), Vec3<Real>{x, y, Real(1.0)}).y)
FUNCTION(FromRotation, from_rotation(to_mat3(from_rpy(x, y, x))).x)
#undef FUNCTION

using Functions =
    ::testing::Types<Arithmetic, Select, MinMaxClamp, Rounding, SquareRoot, Exp, Expm1, Log, Sin,
                     Cos, Tan, Atan2, Asin, Acos, WrapAngle, Norm, Rotation, FromRotation>;
TYPED_TEST_SUITE(SameBits, Functions);

TYPED_TEST(SameBits, ForDoubleAndAllPacksAtAllInstructionSets) {
  const std::vector<double> x = inputs(1), y = inputs(2);
  std::vector<double> expected(kCount);
  evaluate_here<TypeParam, double>(x.data(), y.data(), expected.data());
  compare<TypeParam, double>(x, y, expected);
  compare<TypeParam, Pack<2>>(x, y, expected);
  compare<TypeParam, Pack<4>>(x, y, expected);
  compare<TypeParam, Pack<8>>(x, y, expected);
}

/// Chains Function's results over the common inputs; all NaN count as equal.
template <class Function>
void add_results(const std::vector<double>& x, const std::vector<double>& y, HashChain& chain) {
  for (int i = 0; i < 5000; ++i) {
    const double result = Function::call(x[i], y[i]);
    chain.update(result != result ? 0x7ff8000000000000ull : bit_cast_word(result));
  }
}

template <class... Functions>
std::uint64_t hash_of_results(::testing::Types<Functions...>) {
  const std::vector<double> x = inputs(3), y = inputs(4);
  HashChain chain;
  (add_results<Functions>(x, y, chain), ...);
  return chain.value();
}

// Golden: holds for every compiler flag that Skybody allows, so builds also agree with each other.
TEST(SameBitsEverywhere, ResultsHashToTheGoldenValue) {
  EXPECT_EQ(to_hex(hash_of_results(Functions())), "18d4f85e552c739a");
}

}  // namespace
}  // namespace skybody
