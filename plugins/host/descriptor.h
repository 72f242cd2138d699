// The C descriptor of a plugin: is it sound, and what does it declare?
#pragma once

#include <string>
#include <vector>

#include "core/model/parameter_spec.h"
#include "plugins/api/abi.h"

namespace skybody {

/// What is wrong with a descriptor whose structure sizes are right, or an empty text: names, kind,
/// functions of the kind for every instruction set, parameters with defaults within their ranges.
std::string descriptor_problem(const SkybodyPlugin& plugin);

/// The declared parameters, in order. The descriptor must be sound.
std::vector<ParameterSpec> parameter_specs(const SkybodyPlugin& plugin);

}  // namespace skybody
