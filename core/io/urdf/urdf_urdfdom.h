// Parses a checked URDF with urdfdom. Internal to core/io's URDF reader.
#pragma once

#include <urdf_world/types.h>

#include <string>

#include "core/io/urdf/urdf_xml.h"
#include "core/io/yaml/diagnostics.h"

namespace skybody {

/// urdfdom's model of a document that has passed check_urdf_xml(), or null and an error if urdfdom
/// rejects the file. The model contains every link, joint, visual and collision in `xml`.
urdf::ModelInterfaceSharedPtr read_by_urdfdom(const UrdfXml& xml, const std::string& file,
                                              Diagnostics& diagnostics);

}  // namespace skybody
