#include "core/io/urdf_xml.h"

#include <cmath>
#include <functional>

#include "core/io/text.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

const std::vector<std::string>& joint_types() {
  static const std::vector<std::string> types = {"revolute", "continuous", "prismatic", "floating",
                                                 "fixed"};
  return types;
}

/// Calls `visit` for every child element.
void for_each_child(const XMLElement& parent, const std::function<void(const XMLElement&)>& visit) {
  for (const XMLElement* e = parent.FirstChildElement(); e; e = e->NextSiblingElement()) visit(*e);
}

std::string attribute_of(const XMLElement& element, const char* name) {
  const char* value = element.Attribute(name);
  return value == nullptr ? "" : value;
}

/// "mismatched element" from tinyxml2's XML_ERROR_MISMATCHED_ELEMENT.
std::string error_words(std::string name) {
  const std::string prefix = "XML_ERROR_";
  if (name.rfind(prefix, 0) == 0) name = name.substr(prefix.size());
  for (char& c : name) {
    if (c == '_') c = ' ';
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return name;
}

class Checker {
 public:
  Checker(const std::string& file, UrdfXml& xml, Diagnostics& diagnostics)
      : file_(file), xml_(xml), diagnostics_(diagnostics) {}

  void check_robot(const XMLElement& robot) {
    if (std::string(robot.Name()) != "robot") {
      error(robot, "the document is a <" + std::string(robot.Name()) + ">; a URDF is a <robot>");
      return;
    }
    xml_.name = attribute_of(robot, "name");
    if (xml_.name.empty()) error(robot, "<robot> has no name; write <robot name=\"...\">");
    for_each_child(robot, [&](const XMLElement& e) { check_top_level(e); });
    if (xml_.links.empty()) error(robot, "the robot has no <link>; at least one is needed");
  }

 private:
  SourceMark mark(const XMLElement& e) const { return {file_, e.GetLineNum(), 0}; }
  void error(const XMLElement& e, const std::string& message) {
    diagnostics_.error(mark(e), message);
  }

  void unknown(const XMLElement& e, const std::string& where, const std::string& known) {
    diagnostics_.warning(mark(e), "<" + std::string(e.Name()) + "> in " + where +
                                      " is not part of URDF and is ignored; known: " + known);
  }

  void check_top_level(const XMLElement& e) {
    const std::string name = e.Name();
    if (name == "link") {
      check_link(e);
    } else if (name == "joint") {
      check_joint(e);
    } else if (name.rfind("xacro:", 0) == 0) {
      error(e, "<" + name + "> is a macro; expand the file first: xacro FILE > FILE.urdf");
    } else if (name == "gazebo") {
      if (!saw_gazebo_) diagnostics_.warning(mark(e), "<gazebo> elements are ignored");
      saw_gazebo_ = true;
    } else if (name != "material" && name != "transmission" && name != "sensor") {
      unknown(e, "<robot>", "link, joint, material, transmission, sensor, gazebo");
    }
  }

  /// Notes a name; an error where it is missing or taken.
  template <class Named>
  bool take_name(const XMLElement& e, const std::string& kind, std::vector<Named>& list) {
    const std::string name = attribute_of(e, "name");
    if (name.empty()) {
      error(e, "<" + kind + "> has no name");
      return false;
    }
    for (const Named& other : list) {
      if (other.name != name) continue;
      error(e, "a second " + kind + " called `" + name + "`; the first is in line " +
                   std::to_string(other.line) + "; names must differ");
      return false;
    }
    Named named;
    named.name = name;
    named.line = e.GetLineNum();
    named.element = &e;
    list.push_back(named);
    return true;
  }

  void check_link(const XMLElement& link) {
    take_name(link, "link", xml_.links);
    const std::string where = "the link `" + attribute_of(link, "name") + "`";
    for_each_child(link, [&](const XMLElement& e) {
      const std::string name = e.Name();
      if (name == "inertial") {
        check_inertial(e, where);
      } else if (name == "visual" || name == "collision") {
        check_shape(e, where);
      } else {
        unknown(e, where, "inertial, visual, collision");
      }
    });
  }

  void check_inertial(const XMLElement& inertial, const std::string& where) {
    check_origin(inertial, where);
    const XMLElement* mass = inertial.FirstChildElement("mass");
    const XMLElement* inertia = inertial.FirstChildElement("inertia");
    if (mass == nullptr) {
      error(inertial, "<inertial> of " + where + " has no <mass value=\"...\">");
    } else if (const auto value = number(*mass, "value", where)) {
      if (*value < 0.0) {
        error(*mass,
              "the mass of " + where + " is " + format_number(*value) + "; allowed: 0 or more kg");
      }
    }
    if (inertia == nullptr) {
      error(inertial, "<inertial> of " + where + " has no <inertia>");
      return;
    }
    for (const char* name : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}) {
      number(*inertia, name, where);
    }
  }

  void check_shape(const XMLElement& shape, const std::string& where) {
    check_origin(shape, where);
    const XMLElement* geometry = shape.FirstChildElement("geometry");
    const XMLElement* e = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (e == nullptr) {
      error(shape, "<" + std::string(shape.Name()) + "> of " + where + " has no <geometry>");
      return;
    }
    const std::string name = e->Name();
    if (name == "box") {
      positive(*e, "size", 3, where);
    } else if (name == "cylinder") {
      positive(*e, "radius", 1, where);
      positive(*e, "length", 1, where);
    } else if (name == "sphere") {
      positive(*e, "radius", 1, where);
    } else if (name == "mesh") {
      if (attribute_of(*e, "filename").empty())
        error(*e, "<mesh> of " + where + " has no filename");
      if (e->Attribute("scale") != nullptr) numbers(*e, "scale", 3, where);
    } else {
      error(*e, "<" + name + "> is not a shape; allowed: box, cylinder, sphere, mesh");
    }
  }

  void check_joint(const XMLElement& e) {
    if (!take_name(e, "joint", xml_.joints)) return;
    XmlJoint& joint = xml_.joints.back();
    joint.type = attribute_of(e, "type");
    const std::string where = "the joint `" + joint.name + "`";
    check_type(e, joint);
    joint.parent = end_of(e, "parent", where);
    joint.child = end_of(e, "child", where);
    check_origin(e, where);
    for_each_child(e, [&](const XMLElement& child) { check_joint_part(child, joint, where); });
    const bool needs_limit = joint.type == "revolute" || joint.type == "prismatic";
    if (needs_limit && e.FirstChildElement("limit") == nullptr) {
      error(e, where + " is " + joint.type + " and has no <limit>" +
                   (joint.type == "revolute" ? "; one without limits is `continuous`" : ""));
    }
  }

  void check_type(const XMLElement& e, const XmlJoint& joint) {
    const std::vector<std::string>& types = joint_types();
    for (const std::string& type : types) {
      if (type == joint.type) return;
    }
    std::string remedy = "; allowed: " + join(types);
    if (joint.type == "spherical" || joint.type == "ball" || joint.type == "universal") {
      remedy +=
          "; for a ball or universal joint write three or two continuous joints with one "
          "origin, orthogonal axes and massless links between them";
    } else {
      const std::string found = closest(joint.type, types);
      if (!found.empty()) remedy += "; did you mean `" + found + "`?";
    }
    error(e, "the joint `" + joint.name + "` has the type `" + joint.type + "`" + remedy);
  }

  std::string end_of(const XMLElement& joint, const char* which, const std::string& where) {
    const XMLElement* e = joint.FirstChildElement(which);
    const std::string link = e == nullptr ? "" : attribute_of(*e, "link");
    if (link.empty()) error(joint, where + " has no <" + which + " link=\"...\">");
    return link;
  }

  void check_joint_part(const XMLElement& e, const XmlJoint& joint, const std::string& where) {
    const std::string name = e.Name();
    if (name == "axis") {
      const auto axis = numbers(e, "xyz", 3, where);
      const bool zero = axis && (*axis)[0] == 0.0 && (*axis)[1] == 0.0 && (*axis)[2] == 0.0;
      if (zero && joint.type != "fixed" && joint.type != "floating") {
        error(e, "the axis of " + where + " is [0, 0, 0]; it must have a direction");
      }
    } else if (name == "limit") {
      check_limit(e, joint, where);
    } else if (name == "dynamics") {
      check_dynamics(e, where);
    } else if (name == "mimic") {
      diagnostics_.warning(mark(e), "<mimic> of " + where + " is ignored: the joint moves freely");
    } else if (name != "origin" && name != "parent" && name != "child" && name != "calibration" &&
               name != "safety_controller") {
      unknown(e, where, "origin, parent, child, axis, limit, dynamics");
    }
  }

  void check_limit(const XMLElement& e, const XmlJoint& joint, const std::string& where) {
    const auto optional_number = [&](const char* name) {
      return e.Attribute(name) == nullptr ? 0.0 : number(e, name, where).value_or(0.0);
    };
    for (const char* name : {"effort", "velocity"}) number(e, name, where);
    const double lower = optional_number("lower"), upper = optional_number("upper");
    const bool limited = joint.type == "revolute" || joint.type == "prismatic";
    if (limited && !(lower < upper)) {
      error(e,
            "the limits of " + where + " are " + format_number(lower) + " to " +
                format_number(upper) + "; lower must be less than upper" +
                (joint.type == "revolute" ? ", and a joint without limits is `continuous`" : ""));
    }
  }

  void check_dynamics(const XMLElement& e, const std::string& where) {
    for (const char* name : {"damping", "friction"}) {
      if (e.Attribute(name) == nullptr) continue;
      const double value = number(e, name, where).value_or(0.0);
      if (value < 0.0) {
        error(e, std::string("the ") + name + " of " + where + " is " + format_number(value) +
                     "; allowed: 0 or more");
      } else if (value > 0.0 && std::string(name) == "friction") {
        diagnostics_.warning(
            mark(e), "the friction of " + where + " is ignored; joints have viscous damping only");
      }
    }
  }

  void check_origin(const XMLElement& parent, const std::string& where) {
    const XMLElement* origin = parent.FirstChildElement("origin");
    if (origin == nullptr) return;
    for (const char* name : {"xyz", "rpy"}) {
      if (origin->Attribute(name) != nullptr) numbers(*origin, name, 3, where);
    }
  }

  std::optional<double> number(const XMLElement& e, const char* name, const std::string& where) {
    const auto list = numbers(e, name, 1, where);
    return list ? std::optional<double>((*list)[0]) : std::nullopt;
  }

  std::optional<std::vector<double>> numbers(const XMLElement& e, const char* name, int count,
                                             const std::string& where) {
    const auto list = xml_numbers(e, name, count);
    if (list) return list;
    const std::string allowed = count == 1 ? "a number" : std::to_string(count) + " numbers";
    const char* text = e.Attribute(name);
    const std::string what = "`" + std::string(name) + "` of <" + e.Name() + "> in " + where;
    error(e, text == nullptr ? what + " is missing; needed: " + allowed
                             : what + " is `" + text + "`; allowed: " + allowed);
    return std::nullopt;
  }

  void positive(const XMLElement& e, const char* name, int count, const std::string& where) {
    const auto list = numbers(e, name, count, where);
    if (!list) return;
    for (double value : *list) {
      if (value > 0.0) continue;
      error(e, "`" + std::string(name) + "` of <" + e.Name() + "> in " + where + " is " +
                   format_number(value) + "; allowed: above 0 m");
      return;
    }
  }

  const std::string& file_;
  UrdfXml& xml_;
  Diagnostics& diagnostics_;
  bool saw_gazebo_ = false;
};

}  // namespace

std::optional<std::vector<double>> xml_numbers(const XMLElement& element, const char* attribute,
                                               int count) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return std::nullopt;
  std::vector<double> values;
  for (const std::string& word : split_words(text)) {
    const std::optional<double> value = parse_number(word);
    if (!value || !std::isfinite(*value)) return std::nullopt;
    values.push_back(*value);
  }
  if (static_cast<int>(values.size()) != count) return std::nullopt;
  return values;
}

Pose xml_origin(const XMLElement& element) {
  Pose pose;
  const XMLElement* origin = element.FirstChildElement("origin");
  if (origin == nullptr) return pose;
  if (const auto xyz = xml_numbers(*origin, "xyz", 3)) {
    pose.position = {(*xyz)[0], (*xyz)[1], (*xyz)[2]};
  }
  if (const auto rpy = xml_numbers(*origin, "rpy", 3)) {
    pose.rotation = from_rpy((*rpy)[0], (*rpy)[1], (*rpy)[2]);
  }
  return pose;
}

bool check_urdf_xml(const std::string& text, const std::string& file, UrdfXml& xml,
                    Diagnostics& diagnostics) {
  const int errors_before = diagnostics.error_count();
  if (xml.document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    diagnostics.error({file, xml.document.ErrorLineNum(), 0},
                      "not well-formed XML: " + error_words(xml.document.ErrorName()));
    return false;
  }
  if (xml.document.RootElement() == nullptr) {
    diagnostics.error({file, 0, 0}, "the file has no XML element; a URDF is a <robot>");
    return false;
  }
  Checker(file, xml, diagnostics).check_robot(*xml.document.RootElement());
  if (diagnostics.error_count() > errors_before) return false;
  return check_urdf_tree(file, xml, diagnostics);
}

}  // namespace skybody
