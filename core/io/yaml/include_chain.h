// The files that a scenario includes.
#pragma once

#include <string>
#include <vector>

#include "core/io/yaml/config_tree.h"

namespace skybody {

/// The path of a file named in `include`: relative to the including file, else the shipped scenario
/// of that name (`hover` or `hover.yaml`). The file may not exist.
std::string included_path(const ConfigNode& name);

/// The files that `file` includes, itself or through other files. The nearest come first; of those
/// at one distance the later included, which override the others. A file that cannot
/// be read counts as one without includes: load_config() reports it.
std::vector<std::string> included_files(const std::string& file);

/// The presets of a scenario's training: `training/NAME.yaml` beside the scenario `NAME.yaml`, else
/// the presets of the nearest included file that has some. If none has, the scenario's own place.
/// @param file  the scenario
std::string training_presets(const std::string& file);

}  // namespace skybody
