#include "core/physics/bodies/kinematics.h"

#include "core/physics/world/pose_math.h"

namespace skybody {

std::vector<TreeBody> make_tree(const World& world) {
  std::vector<TreeBody> tree;
  for (const WorldBody& body : world.bodies) {
    const Joint& joint = body.model->joint;
    TreeBody b;
    b.type = joint.type;
    b.parent = body.parent;
    b.q = body.q;
    b.u = body.u;
    b.frame_in_parent = joint.frame_in_parent;
    b.frame_in_body = joint.frame_in_body;
    // A base that is not free has no coordinates for its pose: the pose moves its joint.
    if (body.parent < 0 && joint.type != JointType::kFree) {
      b.frame_in_parent = compose(world.scenario.robots[body.robot].pose, joint.frame_in_parent);
    }
    b.plain_parent = is_identity(b.frame_in_parent);
    b.level_parent = is_identity(b.frame_in_parent.rotation);
    b.plain_body = is_identity(b.frame_in_body);
    tree.push_back(b);
  }
  return tree;
}

}  // namespace skybody
