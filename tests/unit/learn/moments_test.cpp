#include "learn/network/moments.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"

namespace skybody::learn {
namespace {

/// Two columns: one near 1000 with deviations near 1, one that is constant.
std::vector<float> rows(int count, int first) {
  std::vector<float> values;
  for (int r = first; r < first + count; ++r) {
    values.push_back(static_cast<float>(1000.0 + std::sin(r)));
    values.push_back(-3.0f);
  }
  return values;
}

void merge(Moments& moments, const std::vector<float>& values) {
  MomentSums sums(2);
  sums.begin(moments);
  sums.add(values.data(), 2, values.size() / 2);
  moments.merge(sums);
}

TEST(Moments, AreMeanAndVarianceOfAllRows) {
  Moments moments(2);
  for (int part = 0; part < 10; ++part) merge(moments, rows(100, 100 * part));
  const std::vector<float> all = rows(1000, 0);
  double mean = 0.0, variance = 0.0;
  for (std::size_t r = 0; r < 1000; ++r) mean += static_cast<double>(all[2 * r]) / 1000.0;
  for (std::size_t r = 0; r < 1000; ++r) {
    variance += std::pow(static_cast<double>(all[2 * r]) - mean, 2) / 1000.0;
  }
  EXPECT_EQ(moments.count(), 1000.0);
  // Squares of 1000 are summed once, about zero: 1e6 * 2^-53 of a variance of 1/2.
  EXPECT_NEAR(moments.mean()[0], mean, 1e-10);
  EXPECT_NEAR(moments.variance(0), variance, 1e-9);
  EXPECT_EQ(moments.mean()[1], -3.0);
  EXPECT_EQ(moments.variance(1), 0.0);
}

TEST(Moments, AreTheSameForRowsWithSpaceBetween) {
  Moments dense(2), wide(2);
  merge(dense, rows(7, 0));
  MomentSums sums(2);
  sums.begin(wide);
  std::vector<float> spaced;
  for (int r = 0; r < 7; ++r) {
    for (const float v : rows(1, r)) spaced.push_back(v);
    spaced.push_back(99.0f);
  }
  sums.add(spaced.data(), 3, 7);
  wide.merge(sums);
  EXPECT_EQ(dense.state(), wide.state());
}

TEST(Moments, ScaleByOneBeforeTheFirstRow) {
  Moments moments(2);
  std::vector<double> scales(2);
  moments.scales(1e-8, scales);
  EXPECT_EQ(scales, (std::vector<double>{1.0, 1.0}));
  MomentSums none(2);
  none.begin(moments);
  moments.merge(none);
  EXPECT_EQ(moments.count(), 0.0);
  merge(moments, rows(100, 0));
  moments.scales(1e-8, scales);
  EXPECT_DOUBLE_EQ(scales[0], 1.0 / std::sqrt(moments.variance(0) + 1e-8));
}

TEST(Moments, GoOnFromARestoredState) {
  Moments moments(2), restored(2);
  merge(moments, rows(50, 0));
  restored.restore(moments.state());
  merge(moments, rows(50, 50));
  merge(restored, rows(50, 50));
  EXPECT_EQ(moments.state(), restored.state());
  EXPECT_THROW(restored.restore(std::vector<double>(4)), Error);
}

}  // namespace
}  // namespace skybody::learn
