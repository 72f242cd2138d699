// `skybody run --policy PATH` and NetworkPolicy: trained networks in the files that Python writes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/base/math/hash.h"
#include "core/io/files/policy_checksum.h"
#include "core/io/files/policy_file.h"
#include "core/model/located_error.h"
#include "core/policy/network_policy.h"
#include "core/simulation/simulation.h"
#include "tests/integration/policy_draft.h"
#include "tests/integration/process.h"

namespace skybody::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

float act(const fs::path& file, std::vector<float> observation) {
  NetworkPolicy policy(file);
  float action = 0.0f;
  policy.act(observation, {&action, 1});
  return action;
}

TEST(NetworkPolicy, GivesWhatIsComputedByHand) {
  const TemporaryFolder folder;
  const fs::path file = write_policy(folder.path() / "policy.h5", {});
  const double h0 = std::tanh(0.5 * 0.3 - 1.0 * -0.4 + static_cast<double>(0.1f));
  const double h1 = std::tanh(2.0 * 0.3 + 0.25 * -0.4 - static_cast<double>(0.2f));
  const double y = 1.5 * h0 - 0.75 * h1 + static_cast<double>(0.05f);
  // Inputs and output are floats: three roundings of 6e-8 each, times weights below 3.
  EXPECT_NEAR(static_cast<double>(act(file, {0.3f, -0.4f})), y, 3e-7);
}

TEST(NetworkPolicy, ClipsOrSquashesIntoTheRangeOfActions) {
  const TemporaryFolder folder;
  Draft draft;
  draft.layers = {{1, 2, {3.0f, 0.0f}, {0.0f}, "none"}};
  const fs::path clipped = write_policy(folder.path() / "clip.h5", draft);
  EXPECT_EQ(act(clipped, {1.0f, 0.0f}), 1.0f);
  EXPECT_EQ(act(clipped, {-1.0f, 0.0f}), -1.0f);
  EXPECT_EQ(act(clipped, {0.125f, 0.0f}), 0.375f);
  draft.squash = "tanh";
  const fs::path squashed = write_policy(folder.path() / "tanh.h5", draft);
  // One rounding to float of a value below 1.
  EXPECT_NEAR(static_cast<double>(act(squashed, {0.5f, 0.0f})), std::tanh(1.5), 6e-8);
  EXPECT_EQ(act(squashed, {100.0f, 0.0f}), 1.0f);
}

TEST(NetworkPolicy, NormalizesAndClipsObservations) {
  const TemporaryFolder folder;
  Draft draft;
  draft.layers = {{1, 2, {0.25f, 0.0f}, {0.0f}, "relu"}};
  draft.mean = {2.0, 0.0};
  draft.scale = {0.5, 1.0};
  draft.clip = 3.0;
  const fs::path file = write_policy(folder.path() / "policy.h5", draft);
  EXPECT_EQ(act(file, {4.0f, 0.0f}), 0.25f);
  EXPECT_EQ(act(file, {100.0f, 0.0f}), 0.75f) << "beyond the clip";
  EXPECT_EQ(act(file, {0.0f, 0.0f}), 0.0f) << "relu";
}

TEST(NetworkPolicy, ActivatesByExponentialLinearUnits) {
  const TemporaryFolder folder;
  Draft draft;
  draft.layers = {{1, 2, {0.5f, 0.0f}, {0.0f}, "elu"}};
  const fs::path file = write_policy(folder.path() / "policy.h5", draft);
  EXPECT_EQ(act(file, {1.0f, 0.0f}), 0.5f);
  // One rounding to float of a value below 1.
  EXPECT_NEAR(static_cast<double>(act(file, {-1.0f, 0.0f})), std::expm1(-0.5), 6e-8);
}

/// One recurrent unit whose gates read the first observation with these weights and biases.
Draft recurrent_draft() {
  Draft draft;
  draft.layers = {{3,
                   2,
                   {0.5f, 0.0f, -1.0f, 0.0f, 2.0f, 0.0f},
                   {0.1f, 0.2f, 0.3f},
                   "",
                   {0.75f, 1.5f, -0.5f},
                   {-0.1f, 0.4f, 0.6f}},
                  {1, 1, {0.9f}, {0.0f}, "none"}};
  return draft;
}

/// The unit's next state.
double next_state(double h, double x) {
  const auto sigmoid = [](double s) { return 1.0 / (1.0 + std::exp(-s)); };
  const double r = sigmoid(0.5 * x + 0.1 + 0.75 * h - 0.1);
  const double z = sigmoid(-1.0 * x + 0.2 + 1.5 * h + 0.4);
  const double n = std::tanh(2.0 * x + 0.3 + r * (-0.5 * h + 0.6));
  return (1.0 - z) * n + z * h;
}

TEST(NetworkPolicy, RemembersByItsRecurrentLayersUntilItIsReset) {
  const TemporaryFolder folder;
  NetworkPolicy policy(write_policy(folder.path() / "policy.h5", recurrent_draft()));
  for (int episode = 0; episode < 2; ++episode) {
    double h = 0.0;
    for (const float x : {0.3f, -0.8f, 0.1f, 0.0f}) {
      const float observation[] = {x, 5.0f};
      float action = 0.0f;
      policy.act(observation, {&action, 1});
      h = next_state(h, static_cast<double>(x));
      // Weights are floats: 3e-8 of each, over four steps.
      EXPECT_NEAR(static_cast<double>(action), 0.9 * h, 5e-7);
    }
    policy.reset();
  }
}

TEST(NetworkPolicy, IsFoundInACheckpointAndInARunsNewestCheckpoint) {
  const TemporaryFolder folder;
  for (const char* step : {"step_000000000500", "step_000000002000", "step_000000001000"}) {
    const fs::path checkpoint = folder.path() / "checkpoints" / step;
    fs::create_directories(checkpoint);
    write_policy(checkpoint / "policy.h5", {});
  }
  fs::create_directories(folder.path() / "checkpoints" / "step_000000009000");  // unfinished
  const fs::path newest = folder.path() / "checkpoints" / "step_000000002000";
  EXPECT_EQ(find_policy(folder.path()), newest / "policy.h5");
  EXPECT_EQ(find_policy(newest), newest / "policy.h5");
  EXPECT_EQ(find_policy(newest / "policy.h5"), newest / "policy.h5");
}

TEST(RunPolicy, SaysWhatIsWrongWithFilesThatAreNoPolicies) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "text.h5") << "not HDF5";
  fs::create_directory(folder.path() / "empty");
  write_policy(folder.path() / "cut.h5", {});
  write_unsealed(folder.path() / "old.h5", {});
  put_bytes(folder.path() / "newer.h5", "skybody-policy 3\nbytes 0\n");
  put_bytes(folder.path() / "sealed_text.h5", policy_seal("no HDF5") + "no HDF5");
  fs::resize_file(folder.path() / "cut.h5", fs::file_size(folder.path() / "cut.h5") / 2);
  const auto run = [&](const char* policy) {
    const Outcome outcome = run_skybody({"run", "hover", "--policy", policy, "--out", "out"},
                                        {.folder = folder.path()});
    EXPECT_EQ(outcome.exit_code, 2) << policy;
    EXPECT_EQ(lines_of(outcome.err).size(), 1u) << outcome.err;
    return outcome.err;
  };
  EXPECT_EQ(run("text.h5"),
            "text.h5: error: not a policy file: it does not begin with `skybody-policy 2`; give a "
            "policy.h5, which `skybody train` writes\n");
  EXPECT_EQ(run("cut.h5"), std::string("cut.h5: error: ") + kDamaged + "\n");
  EXPECT_EQ(
      run("old.h5"),
      "old.h5: error: an HDF5 file without the seal of policy format 2: export the policy anew\n");
  EXPECT_EQ(run("newer.h5"),
            "newer.h5: error: policy format 3; this Skybody reads format 2: export the policy "
            "anew\n");
  EXPECT_THAT(run("sealed_text.h5"), HasSubstr("error: not a policy file, or cut short: "));
  EXPECT_THAT(run("empty"), HasSubstr("error: the folder empty has neither policy.h5 nor"));
  EXPECT_THAT(run("gone.h5"), HasSubstr("there is no policy or file `gone.h5`"));
}

TEST(NetworkPolicy, RefusesValuesThatNoLearnerMakes) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "policy.h5";
  const auto fault = [&](void (*change)(Draft&)) {
    Draft draft;
    draft.mean = {2.0, 0.0};
    draft.scale = {0.5, 1.0};
    change(draft);
    write_policy(file, draft);
    try {
      read_policy(file);
    } catch (const LocatedError& error) {
      return error.message();
    }
    return std::string();
  };
  EXPECT_EQ(fault([](Draft&) {}), "");
  EXPECT_EQ(fault([](Draft& draft) { draft.scenario_hash = ""; }), "") << "unknown";
  EXPECT_EQ(fault([](Draft& draft) { draft.scale[1] = 0.0; }),
            "value 1 of `/normalization/scale` is 0; allowed: > 0");
  EXPECT_EQ(fault([](Draft& draft) { draft.scale[0] = -0.5; }),
            "value 0 of `/normalization/scale` is -0.5; allowed: > 0");
  EXPECT_EQ(fault([](Draft& draft) { draft.clip = 0.0; }),
            "`clip` of `/normalization` is 0; allowed: > 0");
  EXPECT_EQ(fault([](Draft& draft) { draft.scenario_hash = "none"; }),
            "`scenario_hash` is `none`; needed: 16 hexadecimal digits");
  EXPECT_EQ(fault([](Draft& draft) { draft.scenario_hash = "0123456789ABCDEF"; }),
            "`scenario_hash` is `0123456789ABCDEF`; needed: 16 hexadecimal digits");
}

/// Fits the hover scenario: every rotor at the middle of its range.
Draft hover_draft(const Simulation& simulation) {
  Draft draft;
  const auto inputs = static_cast<hsize_t>(simulation.observation_size());
  const auto outputs = static_cast<hsize_t>(simulation.action_size());
  draft.observation_size = simulation.observation_size();
  draft.action_size = simulation.action_size();
  draft.scenario = "hover";
  draft.scenario_hash = to_hex(simulation.scenario().hash);
  draft.layers = {{outputs, inputs, std::vector<float>(inputs * outputs, 0.01f),
                   std::vector<float>(outputs, 0.1f), "tanh"}};
  return draft;
}

/// The same with a recurrent layer of four units in front.
Draft recurrent_hover_draft(const Simulation& simulation) {
  Draft draft = hover_draft(simulation);
  const auto inputs = static_cast<std::size_t>(simulation.observation_size());
  const Draft::Layer gru = {12,
                            inputs,
                            std::vector<float>(12 * inputs, 0.05f),
                            std::vector<float>(12, 0.1f),
                            "",
                            std::vector<float>(12 * 4, 0.3f),
                            std::vector<float>(12, -0.1f)};
  const hsize_t outputs = draft.layers[0].rows;
  draft.layers = {gru,
                  {outputs, 4, std::vector<float>(outputs * 4, 0.1f),
                   std::vector<float>(outputs, 0.1f), "tanh"}};
  return draft;
}

/// Actions of one step.
std::vector<float> fly_step(Simulation& simulation, NetworkPolicy& policy) {
  std::vector<float> action(static_cast<std::size_t>(simulation.action_size()));
  policy.act(simulation, action);
  simulation.step(action);
  return action;
}

TEST(NetworkPolicy, RemembersSimulationsApartAndBeginsAnewWithAnEpisode) {
  const TemporaryFolder folder;
  Simulation alone({.scenario = "hover", .seed = 1}), one({.scenario = "hover", .seed = 1}),
      other({.scenario = "hover", .seed = 2});
  const fs::path file = write_policy(folder.path() / "policy.h5", recurrent_hover_draft(alone));
  NetworkPolicy policy(file), shared(file);
  for (Simulation* simulation : {&alone, &one, &other}) simulation->reset();
  for (int step = 0; step < 5; ++step) {
    const std::vector<float> wanted = fly_step(alone, policy);
    EXPECT_EQ(fly_step(one, shared), wanted);
    fly_step(other, shared);
  }
  NetworkPolicy fresh(file);
  EXPECT_NE(fly_step(one, fresh), fly_step(alone, policy)) << "it does remember";
  one.reset();
  alone.reset();
  NetworkPolicy again(file);
  EXPECT_EQ(fly_step(one, shared), fly_step(alone, again)) << "of another episode nothing";
}

TEST(RunPolicy, FliesARecurrentNetworkThroughEpisodes) {
  const TemporaryFolder folder;
  const Simulation simulation({.scenario = "hover"});
  write_policy(folder.path() / "policy.h5", recurrent_hover_draft(simulation));
  const Outcome outcome = run_skybody({"run", "hover", "--policy", "policy.h5", "--steps", "20",
                                       "--episodes", "2", "--out", "out", "--no-picture"},
                                      {.folder = folder.path()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
}

TEST(RunPolicy, FliesATrainedNetwork) {
  const TemporaryFolder folder;
  const Simulation simulation({.scenario = "hover"});
  write_policy(folder.path() / "policy.h5", hover_draft(simulation));
  const Outcome outcome = run_skybody(
      {"run", "hover", "--policy", "policy.h5", "--steps", "20", "--out", "out", "--no-picture"},
      {.folder = folder.path()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(fs::exists(folder.path() / "out" / "flight.h5"));
}

TEST(RunPolicy, WarnsOfAnotherScenarioAndRefusesOtherSizes) {
  const TemporaryFolder folder;
  const Simulation simulation({.scenario = "hover"});
  Draft draft = hover_draft(simulation);
  draft.scenario = "other";
  draft.scenario_hash = "0123456789abcdef";
  write_policy(folder.path() / "other.h5", draft);
  draft.scenario = "hover";
  write_policy(folder.path() / "changed.h5", draft);
  Draft small_draft;
  small_draft.scenario = "elsewhere";
  write_policy(folder.path() / "small.h5", small_draft);
  const auto run = [&](const char* policy) {
    return run_skybody(
        {"run", "hover", "--policy", policy, "--steps", "5", "--out", "out", "--no-picture"},
        {.folder = folder.path()});
  };
  const Outcome other = run("other.h5");
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_THAT(other.err,
              HasSubstr("warning: the policy other.h5 was trained on `other`, and flies `hover`: "
                        "both have 22 observations and 4 actions, their meaning and the flight may "
                        "differ\n"));
  const Outcome changed = run("changed.h5");
  EXPECT_EQ(changed.exit_code, 0) << changed.err;
  EXPECT_THAT(changed.err,
              HasSubstr("warning: the policy changed.h5 was trained on `hover`, whose values have "
                        "changed since: observations and actions have the same size, "));
  const Outcome small = run("small.h5");
  EXPECT_EQ(small.exit_code, 2);
  EXPECT_EQ(
      small.err,
      "error: the policy small.h5 was trained on `elsewhere` with 2 observations and 1 action; "
      "`hover` has 22 observations and 4 actions: fly it in `elsewhere`\n");
}

}  // namespace
}  // namespace skybody::test
