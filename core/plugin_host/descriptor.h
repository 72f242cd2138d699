// Checks the C descriptor of a plugin and reads its declarations.
#pragma once

#include <string>
#include <vector>

#include "core/model/parameter_spec.h"
#include "core/plugin_abi/abi.h"

namespace skybody {

/// Problem of a descriptor whose structure sizes are right; empty if it is valid. Checks names,
/// kind, functions of the kind for every instruction set, and parameters with defaults within their
/// ranges.
std::string descriptor_problem(const SkybodyPlugin& plugin);

/// The declared parameters, in order. The descriptor must be valid.
std::vector<ParameterSpec> parameter_specs(const SkybodyPlugin& plugin);

}  // namespace skybody
