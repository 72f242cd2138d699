// What learners are made of, from Python's values.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "learn/learner.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {

/// @throws ValueError for an unknown name
learn::Algorithm algorithm_of(const std::string& name);

/// Hyper-parameters by name; those that are not named have their defaults.
/// @throws ValueError for a name that the algorithm does not have (with the nearest one), a value
/// of
///         another type, or one beyond its range
learn::Hyperparameters hyperparameters_of(const nanobind::dict& values, learn::Algorithm algorithm);

/// Those that an algorithm has, by name, as Python's numbers, bools, tuples and words.
nanobind::dict dict_of(const learn::Hyperparameters& hyper, learn::Algorithm algorithm);

learn::LearnerOptions learner_options(const LoadedScenario& scenario, learn::Algorithm algorithm,
                                      const nanobind::dict& hyper, std::uint64_t seed,
                                      std::int64_t total_steps, int threads);

}  // namespace skybody::python
