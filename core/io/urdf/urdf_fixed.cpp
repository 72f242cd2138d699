#include "core/io/urdf/urdf_fixed.h"

#include <vector>

namespace skybody {
namespace {

/// Per link: whether it or one of its descendants has mass.
std::vector<bool> links_with_mass(const UrdfDocument& document) {
  std::vector<bool> has_mass(document.links.size(), false);
  for (std::size_t i = 0; i < document.links.size(); ++i) {
    if (document.links[i].is_massless()) continue;
    std::size_t at = i;
    while (!has_mass[at]) {
      has_mass[at] = true;
      const int joint = document.links[at].parent_joint;
      if (joint < 0) break;
      at = static_cast<std::size_t>(document.joints[static_cast<std::size_t>(joint)].parent);
    }
  }
  return has_mass;
}

}  // namespace

void fix_joints(UrdfDocument& document, const std::set<std::string>& spinning,
                Diagnostics& diagnostics) {
  const std::vector<bool> has_mass = links_with_mass(document);
  const auto fix = [&](UrdfJoint& joint, const std::string& why) {
    joint.type = UrdfJointType::kFixed;
    joint.limited = false;
    diagnostics.warning(joint.mark, "the joint `" + joint.name + "` is read as fixed: " + why);
  };
  for (UrdfJoint& joint : document.joints) {
    const bool is_on_world =
        document.links[static_cast<std::size_t>(joint.parent)].name == "world" &&
        joint.parent == document.root;
    const bool can_be_fixed =
        joint.type != UrdfJointType::kFixed && joint.type != UrdfJointType::kFloating;
    if (!can_be_fixed) continue;
    if (spinning.count(joint.name) > 0) {
      fix(joint,
          "it turns freely about the axis of a rotor on it, and would take the rotor's drag torque "
          "from the vehicle; make it `fixed`");
    } else if (joint.limited && joint.lower == joint.upper) {
      fix(joint, "its limits are 0 to 0; make it `fixed`");
    } else if (!is_on_world && !has_mass[static_cast<std::size_t>(joint.child)]) {
      fix(joint, "nothing that hangs on it has mass");
    }
  }
}

}  // namespace skybody
