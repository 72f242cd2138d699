// Save, restore, fork and hash over shipped scenarios, including sensors, drawn values and keys.
#include "core/simulation/simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/base/math/random.h"
#include "core/base/system/error.h"
#include "core/policy/hold/hold_policy.h"

namespace skybody {
namespace {

/// The actions depend only on the step.
void fly(Simulation& simulation, int steps, std::uint64_t salt = 0) {
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  for (int i = 0; i < steps; ++i) {
    Random<double> rng({99 + salt, 0}, simulation.episode(), simulation.steps(), 1);
    for (float& a : action) a = static_cast<float>(rng.uniform(-0.2, 0.6));
    if (simulation.done()) {
      simulation.reset();
    } else {
      simulation.step(action);
    }
  }
}

class EveryScenario : public testing::TestWithParam<const char*> {
 protected:
  Simulation make(std::uint64_t seed = 5) {
    return Simulation({.scenario = GetParam(), .seed = seed});
  }
};

TEST_P(EveryScenario, RepeatsBitForBitAndSeedsDiffer) {
  Simulation a = make(), b = make(), c = make(6);
  for (Simulation* s : {&a, &b, &c}) {
    s->reset();
    fly(*s, 300);
  }
  EXPECT_EQ(a.hash(), b.hash());
  EXPECT_NE(a.hash(), c.hash());
}

TEST_P(EveryScenario, RestoringInMidEpisodeGivesTheSameFuture) {
  Simulation a = make();
  a.reset();
  fly(a, 120);
  const Snapshot saved = a.save();
  fly(a, 200);
  a.reset();
  fly(a, 50);
  const std::uint64_t future = a.hash();
  const Snapshot end = a.save();

  a.restore(saved);
  fly(a, 200);
  a.reset();
  fly(a, 50);
  EXPECT_EQ(a.hash(), future);
  EXPECT_EQ(a.save().words, end.words);

  Simulation fresh = make(77);  // another seed: restore() must restore the key too
  fresh.restore(saved);
  fly(fresh, 200);
  fresh.reset();
  fly(fresh, 50);
  EXPECT_EQ(fresh.hash(), future);
}

TEST_P(EveryScenario, AForkHasTheSameFutureAndARekeyedOneItsOwn) {
  Simulation a = make();
  a.reset();
  fly(a, 40);
  Simulation same = a.fork();
  Simulation own = a.fork(true), other = a.fork(true);
  for (Simulation* s : {&a, &same, &own, &other}) {
    s->reset();
    fly(*s, 60);
  }
  // The parent's state counts its rekeyed forks, so compare the episodes' observations.
  const auto observed = [](const Simulation& s) {
    return std::vector<float>(s.observation().begin(), s.observation().end());
  };
  EXPECT_EQ(observed(a), observed(same));
  EXPECT_NE(observed(own), observed(a));
  EXPECT_NE(observed(own), observed(other));
}

INSTANTIATE_TEST_SUITE_P(Shipped, EveryScenario,
                         testing::Values("hover", "payload", "formation", "formation_2",
                                         "formation_20", "boom", "hard_landing",
                                         "cooperative_payload", "formation_obstacles", "forest",
                                         "gates", "platform_landing", "landing", "racing_duel",
                                         "racing_drawn", "four_bar", "windy_hover", "downwash_pair",
                                         "low_battery", "rotor_out", "arm", "payload_paper",
                                         "vehicles", "omav"));

TEST(Simulation, RefusesASnapshotOfAnotherScenario) {
  Simulation hover({.scenario = "hover"});
  Simulation payload({.scenario = "payload"});
  hover.reset();
  EXPECT_THROW(payload.restore(hover.save()), Error);
}

TEST(Simulation, RefusesAnActionOfAnotherSizeAndAStepBeforeAReset) {
  Simulation hover({.scenario = "hover"});
  const std::vector<float> four(4), five(5);
  EXPECT_THROW(hover.step(four), Error);
  hover.reset();
  EXPECT_THROW(hover.step(five), Error);
}

TEST(Simulation, AWrenchOnTheBodyStartsInBalanceWithTheRotorsOfTheStart) {
  Simulation hover(
      {.scenario = "hover",
       .overrides = {"robots[0].controllers=[{plugin: ctbt, parameters: {apply: body}}]"}});
  hover.reset();
  for (const double speed : hover.rotor_speeds())
    EXPECT_EQ(speed, 0.0);  // idle: the wrench acts on the body
  const std::vector<float> level = {0.0f, 0.0f, 0.0f, 0.0f};
  const double before = hover.bodies()[0].velocity.z;
  hover.step(level);
  // The lag starts at hover thrust, and one millisecond towards another thrust changes little: far
  // less than the 9.81 mm/s of a free fall.
  EXPECT_LT(std::abs(hover.bodies()[0].velocity.z - before), 0.002);
  for (int i = 0; i < 50; ++i) hover.step(level);
  for (const double speed : hover.rotor_speeds()) EXPECT_EQ(speed, 0.0);
}

TEST(Simulation, RandomizingInMidFlightChangesParametersAndNotTheMotion) {
  Simulation payload({.scenario = "payload", .seed = 2});
  payload.reset();
  fly(payload, 5);
  const auto params = payload.params();
  const BodyState before = payload.bodies()[0];
  payload.randomize();
  EXPECT_NE(payload.params(), params);
  EXPECT_EQ(payload.bodies()[0].position.x, before.position.x);
  EXPECT_EQ(payload.bodies()[0].velocity.z, before.velocity.z);
}

TEST(Simulation, ParametersAreReadSetAndHeldToTheirBounds) {
  Simulation hover({.scenario = "hover"});
  hover.reset();
  const std::string path = hover.compiled().layout().param_info[0].path;
  hover.set_param(path, 1.0);
  EXPECT_EQ(hover.param(path), 1.0);
  EXPECT_THROW(hover.set_param(path, -1.0), Error);
  EXPECT_THROW(hover.param("robots.nobody.mass"), Error);
}

}  // namespace
}  // namespace skybody
