// Tables of declared parameters: for the terminal, and in Markdown for the plugins' READMEs.
#pragma once

#include <string>
#include <vector>

#include "core/model/parameter_spec.h"

namespace skybody {

/// One aligned line per parameter, indented.
std::string parameter_lines(const std::vector<ParameterSpec>& parameters);

/// A Markdown table with one row per parameter.
std::string parameter_markdown(const std::vector<ParameterSpec>& parameters);

}  // namespace skybody
