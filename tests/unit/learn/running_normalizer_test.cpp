// Running normalization: moments of earlier rows only.
#include "learn/common/running_normalizer.h"

#include <gtest/gtest.h>

#include <vector>

namespace skybody::learn {
namespace {

TEST(RunningNormalizer, HasTheMomentsOfTheRowsBeforeTheLastUpdate) {
  RunningNormalizer normalizer(1, 10.0);
  std::vector<float> rows = {2.0f, 6.0f};
  normalizer.apply(rows.data(), 2, 1, true);
  EXPECT_FLOAT_EQ(rows[1], 6.0f) << "no rows before: mean 0, variance 1";
  normalizer.update();
  EXPECT_NEAR(normalizer.moments().mean[0], 4.0, 1e-12);
  EXPECT_NEAR(normalizer.moments().variance[0], 4.0, 1e-12);
  rows = {2.0f, 6.0f};
  normalizer.apply(rows.data(), 2, 1, false);
  EXPECT_NEAR(rows[0], -1.0f, 1e-6);
  EXPECT_NEAR(rows[1], 1.0f, 1e-6);
}

TEST(RunningNormalizer, LeavesOutRowsThatDoNotCount) {
  RunningNormalizer normalizer(1);
  std::vector<float> rows = {100.0f};
  normalizer.apply(rows.data(), 1, 1, false);
  normalizer.update();
  EXPECT_EQ(normalizer.moments().count, 0.0);
  EXPECT_FLOAT_EQ(rows[0], 10.0f) << "the bound";
}

TEST(MomentsOf, ValuesAreThoseOfTheirColumn) {
  const std::vector<float> values = {1.0f, 2.0f, 6.0f};
  const RunningMoments moments = moments_of(values);
  EXPECT_NEAR(moments.mean[0], 3.0, 1e-12);
  EXPECT_NEAR(moments.variance[0], 14.0 / 3.0, 1e-12);
}

}  // namespace
}  // namespace skybody::learn
