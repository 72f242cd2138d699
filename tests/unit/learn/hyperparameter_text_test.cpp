// Hyper-parameters as text: every type, and refused texts.
#include "learn/hyperparameter_text.h"

#include <gtest/gtest.h>

#include "core/base/system/error.h"

namespace skybody::learn {
namespace {

constexpr Algorithm kPpo = Algorithm::kFastPpo, kGradient = Algorithm::kGradient;

std::string refusal(const std::string& setting, Algorithm algorithm = kPpo) {
  Hyperparameters hyper;
  try {
    set(hyper, algorithm, setting);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(HyperparameterText, OfEveryTypeIsRead) {
  Hyperparameters hyper;
  for (const char* setting :
       {"envs=1e3", "learning_rate=2.5e-3", "bounded_mean=true", "normalize_rewards=false",
        "hidden=128,64,32", "activation=elu", "averaging_steps=3e5"}) {
    set(hyper, kPpo, setting);
  }
  EXPECT_EQ(hyper.envs, 1000);
  EXPECT_EQ(hyper.learning_rate, 2.5e-3);
  EXPECT_TRUE(hyper.bounded_mean);
  EXPECT_FALSE(hyper.normalize_rewards);
  EXPECT_EQ(hyper.hidden, (Sizes{128, 64, 32}));
  EXPECT_EQ(hyper.activation, Activation::kElu);
  EXPECT_EQ(hyper.averaging_steps, 3e5);
  set(hyper, kGradient, "hidden=");
  EXPECT_TRUE(hyper.hidden.empty());
}

TEST(HyperparameterText, OfAnotherLearnerOrNobodyIsRefusedWithTheNearestName) {
  EXPECT_EQ(refusal("leraning_rate=1"),
            "no hyper-parameter `leraning_rate`; did you mean `learning_rate`?");
  EXPECT_EQ(refusal("minibatch=64"), "");
  EXPECT_EQ(refusal("minibatch=64", kGradient).rfind("no hyper-parameter `minibatch`", 0), 0u);
  EXPECT_EQ(refusal("envs"), "`envs`: write NAME=VALUE");
}

TEST(HyperparameterText, ThatIsNoValueIsRefusedAndChangesNothing) {
  EXPECT_EQ(refusal("envs=2.5"), "`envs=2.5`: `2.5` is not a whole number");
  EXPECT_EQ(refusal("envs=1e12"), "`envs=1e12`: `1e12` is not a whole number");
  EXPECT_EQ(refusal("discount=much"), "`discount=much`: `much` is not a number");
  EXPECT_EQ(refusal("bounded_mean=1"), "`bounded_mean=1`: `1` is not true or false");
  EXPECT_EQ(refusal("hidden=64,x"), "`hidden=64,x`: `64,x` is not sizes as 64,64");
  EXPECT_EQ(refusal("activation=none"), "`activation` is `none`; allowed: tanh, relu, elu");
  Hyperparameters hyper;
  EXPECT_THROW(set(hyper, kPpo, "hidden=8,x"), Error);
  EXPECT_EQ(hyper.hidden, Hyperparameters().hidden);
}

}  // namespace
}  // namespace skybody::learn
