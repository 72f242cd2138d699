// Bouncing bodies keep their energy without dissipation and friction.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/unit/physics/contact_worlds.h"

namespace skybody::test {
namespace {

class Lossless : public testing::TestWithParam<double> {};

/// 64 boxes, thrown, over 10 s of bounces. The error of an impact is of second order in a part's
/// share of the spring's period: (1/16)^2 / 24 = 0.016 % of the spring's energy, of either sign.
/// Some tens of impacts add up as a random walk: 0.1 % is about 5 standard deviations of a box,
/// 0.015 % is as many of the mean.
TEST_P(Lossless, TumblingBoxesKeepTheirEnergy) {
  constexpr int kGroups = 2;
  constexpr double kSeconds = 10.0;
  double sum = 0.0;
  for (std::uint64_t k = 0; k < kGroups; ++k) {
    Random<double> random{RandomKey{2026, 92}, k, 0, derive_stream("contact_lossless_test")};
    const auto size = [&] { return random.uniform(0.05, 0.4); };
    const Shape box = make_box(size(), size(), size());
    Scenario scenario = world_of(solid(random.uniform(0.1, 3.0), box), GetParam());
    scenario.constants[kDissipation] = scenario.constants[kFriction] = 0.0;
    LaneTries tries(scenario);
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      LaneState state = tries.nominal;
      state.q[2] = random.uniform(0.4, 0.8);
      store(random.quaternion(), state.q.data() + 3);
      store(in_cube(random, 2.0), state.u.data());
      store(in_cube(random, 5.0), state.u.data() + 3);
      tries.set(lane, state);
    }
    tries.begin();
    std::vector<double> before, after;
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      before.push_back(energy_of(tries.body(lane), tries.world));
    }
    after = before;
    for (int i = 0; i * GetParam() < kSeconds; ++i) {
      ASSERT_TRUE(tries.advance());
      for (int lane = 0; lane < kGroupLanes; ++lane) {  // no spring holds energy
        const auto place = static_cast<std::size_t>(lane);
        if (!tries.was_near(lane)) after[place] = energy_of(tries.body(lane), tries.world);
      }
    }
    for (int lane = 0; lane < kGroupLanes; ++lane) {
      const auto place = static_cast<std::size_t>(lane);
      const double change = after[place] / before[place] - 1.0;
      sum += change;
      EXPECT_LT(std::fabs(change), 0.001) << "world " << k << " lane " << lane;
    }
  }
  EXPECT_LT(std::fabs(sum) / (kGroups * kGroupLanes), 0.00015);
}

INSTANTIATE_TEST_SUITE_P(Steps, Lossless, testing::Values(2.5e-4, 1e-3, 2e-3, 4e-3));

}  // namespace
}  // namespace skybody::test
