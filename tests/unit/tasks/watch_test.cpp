// The task that only observes.
#include "tests/unit/plugin_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

class WatchTask : public ::testing::Test {
 protected:
  WatchTask() {
    world.add_quad("quad", 0, 0, 1.5);
    world.add_payload("bob");
  }
  PluginWorld world;
};

TEST_F(WatchTask, ObservesTheMotionOfALinkAndRewardsNothing) {
  const Instance task("watch", world, {{"link", "bob"}});
  Group g = task.group(1);
  const int body = world.links[1].body;
  for (int k = 0; k < 3; ++k) g.bodies[static_cast<std::size_t>(13 * body + 7 + k)] = 1.0 + k;
  task.call(Call::kEvaluate, g);
  EXPECT_EQ(g.observation[7], 1.0);
  EXPECT_EQ(g.observation[9], 3.0);
  EXPECT_EQ(g.reward[0], 0.0);
  EXPECT_EQ(g.end[0], 0u);
}

TEST_F(WatchTask, GivesTheBitsOfDouble) { expect_same_bits("watch", world, {{"link", "bob"}}); }

TEST_F(WatchTask, BadConfigurationNamesValueAndRemedy) {
  EXPECT_THAT(refusal("watch", world, {{"link", "bobb"}}), HasSubstr("bobb"));
}

}  // namespace
}  // namespace skybody::testing
