// How quickly `gradient` learns: trains, and every few iterations flies held-out episodes with the
// policy at the scenario's own physics steps. One line a look: seconds of training so far (and of
// the process), median error over the last second of each episode, failures, mean return, rad of
// yaw.
//
//   bench_gradient [SCENARIO] [NAME=VALUE ...]   seed, updates, threads, every, held_out, envs, ...
#include "learn/gradient/gradient.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "core/assemble/load.h"
#include "core/batch/pool.h"

namespace {

using namespace skybody;
using Clock = std::chrono::steady_clock;

struct Figures {
  double median = 0.0, worst_tenth = 0.0, mean_return = 0.0;
  int failures = 0;
};

std::vector<double> act(const PolicyFile& policy, const float* seen) {
  std::vector<double> x(policy.mean.size());
  for (std::size_t k = 0; k < x.size(); ++k)
    x[k] = (static_cast<double>(seen[k]) - policy.mean[k]) * policy.scale[k];
  for (const PolicyLayer& layer : policy.layers) {
    std::vector<double> y(layer.bias);
    for (int o = 0; o < layer.outputs; ++o) {
      for (int i = 0; i < layer.inputs; ++i) {
        y[static_cast<std::size_t>(o)] +=
            layer.weight[static_cast<std::size_t>(o * layer.inputs + i)] *
            x[static_cast<std::size_t>(i)];
      }
      double& value = y[static_cast<std::size_t>(o)];
      if (layer.activation == Activation::kTanh) value = std::tanh(value);
      if (layer.activation == Activation::kRelu) value = std::max(value, 0.0);
    }
    x = std::move(y);
  }
  for (double& a : x) a = std::tanh(a);
  return x;
}

/// 100 episodes, each judged by its last 50 steps.
Figures fly(const std::shared_ptr<const CompiledScenario>& compiled, const PolicyFile& policy,
            std::uint64_t seed) {
  constexpr int kEpisodes = 100, kLast = 50;
  PoolOptions options;
  options.envs = kEpisodes;
  options.threads = 1;
  options.seed = seed;
  options.autoreset = Autoreset::kSameStep;
  Pool pool(compiled, options);
  pool.send_reset();
  auto batch = pool.recv();
  const int actions = compiled->action_size();
  std::vector<float> row(static_cast<std::size_t>(kEpisodes * actions));
  std::vector<std::vector<double>> errors(kEpisodes);
  std::vector<double> returns(kEpisodes);
  std::vector<bool> is_over(kEpisodes);
  Figures figures;
  for (std::int64_t t = 0; t < compiled->scenario().stepping.horizon; ++t) {
    for (int i = 0; i < kEpisodes; ++i) {
      const std::vector<double> a =
          act(policy, batch->observation.data() + i * batch->width.observation);
      std::copy(a.begin(), a.end(), row.begin() + i * actions);
    }
    pool.send(row);
    batch = pool.recv();
    for (std::size_t i = 0; i < kEpisodes; ++i) {
      if (is_over[i]) continue;
      const bool ends = batch->terminated[i] != 0 || batch->truncated[i] != 0;
      const float* info = (ends ? batch->final_info.data() : batch->info.data()) +
                          i * static_cast<std::size_t>(batch->width.info);
      errors[i].push_back(static_cast<double>(info[0]));
      returns[i] += static_cast<double>(batch->reward[i]);
      is_over[i] = ends;
      if (batch->terminated[i] != 0 || batch->fault[i] != 0) ++figures.failures;
    }
  }
  std::vector<double> last;
  for (const auto& e : errors) {
    double sum = 0.0;
    const std::size_t count = std::min<std::size_t>(kLast, e.size());
    for (std::size_t k = e.size() - count; k < e.size(); ++k) sum += e[k];
    last.push_back(sum / static_cast<double>(count));
  }
  std::sort(last.begin(), last.end());
  figures.median = 0.5 * (last[49] + last[50]);
  figures.worst_tenth = last[90];
  for (const double r : returns) figures.mean_return += r / kEpisodes;
  return figures;
}

double seconds(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace

int main(int argc, char** argv) {
  const Clock::time_point start = Clock::now();
  std::map<std::string, double> set = {{"seed", 1},
                                       {"updates", 100},
                                       {"threads", 2},
                                       {"every", 20},
                                       {"held_out", 777},
                                       {"envs", 256},
                                       {"rollout_steps", 32},
                                       {"learning_rate", 3e-3},
                                       {"max_grad_norm", 1},
                                       {"physics_steps", 4},
                                       {"approach_speed", 3},
                                       {"approach_rate", 2},
                                       {"hidden", 64},
                                       {"reward_weight", 0},
                                       {"final_learning_rate", 0.05},
                                       {"normalization_steps", 0},
                                       {"averaging_steps", 0},
                                       {"goal_weight", 1},
                                       {"end_value_weight", 0},
                                       {"value_epochs", 5},
                                       {"discount", 0.99}};
  LoadOptions load;
  load.scenario = "hover_learn";
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto at = argument.find('=');
    if (at == std::string::npos) {
      load.scenario = argument;
    } else if (set.count(argument.substr(0, at)) == 0) {
      std::fprintf(stderr, "bench_gradient: error: no option `%s`\n", argument.c_str());
      return 2;
    } else {
      set[argument.substr(0, at)] = std::atof(argument.c_str() + at + 1);
    }
  }
  learn::LearnerOptions options;
  options.compiled = compile_scenario(load);
  options.hyper.envs = static_cast<int>(set["envs"]);
  options.hyper.rollout_steps = static_cast<int>(set["rollout_steps"]);
  options.hyper.learning_rate = set["learning_rate"];
  options.hyper.final_learning_rate = set["final_learning_rate"];
  options.hyper.max_grad_norm = set["max_grad_norm"];
  options.hyper.physics_steps = static_cast<int>(set["physics_steps"]);
  options.hyper.reward_weight = set["reward_weight"];
  options.hyper.approach_speed = set["approach_speed"];
  options.hyper.approach_rate = set["approach_rate"];
  options.hyper.hidden = {static_cast<int>(set["hidden"]), static_cast<int>(set["hidden"])};
  options.hyper.normalization_steps = set["normalization_steps"];
  options.hyper.averaging_steps = set["averaging_steps"];
  options.hyper.goal_weight = set["goal_weight"];
  options.hyper.end_value_weight = set["end_value_weight"];
  options.hyper.value_epochs = static_cast<int>(set["value_epochs"]);
  options.hyper.discount = set["discount"];
  options.seed = static_cast<std::uint64_t>(set["seed"]);
  options.threads = static_cast<int>(set["threads"]);
  options.total_steps =
      static_cast<std::int64_t>(set["updates"] * set["envs"] * set["rollout_steps"]);
  load.overrides = learn::training_overrides(*options.compiled, options.hyper);
  options.training = compile_scenario(load);
  learn::Gradient learner(options);
  std::printf("ready after %.3f s\n", seconds(start));
  double looked = 0.0;
  for (int u = 1; u <= static_cast<int>(set["updates"]); ++u) {
    const learn::Report report = learner.iterate();
    if (u % static_cast<int>(set["every"]) != 0 && u != static_cast<int>(set["updates"])) continue;
    const Clock::time_point look = Clock::now();
    const Figures f =
        fly(options.compiled, learner.policy(), static_cast<std::uint64_t>(set["held_out"]));
    looked += seconds(look);
    std::printf(
        "update %4d steps %8lld  %.3f s of process  cost %.3f norm %.2f error %.2f m faults %lld | "
        "median "
        "%.4f m p90 %.4f m failures %d return %.1f\n",
        u, static_cast<long long>(learner.steps()), seconds(start) - looked,
        report.losses[0].second, report.losses[1].second, report.position_error,
        static_cast<long long>(report.faults), f.median, f.worst_tenth, f.failures, f.mean_return);
    std::fflush(stdout);
  }
  std::printf("hash %016llx\n", static_cast<unsigned long long>(learner.parameter_hash()));
}
