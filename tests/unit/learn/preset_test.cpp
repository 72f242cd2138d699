// Presets of scenarios, and their mistakes.
#include "learn/preset.h"

#include <gtest/gtest.h>

#include "core/io/yaml/diagnostics.h"
#include "tests/unit/io/temp_folder.h"

namespace skybody::learn {
namespace {

std::string refusal(const std::string& scenario, Algorithm algorithm = Algorithm::kFastPpo) {
  try {
    read_preset(scenario, algorithm);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Preset, OfAShippedScenarioIsFoundByItsName) {
  const Preset ppo = read_preset("hover_learn", Algorithm::kFastPpo);
  EXPECT_EQ(ppo.total_steps, 9'000'000);
  EXPECT_EQ(ppo.hyper.discount, 0.98);
  EXPECT_TRUE(ppo.hyper.bounded_mean);
  EXPECT_EQ(read_preset("hover_learn", Algorithm::kGradient).hyper.envs, 128);
}

TEST(Preset, FollowsTheIncludesOfAScenario) {
  const TempFolder folder;
  const std::string scenario =
      folder.write("mine.yaml", "include: [hover, base.yaml]\nname: mine\n");
  folder.write("base.yaml", "include: hover_learn\n");
  EXPECT_EQ(read_preset(scenario, Algorithm::kFastPpo).total_steps, 9'000'000);
  folder.write("training/base.yaml", "fast-ppo: {envs: 24, hidden: [8, 16]}\n");
  const Preset nearer = read_preset(scenario, Algorithm::kFastPpo);
  EXPECT_EQ(nearer.hyper.envs, 24);
  EXPECT_EQ(nearer.hyper.hidden, (Sizes{8, 16}));
  EXPECT_EQ(nearer.total_steps, 1'000'000) << "its own file replaces them as a whole";
}

TEST(Preset, WithoutAFileIsTheLearnersDefaults) {
  const TempFolder folder;
  const std::string scenario = folder.write("mine.yaml", "name: mine\n");
  EXPECT_EQ(read_preset(scenario, Algorithm::kFastPpo).hyper.envs, Hyperparameters().envs);
  EXPECT_EQ(read_preset(scenario, Algorithm::kGradient).hyper.envs, Hyperparameters().envs);
  const Preset fitted = read_preset(scenario, Algorithm::kGradient, 0.01);
  EXPECT_EQ(fitted.hyper.rollout_steps, 64) << "0.64 s";
  EXPECT_EQ(fitted.hyper.envs, 32);
  EXPECT_EQ(read_preset(scenario, Algorithm::kGradient, 1e-4).hyper.rollout_steps, 640);
}

TEST(Preset, NamesThePlaceOfAMistake) {
  const TempFolder folder;
  const std::string scenario = folder.write("mine.yaml", "name: mine\n");
  const auto said = [&](const std::string& text) {
    const std::string file = folder.write("training/mine.yaml", text);
    const std::string what = refusal(scenario);
    EXPECT_EQ(what.rfind(file + ":", 0), 0u) << what;
    return what.substr(std::min(file.size(), what.size()));
  };
  EXPECT_EQ(said("fast-pp: {envs: 8}\n"),
            ":1:1: error: no learner `fast-pp`; did you mean `fast-ppo`?");
  EXPECT_EQ(said("fast-ppo:\n  epoch: 2\n"),
            ":2:3: error: no hyper-parameter `epoch`; did you mean `epochs`?");
  EXPECT_EQ(said("fast-ppo:\n  total_steps: 1.5\n"),
            ":2:3: error: total_steps: `1.5` is not a whole number");
  EXPECT_EQ(said("fast-ppo:\n  envs: 8\n  discount: 2\n"),
            ":3:3: error: fast-ppo: hyper-parameter discount = 2: allowed is 0 to 1");
  EXPECT_EQ(said("fast-ppo: {envs: {a: 1}}\n"),
            ":1:18: error: `envs` is a map; it must be a value or a list of values");
  EXPECT_NE(said("fast-ppo:\n  envs: 8\n  cnn_channels: [8, 8]\n").find(":3:3: error: "),
            std::string::npos);
}

TEST(Preset, MayHaveASectionOfTheLearnerInPython) {
  const TempFolder folder;
  const std::string scenario = folder.write("mine.yaml", "name: mine\n");
  folder.write("training/mine.yaml", "ppo: {torch_threads: 2}\nfast-ppo: {envs: 8}\n");
  EXPECT_EQ(read_preset(scenario, Algorithm::kFastPpo).hyper.envs, 8);
}

}  // namespace
}  // namespace skybody::learn
