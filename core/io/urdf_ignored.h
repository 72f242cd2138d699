// Warnings of what a URDF holds and nobody reads. Internal to core/io's URDF reader.
#pragma once

#include <tinyxml2.h>

#include <string>

#include "core/io/diagnostics.h"

namespace skybody {

/// Elements and attributes that URDF does not have, with a suggestion; and those that it has and
/// that are ignored here: once a file where they stand in every joint of many robots.
void warn_of_ignored(const std::string& file, const tinyxml2::XMLElement& robot,
                     Diagnostics& diagnostics);

}  // namespace skybody
