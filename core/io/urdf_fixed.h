// Joints that a file lets move, and that are read as fixed. Internal to core/io's URDF reader.
#pragma once

#include <set>
#include <string>

#include "core/io/diagnostics.h"
#include "core/io/urdf_document.h"

namespace skybody {

/// Makes joints of the document fixed, with a warning each: those in `spinning`, which turn freely
/// about the axis of a rotor on them, those whose limits are 0 to 0, and those on which nothing has
/// mass.
void fix_joints(UrdfDocument& document, const std::set<std::string>& spinning,
                Diagnostics& diagnostics);

}  // namespace skybody
