// Names of state words and of observation values, for people.
#pragma once

#include <string>
#include <vector>

#include "core/env/compiled_scenario.h"

namespace skybody {

/// One per word, in the order of the layout: "step", "q quad.base_link[2]", "params
/// robots.quad.rotors[0].thrust_constant", "plugin_state[7]".
std::vector<std::string> state_names(const CompiledScenario& compiled);

/// One per value of a row of observations: "velocity[2]", "height".
std::vector<std::string> observation_names(const CompiledScenario& compiled);
/// The source of a column's values: "task", or a sensor and its channel, "imu.angular_rate".
std::string source_of(const CompiledScenario& compiled, const ObservationColumn& column);

/// One per column: "velocity float32 [3] from task", "gyro float32 [3] from imu.angular_rate,
/// privileged".
std::vector<std::string> column_texts(const CompiledScenario& compiled);

/// One per value of a privileged row.
std::vector<std::string> privileged_names(const CompiledScenario& compiled);

}  // namespace skybody
