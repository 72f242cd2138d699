// What learners are made of, from Python's values.
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <string>

#include "learn/learner.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {

/// Hyper-parameters by name; those that are not named have their defaults.
/// @throws ValueError for an unknown name or a value of another type, which it names
learn::Hyperparameters hyperparameters_of(const nanobind::dict& values);

/// Those that an algorithm has, by name, as Python's numbers, bools, tuples and words.
/// @throws ValueError for an unknown algorithm
nanobind::dict dict_of(const learn::Hyperparameters& hyper, const std::string& algorithm);

learn::LearnerOptions learner_options(const LoadedScenario& scenario, const nanobind::dict& hyper,
                                      std::uint64_t seed, std::int64_t total_steps, int threads);

/// The learner `gradient`, with the scenario as it is trained in, whose physics steps are longer.
std::unique_ptr<learn::Learner> make_gradient(const LoadedScenario& scenario,
                                              learn::LearnerOptions options);

}  // namespace skybody::python
