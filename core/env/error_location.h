// Where in the scenario the mistakes are that plugins find, and that are found about them.
#pragma once

#include <string>

#include "core/model/layout.h"

namespace skybody {

/// Whether the user says it: in the scenario's own file and no included one, or by `--set`.
bool is_own(const Scenario& scenario, const SourceLocation& mark);

/// Where the mistake is that a plugin finds, by the words of its message in backticks: at an
/// obstacle if the first word names one, or at a parameter (`range`, `kind: hold`); of several, at
/// the first that is_own(), else at the first. If there is none, at the parameter whose text the
/// message repeats, such as a robot's name or a path; else where the scenario names the plugin.
SourceLocation blamed(const Scenario& scenario, const PluginUse& use, const std::string& message);

/// The message; where it says that a path names nothing, with the path that is spelled most like
/// it, which plugins do not know.
std::string with_nearest_param(const Layout& layout, const std::string& message);

/// Where a plugin is told to write an EnvParam: at its parameter whose texts name it, else where
/// the scenario names the plugin.
SourceLocation mark_of_writer(const Scenario& scenario, const PluginUse& use,
                              const EnvParam& param);

}  // namespace skybody
