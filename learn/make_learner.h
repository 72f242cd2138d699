// Learners by their algorithm's name, for a scenario as it is loaded.
#pragma once

#include <memory>

#include "core/assemble/load.h"
#include "learn/hyperparameters.h"
#include "learn/learner.h"

namespace skybody::learn {

/// A learner in this process. `gradient` is given the scenario as it is trained in, too: loaded
/// once more, with the longer physics steps that the hyper-parameter `physics_steps` asks for.
/// @param load     the scenario
/// @param options  `compiled`: what `load` has been compiled to, or null: it is compiled here
/// @throws InputError where the scenario is wrong, Error as Ppo and AnalyticGradientLearner
std::unique_ptr<Learner> make_learner(Algorithm algorithm, const LoadOptions& load,
                                      LearnerOptions options);

}  // namespace skybody::learn
