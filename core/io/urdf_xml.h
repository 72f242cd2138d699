// The XML side of a URDF: elements with their lines, and checks whose messages name them. Internal
// to core/io's URDF reader.
#pragma once

#include <tinyxml2.h>

#include <optional>
#include <string>
#include <vector>

#include "core/io/diagnostics.h"
#include "core/model/robot_model.h"

namespace skybody {

/// A named element.
struct XmlNamed {
  std::string name;
  int line = 0;
  const tinyxml2::XMLElement* element = nullptr;
};

/// A joint with its ends.
struct XmlJoint : XmlNamed {
  std::string type;
  std::string parent;
  std::string child;
};

/// What the check of the XML found: names, lines, elements.
struct UrdfXml {
  tinyxml2::XMLDocument document;
  std::string name;  ///< of the robot
  std::vector<XmlNamed> links;
  std::vector<XmlJoint> joints;
  std::string root;  ///< name of the root link
};

/// Exactly `count` finite numbers of an attribute; nothing where it is absent or broken.
std::optional<std::vector<double>> xml_numbers(const tinyxml2::XMLElement& element,
                                               const char* attribute, int count);

/// The pose that the child element <origin> gives (identity where it is absent). Rotations by
/// core/base math.
Pose xml_origin(const tinyxml2::XMLElement& element);

/// Parses `text` into `xml` and checks every element that matters: known names, numbers, types,
/// ranges, and that links and joints form one tree. Returns whether there were no errors.
bool check_urdf_xml(const std::string& text, const std::string& file, UrdfXml& xml,
                    Diagnostics& diagnostics);

/// Checks the elements of the parsed document one by one and lists links and joints.
void check_urdf_elements(const std::string& file, UrdfXml& xml, Diagnostics& diagnostics);

/// Checks that links and joints of `xml` form one tree and finds its root.
bool check_urdf_tree(const std::string& file, UrdfXml& xml, Diagnostics& diagnostics);

}  // namespace skybody
