// Warnings of ignored contents of a URDF. Internal to core/io's URDF reader.
#pragma once

#include <tinyxml2.h>

#include <string>

#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Warns of elements and attributes that URDF does not have, with a suggestion, and of those that
/// URDF has and Skybody ignores. The latter appear once per file: many robots have them in every
/// joint.
void warn_of_ignored(const std::string& file, const tinyxml2::XMLElement& robot,
                     Diagnostics& diagnostics);

}  // namespace skybody
