#include "learn/make_learner.h"

#include <string>
#include <utility>
#include <vector>

#include "learn/gradient/gradient.h"
#include "learn/ppo/ppo.h"

namespace skybody::learn {
namespace {

std::shared_ptr<const CompiledScenario> compile_training(const LoadOptions& load,
                                                         const LearnerOptions& options) {
  const std::vector<std::string> longer_steps =
      training_overrides(*options.compiled, options.hyper);
  if (longer_steps.empty()) return options.compiled;
  LoadOptions training = load;
  training.overrides.insert(training.overrides.end(), longer_steps.begin(), longer_steps.end());
  return compile_scenario(training);
}

}  // namespace

std::unique_ptr<Learner> make_learner(Algorithm algorithm, const LoadOptions& load,
                                      LearnerOptions options) {
  check(options.hyper, algorithm);  // before a scenario is compiled with them
  if (options.compiled == nullptr) options.compiled = compile_scenario(load);
  if (algorithm == Algorithm::kFastPpo) return std::make_unique<Ppo>(options);
  return std::make_unique<AnalyticGradientLearner>(options, compile_training(load, options));
}

}  // namespace skybody::learn
