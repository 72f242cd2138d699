// An algorithm of one's own from the parts of the learners: advantage actor-critic (Mnih et al.
// 2016, arXiv 1602.01783) on hover_learn. Usage: example_own_algorithm [STEPS] [SEED]
#include <skybody/learn.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

using namespace skybody::learn;

int main(int argc, char** argv) {
  const double total_steps = argc > 1 ? std::atof(argv[1]) : 4e6;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  const auto compiled = skybody::compile_scenario({"hover_learn", {}, {}});
  const Hyperparameters hyper = read_preset("hover_learn", Algorithm::kFastPpo).hyper;
  Rollout rollout({.compiled = compiled, .envs = 256, .steps = 16, .seed = seed});
  const int inputs = compiled->observation_size(), outputs = compiled->action_size();
  const int stride = rollout.stride(), rows = rollout.rows();
  TrainedNetwork policy({inputs, hyper.hidden, outputs}, 0.5),
      value({inputs, hyper.hidden, 1}, 0.5);
  policy.initialize(0.01, seed, 1);
  value.initialize(1.0, seed, 2);
  std::vector<float> mean(rollout.actions().size()), noise(mean.size()), slope(mean.size());
  std::vector<float> estimate(rollout.targets().size());
  double left = 1.0;  // of the steps
  for (std::uint64_t update = 0; left > 0.0; ++update) {
    const auto deviation = static_cast<float>(std::exp(-2.7 + 1.7 * left));  // of the actions
    draw_noise({.seed = seed, .rollout = update}, noise);
    rollout.collect([&](int step, const float* x, std::span<float> actions) {
      policy.forward(x, stride, rollout.envs(), actions.data());
      const float* drawn = noise.data() + static_cast<std::size_t>(step) * actions.size();
      for (float& action : actions) action += deviation * *drawn++;
    });
    rollout.find_advantages(
        [&](const float* x, int count, float* y) { value.forward(x, stride, count, y); });

    const float* x = rollout.observations();
    const RunningMoments advantage = moments_of(rollout.advantages());
    policy.forward(x, stride, rows, mean.data());
    for (std::size_t k = 0; k < mean.size(); ++k) {  // of -advantage ln(density of the action)
      const double a = rollout.advantages()[k / static_cast<std::size_t>(outputs)];
      const double weight = (a - advantage.mean[0]) * advantage.scale(0) / (deviation * deviation);
      slope[k] = static_cast<float>(weight / rows) * (mean[k] - rollout.actions()[k]);
    }
    policy.backward(x, stride, slope.data());
    policy.step(3e-3 * left);
    for (int pass = 0; pass < 5; ++pass) {
      value.forward(x, stride, rows, estimate.data());
      for (std::size_t r = 0; r < estimate.size(); ++r) {  // of half the squared error
        slope[r] = (estimate[r] - rollout.targets()[r]) / static_cast<float>(rows);
      }
      value.backward(x, stride, slope.data());
      value.step(3e-3);
    }
    left = 1.0 - static_cast<double>(rollout.total_steps()) / total_steps;
    if (update % 100 == 0)
      std::printf("%3.0f %%: %.2f m\n", 100 - 100 * left, rollout.position_error());
  }
  skybody::write_policy("policy.h5", rollout.policy(policy, "actor-critic"), seed);
}
