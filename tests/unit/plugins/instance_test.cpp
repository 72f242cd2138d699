// Instances: declarations, refusals, and the lifetime of their library.
#include "core/plugin_host/instance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <xmmintrin.h>

#include "tests/unit/plugins/small_world.h"

namespace skybody {
namespace {

using testing::ElementsAre;

class Instance : public testing::Test {
 protected:
  const PluginEntry& entry(SkybodyKind kind, const char* name) {
    const PluginEntry* found = registry_->find(kind, name);
    if (found == nullptr) throw std::runtime_error(std::string("no plugin ") + name);
    return *found;
  }
  std::string refusal(const char* name) {
    test::SmallWorld world(entry(SKYBODY_CONTROLLER, name));
    try {
      world.create();
    } catch (const PluginConfigureError& e) {
      EXPECT_EQ(e.plugin(), name);
      return e.what();
    }
    return "was accepted";
  }
  std::unique_ptr<PluginRegistry> registry_ =
      std::make_unique<PluginRegistry>(std::vector{test::good_plugins()});
};

TEST_F(Instance, DeclaresWhatItTakesAndGives) {
  test::SmallWorld controller(entry(SKYBODY_CONTROLLER, "lane_controller"));
  controller.create();
  EXPECT_THAT(controller.declared.lines,
              ElementsAre("input 0 x 4 0.000000..1000.000000", "output 0 x 4"));
  test::SmallWorld sensor(entry(SKYBODY_SENSOR, "delay_sensor"));
  sensor.create();
  EXPECT_THAT(sensor.declared.lines,
              ElementsAre("period 2", "channel height x 1", "channel curve x 1"));
  EXPECT_EQ(sensor.declared.buffer_words, 4);
  test::SmallWorld randomizer(entry(SKYBODY_RANDOMIZER, "lane_randomizer"));
  randomizer.create();
  EXPECT_THAT(randomizer.declared.lines, ElementsAre("writes 0"));
  test::SmallWorld task(entry(SKYBODY_TASK, "lane_task"));
  task.create();
  EXPECT_THAT(task.declared.lines,
              ElementsAre("channel error x 3", "channel action x 1", "goal 0 0"));
}

TEST_F(Instance, RefusesInItsOwnWords) {
  EXPECT_EQ(refusal("throws_error"), "needs 6 rotors, robot `quad` has 4");
  EXPECT_EQ(refusal("throws_int"), "threw something that is no std::exception");
}

TEST_F(Instance, OfAnUnusablePluginThrows) {
  const PluginRegistry broken({test::bad_plugins()});
  const PluginEntry* entry = broken.find(SKYBODY_CONTROLLER, "wrong_version");
  test::SmallWorld world(*entry);
  EXPECT_THROW(world.create(), PluginLoadError);
}

TEST_F(Instance, KeepsItsLibraryLoaded) {
  test::SmallWorld world(entry(SKYBODY_CONTROLLER, "lane_controller"));
  PluginEntry copy = entry(SKYBODY_CONTROLLER, "lane_controller");
  const SkybodyKernels kernels = kernels_for(*copy.descriptor, kIsas[0]);
  std::weak_ptr<PluginLibrary> library = copy.library;
  auto self = world.create();
  // Only the instance still holds the library.
  const int state_words = static_cast<int>(copy.descriptor->state_words);
  copy.library.reset();
  registry_.reset();
  EXPECT_FALSE(library.expired());
  test::Group group(SKYBODY_GROUP_LANES, 0, 0xff, state_words, 0);
  group.run(kernels, self.get(), 1);
  self.reset();
  EXPECT_TRUE(library.expired());
}

TEST_F(Instance, LeavesTheCallersFloatingPointModeAlone) {
  const unsigned before = _mm_getcsr();
  _mm_setcsr(before | 0x8000u);  // flush to zero
  test::SmallWorld world(entry(SKYBODY_CONTROLLER, "lane_controller"));
  world.create();
  EXPECT_EQ(_mm_getcsr() & 0x8000u, 0x8000u);
  _mm_setcsr(before);
}

}  // namespace
}  // namespace skybody
