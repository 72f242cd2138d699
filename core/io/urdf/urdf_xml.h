// The XML layer of a URDF: elements with their locations, and checks whose messages name them.
// Internal to core/io's URDF reader.
#pragma once

#include <tinyxml2.h>

#include <optional>
#include <string>
#include <vector>

#include "core/io/yaml/diagnostics.h"
#include "core/model/robot_model.h"

namespace skybody {

/// A named element.
struct XmlNamed {
  std::string name;
  SourceLocation mark;
  const tinyxml2::XMLElement* element = nullptr;
};

/// A joint with its parent and child links.
struct XmlJoint : XmlNamed {
  std::string type;
  std::string parent;
  std::string child;
};

/// The results of the XML checks: names, locations, elements.
struct UrdfXml {
  tinyxml2::XMLDocument document;
  std::string name;  ///< of the robot
  std::vector<XmlNamed> links;
  std::vector<XmlJoint> joints;
  std::string root;  ///< name of the root link
};

/// Exactly `count` finite numbers of an attribute; nullopt if it is missing or invalid.
std::optional<std::vector<double>> xml_numbers(const tinyxml2::XMLElement& element,
                                               const char* attribute, int count);

/// The pose of the child element <origin> (identity if it is missing). Rotations are computed with
/// core/base.
Pose xml_origin(const tinyxml2::XMLElement& element);

/// Parses `text` into `xml` and checks every relevant element: known names, numbers, types, ranges,
/// and that links and joints form one tree. Returns whether there were no errors.
bool check_urdf_xml(const std::string& text, const std::string& file, UrdfXml& xml,
                    Diagnostics& diagnostics);

/// Checks the elements of the parsed document one by one and lists links and joints.
void check_urdf_elements(const std::string& file, UrdfXml& xml, Diagnostics& diagnostics);

/// Checks that links and joints of `xml` form one tree and finds its root.
bool check_urdf_tree(UrdfXml& xml, Diagnostics& diagnostics);

}  // namespace skybody
