// Scenario lines for errors that plugins report, and for errors found in plugins.
#pragma once

#include <string>

#include "core/model/state_layout.h"

namespace skybody {

/// Whether a location is the user's own: in the scenario's main file (not an included one) or in a
/// `--set` option.
bool is_own(const Scenario& scenario, const SourceLocation& mark);

/// The location of an error that a plugin reports, found from the words in backticks in its
/// message:
///
/// 1. A parameter that the words name (`range`, `kind: hold`), or an obstacle if the first word
///    names one. Of several, the first that is_own(), else the first.
/// 2. Else the parameter whose text the message repeats, such as a robot's name or a path.
/// 3. Else the line where the scenario names the plugin.
SourceLocation blamed(const Scenario& scenario, const PluginUse& use, const std::string& message);

/// The message. If it reports that a path names nothing, the nearest existing path is appended,
/// because plugins have no list of paths.
std::string with_nearest_param(const StateLayout& layout, const std::string& message);

/// The location of the setting that makes a plugin write an EnvParam: its parameter whose texts
/// name the EnvParam, else the line where the scenario names the plugin.
SourceLocation mark_of_writer(const Scenario& scenario, const PluginUse& use,
                              const EnvParam& param);

}  // namespace skybody
