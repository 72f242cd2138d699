// The bindings of skybody._native: one function per file, called by module.cpp.
#pragma once

#include <nanobind/nanobind.h>

#include "core/io/files/policy_file.h"

namespace skybody::python {

namespace nb = nanobind;

/// A layer of a policy: (weight, bias, activation), or if recurrent (weight, bias, "none",
/// state_weight, state_bias).
nb::tuple tuple_of(const PolicyLayer& layer);
/// A policy in the form of `read_policy_file`.
nb::dict dict_of(const PolicyFile& policy);

void bind_errors(nb::module_& m);
void bind_compiled_scenario(nb::module_& m);
void bind_batch(nb::module_& m);
void bind_differentiable_envs(nb::module_& m);
void bind_info_columns(nb::module_& m);
void bind_learn(nb::module_& m);
void bind_flight_policy(nb::module_& m);
void bind_mission(nb::module_& m);
void bind_policy_network(nb::module_& m);
void bind_policy(nb::module_& m);
void bind_pool(nb::module_& m);
void bind_ppo(nb::module_& m);
void bind_render(nb::module_& m);
void bind_settings(nb::module_& m);
void bind_shapes(nb::module_& m);
void bind_simulation(nb::module_& m);
void bind_simulation_pool(nb::module_& m);
void bind_versions(nb::module_& m);

}  // namespace skybody::python
