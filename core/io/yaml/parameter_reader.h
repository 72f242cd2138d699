// Reads one declared value from a tree: checks type, range and length, fills in defaults.
//
// Rules:
// - Booleans are only `true` and `false`. Integers must be integral. NaN and infinities are errors.
// - Quoted numbers are texts.
// - A plugin's parameter that is a list of fixed length N > 1 of numbers accepts a single number
//   and repeats it N times. Lists of variable length, and the scenario's own vectors (positions,
//   forces), must be lists.
// - Texts are limited to the declared choices; names of files become paths.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/parameter_spec.h"
#include "core/model/scenario.h"

namespace skybody {

/// The allowed values: "a number from 0 to 1 s", "a list of 3 numbers [m]", "true or false".
std::string describe_allowed(const ParameterSpec& spec);

/// The default value of `spec` (empty if it has none), with the location `mark`.
ParameterValue default_value(const ParameterSpec& spec, const SourceLocation& mark);

/// Whether a single number may stand for a list of fixed length.
enum class Broadcast { kNo, kYes };

/// Reads `node` according to `spec`. Returns nullopt and errors with locations if it is invalid.
std::optional<ParameterValue> read_value(const ConfigNode& node, const ParameterSpec& spec,
                                         Broadcast broadcast, Diagnostics& diagnostics);

/// Reads a map of parameters: one value per spec, in the order of the specs, defaults filled in.
/// Unknown keys and missing required ones are errors. `map` may be null (no parameters given).
/// After an error the value is the default, so that reading continues.
std::vector<ParameterValue> read_parameters(const ConfigNode& map,
                                            const std::vector<ParameterSpec>& specs,
                                            Diagnostics& diagnostics);

/// A Markdown table of names, types, units, defaults, ranges and meanings.
std::string parameter_table(const std::vector<ParameterSpec>& specs);

/// The default in YAML syntax, "required", or "-".
std::string default_text(const ParameterSpec& spec);

}  // namespace skybody
