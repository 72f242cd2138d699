// Checks all relevant elements of a URDF: names, numbers, ranges, and elements allowed only once.
#include <functional>
#include <initializer_list>
#include <unordered_map>

#include "core/base/math/vec3.h"
#include "core/base/system/printable.h"
#include "core/io/files/text.h"
#include "core/io/urdf/urdf_ignored.h"
#include "core/io/urdf/urdf_materials.h"
#include "core/io/urdf/urdf_xml.h"
#include "core/io/urdf/xml_text.h"
#include "core/io/yaml/ranges.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

constexpr std::size_t kMostLinks = 10'000;  // and joints; the largest humanoids have about 200
constexpr int kMostShapes = 10'000;

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

class Checker {
 public:
  Checker(const std::string& file, UrdfXml& xml, Diagnostics& diagnostics)
      : file_(file), xml_(xml), diagnostics_(diagnostics), materials_(file, diagnostics) {}

  void check_robot(const XMLElement& robot) {
    if (std::string(robot.Name()) != "robot") {
      error(robot, "the document is a <" + std::string(robot.Name()) + ">; a URDF is a <robot>");
      return;
    }
    xml_.name = attribute_of(robot, "name");
    if (xml_.name.empty()) error(robot, "<robot> has no name; write <robot name=\"...\">");
    check_name(robot, xml_.name);
    check_version(robot);
    // First declare the materials: links may use materials declared after them.
    for_each_child(robot, [&](const XMLElement& e) {
      if (std::string(e.Name()) == "material") materials_.declare(e);
    });
    for_each_child(robot, [&](const XMLElement& e) {
      if (!too_many_) check_top_level(e);
    });
    if (xml_.links.empty()) error(robot, "the robot has no <link>; at least one is needed");
  }

 private:
  SourceLocation mark(const XMLElement& e) const { return xml_mark(file_, e); }
  void error(const XMLElement& e, const std::string& message) {
    diagnostics_.error(mark(e), message);
  }

  void check_version(const XMLElement& robot) {
    const std::string version = attribute_of(robot, "version");
    if (version.empty() || version == "1" || version == "1.0") return;
    error(robot, "the `version` of <robot> is `" + version + "`; allowed: 1.0");
  }

  /// Checks a name. Names are parts of parameters' paths and of messages: they must be one line.
  void check_name(const XMLElement& e, const std::string& name) {
    const std::string which = "the name of this <" + std::string(e.Name()) + ">";
    if (name.size() > kLongestName) {
      error(e, which + " has " + std::to_string(name.size()) + " bytes; allowed: at most " +
                   std::to_string(kLongestName));
    } else if (printable(name) != name) {
      error(e, which + ", `" + name +
                   "`, holds a line break, another control character or bytes that are no UTF-8; "
                   "remove them");
    }
  }

  /// An error at the second <NAME>, for elements that URDF allows only once.
  void check_single(const XMLElement& parent, std::initializer_list<const char*> names,
                    const std::string& where) {
    for (const char* name : names) {
      const XMLElement* first = parent.FirstChildElement(name);
      const XMLElement* second = first == nullptr ? nullptr : first->NextSiblingElement(name);
      if (second == nullptr) continue;
      error(*second, "a second <" + std::string(name) + "> in <" + parent.Name() + "> of " + where +
                         "; the first is in line " + std::to_string(first->GetLineNum()) +
                         "; remove one");
    }
  }

  void check_top_level(const XMLElement& e) {
    const std::string name = e.Name();
    if (name == "link") {
      check_link(e);
    } else if (name == "joint") {
      check_joint(e);
    } else if (name.rfind("xacro:", 0) == 0) {
      error(e, "<" + name + "> is a macro; expand the file first: xacro FILE > FILE.urdf");
    }
  }

  /// Records a name; an error if it is missing or used twice, or if there are too many.
  template <class Named>
  bool take_name(const XMLElement& e, const std::string& kind, std::vector<Named>& list,
                 std::unordered_map<std::string, int>& lines) {
    const std::string name = attribute_of(e, "name");
    if (name.empty()) {
      error(e, "<" + kind + "> has no name");
      return false;
    }
    check_name(e, name);
    const auto [known, is_new] = lines.emplace(name, e.GetLineNum());
    if (!is_new) {
      error(e, "a second " + kind + " called `" + name + "`; the first is in line " +
                   std::to_string(known->second) + "; names must differ");
      return false;
    }
    if (list.size() == kMostLinks) {
      error(e, "more than " + std::to_string(kMostLinks) + " " + kind +
                   "s, which is the most that is allowed; take some out");
      too_many_ = true;
      return false;
    }
    Named named;
    named.name = name;
    named.mark = mark(e);
    named.element = &e;
    list.push_back(named);
    return true;
  }

  void check_link(const XMLElement& link) {
    take_name(link, "link", xml_.links, link_lines_);
    const std::string where = "the link `" + attribute_of(link, "name") + "`";
    check_single(link, {"inertial"}, where);
    for_each_child(link, [&](const XMLElement& e) {
      const std::string name = e.Name();
      if (name == "inertial") {
        check_inertial(e, where);
      } else if (name == "visual" || name == "collision") {
        check_shape(e, where);
      }
    });
  }

  void check_inertial(const XMLElement& inertial, const std::string& where) {
    check_single(inertial, {"origin", "mass", "inertia"}, where);
    check_origin(inertial, where);
    const XMLElement* mass = inertial.FirstChildElement("mass");
    const XMLElement* inertia = inertial.FirstChildElement("inertia");
    if (mass == nullptr) {
      error(inertial, "<inertial> of " + where + " has no <mass value=\"...\">");
    } else if (const auto value = number(*mass, "value", where)) {
      check_range(*mass, "the mass of " + where, *value, kMassRange);
    }
    if (inertia == nullptr) {
      error(inertial, "<inertial> of " + where + " has no <inertia>");
      return;
    }
    for (const char* name : {"ixx", "iyy", "izz"}) within(*inertia, name, 1, kInertiaRange, where);
    for (const char* name : {"ixy", "ixz", "iyz"}) check_product(*inertia, name, where);
  }

  /// Checks a product of inertia. URDF has one name of each symmetric pair, such as ixy; the
  /// mirrored name, iyx, may only repeat its value.
  void check_product(const XMLElement& inertia, const std::string& name, const std::string& where) {
    const std::string mirrored = {name[0], name[2], name[1]};
    const bool has_mirrored = inertia.Attribute(mirrored.c_str()) != nullptr;
    if (has_mirrored && inertia.Attribute(name.c_str()) == nullptr) {
      error(inertia, "<inertia> of " + where + " has `" + mirrored + "` and no `" + name +
                         "`; URDF has the elements ixy, ixz and iyz: write it as `" + name + "`");
      return;
    }
    const auto value = within(inertia, name.c_str(), 1, kProductRange, where);
    if (!has_mirrored) return;
    const auto mirror = within(inertia, mirrored.c_str(), 1, kProductRange, where);
    if (!value || !mirror || *value == *mirror) return;
    error(inertia, "the inertia of " + where + " is not symmetric: " + name + " is " +
                       format_numbers(*value) + " and " + mirrored + " is " +
                       format_numbers(*mirror) + "; remove `" + mirrored + "`");
  }

  void check_shape(const XMLElement& shape, const std::string& where) {
    if (++shapes_ == kMostShapes + 1) {
      error(
          shape,
          "more than " + std::to_string(kMostShapes) +
              " shapes (<visual>, <collision>), which is the most that is allowed; take some out");
      too_many_ = true;
    }
    check_single(shape, {"origin", "geometry", "material"}, where);
    check_origin(shape, where);
    if (std::string(shape.Name()) == "visual") materials_.check(shape, where);
    const XMLElement* geometry = shape.FirstChildElement("geometry");
    const XMLElement* e = geometry == nullptr ? nullptr : geometry->FirstChildElement();
    if (e == nullptr) {
      error(shape, "<" + std::string(shape.Name()) + "> of " + where + " has no <geometry>");
      return;
    }
    if (const XMLElement* origin = geometry->FirstChildElement("origin")) {
      error(*origin, "<origin> stands in <geometry> of " + where +
                         "; move it out of <geometry>, into <" + shape.Name() + ">");
      return;
    }
    if (const XMLElement* second = e->NextSiblingElement()) {
      error(*second, "a second shape, <" + std::string(second->Name()) + ">, in <geometry> of " +
                         where + "; write another <" + shape.Name() + "> for it");
    }
    const std::string name = e->Name();
    if (name == "box") {
      within(*e, "size", 3, kSizeRange, where);
    } else if (name == "cylinder" || name == "capsule") {
      within(*e, "radius", 1, kSizeRange, where);
      within(*e, "length", 1, kSizeRange, where);
    } else if (name == "sphere") {
      within(*e, "radius", 1, kSizeRange, where);
    } else if (name == "mesh") {
      if (attribute_of(*e, "filename").empty())
        error(*e, "<mesh> of " + where + " has no filename");
      if (e->Attribute("scale") != nullptr) {
        within(*e, "scale", 3, kScaleRange, where);
      }
    } else {
      error(*e, "<" + name + "> is not a shape; allowed: box, cylinder, sphere, capsule, mesh");
    }
  }

  void check_joint(const XMLElement& e) {
    if (!take_name(e, "joint", xml_.joints, joint_lines_)) return;
    XmlJoint& joint = xml_.joints.back();
    joint.type = attribute_of(e, "type");
    const std::string where = "the joint `" + joint.name + "`";
    check_type(e, joint);
    check_single(e,
                 {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration",
                  "safety_controller"},
                 where);
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
      check_axis(e, joint, where);
    } else if (name == "limit") {
      check_limit(e, joint, where);
    } else if (name == "dynamics") {
      check_dynamics(e, where);
    } else if (name == "mimic") {
      diagnostics_.warning(mark(e), "<mimic> of " + where + " is ignored: the joint moves freely");
    }
  }

  void check_axis(const XMLElement& e, const XmlJoint& joint, const std::string& where) {
    const auto axis = within(e, "xyz", 3, kAxisRange, where);
    if (!axis || joint.type == "fixed" || joint.type == "floating") return;
    const double length = norm(Vec3<double>{(*axis)[0], (*axis)[1], (*axis)[2]});
    if (length >= kShortestAxis) return;
    error(e,
          "the axis of " + where + " is " + format_numbers(*axis) +
              (length == 0.0 ? "; it must have a direction"
                             : "; it must be at least " + format_number(kShortestAxis) + " long"));
  }

  void check_limit(const XMLElement& e, const XmlJoint& joint, const std::string& where) {
    const auto optional_number = [&](const char* name) {
      return e.Attribute(name) == nullptr ? 0.0 : number(e, name, where).value_or(0.0);
    };
    for (const char* name : {"effort", "velocity"}) optional_number(name);
    const double lower = optional_number("lower"), upper = optional_number("upper");
    const bool limited = joint.type == "revolute" || joint.type == "prismatic";
    // Limits of 0 and 0 make the joint fixed (fix_joints).
    const bool is_written = e.Attribute("lower") != nullptr && e.Attribute("upper") != nullptr;
    const bool stays_at_zero = is_written && lower == 0.0 && upper == 0.0;
    if (limited && !(lower < upper) && !stays_at_zero) {
      const bool is_stuck = lower == upper;
      error(e, "the limits of " + where + " are " + format_number(lower) + " to " +
                   format_number(upper) + "; lower must be less than upper" +
                   (is_stuck ? ": a joint that cannot move is `fixed`" : "") +
                   (joint.type == "revolute" ? std::string(is_stuck ? "," : ", and") +
                                                   " one without limits is `continuous`"
                                             : ""));
    }
    if (!limited) return;
    check_range(e, "the lower limit of " + where, lower, kTravelRange);
    check_range(e, "the upper limit of " + where, upper, kTravelRange);
  }

  void check_dynamics(const XMLElement& e, const std::string& where) {
    for (const char* name : {"damping", "friction"}) {
      if (e.Attribute(name) == nullptr) continue;
      const double value = number(e, name, where).value_or(0.0);
      check_range(e, std::string("the ") + name + " of " + where, value, kDampingRange);
      if (value > 0.0 && std::string(name) == "friction") {
        diagnostics_.warning(
            mark(e), "the friction of " + where + " is ignored; joints have viscous damping only");
      }
    }
  }

  void check_origin(const XMLElement& parent, const std::string& where) {
    const XMLElement* origin = parent.FirstChildElement("origin");
    if (origin == nullptr) return;
    if (origin->Attribute("xyz") != nullptr) within(*origin, "xyz", 3, kPlaceRange, where);
    if (origin->Attribute("rpy") != nullptr) within(*origin, "rpy", 3, kTurnRange, where);
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

  bool check_range(const XMLElement& e, const std::string& what, double value, const Range& range) {
    if (range.has(value)) return true;
    error(e, what + " is " + format_number(value) + "; allowed: " + range.text());
    return false;
  }

  /// Numbers of an attribute; an error if one of them is out of range.
  std::optional<std::vector<double>> within(const XMLElement& e, const char* name, int count,
                                            const Range& range, const std::string& where) {
    const auto list = numbers(e, name, count, where);
    if (!list) return std::nullopt;
    const std::string what = "`" + std::string(name) + "` of <" + e.Name() + "> in " + where;
    for (double value : *list) {
      if (!check_range(e, what, value, range)) return std::nullopt;
    }
    return list;
  }

  const std::string& file_;
  UrdfXml& xml_;
  Diagnostics& diagnostics_;
  MaterialCheck materials_;
  std::unordered_map<std::string, int> link_lines_, joint_lines_;  ///< by name
  int shapes_ = 0;
  bool too_many_ = false;  ///< links, joints or shapes: the rest is not checked
};

}  // namespace

void check_urdf_elements(const std::string& file, UrdfXml& xml, Diagnostics& diagnostics) {
  const XMLElement& robot = *xml.document.RootElement();
  Checker(file, xml, diagnostics).check_robot(robot);
  if (!diagnostics.has_errors()) warn_of_ignored(file, robot, diagnostics);
}

}  // namespace skybody
