// Every plugin's kernels give the same bits on each instruction set, in lanes and one by one;
// inactive lanes keep all values.
#include <gtest/gtest.h>

#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

constexpr int kSteps = 7;
constexpr std::uint32_t kLanes = SKYBODY_GROUP_LANES;

class SameBits : public testing::TestWithParam<std::pair<SkybodyKind, std::string>> {
 protected:
  SameBits() : registry_({test::good_plugins()}) {}
  PluginRegistry registry_;
};

TEST_P(SameBits, AcrossInstructionSetsLanesAndMasks) {
  const auto [kind, name] = GetParam();
  const PluginEntry* entry = registry_.find(kind, name);
  ASSERT_NE(entry, nullptr);
  ASSERT_EQ(entry->failure, "");
  test::SmallWorld world(*entry);
  const auto self = world.create();
  const int state = static_cast<int>(entry->descriptor->state_words);
  const int buffer = world.declared.buffer_words;

  std::vector<std::vector<std::uint64_t>> expected, kept;
  for (std::uint32_t e = 0; e < kLanes; ++e) {
    test::Group one(1, e, 1, state, buffer);
    const std::vector<std::uint64_t> one_before = one.lane(0);
    kept.push_back(one.kept(0, kind == SKYBODY_SENSOR));
    one.run(kernels_for(*entry->descriptor, kIsas[0]), self.get(), kSteps);
    expected.push_back(one.lane(0));
    EXPECT_NE(expected[e], one_before);
  }
  EXPECT_NE(expected[0], expected[1]);

  for (const Isa isa : kIsas) {
    if (!machine_has(isa)) continue;
    const SkybodyKernels& kernels = kernels_for(*entry->descriptor, isa);
    for (const std::uint32_t active :
         {0xffffffffu, 0x00ff00a5u, 0x00000001u, 0x80000000u, 0xff0f0f00u, 0u}) {
      test::Group all(kLanes, 0, active, state, buffer);
      all.run(kernels, self.get(), kSteps);
      for (std::uint32_t e = 0; e < kLanes; ++e) {
        const bool served = (active >> e & 1u) != 0;
        // In inactive lanes, outputs of controllers and tasks are scratch memory.
        EXPECT_EQ(served ? all.lane(e) : all.kept(e, kind == SKYBODY_SENSOR),
                  served ? expected[e] : kept[e])
            << skybody::name(isa) << ", lanes " << active << ", environment " << e;
      }
    }
    for (std::uint32_t e = 0; e < kLanes; ++e) {
      test::Group one(1, e, 1, state, buffer);
      one.run(kernels, self.get(), kSteps);
      EXPECT_EQ(one.lane(0), expected[e]) << skybody::name(isa) << ", environment " << e;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Plugins, SameBits,
    testing::Values(std::pair{SKYBODY_CONTROLLER, std::string("plain_controller")},
                    std::pair{SKYBODY_CONTROLLER, std::string("lane_controller")},
                    std::pair{SKYBODY_SENSOR, std::string("delay_sensor")},
                    std::pair{SKYBODY_RANDOMIZER, std::string("lane_randomizer")},
                    std::pair{SKYBODY_TASK, std::string("lane_task")}),
    [](const auto& plugin) { return plugin.param.second; });

TEST(SameBits, PlainDoubleAndLaneCodeAgree) {
  const PluginRegistry registry({test::good_plugins()});
  std::vector<std::vector<std::uint64_t>> lanes;
  for (const char* name : {"plain_controller", "lane_controller"}) {
    const PluginEntry* entry = registry.find(SKYBODY_CONTROLLER, name);
    ASSERT_NE(entry, nullptr);
    test::SmallWorld world(*entry);
    const auto self = world.create();
    test::Group group(kLanes, 0, 0xffffffffu, static_cast<int>(entry->descriptor->state_words), 0);
    group.run(kernels_for(*entry->descriptor, best_isa()), self.get(), kSteps);
    for (std::uint32_t e = 0; e < kLanes; ++e) lanes.push_back(group.lane(e));
  }
  for (std::uint32_t e = 0; e < kLanes; ++e) EXPECT_EQ(lanes[e], lanes[kLanes + e]);
}

}  // namespace
}  // namespace skybody
