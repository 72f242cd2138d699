#include "core/io/urdf/urdf_ignored.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <vector>

#include "core/base/system/suggestion.h"
#include "core/io/urdf/xml_text.h"

namespace skybody {
namespace {

using tinyxml2::XMLElement;

using Names = std::vector<std::string>;

/// The attributes and children that URDF allows in an element.
struct Part {
  std::string name;
  Names attributes, children;
};

const std::vector<Part>& parts() {
  static const std::vector<Part> all = {
      {"robot",
       {"name", "version"},
       {"link", "joint", "material", "transmission", "sensor", "gazebo"}},
      {"link", {"name", "type"}, {"inertial", "visual", "collision"}},
      {"inertial", {}, {"origin", "mass", "inertia"}},
      {"visual", {"name"}, {"origin", "geometry", "material"}},
      {"collision", {"name"}, {"origin", "geometry"}},
      {"geometry", {}, {"box", "cylinder", "sphere", "capsule", "mesh"}},
      {"box", {"size"}, {}},
      {"cylinder", {"radius", "length"}, {}},
      {"sphere", {"radius"}, {}},
      {"capsule", {"radius", "length"}, {}},
      {"mesh", {"filename", "scale"}, {}},
      {"material", {"name"}, {"color", "texture"}},
      {"color", {"rgba"}, {}},
      {"texture", {"filename"}, {}},
      {"origin", {"xyz", "rpy"}, {}},
      {"mass", {"value"}, {}},
      {"inertia", {"ixx", "ixy", "ixz", "iyy", "iyz", "izz", "iyx", "izx", "izy"}, {}},
      {"joint",
       {"name", "type"},
       {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration",
        "safety_controller"}},
      {"parent", {"link"}, {}},
      {"child", {"link"}, {}},
      {"axis", {"xyz"}, {}},
      {"limit", {"lower", "upper", "effort", "velocity"}, {}},
      {"dynamics", {"damping", "friction"}, {}},
  };
  return all;
}

bool is_among(const Names& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Elements of other tools, whose contents are not checked.
bool is_left_out(std::string_view name) {
  static const Names all = {"gazebo", "transmission", "sensor", "calibration", "safety_controller"};
  return is_among(all, name);
}

/// A name for messages about an element's contents, such as `the link 'base'`.
std::string place_of(const XMLElement& element, const std::string& outside) {
  const char* name = element.Attribute("name");
  const std::string kind = element.Name();
  if (kind == "robot") return "<robot>";
  if (kind == "link" || kind == "joint") {
    return "the " + kind + " `" + (name == nullptr ? "" : name) + "`";
  }
  return outside.front() == '<' ? "<" + kind + ">" : "<" + kind + "> of " + outside;
}

class Warner {
 public:
  Warner(const std::string& file, Diagnostics& diagnostics)
      : file_(file), diagnostics_(diagnostics) {}

  /// @param outside  the link or joint that contains the element
  void look_at(const XMLElement& element, const std::string& outside) {
    const auto part = std::find_if(parts().begin(), parts().end(),
                                   [&](const Part& p) { return p.name == element.Name(); });
    if (part == parts().end()) return;
    const std::string place = place_of(element, outside);
    look_at_attributes(element, *part, place);
    if (part->name == "joint") look_at_joint(element, place);
    const bool is_outside = part->name == "link" || part->name == "joint" || part->name == "robot";
    for (const XMLElement* e = element.FirstChildElement(); e; e = e->NextSiblingElement()) {
      look_at_child(*e, *part, place, is_outside ? place : outside);
    }
  }

 private:
  void warn(const XMLElement& e, const std::string& message) {
    diagnostics_.warning(xml_mark(file_, e), message);
  }
  void warn_once(const XMLElement& e, const std::string& what, const std::string& message) {
    if (told_.insert(what).second) warn(e, message);
  }

  void look_at_attributes(const XMLElement& element, const Part& part, const std::string& place) {
    for (const tinyxml2::XMLAttribute* a = element.FirstAttribute(); a; a = a->Next()) {
      const std::string name = a->Name();
      if (is_among(part.attributes, name) || name.rfind("xmlns", 0) == 0) continue;
      const std::string found = closest(name, part.attributes);
      warn(element, "`" + name + "` of " + place + " is not part of URDF and is ignored" +
                        (found.empty() ? "" : "; did you mean `" + found + "`?"));
    }
  }

  void look_at_child(const XMLElement& e, const Part& part, const std::string& place,
                     const std::string& outside) {
    const std::string name = e.Name();
    if (!is_among(part.children, name)) {
      if (name.rfind("xacro:", 0) == 0) return;  // already reported as an error
      std::string known;
      for (const std::string& child : part.children) known += (known.empty() ? "" : ", ") + child;
      warn(e, "<" + name + "> in " + place + " is not part of URDF and is ignored" +
                  (known.empty() ? "" : "; known: " + known));
    } else if (is_left_out(name)) {
      warn_once(e, name, "<" + name + "> elements are ignored");
    } else {
      look_at(e, outside);
    }
  }

  /// Warns of contents that are meaningless on joints of this type, or in Skybody.
  void look_at_joint(const XMLElement& joint, const std::string& place) {
    const char* given = joint.Attribute("type");
    const std::string type = given == nullptr ? "" : given;
    const bool turns_or_slides = type == "revolute" || type == "prismatic" || type == "continuous";
    const XMLElement* limit = joint.FirstChildElement("limit");
    const XMLElement* axis = joint.FirstChildElement("axis");
    const XMLElement* dynamics = joint.FirstChildElement("dynamics");
    if (axis != nullptr && !turns_or_slides) {
      warn(*axis, "<axis> of " + place + " is ignored: the joint is " + type);
    }
    if (dynamics != nullptr && !turns_or_slides && dynamics->DoubleAttribute("damping") > 0.0) {
      warn(*dynamics, "the damping of " + place + " is ignored: the joint is " + type);
    }
    if (limit == nullptr) return;
    const bool has_travel = limit->Attribute("lower") != nullptr || limit->Attribute("upper");
    if (has_travel && (type == "continuous" || !turns_or_slides)) {
      warn(*limit, "`lower` and `upper` of " + place + " are ignored: the joint is " + type);
    }
    if (limit->DoubleAttribute("effort") > 0.0 || limit->DoubleAttribute("velocity") > 0.0) {
      warn_once(*limit, "effort",
                "`effort` and `velocity` of <limit> are ignored; `effort_limit` of the controller "
                "`joint` limits a drive");
    }
  }

  const std::string& file_;
  Diagnostics& diagnostics_;
  std::set<std::string> told_;
};

}  // namespace

void warn_of_ignored(const std::string& file, const XMLElement& robot, Diagnostics& diagnostics) {
  Warner(file, diagnostics).look_at(robot, "<robot>");
}

}  // namespace skybody
