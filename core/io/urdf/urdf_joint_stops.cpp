#include "core/io/urdf/urdf_bodies.h"
#include "core/io/yaml/pose.h"

namespace skybody {
namespace {

constexpr double kStopFrequency = 100.0;  // [rad/s]

/// Frames of all bodies with every joint at zero, in the frame of body 0 or of the world.
std::vector<Pose> poses_at_zero(const RobotModel& model) {
  std::vector<Pose> poses;
  for (const Body& body : model.bodies) {
    const Joint& joint = body.joint;
    const Pose relative = compose(joint.frame_in_parent, inverse(joint.frame_in_body));
    const bool has_parent = joint.parent >= 0;
    poses.push_back(has_parent ? compose(poses[static_cast<std::size_t>(joint.parent)], relative)
                               : relative);
  }
  return poses;
}

/// Moment of inertia of `mass` about the line through `point` along the unit vector `axis`, all in
/// one frame.
double inertia_about(const MassProperties& mass, const Vec3<double>& point,
                     const Vec3<double>& axis) {
  const SymMat3<double> total = mass.inertia + point_inertia(mass.mass, mass.com - point);
  return dot(axis, total * axis);
}

}  // namespace

void derive_limit_springs(RobotModel& model) {
  const std::vector<Pose> poses = poses_at_zero(model);
  std::vector<MassProperties> masses;  // in one frame
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    masses.push_back(transform(poses[b], model.bodies[b].mass));
  }
  for (std::size_t k = 0; k < model.bodies.size(); ++k) {
    Joint& joint = model.bodies[k].joint;
    if (!joint.limit.enabled) continue;
    const bool pin = joint.type == JointType::kPin;
    const Pose frame = compose(poses[k], joint.frame_in_body);
    const Vec3<double> axis =
        rotate(frame.rotation, pin ? Vec3<double>{0, 0, 1} : Vec3<double>{1, 0, 0});
    // Bodies follow their parents, so one pass finds all bodies outboard of joint k.
    std::vector<bool> outboard(model.bodies.size(), false);
    double moved = 0.0, rest = 0.0;
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      const int parent = model.bodies[b].joint.parent;
      outboard[b] = b == k || (parent >= 0 && outboard[static_cast<std::size_t>(parent)]);
      const double share = pin ? inertia_about(masses[b], frame.position, axis) : masses[b].mass;
      (outboard[b] ? moved : rest) += share;
    }
    const bool free = !model.fixed_base && rest > 0.0;
    const double inertia = free ? moved * rest / (moved + rest) : moved;
    joint.constants[kLimitStiffness] = inertia * kStopFrequency * kStopFrequency;
    joint.constants[kLimitDamping] = 2.0 * inertia * kStopFrequency;
  }
}

}  // namespace skybody
