// Joints that are movable in the file but read as fixed. Internal to core/io's URDF reader.
#pragma once

#include <set>
#include <string>

#include "core/io/urdf/urdf_links_and_joints.h"
#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// Makes joints of the document fixed, with one warning each:
/// - joints in `spinning`, which turn freely about the axis of a rotor on them
/// - joints with limits of 0 and 0
/// - joints whose outboard links have no mass
void fix_joints(UrdfDocument& document, const std::set<std::string>& spinning,
                Diagnostics& diagnostics);

}  // namespace skybody
