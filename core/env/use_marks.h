// Where in the scenario the mistakes are that plugins find, and that are found about them.
#pragma once

#include <string>

#include "core/model/layout.h"

namespace skybody {

/// Where the mistake is that a plugin finds: at the first of its parameters that the message names
/// in backticks (`range`, `range[1]`), else at the one whose text it repeats, such as a robot's
/// name or a path; else where the scenario names the plugin.
SourceMark blamed(const PluginUse& use, const std::string& message);

/// The message; where it says that a path names nothing, with the path that is spelled most like
/// it, which plugins do not know.
std::string with_nearest_param(const Layout& layout, const std::string& message);

/// Where a plugin is told to write an EnvParam: at its parameter whose texts name it, else where
/// the scenario names the plugin.
SourceMark mark_of_writer(const Scenario& scenario, const PluginUse& use, const EnvParam& param);

}  // namespace skybody
