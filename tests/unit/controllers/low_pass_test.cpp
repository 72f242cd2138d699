// The second-order low-pass filter by its closed forms.
#include "controllers/common/low_pass.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace skybody::control {
namespace {

using ::testing::HasSubstr;

constexpr double kInterval = 0.002;

LowPass filter_of(double cutoff) {
  LowPass filter;
  filter.configure("cutoff", cutoff, kInterval);
  return filter;
}

/// Gain at a frequency [Hz] after the transient.
double gain_at(const LowPass& filter, double frequency) {
  LowPassState<double> state{};
  std::complex<double> in, out;
  constexpr int kSettled = 2000, kAll = 12000;
  for (int n = 0; n < kAll; ++n) {
    const double phase = kTwoPi * frequency * kInterval * n;
    const double x = std::cos(phase), y = filter.filtered(x, state);
    if (n < kSettled) continue;
    in += x * std::polar(1.0, -phase);
    out += y * std::polar(1.0, -phase);
  }
  return std::abs(out) / std::abs(in);
}

TEST(LowPass, LetsThroughSlowChangesAndHalvesPowerAtTheCutoff) {
  const LowPass filter = filter_of(30.0);
  // 10000 samples are whole periods of these frequencies: the remainder is the decayed transient.
  EXPECT_NEAR(gain_at(filter, 0.05), 1.0, 1e-6);
  EXPECT_NEAR(gain_at(filter, 30.0), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(gain_at(filter, 245.0), 0.0, 1e-4);
}

TEST(LowPass, FollowsTheTransferFunctionOfTheBilinearTransform) {
  const LowPass filter = filter_of(20.0);
  const double k = std::tan(kPi * 20.0 * kInterval);
  for (const double frequency : {5.0, 12.5, 40.0, 100.0}) {
    // s in units of the cutoff at this frequency: j tan(pi f T) / K
    const std::complex<double> s(0.0, std::tan(kPi * frequency * kInterval) / k);
    EXPECT_NEAR(gain_at(filter, frequency), 1.0 / std::abs(s * s + std::sqrt(2.0) * s + 1.0), 1e-9)
        << frequency << " Hz";
  }
}

TEST(LowPass, OfAStepOvershootsByFourPercentAndEndsAtIt) {
  const LowPass filter = filter_of(5.0);
  LowPassState<double> state{};
  double most = 0.0, last = 0.0;
  for (int n = 0; n < 1000; ++n) most = std::fmax(most, last = filter.filtered(1.0, state));
  // exp(-pi) for damping sqrt(1/2), minus the error of sampling at 1 % of the period.
  EXPECT_NEAR(most, 1.0 + std::exp(-kPi), 1e-3);
  EXPECT_NEAR(last, 1.0, 1e-12);
}

TEST(LowPass, IsLinearAndHasNoMemoryOfZero) {
  const LowPass filter = filter_of(30.0);
  LowPassState<double> zero{}, a{}, b{}, sum{};
  for (int n = 0; n < 50; ++n) {
    const double x = std::sin(0.7 * n), y = n % 7;
    EXPECT_EQ(filter.filtered(0.0, zero), 0.0);
    const double both = filter.filtered(x, a) + filter.filtered(y, b);
    EXPECT_NEAR(filter.filtered(x + y, sum), both, 1e-14);
  }
}

TEST(LowPass, ThatIsTooQuickForItsSamplesIsRefused) {
  LowPass filter;
  try {
    filter.configure("cutoff", 300.0, kInterval);
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), HasSubstr("`cutoff` 300 Hz is too high for 0.002 s between two samples: "
                                    "at most 225 Hz, or a shorter `period`"));
  }
}

}  // namespace
}  // namespace skybody::control
