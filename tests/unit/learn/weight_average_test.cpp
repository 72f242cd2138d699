#include "learn/network/weight_average.h"

#include <gtest/gtest.h>

#include <cmath>

#include "learn/common/state_blocks.h"

namespace skybody::learn {
namespace {

constexpr std::size_t kWeights = 3;

std::vector<float> weights_at(int update) {
  const auto t = static_cast<float>(update);
  return {t, 2.0f - t, std::sin(t)};
}

TEST(WeightAverage, IsThePlainMeanUntilItsWindowIsFull) {
  WeightAverage average(kWeights, 100.0);
  for (int t = 0; t < 5; ++t) average.add(weights_at(t), 10.0);
  const std::vector<float> mean = average.of(weights_at(9));
  EXPECT_FLOAT_EQ(mean[0], 2.0f);
  EXPECT_FLOAT_EQ(mean[1], 0.0f);
}

/// For weights that rise by 1 per update, an exponential mean with share s lags by (1 - s) / s.
TEST(WeightAverage, LagsBehindByItsWindow) {
  WeightAverage average(kWeights, 100.0);
  for (int t = 0; t < 400; ++t) average.add(weights_at(t), 20.0);
  EXPECT_NEAR(average.of(weights_at(0))[0], 399.0f - 4.0f, 1e-4);
}

TEST(WeightAverage, IsTheWeightsThemselvesWithoutAWindowOrAnUpdate) {
  WeightAverage none(kWeights, 0.0), fresh(kWeights, 50.0);
  none.add(weights_at(1), 10.0);
  EXPECT_EQ(none.of(weights_at(2)), weights_at(2));
  EXPECT_EQ(fresh.of(weights_at(2)), weights_at(2));
}

TEST(WeightAverage, GoesOnFromItsStateWithTheSameBits) {
  WeightAverage whole(kWeights, 60.0), resumed(kWeights, 60.0);
  for (int t = 0; t < 3; ++t) whole.add(weights_at(t), 10.0);
  StateBlocks blocks;
  StateWriter writer(blocks);
  WeightAverage::visit(std::as_const(whole), "average", writer);
  StateReader reader(blocks, StateReader::Mode::kCopy);
  WeightAverage::visit(resumed, "average", reader);
  for (WeightAverage* average : {&whole, &resumed}) average->add(weights_at(7), 10.0);
  EXPECT_EQ(whole.of(weights_at(0)), resumed.of(weights_at(0)));
}

}  // namespace
}  // namespace skybody::learn
