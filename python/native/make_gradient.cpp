#include "core/assemble/load.h"
#include "learn/gradient/gradient.h"
#include "python/native/learner_options.h"

namespace skybody::python {

std::unique_ptr<learn::Learner> make_gradient(const LoadedScenario& scenario,
                                              learn::LearnerOptions options) {
  const std::vector<std::string> overrides =
      learn::training_overrides(*options.compiled, options.hyper);
  if (!overrides.empty()) {
    LoadOptions load = scenario.options();
    load.overrides.insert(load.overrides.end(), overrides.begin(), overrides.end());
    options.training = compile_scenario(load);
  }
  return std::make_unique<learn::Gradient>(options);
}

}  // namespace skybody::python
