// Dual numbers: values have the bits of plain numbers, tangents are derivatives.
#include "core/base/math/dual.h"

#include <gtest/gtest.h>

#include <random>

#include "core/base/math/quat.h"
#include "core/base/math/random.h"

namespace skybody {
namespace {

using D = Dual<double>;

/// Equal bits; all NaN count as equal.
bool same(double a, double b) { return bit_cast_word(a) == bit_cast_word(b) || (a != a && b != b); }

/// Functions of two numbers that exist for double, packs and dual numbers.
#define SKYBODY_CASE(NAME, LOW, HIGH, ...)            \
  struct NAME {                                       \
    static constexpr const char* kName = #NAME;       \
    static constexpr double kLow = LOW, kHigh = HIGH; \
    template <class Real>                             \
    static Real call(const Real& x, const Real& y) {  \
      return __VA_ARGS__;                             \
    }                                                 \
  }
SKYBODY_CASE(Sum, -3, 3, (x + y) + 0.5 + (2.0 + x));
SKYBODY_CASE(Difference, -3, 3, ((-x - y) - 0.5) + (2.0 - +y));
SKYBODY_CASE(Product, -3, 3, (x * y) * 0.7 + 0.3 * x);
SKYBODY_CASE(Quotient, 0.5, 3, x / y + x / 3.0 + 2.0 / y);
SKYBODY_CASE(Assigned, 0.5, 3, [](Real a, const Real& b) {
  a += b;
  a *= b;
  a -= 0.25;
  a /= b;
  return a;
}(x, y));
SKYBODY_CASE(SquareRoot, 0.1, 9, sqrt(x) * y);
SKYBODY_CASE(Magnitude, -3, 3, abs(x) * y);
SKYBODY_CASE(SignOf, -3, 3, copysign(x, y) + copysign(2.0, x) * y + copysign(y, -1.0));
SKYBODY_CASE(Least, -3, 3, min(x, y) + min(x, 0.5) + min(-0.5, y));
SKYBODY_CASE(Greatest, -3, 3, max(x, y) + max(x, 0.5) + max(-0.5, y));
SKYBODY_CASE(Limited, -3, 3, clamp(x, -1.0, 1.0) + clamp(y, min(x, 0.0), max(x, 0.0)));
SKYBODY_CASE(Whole, -3, 3, floor(x) * y + round_half_even(y) * x);
SKYBODY_CASE(Chosen, -3, 3, select(x < y, x* x, y + 1.0) + select(x >= 0.5, y, Real(2.0)));
SKYBODY_CASE(Lengths, 0.1, 3, norm(x, y) + norm(x, y, x + y) + square(x) + pow_3_2(y));
SKYBODY_CASE(Exponential, -3, 3, exp(x) * y + expm1(x * y));
SKYBODY_CASE(Logarithm, 0.1, 9, log(x) * y);
SKYBODY_CASE(Angles, -9, 9, sin(x) + 2.0 * cos(y) + sincos(x * y).sin * sincos(x + y).cos);
SKYBODY_CASE(Tangent, -1.4, 1.4, tan(x) * y);
SKYBODY_CASE(Wrapped, -9, 9, wrap_angle(x) * y);
SKYBODY_CASE(Bearing, -3, 3, atan2(y, x));
SKYBODY_CASE(Inverses, -0.99, 0.99, asin(x) + 2.0 * acos(y));
SKYBODY_CASE(Finite, -3, 3, select(is_finite(x), x, y) + select(is_nan(x / y), x, y* y));
SKYBODY_CASE(Cast, 0.1, 9, to_real(to_word(floor(x))) * y);

template <class... Cases>
struct List {
  template <class F>
  static void each(F&& f) {
    (f(Cases()), ...);
  }
};
using All = List<Sum, Difference, Product, Quotient, Assigned, SquareRoot, Magnitude, SignOf, Least,
                 Greatest, Limited, Whole, Chosen, Lengths, Exponential, Logarithm, Angles, Tangent,
                 Wrapped, Bearing, Inverses, Finite, Cast>;

class Draw {
 public:
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  std::uint64_t word() { return bits_(); }

 private:
  std::mt19937_64 bits_{20260817};
};

/// Random bit patterns, whole numbers, and ordinary values.
double any_value(Draw& draw, int i) {
  if (i % 3 == 0) return bit_cast_real(draw.word());
  const double x = draw(-4.0, 4.0);
  return i % 3 == 1 ? x : round_half_even(x);
}

template <class Case, int W>
void expect_values_of(const Case&) {
  Draw draw;
  for (int i = 0; i < 3000; ++i) {
    Dual<Pack<W>> x, y;
    for (int l = 0; l < W; ++l) {
      set_lane(x.value, l, any_value(draw, i));
      set_lane(y.value, l, any_value(draw, i / 3));
      set_lane(x.tangent, l, draw(-1.0, 1.0));
      set_lane(y.tangent, l, draw(-1.0, 1.0));
    }
    const Pack<W> plain = Case::call(x.value, y.value);
    const Dual<Pack<W>> dual = Case::call(x, y);
    for (int l = 0; l < W; ++l) {
      ASSERT_TRUE(same(lane(dual.value, l), lane(plain, l)))
          << Case::kName << " of packs of " << W << " at " << lane(x.value, l) << ", "
          << lane(y.value, l);
      const D one = Case::call(D(lane(x.value, l), lane(x.tangent, l)),
                               D(lane(y.value, l), lane(y.tangent, l)));
      ASSERT_TRUE(same(one.value, lane(plain, l))) << Case::kName << " of doubles";
      ASSERT_TRUE(same(one.tangent, lane(dual.tangent, l)))
          << Case::kName << ": the tangent in a pack is another one than alone";
    }
  }
}

TEST(Dual, ValuesHaveTheBitsOfPlainNumbersAndTangentsThoseOfDoubles) {
  All::each([](auto c) {
    expect_values_of<decltype(c), 2>(c);
    expect_values_of<decltype(c), 4>(c);
    expect_values_of<decltype(c), 8>(c);
  });
}

/// Central differences of f along (dx, dy) where f is smooth between the points; NaN elsewhere.
template <class F>
double slope(const F& f, double x, double y, double dx, double dy) {
  const auto between = [&](double h) {
    return (f(x + h * dx, y + h * dy) - f(x - h * dx, y - h * dy)) / (2.0 * h);
  };
  const double near = between(1e-4), far = between(2e-4);
  const double size = abs(near) + abs(f(x, y));
  return abs(near - far) <= 1e-5 * size ? near + (near - far) / 3.0 : kNan;
}

TEST(Dual, TangentsAreDerivatives) {
  All::each([](auto c) {
    using Case = decltype(c);
    Draw draw;
    int compared = 0;
    for (int i = 0; i < 2000; ++i) {
      const D x(draw(Case::kLow, Case::kHigh), draw(-1.0, 1.0));
      const D y(draw(Case::kLow, Case::kHigh), draw(-1.0, 1.0));
      const double want = slope([](double a, double b) { return Case::call(a, b); }, x.value,
                                y.value, x.tangent, y.tangent);
      if (want != want) continue;  // a kink, a jump, a pole
      ++compared;
      const D got = Case::call(x, y);
      // Four-point differences: rounding 1e-16 / 1e-4, and h^4 times a fifth derivative.
      ASSERT_NEAR(got.tangent, want, 1e-7 * (1.0 + abs(want) + abs(got.value)))
          << Case::kName << " at " << x.value << ", " << y.value;
    }
    EXPECT_GT(compared, 1500) << Case::kName;
  });
}

TEST(Dual, TangentsWhereThereIsNoSlopeAreThoseOfTheBranchTakenOrZero) {
  const D zero(0.0, 1.0), one(1.0, 1.0), below(-2.0, 3.0);
  EXPECT_EQ(sqrt(zero).tangent, 0.0);
  EXPECT_EQ(norm(Vec3<D>{zero, zero, zero}).tangent, 0.0);
  EXPECT_EQ(atan2(zero, zero).tangent, 0.0);
  EXPECT_EQ(asin(one).tangent, 0.0);
  EXPECT_EQ(acos(one).tangent, 0.0);
  EXPECT_EQ(abs(zero).tangent, 1.0);
  EXPECT_EQ(min(zero, D(0.0, 5.0)).tangent, 5.0);
  EXPECT_EQ(max(zero, D(0.0, 5.0)).tangent, 5.0);
  EXPECT_EQ(clamp(below, -1.0, 1.0).tangent, 0.0);
  EXPECT_EQ(clamp(D(1.0, 3.0), -1.0, 1.0).tangent, 3.0);
  EXPECT_EQ(floor(one).tangent, 0.0);
  EXPECT_EQ(round_half_even(D(2.5, 1.0)).tangent, 0.0);
}

TEST(Dual, ATangentThatIsNotChosenDoesNotMatter) {
  const D bad(kNan, kNan), good(2.0, 1.0);
  EXPECT_EQ(select(true, good, 1.0 / bad).tangent, 1.0);
  EXPECT_EQ(min(good, D(kInfinity)).tangent, 1.0);
}

/// A rotation, its matrix and angles, and an inertia: covers vec3.h, quat.h and mat3.h.
template <class Real>
Real of_geometry(const Real& x, const Real& y) {
  const Quat<Real> q = normalized(Quat<Real>{Real(1.0), x, y, x * y});
  const Vec3<Real> v{x, y - 2.0, x + y};
  const Vec3<Real> angles = to_rpy(q * from_rotation_vector(v * Real(0.3)));
  const Mat3<Real> m = to_mat3(from_rotation(to_mat3(conjugate(q))));
  const SymMat3<Real> inertia{2.0 + x * x, Real(3.0), 4.0 + y * y, 0.1 * x, 0.2 * y, Real(0.1)};
  const Vec3<Real> turned = m * rotate(q, inverse(inertia) * v) + Ldl3<Real>(inertia).solve(v);
  return (dot(angles, turned) + norm(cross(v, turned))) / squared_norm(v) +
         determinant(rotate_inertia(m, inertia)) + yaw(q) * tilt_cosine(q) +
         select(x < y, v, turned).z;
}

TEST(Dual, GeometryHasValuesAndDerivatives) {
  Draw draw;
  int compared = 0;
  for (int i = 0; i < 2000; ++i) {
    const D x(draw(-1.0, 1.0), draw(-1.0, 1.0)), y(draw(-1.0, 1.0), draw(-1.0, 1.0));
    const D got = of_geometry(x, y);
    ASSERT_TRUE(same(got.value, of_geometry(x.value, y.value)));
    const double want = slope([](double a, double b) { return of_geometry(a, b); }, x.value,
                              y.value, x.tangent, y.tangent);
    if (want != want) continue;
    ++compared;
    ASSERT_NEAR(got.tangent, want, 1e-6 * (1.0 + abs(want) + abs(got.value)));
  }
  EXPECT_GT(compared, 1500);
}

TEST(Dual, RandomNumbersAreConstants) {
  Random<Dual<Pack<4>>> dual({7, 3}, 2, 5, 11);
  Random<Pack<4>> plain({7, 3}, 2, 5, 11);
  const auto expect = [](const Dual<Pack<4>>& d, const Pack<4>& p) {
    for (int l = 0; l < 4; ++l) {
      EXPECT_TRUE(same(lane(d.value, l), lane(p, l)));
      EXPECT_EQ(lane(d.tangent, l), 0.0);
    }
  };
  for (int i = 0; i < 100; ++i) {
    expect(dual.uniform(), plain.uniform());
    expect(dual.uniform(2.0, 3.0), plain.uniform(2.0, 3.0));
    expect(dual.normal(), plain.normal());
    Dual<Pack<4>> first, second;
    Pack<4> one, two;
    dual.normal_pair(first, second);
    plain.normal_pair(one, two);
    expect(first, one);
    expect(second, two);
    expect(dual.unit_vector().x, plain.unit_vector().x);
    expect(dual.quaternion().z, plain.quaternion().z);
    EXPECT_TRUE(all(dual.integer(9) == plain.integer(9)));
  }
}

TEST(Dual, LiesInMemoryAsARowOfValuesAndARowOfTangents) {
  double rows[3 * 8] = {};
  for (int i = 0; i < 24; ++i) rows[i] = i;
  const auto x = load_rows<Dual<Pack<2>>>(rows + 2, 8);
  EXPECT_EQ(lane(x.value, 1), 3.0);
  EXPECT_EQ(lane(x.tangent, 1), 11.0);
  store_rows(rows + 4, 8, x, mask_from_bits<Pack<2>>(2));
  EXPECT_EQ(rows[4], 4.0);  // outside the mask
  EXPECT_EQ(rows[5], 3.0);
  EXPECT_EQ(rows[12], 12.0);
  EXPECT_EQ(rows[13], 11.0);
  EXPECT_EQ(kRowsOf<Dual<double>>, 2);
  EXPECT_EQ(kRowsOf<Pack<4>>, 1);
}

}  // namespace
}  // namespace skybody
