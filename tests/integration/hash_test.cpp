// `skybody hash` over the batch engine: one hash, for every way of stepping the environments.
#include "core/base/math/hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/base/math/random.h"
#include "core/base/simd/isa.h"
#include "core/io/files/shipped_files.h"
#include "core/simulation/simulation.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

// Short episodes, so that the hash covers resets.
const std::string kHorizon = "stepping.horizon=7";
const std::vector<std::string> kLonger = {"stepping.horizon=21"};
/// Moves timed events into these short episodes.
const std::map<std::string, std::vector<std::string>> kInTime = {
    {"arm",
     {"randomization[0].parameters.time=[0,0.05]", "randomization[1].parameters.time=[0,0.05]"}},
    // Longer than the tasks' histories, but short enough to contain an episode's end.
    {"pendulum", kLonger},
    {"pendulum_paper", kLonger},
    {"pendulum_randomized", kLonger},
    {"trajectory", kLonger},
    {"trajectory_compact", kLonger},
    {"trajectory_ctbr", kLonger},
    {"trajectory_modular", kLonger},
    {"trajectory_modular_paper", kLonger},
    {"trajectory_paper", kLonger},
    {"vehicles_trajectory", kLonger},
    {"rotor_out", {"effects[0].parameters.earliest=0.01", "effects[0].parameters.latest=0.05"}}};

std::string hash_of(const std::string& scenario, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"hash",   scenario, "--steps", "22",
                                        "--seed", "3",      "--set",   kHorizon};
  arguments.insert(arguments.end(), more.begin(), more.end());
  if (const auto found = kInTime.find(scenario); found != kInTime.end()) {
    for (const std::string& setting : found->second) {
      arguments.insert(arguments.end(), {"--set", setting});
    }
  }
  const Outcome outcome = run_skybody(arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return outcome.out;
}

class HashMatrix : public testing::TestWithParam<std::string> {};

TEST_P(HashMatrix, DoesNotDependOnThreadsBatchesOrOrder) {
  const std::string expected = hash_of(GetParam(), {"--envs", "6"});
  for (const char* threads : {"1", "2", "4"}) {
    for (const char* batch : {"6", "2", "1"}) {
      for (const char* order : {"fixed", "arrival"}) {
        EXPECT_EQ(hash_of(GetParam(), {"--envs", "6", "--threads", threads, "--batch", batch,
                                       "--order", order}),
                  expected)
            << threads << " threads, batch " << batch << ", " << order;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, HashMatrix, testing::ValuesIn(shipped_scenarios()),
                         [](const auto& test) { return test.param; });

TEST(Hash, OfOneEnvironmentIsThatOfASimulation) {
  Simulation simulation({.scenario = "hover", .overrides = {kHorizon}, .seed = 3});
  simulation.reset();
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  for (std::uint64_t k = 0; k < 22; ++k) {
    if (simulation.done()) {
      simulation.reset();
      continue;
    }
    Random<double> random(RandomKey{3, 0}, 0, k, derive_stream("hash.action"));
    for (float& value : action) value = static_cast<float>(random.uniform(-1.0, 1.0));
    simulation.step(action);
  }
  HashChain all;
  all.update(simulation.hash());
  EXPECT_EQ(hash_of("hover", {}), to_hex(all.value()) + "\n");
}

TEST(Hash, OfTheMotionAloneIsASecondLineThatDoesNotDependOnThreads) {
  const std::string all = hash_of("payload", {"--envs", "6"});
  const std::string both = hash_of("payload", {"--envs", "6", "--motion"});
  ASSERT_EQ(both.substr(0, all.size()), all);
  EXPECT_EQ(both.size(), 2 * all.size());
  EXPECT_NE(both.substr(all.size()), all);
  EXPECT_EQ(hash_of("payload", {"--envs", "6", "--motion", "--threads", "2", "--batch", "2"}),
            both);
}

TEST(Hash, OfTheMotionDoesNotGoWithARecording) {
  const Outcome outcome = run_skybody({"hash", "hover", "--motion", "--record", "run.h5"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err, "error: --motion does not go with --record FILE: give one of them\n");
}

/// Ways of stepping:
/// - groups of 32 and 31 lanes on one thread
/// - parts of the groups, in batches of five
/// - blocks of eight lanes in order of arrival
/// - groups of 16 and 15 on four threads Each covers rows, physics and plugins.
TEST(Hash, IsTheSameOnEveryInstructionSetInLanesAndOneByOne) {
  const std::vector<std::vector<std::string>> scenarios = {
      {"hover"},
      {"hover", "--set", "robots.quad.controllers=[{plugin: velocity}]"},  // a driven base
      {"payload"}};
  for (const std::vector<std::string>& scenario : scenarios) {
    std::set<std::string> hashes;
    for (const Isa isa : kIsas) {
      if (!machine_has(isa)) continue;
      for (const std::vector<std::string>& shape : std::vector<std::vector<std::string>>{
               {"--threads", "1"},
               {"--threads", "1", "--batch", "5"},
               {"--threads", "2", "--batch", "20", "--order", "arrival"},
               {"--threads", "4"}}) {
        std::vector<std::string> arguments = {"hash", "--envs", "63", "--steps",
                                              "40",   "--seed", "3"};
        arguments.insert(arguments.end(), scenario.begin(), scenario.end());
        arguments.insert(arguments.end(), shape.begin(), shape.end());
        ProcessOptions on;
        on.environment = {std::string("SKYBODY_ISA=") + name(isa)};
        const Outcome outcome = run_skybody(arguments, on);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        hashes.insert(outcome.out);
      }
    }
    EXPECT_EQ(hashes.size(), 1u) << scenario.front();
  }
}

/// The C library selects its mathematical functions by processor: with FMA they round differently.
/// The scenario uses a randomized lag (exponentials), noise (logarithms, sines) and a revolute
/// joint (sines).
TEST(Hash, IsTheSameWithTheCLibrarysVariantsForThisProcessorSwitchedOff) {
  const std::vector<std::string> arguments = {
      "hash",
      (SKYBODY_SOURCE_DIR "/research/bench/scenarios/pin_rod.yaml"),
      "--envs",
      "9",
      "--steps",
      "300",
      "--seed",
      "5",
      "--set",
      ("sensors=[{plugin: imu, parameters: {robot: quad, accelerometer_noise: 0.002, "
       "gyroscope_noise: 0.0002, accelerometer_walk: 0.001}}]"),
      "--set",
      ("randomization=[{plugin: vehicle_constants, name: inertia, parameters: {robot: quad, mass: "
       "[0.8, 1.2], tau_up: [0.5, "
       "1.5], tau_down: [0.5, 1.5]}}, {plugin: start, parameters: {robot: quad, position_min: [-1, "
       "-1, 1.5], position_max: [1, 1, 3]}}]")};
  const Outcome as_it_is = run_skybody(arguments);
  ASSERT_EQ(as_it_is.exit_code, 0) << as_it_is.err;
  ProcessOptions plain;
  plain.environment = {"GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable"};
  EXPECT_EQ(run_skybody(arguments, plain).out, as_it_is.out);
}

TEST(Hash, SaysWhereARecordingCannotBeWritten) {
  const Outcome outcome =
      run_skybody({"hash", "hover", "--steps", "5", "--record", "/nowhere/run.h5"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err,
            "error: cannot write the replay /nowhere/run.h5: No such file or directory\n");
}

}  // namespace
}  // namespace skybody::test
