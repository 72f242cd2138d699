// Ropes in whole environments: saving and restoring, and ropes suspended from a driven base.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/system/error.h"
#include "core/simulation/simulation.h"

namespace skybody {
namespace {

using testing::HasSubstr;

/// Three robots carry a plate on ropes, which become slack and taut.
TEST(Ropes, HaveTheSameBitsWhereEveryStepIsSavedAndRestored) {
  std::vector<std::string> overrides;
  for (const char* rope : {"alpha_rod", "bravo_rod", "charlie_rod"}) {
    overrides.push_back("couplings." + std::string(rope) + ".kind=rope");
    overrides.push_back("couplings." + std::string(rope) + ".length=1.1");  // slack at first
  }
  const SimulationOptions options{
      .scenario = "cooperative_payload", .overrides = overrides, .seed = 5};
  Simulation straight(options), restored(options);
  straight.reset();
  restored.reset();
  std::vector<float> action(static_cast<std::size_t>(straight.action_size()));
  int slack = 0, taut = 0;
  for (int k = 0; k < 80; ++k) {
    for (std::size_t i = 0; i < action.size(); ++i) {
      action[i] = (k / 10 + static_cast<int>(i) / 4) % 2 == 0 ? 0.6f : -0.6f;
    }
    restored.restore(restored.save());
    straight.step(action);
    restored.step(action);
    ASSERT_FALSE(straight.fault());
    ASSERT_EQ(straight.hash(), restored.hash()) << k;
    const std::vector<double> pull = straight.state("couplings.alpha_rod.force");
    (pull == std::vector<double>{0.0, 0.0, 0.0} ? slack : taut) += 1;
  }
  EXPECT_GT(slack, 0);
  EXPECT_GT(taut, 0);
}

const std::string kLanding = "platform_landing";

/// The pad follows its path bit for bit, regardless of a rope's impacts and loads.
TEST(Ropes, DoNotMoveADrivenBase) {
  const std::string rope =
      "couplings=[{name: leash, kind: rope, length: 1.6, ends: [{robot: quad}, {robot: pad}]}]";
  const std::string turning =
      "robots.pad.controllers=[{plugin: rail, parameters: {times: [0, 1, 2], positions: [0, 0, 0, "
      "0.3, 0, -0.4, -0.2, 0.1, 0.1], rpy: [0, 0, 0, 0.3, 0.1, 0.5, 0, 0.2, 0]}}]";
  Simulation free({.scenario = kLanding, .overrides = {turning, "randomization=[]"}});
  Simulation held({.scenario = kLanding, .overrides = {turning, "randomization=[]", rope}});
  free.reset();
  held.reset();
  const std::vector<float> action(static_cast<std::size_t>(free.action_size()), 0.3f);
  bool is_taut = false;
  for (int k = 0; k < 180; ++k) {
    free.step(action);
    held.step(action);
    ASSERT_FALSE(held.fault()) << k;
    ASSERT_EQ(free.state("robots.pad.base.position"), held.state("robots.pad.base.position")) << k;
    ASSERT_EQ(free.state("robots.pad.base.rotation"), held.state("robots.pad.base.rotation")) << k;
    is_taut |= held.state("couplings.leash.force")[2] != 0.0;
  }
  EXPECT_TRUE(is_taut);
}

TEST(Couplings, OfTwoDrivenBasesAreRefusedWhereTheyAreWritten) {
  const std::string rod =
      "couplings=[{name: bar, kind: rod, ends: [{robot: pad}, {point: [0, 0, 3]}]}]";
  try {
    Simulation simulation({.scenario = kLanding, .overrides = {rod}});
    FAIL() << "a rod between a driven pad and the world";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("the ends of `bar` are of the base of `pad`, which a "
                                        "controller drives, and of the world"));
  }
}

}  // namespace
}  // namespace skybody
