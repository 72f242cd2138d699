// Hyper-parameters that learners refuse before they start, from C++.
#include "learn/hyperparameters.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "core/assemble/compile_scenario.h"
#include "core/base/system/error.h"
#include "core/io/files/policy_file.h"
#include "core/io/files/policy_writer.h"
#include "learn/make_learner.h"
#include "learn/ppo/ppo.h"

namespace skybody::learn {
namespace {

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

std::string refusal_of(Algorithm algorithm, const std::function<void(Hyperparameters&)>& change) {
  LearnerOptions options;
  options.threads = 1;
  change(options.hyper);
  return message_of([&] { make_learner(algorithm, {"hover_learn", {}, {}}, options); });
}

TEST(Hyperparameters, BeyondTheirRangeAreRefusedByEveryLearnerThatHasThem) {
  const auto no_envs = [](Hyperparameters& hyper) { hyper.envs = 0; };
  const std::string message = "hyper-parameter envs = 0: allowed is 1 to 1.67772e+07";
  EXPECT_EQ(refusal_of(Algorithm::kFastPpo, no_envs), message);
  EXPECT_EQ(refusal_of(Algorithm::kGradient, no_envs), message);
  EXPECT_EQ(refusal_of(Algorithm::kFastPpo,
                       [](Hyperparameters& hyper) {
                         hyper.hidden = {64, 0};
                       }),
            "hyper-parameter hidden = 0: allowed is 1 to 8192");
}

TEST(Hyperparameters, WithMoreLayersThanAPolicyFileHasAreRefused) {
  Hyperparameters hyper;
  hyper.hidden.assign(63, 4);
  const auto refusal = [&](Algorithm algorithm) {
    return message_of([&] { check(hyper, algorithm); });
  };
  EXPECT_EQ(refusal(Algorithm::kFastPpo), "");
  EXPECT_EQ(refusal(Algorithm::kGradient), "");
  hyper.recurrent_units = 8;
  EXPECT_EQ(refusal(Algorithm::kFastPpo),
            "hyper-parameter hidden = 63 sizes: allowed is at most 62, as a policy file has 64 "
            "layers with the last one and the recurrent one");
  EXPECT_EQ(refusal(Algorithm::kGradient), "");  // has no memory
  hyper.hidden.assign(64, 4);
  EXPECT_EQ(refusal(Algorithm::kGradient),
            "hyper-parameter hidden = 64 sizes: allowed is at most 63, as a policy file has 64 "
            "layers with the last one");
}

/// Policies of all sizes that check() accepts can be read: the deepest with and without a memory.
TEST(Hyperparameters, OfTheDeepestNetworksGivePoliciesThatCanBeRead) {
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / "deepest_policy.h5";
  for (const int units : {0, 4}) {
    LearnerOptions options;
    options.compiled = compile_scenario({"hover_learn", {}, {}});
    options.threads = 1;
    options.hyper.envs = 8;
    options.hyper.minibatch = 64;
    options.hyper.recurrent_units = units;
    options.hyper.hidden.assign(units > 0 ? 62 : 63, 4);
    write_policy(file, Ppo(options).policy(), 1);
    EXPECT_EQ(read_policy(file).layers.size(), std::size_t{kMostLayers});
  }
  std::filesystem::remove(file);
}

TEST(Hyperparameters, OfTheOtherLearnerAreNotLookedAt) {
  Hyperparameters hyper;
  hyper.minibatch = 0;
  EXPECT_EQ(message_of([&] { check(hyper, Algorithm::kGradient); }), "");
  EXPECT_EQ(message_of([&] { check(hyper, Algorithm::kFastPpo); }),
            "hyper-parameter minibatch = 0: allowed is 2 to 1e+09");
}

TEST(Hyperparameters, ThatDoNotFitOneAnotherAreRefused) {
  EXPECT_EQ(
      refusal_of(Algorithm::kFastPpo, [](Hyperparameters& hyper) { hyper.minibatch = 1 << 20; }),
      "hyper-parameter minibatch = 1048576: allowed is 2 to the rows of a rollout, 8192 "
      "(envs * rollout_steps, with shared_policy times the robots)");
}

}  // namespace
}  // namespace skybody::learn
