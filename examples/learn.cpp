// Trains a quadrotor to hover, on all processors, and writes policy.h5 for `skybody run --policy`.
// Usage: example_learn [STEPS] [SEED]
#include <skybody/learn.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  skybody::learn::LearnerOptions options;
  options.total_steps = argc > 1 ? std::atoll(argv[1]) : 9'000'000;
  options.seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  options.hyper.discount = 0.98;
  options.hyper.bounded_mean = true;
  options.hyper.final_log_std = -2.7;
  options.hyper.normalization_steps = 1.5e6;
  options.hyper.averaging_steps = 3e5;

  const auto learner = skybody::learn::make_learner(skybody::learn::Algorithm::kFastPpo,
                                                    {"hover_learn", {}, {}}, options);
  for (int iteration = 0; learner->steps() < options.total_steps; ++iteration) {
    const skybody::learn::Report report = learner->iterate();
    if (iteration % 50 == 0 || report.steps >= options.total_steps) {
      std::printf("%9lld steps: %.2f m from the goal\n", static_cast<long long>(report.steps),
                  report.position_error);
    }
  }
  skybody::write_policy("policy.h5", learner->policy(), options.seed);
  std::printf("policy.h5, parameters %016llx\n",
              static_cast<unsigned long long>(learner->parameter_hash()));
}
