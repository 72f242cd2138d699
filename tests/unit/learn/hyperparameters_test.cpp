// What learners refuse before they begin, from C++.
#include "learn/hyperparameters.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "core/assemble/load.h"
#include "core/base/error.h"
#include "core/io/policy_file.h"
#include "core/io/policy_writer.h"
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
