#include "onboard/latency.h"

#include <gtest/gtest.h>

namespace skybody::onboard {
namespace {

TEST(LatencyHistogram, GivesQuantilesToThreePercentAndTheExactMaximum) {
  LatencyHistogram histogram;
  for (std::int64_t k = 1; k <= 100'000; ++k) histogram.add(10 * k);
  EXPECT_NEAR(static_cast<double>(histogram.quantile(0.5)), 500e3, 0.032 * 500e3);
  EXPECT_NEAR(static_cast<double>(histogram.quantile(0.999)), 999e3, 0.032 * 999e3);
  EXPECT_EQ(histogram.quantile(1.0), 1'000'000);
  EXPECT_EQ(histogram.largest(), 1'000'000);
  EXPECT_EQ(histogram.count(), 100'000u);
}

TEST(LatencyHistogram, CountsWhatIsAboveABound) {
  LatencyHistogram histogram;
  for (const double ms : {1e-5, 0.9, 1.1, 5000.0}) {
    histogram.add(static_cast<std::int64_t>(1e6 * ms));
  }
  EXPECT_EQ(histogram.above(1'000'000), 2u);
  EXPECT_NE(histogram.json().find("\"above_1_ms\": 2"), std::string::npos);
}

TEST(LatencyHistogram, IsZeroWithoutValues) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.quantile(0.99), 0);
  EXPECT_EQ(histogram.above(0), 0u);
}

}  // namespace
}  // namespace skybody::onboard
