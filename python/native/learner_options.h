// Converts Python values to options of learners.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include "learn/learner.h"
#include "python/native/loaded_scenario.h"

namespace skybody::python {

/// @throws ValueError for an unknown name
learn::Algorithm algorithm_of(const std::string& name);

/// Hyper-parameters by name; missing ones have their defaults.
/// @throws ValueError for a name that the algorithm does not have (with the nearest one), a value
///         of another type, or a value out of range
learn::Hyperparameters hyperparameters_of(const nanobind::dict& values, learn::Algorithm algorithm);

/// An algorithm's hyper-parameters by name, as Python numbers, bools, tuples and strings.
nanobind::dict dict_of(const learn::Hyperparameters& hyper, learn::Algorithm algorithm);

learn::LearnerOptions learner_options(const LoadedScenario& scenario, learn::Algorithm algorithm,
                                      const nanobind::dict& hyper, std::uint64_t seed,
                                      std::int64_t total_steps, int threads);

}  // namespace skybody::python
