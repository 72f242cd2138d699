#include "core/physics/tree/multibody_tree.h"

namespace skybody {

MultibodyTree::MultibodyTree(const World& world) : bodies_(make_tree(world)) {
  for (std::size_t r = 0; r < world.layout.robots.size(); ++r) {
    const RobotLayout& robot = world.layout.robots[r];
    if (robot.body_count == 0) continue;
    const bool driven = r < world.drives.size() && world.drives[r] != DriveKind::kNone;
    const TreeBody& base = bodies_[static_cast<std::size_t>(robot.first_body)];
    const bool floats =
        base.type == JointType::kFree && base.plain_parent && base.plain_body && !driven;
    trees_.push_back({static_cast<int>(r), robot.first_body, robot.first_body + robot.body_count,
                      robot.body_count == 1 && floats, driven, floats});
  }
}

}  // namespace skybody
