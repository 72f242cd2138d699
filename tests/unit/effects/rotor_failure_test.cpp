// Rotor failures: time, affected rotors, and remaining performance.
#include <cmath>
#include <set>

#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using Words = std::vector<std::string>;
using ::testing::HasSubstr;

class RotorFailureTest : public ::testing::Test {
 protected:
  RotorFailureTest() { world.add_quad("quad"); }

  /// Held inputs before a physics step, from the engine's neutral values.
  static void step(const Instance& failure, Group& g, std::uint64_t physics_step) {
    g.held = failure.group(1).held;
    g.physics_step[0] = physics_step;
    failure.call(Call::kApply, g);
  }
  /// The start of the episode with this number.
  static Group begin(const Instance& failure, std::uint64_t episode = 1) {
    Group g = failure.group(1);
    g.episode[0] = episode;
    failure.call(Call::kReset, g);
    return g;
  }
  static Numbers limits(const Group& g, int rotor) {
    const double* of = g.held[SKYBODY_HELD_ROTOR_LIMIT].data() + 2 * rotor;
    return {of[0], of[1]};
  }
  PluginWorld world;
  const Numbers free{0.0, kInfinity};
};

TEST_F(RotorFailureTest, GivesTheBitsOfDouble) {
  for (const char* kind : {"off", "stuck", "partial"}) {
    expect_same_bits("rotor_failure", world,
                     {{"kind", kind}, {"earliest", 0.0}, {"latest", 0.008}, {"probability", 0.7}});
  }
  expect_same_bits("rotor_failure", world,
                   {{"kind", "stuck"},
                    {"earliest", 0.003},
                    {"latest", 0.003},
                    {"rotors", Words{"rotor1", "3"}}});
}

TEST_F(RotorFailureTest, OfKindOffBoundsTheSpeedByNothingFromItsTimeOn) {
  const Instance failure("rotor_failure", world,
                         {{"earliest", 0.25}, {"latest", 0.25}, {"rotors", Words{"rotor2"}}});
  Group g = begin(failure);
  for (const std::uint64_t k : {0u, 100u, 249u, 250u, 251u, 9000u}) {
    step(failure, g, k);
    EXPECT_EQ(limits(g, 2), k < 250 ? free : (Numbers{0.0, 0.0})) << k;
    EXPECT_EQ(limits(g, 1), free);
    EXPECT_EQ((Numbers{g.buffer.begin(), g.buffer.begin() + 5}),
              (Numbers{0.25, 0.0, 0.0, k < 250 ? 0.0 : 1.0, 0.0}));
  }
}

TEST_F(RotorFailureTest, ATimeOnTheGridIsMetWhateverItRoundsTo) {
  for (const int steps : {1, 3, 7, 29, 58, 115, 1001}) {
    const double time = steps * 0.001;
    const Instance failure("rotor_failure", world,
                           {{"earliest", time}, {"latest", time}, {"rotors", Words{"0"}}});
    Group g = begin(failure);
    step(failure, g, static_cast<std::uint64_t>(steps - 1));
    EXPECT_EQ(limits(g, 0), free);
    step(failure, g, static_cast<std::uint64_t>(steps));
    EXPECT_EQ(limits(g, 0), (Numbers{0.0, 0.0}));
  }
}

TEST_F(RotorFailureTest, OfKindStuckKeepsTheSpeedOfThatTime) {
  const Instance failure("rotor_failure", world,
                         {{"kind", "stuck"},
                          {"earliest", 0.01},
                          {"latest", 0.01},
                          {"rotors", Words{"rotor0", "rotor3"}}});
  Group g = begin(failure);
  for (std::uint64_t k = 0; k < 30; ++k) {
    for (std::size_t i = 0; i < 4; ++i) {
      g.rotor_speed[i] = 500.0 + 100.0 * static_cast<double>(i) + static_cast<double>(k);
    }
    step(failure, g, k);
    EXPECT_EQ(limits(g, 0), k < 10 ? free : (Numbers{510.0, 510.0}));
    EXPECT_EQ(limits(g, 3), k < 10 ? free : (Numbers{810.0, 810.0}));
    EXPECT_EQ(limits(g, 1), free);
  }
}

TEST_F(RotorFailureTest, OfKindPartialScalesThrustAndMoment) {
  const Instance failure("rotor_failure", world,
                         {{"kind", "partial"},
                          {"earliest", 0.0},
                          {"latest", 0.0},
                          {"rotors", Words{"rotor1"}},
                          {"thrust_gain", 0.6},
                          {"moment_gain", 1.2}});
  Group g = begin(failure);
  step(failure, g, 0);
  Numbers expected(16, 1.0);
  expected[4 + SKYBODY_GAIN_THRUST] = 0.6;
  expected[4 + SKYBODY_GAIN_MOMENT] = 1.2;
  EXPECT_EQ(g.held[SKYBODY_HELD_ROTOR_GAIN], expected);
}

TEST_F(RotorFailureTest, DrawsOneRotorAndATimeUniformly) {
  const Instance failure("rotor_failure", world,
                         {{"earliest", 2.0}, {"latest", 6.0}, {"probability", 0.75}});
  constexpr int kEpisodes = 8000;
  int failures = 0, of_rotor[4] = {};
  double sum = 0.0, least = kInfinity, most = 0.0;
  for (std::uint64_t e = 1; e <= kEpisodes; ++e) {
    Group g = begin(failure, e);
    step(failure, g, 100000);
    const double time = g.buffer[0];
    if (time < 0.0) {
      EXPECT_EQ((Numbers{g.buffer.begin() + 1, g.buffer.begin() + 5}), Numbers(4, 0.0));
      continue;
    }
    ++failures;
    sum += time;
    least = std::min(least, time);
    most = std::max(most, time);
    int failed = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      of_rotor[i] += g.buffer[1 + i] == 1.0 ? 1 : 0;
      failed += g.buffer[1 + i] == 1.0 ? 1 : 0;
      EXPECT_EQ(limits(g, static_cast<int>(i)), g.buffer[1 + i] == 1.0 ? (Numbers{0, 0}) : free);
    }
    EXPECT_EQ(failed, 1);
  }
  // Four standard deviations each: sqrt(n p (1 - p)) of counts, 4 s / sqrt(12 n) of the mean time.
  EXPECT_NEAR(failures, 0.75 * kEpisodes, 4.0 * std::sqrt(kEpisodes * 0.75 * 0.25));
  for (const int count : of_rotor) {
    EXPECT_NEAR(count, failures / 4.0, 4.0 * std::sqrt(failures * 0.25 * 0.75));
  }
  EXPECT_NEAR(sum / failures, 4.0, 4.0 * 4.0 / std::sqrt(12.0 * failures));
  EXPECT_GE(least, 2.0);
  EXPECT_LE(most, 6.0);
}

TEST_F(RotorFailureTest, ProbabilityMayBeDrawn) {
  const Instance failure("rotor_failure", world);
  Group g = failure.group(1);
  g.params[static_cast<std::size_t>(failure.env_param("probability"))] = 0.0;
  failure.call(Call::kReset, g);
  EXPECT_EQ(g.buffer[0], -1.0);
}

TEST_F(RotorFailureTest, DerivativesAreThoseOfItsDifferences) {
  // The harness has already made this step's call, so the speeds at the failure are kept: they and
  // the state depend on themselves, gains on parameters.
  expect_derivatives({"rotor_failure", world, {{"kind", "partial"}}, Call::kApply, {}},
                     {"buffer", "params", "state"});
}

TEST_F(RotorFailureTest, SaysWhatDoesNotFit) {
  const auto refused = [&](const Parameters& given) {
    return refusal("rotor_failure", world, given);
  };
  EXPECT_THAT(refused({{"earliest", 5.0}}),
              HasSubstr("`latest` is 1 s, before `earliest` 5 s: raise it"));
  EXPECT_THAT(
      refused({{"rotors", Words{"rotor9"}}}),
      HasSubstr("`rotors`: no rotor `rotor9`: there are rotor0, rotor1, rotor2, rotor3, or 0 to "
                "3 by their places"));
  EXPECT_THAT(refused({{"rotors", Words{"rotor1", "1"}}}),
              HasSubstr("`rotors` names `1` twice: name each rotor once"));
  world.horizon = 1000;  // steps of 1 ms
  EXPECT_EQ(refused({{"latest", 2.0}}),
            "`latest` is 2 s, but an episode ends after 1 s: let rotors fail before");
  world.horizon = 0;
  world.add_quad("other");
  EXPECT_THAT(refused({}), HasSubstr("several robots: name one of quad, other"));
  world.robots[0].rotor_count = 0;
  EXPECT_THAT(refused({{"robot", "quad"}}),
              HasSubstr("robot `quad` has no rotors that could fail: name another one in `robot`"));
}

}  // namespace
}  // namespace skybody::testing
