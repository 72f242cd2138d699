// Derivatives of plugins as authors write them: with counters in their state, and with process().
#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
constexpr const char kController[] = "tests/plugins/good/lane_controller";
constexpr const char kTask[] = "tests/plugins/good/lane_task";

TEST(PluginDerivatives, GoThroughAStateThatHasCounters) {
  PluginWorld world;
  world.add_quad("quad");
  const std::set<int> calls{4};
  expect_derivatives({kController, world, {}, Call::kControl, calls}, {"input", "params", "state"});
  expect_derivatives({kController, world, {}, Call::kReset, calls}, {"rotor_speed"});
}

TEST(PluginDerivatives, CountersCountOnDualNumbersAndHaveNoTangent) {
  PluginWorld world;
  world.add_quad("quad");
  const Instance controller(kController, world);
  const Group plain = controller.group(SKYBODY_GROUP_LANES);
  const std::size_t lanes = SKYBODY_GROUP_LANES, calls = 4;
  Group dual = with_tangents(plain, zeros(plain));
  dual.state[(2 * calls + 1) * lanes] = 99;
  for (int i = 0; i < 3; ++i) {
    controller.call(Call::kControl, dual, 0xffffffffu, 0, SKYBODY_NUMBER_DUAL);
  }
  EXPECT_EQ(dual.state[2 * calls * lanes], 3u);
  EXPECT_EQ(dual.state[(2 * calls + 1) * lanes], 99u);  // neither read nor written
}

TEST(PluginDerivatives, GoThroughProcessAndEvaluate) {
  PluginWorld world;
  world.add_quad("quad");
  expect_derivatives({kTask, world, {}, Call::kProcess, {}}, {"action", "command", "state"});
  expect_derivatives({kTask, world, {}, Call::kEvaluate, {}}, {"action", "bodies", "state"});
}

}  // namespace
}  // namespace skybody::testing
