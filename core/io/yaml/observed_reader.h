// The entries of `observe`: channels of sensors added to the task's observation.
#pragma once

#include <vector>

#include "core/io/yaml/config_tree.h"
#include "core/io/yaml/diagnostics.h"
#include "core/model/scenario.h"

namespace skybody {

/// Reads the list (null or absent: none). An entry is `SENSOR.CHANNEL`, or a map of
/// observed_fields. Two entries of one channel or of one name are an error. The existence of the
/// channels is checked later: sensors declare them when the CompiledScenario is built.
std::vector<ObservedChannel> read_observed(const ConfigNode* node, Diagnostics& diagnostics);

}  // namespace skybody
