// Creates learners by their algorithm's name.
#pragma once

#include <memory>

#include "core/assemble/compile_scenario.h"
#include "learn/hyperparameters.h"
#include "learn/learner.h"

namespace skybody::learn {

/// A learner in this process. `gradient` trains in a second copy of the scenario, loaded with the
/// longer physics steps of the hyper-parameter `physics_steps`.
/// @param load     the scenario
/// @param options  `compiled`: the compiled form of `load`, or null: it is compiled here
/// @throws InputError if the scenario is invalid, Error as Ppo and AnalyticGradientLearner
std::unique_ptr<Learner> make_learner(Algorithm algorithm, const LoadOptions& load,
                                      LearnerOptions options);

}  // namespace skybody::learn
