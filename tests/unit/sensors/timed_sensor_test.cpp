// The times that all sensors share: period, phase, latency, their draws, and lost samples. The
// sensor is `pose`, and the base is at x = number of the physics step.
#include <set>

#include "tests/unit/sensors/sensor_run.h"

namespace skybody::testing {
namespace {

using ::testing::HasSubstr;

class TimingTest : public ::testing::Test {
 protected:
  TimingTest() { world.add_quad("quad"); }

  /// The step whose sample the output shows after each of `count` physics steps.
  Numbers shown(const Parameters& given, int count, std::uint64_t env = 7) {
    const Instance sensor("pose", world, given);
    SensorRun run(sensor, env);
    Numbers all;
    for (int n = 1; n <= count; ++n) {
      run.place(n, 0, 0);
      run.step();
      all.push_back(run.group.output[0]);
      EXPECT_NEAR(run.group.output[7], run.group.output[0] * world.dt, 1e-12) << "the stamp";
    }
    return all;
  }
  PluginWorld world;
};

TEST_F(TimingTest, GivesTheBitsOfDouble) {
  for (const Parameters& given : std::vector<Parameters>{
           {{"period", 1}},
           {{"period", 4}, {"phase", 3}, {"latency", 6}, {"dropout", 0.3}},
           {{"period", 3}, {"phase_spread", 2}, {"latency_spread", 7}},
           {{"period", 1}, {"dropout", 0.5}, {"position_noise", 0.1}, {"rotation_noise", 0.01}},
           {{"period", 1},
            {"position", Numbers{0.1, 0, 0.2}},
            {"orientation", Numbers{0, 1, 0}}}}) {
    expect_same_bits("pose", world, given);
  }
}

TEST_F(TimingTest, TheRateIsRoundedToPhysicsSteps) {
  EXPECT_EQ(Instance("pose", world).declared.period, 8) << "120 Hz at 1 kHz: 8.33 steps";
  world.dt = 1.0 / 480.0;
  EXPECT_EQ(Instance("pose", world).declared.period, 4);
  world.dt = 0.02;
  EXPECT_EQ(Instance("pose", world).declared.period, 1) << "no more than every step";
}

TEST_F(TimingTest, ShowsTheFirstSampleUntilTheNextOneArrives) {
  EXPECT_EQ(shown({{"period", 3}}, 7), (Numbers{0, 0, 3, 3, 3, 6, 6}));
  EXPECT_EQ(shown({{"period", 3}, {"phase", 2}}, 8), (Numbers{0, 2, 2, 2, 5, 5, 5, 8}));
  EXPECT_EQ(shown({{"period", 2}, {"phase", 1}, {"latency", 3}}, 8),
            (Numbers{0, 0, 0, 1, 1, 3, 3, 5}));
}

TEST_F(TimingTest, EveryLatencyAndPeriodAreExact) {
  for (const int period : {1, 2, 3, 5}) {
    for (const int latency : {0, 1, 2, 3, 4, 5, 6, 11}) {
      const Numbers all = shown({{"period", period}, {"latency", latency}}, 40);
      for (int n = 1; n <= 40; ++n) {
        const int taken = n >= latency ? (n - latency) / period * period : 0;
        EXPECT_EQ(all[static_cast<std::size_t>(n - 1)], taken)
            << "period " << period << ", latency " << latency << ", step " << n;
      }
    }
  }
}

TEST_F(TimingTest, EachEpisodeDrawsItsDelays) {
  std::set<double> latencies, phases;
  for (std::uint64_t env = 0; env < 200; ++env) {
    const Numbers late = shown({{"period", 1}, {"latency", 2}, {"latency_spread", 3}}, 20, env);
    const double latency = 20.0 - late.back();
    latencies.insert(latency);
    for (std::size_t n = 6; n < 20; ++n) EXPECT_EQ(late[n], static_cast<double>(n + 1) - latency);
    const Numbers waits = shown({{"period", 4}, {"phase_spread", 3}}, 20, env);
    const double phase = std::fmod(waits.back(), 4.0);
    phases.insert(phase);
    for (const double taken : waits) EXPECT_TRUE(taken == 0 || std::fmod(taken, 4.0) == phase);
  }
  EXPECT_EQ(latencies, (std::set<double>{2, 3, 4, 5}));
  EXPECT_EQ(phases, (std::set<double>{0, 1, 2, 3}));
}

TEST_F(TimingTest, ALostSampleLeavesTheOneBefore) {
  const int count = 4000;
  const Numbers all = shown({{"period", 1}, {"dropout", 0.25}}, count);
  int lost = 0;
  for (std::size_t n = 1; n < all.size(); ++n) {
    const bool is_new = all[n] == static_cast<double>(n + 1);
    EXPECT_TRUE(is_new || all[n] == all[n - 1]);
    lost += is_new ? 0 : 1;
  }
  EXPECT_NEAR(lost / (count - 1.0), 0.25, 4.0 * std::sqrt(0.25 * 0.75 / count))
      << "four standard errors";
}

TEST_F(TimingTest, ASampleIsLostOnItsWay) {
  const Numbers now = shown({{"period", 2}, {"dropout", 0.4}}, 60);
  const Numbers late = shown({{"period", 2}, {"dropout", 0.4}, {"latency", 5}}, 65);
  for (std::size_t n = 0; n < now.size(); ++n) EXPECT_EQ(late[n + 5], now[n]) << n;
}

TEST_F(TimingTest, ALaneWithoutLossLosesNothing) {
  const Instance sensor("pose", world, {{"period", 1}, {"dropout", 0.9}});
  SensorRun run(sensor);
  run.group.params[static_cast<std::size_t>(sensor.env_param("dropout"))] = 0.0;
  for (int n = 1; n <= 50; ++n) {
    run.place(n, 0, 0);
    run.step();
    EXPECT_EQ(run.group.output[0], n);
  }
}

TEST_F(TimingTest, IsLeftOutOnlyWhereNothingIsLost) {
  EXPECT_TRUE(Instance("pose", world).declared.sensor.is_only_when_read);
  EXPECT_FALSE(Instance("pose", world, {{"latency", 8}}).declared.sensor.is_only_when_read);
  EXPECT_FALSE(Instance("pose", world, {{"dropout", 0.1}}).declared.sensor.is_only_when_read);
  EXPECT_FALSE(Instance("pose", world, {{"phase", 2}}).declared.sensor.is_only_when_read);
}

TEST_F(TimingTest, ANewEpisodeForgetsSamplesUnderWay) {
  const Instance sensor("pose", world, {{"period", 2}, {"latency", 6}});
  SensorRun run(sensor);
  for (int n = 1; n <= 9; ++n) {
    run.place(n, 0, 0);
    run.step();
  }
  run.place(100, 0, 0);
  run.begin();
  EXPECT_EQ(run.group.output[0], 100.0);
  for (int n = 1; n <= 5; ++n) {
    run.place(200, 0, 0);
    run.step();
    EXPECT_EQ(run.group.output[0], 100.0) << n;
  }
}

TEST_F(TimingTest, BadTimesNameTheRemedy) {
  EXPECT_THAT(refusal("pose", world, {{"period", 4}, {"phase", 4}}),
              HasSubstr("`phase` lets the first sample be 4 physics steps late, and `period` is 4: "
                        "allowed is less than a period"));
  EXPECT_THAT(refusal("pose", world, {{"period", 4}, {"phase", 2}, {"phase_spread", 2}}),
              HasSubstr("`phase_spread` lets"));
}

}  // namespace
}  // namespace skybody::testing
