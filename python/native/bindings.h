// The nouns of skybody._native: one function a file, called by module.cpp.
#pragma once

#include <nanobind/nanobind.h>

#include "core/io/policy_file.h"

namespace skybody::python {

namespace nb = nanobind;

/// A policy's layer: (weight, bias, activation), of a recurrent one (weight, bias, "none",
/// state_weight, state_bias).
nb::tuple tuple_of(const PolicyLayer& layer);
/// A policy as `read_policy_file` gives it.
nb::dict dict_of(const PolicyFile& policy);

void bind_errors(nb::module_& m);
void bind_compiled_scenario(nb::module_& m);
void bind_batch(nb::module_& m);
void bind_learn(nb::module_& m);
void bind_policy(nb::module_& m);
void bind_pool(nb::module_& m);
void bind_ppo(nb::module_& m);
void bind_settings(nb::module_& m);
void bind_shapes(nb::module_& m);
void bind_simulation(nb::module_& m);
void bind_simulation_pool(nb::module_& m);
void bind_versions(nb::module_& m);

}  // namespace skybody::python
