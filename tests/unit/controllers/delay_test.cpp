// A delay outputs the command of a number of steps ago, independently of the other lanes.
#include <algorithm>
#include <cmath>
#include <map>

#include "tests/unit/dual_harness.h"

namespace skybody::testing {
namespace {

using Call = Instance::Call;
using Numbers = std::vector<double>;
using ::testing::HasSubstr;

class DelayTest : public ::testing::Test {
 protected:
  DelayTest() { world.add_quad("quad"); }

  static Parameters given(double latency, const Parameters& others = {}) {
    Parameters all = others;
    all.insert({{"signal", "ctbr"}, {"latency", latency}});
    return all;
  }
  /// The output in the next physics step, for the commands k, k + 0.25, ...
  static Numbers step(const Instance& delay, Group& g, int k) {
    for (int i = 0; i < 4; ++i) g.at(g.input, i) = k + 0.25 * i;
    delay.call(Call::kControl, g);
    ++g.physics_step[0];
    return g.output;
  }
  static double latency_of(const Instance& delay, std::uint64_t episode) {
    Group g = delay.group(1);
    g.episode[0] = episode;
    int k = 0;
    while (step(delay, g, k)[0] == 0.0) ++k;
    return k - 1;  // the command of step 1 is the first that differs
  }
  PluginWorld world;
};

TEST_F(DelayTest, GivesTheBitsOfDouble) {
  expect_same_bits("delay", world, given(0.003));
  expect_same_bits("delay", world, given(0.004, {{"jitter", 0.003}}));
  expect_same_bits("delay", world, given(0.004, {{"jitter", 0.004}, {"draw", "action"}}));
}

TEST_F(DelayTest, ShiftsCommandsByWholePhysicsSteps) {
  for (const int steps : {0, 1, 7, 40}) {
    const Instance delay("delay", world, given(0.001 * steps));
    Group g = delay.group(1);
    for (int k = 0; k < 200; ++k) {
      const double first = std::max(k - steps, 0);  // until then the first command
      EXPECT_EQ(step(delay, g, k), (Numbers{first, first + 0.25, first + 0.5, first + 0.75}));
    }
  }
}

TEST_F(DelayTest, RoundsToTheNearestStep) {
  for (const auto& [latency, steps] :
       std::map<double, double>{{0.0034, 3.0}, {0.0036, 4.0}, {0.02, 20.0}, {0.0004, 0.0}}) {
    EXPECT_EQ(latency_of(Instance("delay", world, given(latency)), 1), steps);
  }
}

TEST_F(DelayTest, JitterIsUniformBetweenItsBounds) {
  const Instance delay("delay", world, given(0.01, {{"jitter", 0.004}}));
  std::map<double, int> counts;
  constexpr int kEpisodes = 4000;
  for (std::uint64_t e = 1; e <= kEpisodes; ++e) ++counts[latency_of(delay, e)];
  ASSERT_EQ(counts.begin()->first, 6.0);
  ASSERT_EQ(counts.rbegin()->first, 14.0);
  for (const auto& [steps, count] : counts) {
    const double share =
        steps == 6.0 || steps == 14.0 ? 1.0 / 16.0 : 1.0 / 8.0;  // at the ends: half a step
    EXPECT_NEAR(count, share * kEpisodes, 4.0 * std::sqrt(share * (1 - share) * kEpisodes))
        << steps;
  }
}

TEST_F(DelayTest, DrawnPerActionChangesBetweenActionsAndNeverGoesBack) {
  const Instance delay("delay", world, given(0.005, {{"jitter", 0.005}, {"draw", "action"}}));
  Group g = delay.group(1);
  std::map<int, int> ages;
  double before = 0.0;
  for (int k = 0; k < 20000; ++k) {
    g.step[0] = static_cast<std::uint64_t>(k / 20);
    const double command = step(delay, g, k)[0];
    EXPECT_GE(command, before);  // the latest that has arrived; an overtaken command never returns
    before = command;
    if (k % 20 == 19) ++ages[k - static_cast<int>(command)];
  }
  EXPECT_EQ(ages.begin()->first, 0);
  EXPECT_EQ(ages.rbegin()->first, 10);
  EXPECT_NEAR(ages[5], 100, 40);  // 1000 actions, a tenth each: four standard deviations of 9.5
}

TEST_F(DelayTest, DrawnPerEpisodeStaysForTheEpisode) {
  const Instance delay("delay", world, given(0.005, {{"jitter", 0.005}}));
  Group g = delay.group(1);
  const double latency = latency_of(delay, 1);
  for (int k = 0; k < 500; ++k) {
    g.step[0] = static_cast<std::uint64_t>(k / 4);
    EXPECT_EQ(step(delay, g, k)[0], std::max(k - latency, 0.0));
  }
}

TEST_F(DelayTest, ReportsTheLatencyThatItHasDrawn) {
  const Instance delay("delay", world, given(0.01, {{"jitter", 0.004}}));
  ASSERT_EQ(delay.declared.reports.size(), 1u);
  const Report& report = delay.declared.reports[0];
  EXPECT_EQ(report.info.name, "latency");
  EXPECT_EQ(report.info.unit, "s");
  for (std::uint64_t episode = 1; episode <= 20; ++episode) {
    Group g = delay.group(1);
    g.episode[0] = episode;
    const Numbers& words = g.buffer;
    step(delay, g, 0);
    const double reported = words[static_cast<std::size_t>(report.word)];
    EXPECT_EQ(reported, 0.001 * latency_of(delay, episode));
  }
}

TEST_F(DelayTest, GoesOnFromItsStateWords) {
  const Instance delay("delay", world, given(0.006, {{"jitter", 0.003}, {"draw", "action"}}));
  Group g = delay.group(1);
  for (int k = 0; k < 57; ++k) step(delay, g, k);
  Group saved = g;
  Numbers once, again;
  for (int k = 57; k < 90; ++k) once.push_back(step(delay, g, k)[0]);
  for (int k = 57; k < 90; ++k) again.push_back(step(delay, saved, k)[0]);
  EXPECT_EQ(once, again);
}

TEST_F(DelayTest, StaysInItsRingWhateverWordsItsStateHas) {
  const Instance delay("delay", world, given(0.006));  // 7 slots of 4 values
  const std::vector<std::uint64_t> words{0, 1, 6, 7, 8, 1ull << 32, 1ull << 63, ~0ull};
  for (const std::uint64_t steps : words) {
    for (const std::uint64_t place : words) {
      for (const std::uint64_t age : words) {
        Group g = delay.group(1);
        std::fill(g.buffer.begin(), g.buffer.end(), 1.0);
        std::fill(g.input.begin(), g.input.end(), 2.0);
        g.state = {1, 0, steps, place, age};
        delay.call(Call::kControl, g);
        EXPECT_EQ(std::count(g.buffer.begin(), g.buffer.end(), 2.0), 4);
        EXPECT_TRUE(g.output == Numbers(4, 1.0) || g.output == Numbers(4, 2.0));
      }
    }
  }
}

TEST_F(DelayTest, TakesTheSizeOfItsSignal) {
  const std::map<std::string, int> sizes{{"rotor_speed", 4}, {"throttle", 4}, {"srt", 4},
                                         {"attitude", 5},    {"position", 4}, {"pose", 7},
                                         {"trajectory", 17}};
  for (const auto& [signal, size] : sizes) {
    const Instance delay("delay", world, {{"signal", signal.c_str()}, {"latency", 0.01}});
    EXPECT_EQ(delay.declared.controller.input_count(), size) << signal;
    EXPECT_EQ(delay.declared.controller.output_count(), size) << signal;
    EXPECT_TRUE(delay.declared.controller.passes_on);
  }
  const Instance joints("delay", world, {{"signal", "joint"}, {"values", 3}, {"latency", 0.01}});
  EXPECT_EQ(joints.declared.controller.output_count(), 3);
}

TEST_F(DelayTest, DerivativesAreThoseOfTheCommandThatItGives) {
  expect_derivatives({"delay", world, given(0.002), Call::kControl, {0, 1, 2, 3, 4}},
                     {"buffer", "input"});
}

TEST_F(DelayTest, SaysWhatDoesNotFit) {
  const auto refused = [&](const Parameters& all) { return refusal("delay", world, all); };
  EXPECT_THAT(refused(given(0.01, {{"jitter", 0.02}})),
              HasSubstr("`jitter` is 0.02 s, above `latency` 0.01 s"));
  EXPECT_THAT(refused(given(5.0)),
              HasSubstr("`latency` and `jitter` are 5000 physics steps together; allowed: up to "
                        "4095: lower them"));
  EXPECT_THAT(refused({{"signal", "joint"}, {"latency", 0.01}}),
              HasSubstr("`values` is 0, but the signal `joint` has as many"));
  world.robots[0].rotor_count = 0;
  EXPECT_THAT(refused({{"signal", "srt"}, {"latency", 0.01}}),
              HasSubstr("robot `quad` has no rotors, which `srt` speaks to"));
  world.team = {0, 0};
  EXPECT_THAT(refused(given(0.01)), HasSubstr("serves one robot, and is given a team of 2"));
}

}  // namespace
}  // namespace skybody::testing
