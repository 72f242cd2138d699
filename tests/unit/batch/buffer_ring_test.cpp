// Lifetime of the values in the rows of a recv().
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/batch/small_env.h"

namespace skybody {
namespace {

using test::actions_of;
using test::begin;
using test::small_env;

std::shared_ptr<const Batch> step(Pool& envs, int k) {
  std::vector<std::int32_t> all(static_cast<std::size_t>(envs.envs()));
  for (std::size_t e = 0; e < all.size(); ++e) all[e] = static_cast<std::int32_t>(e);
  envs.send(actions_of(all, k, 4));
  return envs.recv();
}

class Buffers : public testing::TestWithParam<int> {  // N_B of 2 environments
 protected:
  Pool make(bool debug) {
    return Pool(small_env(),
                {.envs = 2, .batch = GetParam(), .threads = 2, .debug_buffers = debug});
  }
  /// Sends all actions, returns the first batch and waits for the others.
  static std::shared_ptr<const Batch> first_of(Pool& envs, int k) {
    auto batch = step(envs, k);
    while (envs.in_flight() > 0) envs.recv();
    return batch;
  }
};

TEST_P(Buffers, KeepTheirValuesUntilTheSecondNextRecv) {
  for (const bool debug : {false, true}) {
    Pool envs = make(debug);
    begin(envs);
    std::vector<const float*> rows;
    std::vector<float> heights;
    for (int k = 1, received = 0; k < 30; ++k) {
      const std::vector<std::int32_t> both = {0, 1};
      envs.send(actions_of(both, k, 4));
      while (envs.in_flight() > 0) {
        const auto batch = envs.recv();
        rows.push_back(batch->observation.data());
        heights.push_back(batch->observation[0]);
        ++received;
        if (received < 2) continue;
        const auto before = static_cast<std::size_t>(received - 2);
        ASSERT_EQ(*rows[before], heights[before]);
      }
    }
    EXPECT_EQ(envs.fresh_buffers(), 0u);
  }
}

TEST_P(Buffers, StayAsTheyAreForAsLongAsTheyAreHeld) {
  Pool envs = make(false);
  begin(envs);
  const auto held = first_of(envs, 1);
  const Column<float> before = held->observation;
  for (int k = 2; k < 20; ++k)
    step(envs, k), [&] {
      while (envs.in_flight() > 0) envs.recv();
    }();
  EXPECT_EQ(held->observation, before);
  EXPECT_EQ(envs.fresh_buffers(), 1u);  // it was replaced only once
}

TEST_P(Buffers, HeldTooLongAreAnErrorInDebugModeAndNothingIsLost) {
  Pool envs = make(true);
  begin(envs);
  auto held = first_of(envs, 1);
  const auto on = [&] {
    for (int k = 2; k < 6; ++k) first_of(envs, k);
  };
  EXPECT_THROW(on(), BufferInUse);
  held.reset();
  while (envs.in_flight() > 0) EXPECT_NE(envs.recv(), nullptr);
  EXPECT_NO_THROW(on());
  EXPECT_EQ(envs.fresh_buffers(), 0u);
}

TEST_P(Buffers, AreFilledWithNanBeforeTheyAreUsedAgainInDebugMode) {
  Pool envs = make(true);
  begin(envs);
  const auto held = first_of(envs, 1);
  const float* row = held->observation.data() + 3 * (GetParam() - 1);  // a row that will be unused
  const_cast<std::shared_ptr<const Batch>&>(held).reset();
  const std::vector<std::int32_t> one = {0};
  for (int k = 2; k < 6; ++k) {  // batches of one row: the second row of a buffer of two stays NaN
    envs.send(actions_of(one, k, 4), one);
    const auto batch = envs.recv();
    ASSERT_EQ(batch->rows, 1);
    if (GetParam() == 2 && batch->observation.data() + 3 == row) {
      EXPECT_TRUE(std::isnan(*row));
      return;
    }
    EXPECT_FALSE(std::isnan(batch->observation[0]));
  }
  EXPECT_EQ(GetParam(), 1) << "the buffer never came round";
}

TEST(Reseeding, RefusedByABufferThatIsHeldChangesNothing) {
  Pool envs(small_env(), {.envs = 2, .threads = 2, .seed = 4, .debug_buffers = true});
  begin(envs);
  auto held = step(envs, 1);
  const auto on = [&] {
    for (int k = 2; k < 6; ++k) step(envs, k);
  };
  EXPECT_THROW(on(), BufferInUse);
  const auto saved = envs.save();
  EXPECT_THROW(envs.send_reset(9), BufferInUse);
  EXPECT_EQ(envs.save(), saved);
  EXPECT_EQ(envs.options().seed, 4u);
  held.reset();
  EXPECT_NO_THROW(on());
}

INSTANTIATE_TEST_SUITE_P(Batches, Buffers, testing::Values(2, 1));

}  // namespace
}  // namespace skybody
