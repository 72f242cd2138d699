// urdfdom's reading of a checked URDF. Internal to core/io's URDF reader.
#pragma once

#include <urdf_world/types.h>

#include <string>

#include "core/io/diagnostics.h"
#include "core/io/urdf_xml.h"

namespace skybody {

/// What urdfdom makes of a document that has passed check_urdf_xml(), or null and an error where it
/// refuses the file. Every link, joint, visual and collision that `xml` lists is in the model.
urdf::ModelInterfaceSharedPtr read_by_urdfdom(const UrdfXml& xml, const std::string& file,
                                              Diagnostics& diagnostics);

}  // namespace skybody
