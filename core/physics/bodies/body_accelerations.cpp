#include "core/physics/bodies/body_accelerations.h"

namespace skybody {
namespace {

/// Both in W axes.
struct Acceleration {
  Vec3<double> linear{0.0, 0.0, 0.0}, angular{0.0, 0.0, 0.0};
};

/// The same at a point that turns along, `arm` [m] away; W axes.
Vec3<double> at(const Acceleration& a, const Vec3<double>& w, const Vec3<double>& arm) {
  return a.linear + cross(a.angular, arm) + cross(w, cross(w, arm));
}

/// Derivative of JointMotion's two velocities, each in the axes that it is written in.
Acceleration joint_acceleration(JointType type, const double* q, const double* u,
                                const double* udot) {
  Acceleration a;
  switch (type) {
    case JointType::kWeld:
      break;
    case JointType::kFree:
      a = {load_vec3(udot), load_vec3(udot + 3)};
      break;
    case JointType::kPin:
      a.angular.z = udot[0];
      break;
    case JointType::kSlider:
      a.linear.x = udot[0];
      break;
    case JointType::kUniversal: {
      const SinCos<double> y = sincos(q[1]);
      a.angular = {y.cos * udot[0] - y.sin * u[1] * u[0], udot[1],
                   y.sin * udot[0] + y.cos * u[1] * u[0]};
      break;
    }
    case JointType::kBall:
      a.angular = load_vec3(udot);
      break;
  }
  return a;
}

}  // namespace

void body_accelerations(const std::vector<TreeBody>& tree, const double* q, const double* u,
                        const double* udot, const BodyKinematics<double>* motion,
                        BodyAcceleration* out) {
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const TreeBody& body = tree[i];
    const JointMotion<double> joint = joint_motion(body.type, q + body.q, u + body.u);
    const Acceleration relative =
        joint_acceleration(body.type, q + body.q, u + body.u, udot + body.u);
    const BodyKinematics<double> frame = frame_on_parent(body, motion);
    Acceleration a;  // of F
    if (body.parent >= 0) {
      const auto parent = static_cast<std::size_t>(body.parent);
      a = {out[parent].linear, motion[parent].axes * out[parent].angular};
      a.linear = at(a, frame.angular_velocity, frame.position - motion[parent].position);
    }
    // Of M: F carries it along while it moves in F.
    a.linear = at(a, frame.angular_velocity, frame.axes * joint.translation) +
               2.0 * cross(frame.angular_velocity, frame.axes * joint.velocity) +
               frame.axes * relative.linear;
    const Mat3<double> m_axes = to_mat3(frame.rotation * joint.rotation);
    a.angular +=
        cross(frame.angular_velocity, m_axes * joint.angular_velocity) + m_axes * relative.angular;
    // Of the body's own frame, which is fixed to M.
    const Vec3<double> arm = motion[i].axes * body.frame_in_body.position;
    a.linear = at(a, motion[i].angular_velocity, -arm);
    out[i] = {a.linear, transpose_times(motion[i].axes, a.angular)};
  }
}

std::vector<BodyAcceleration> body_accelerations(const std::vector<TreeBody>& tree, const double* q,
                                                 const double* u, const double* udot) {
  std::vector<BodyKinematics<double>> motion(tree.size());
  std::vector<BodyAcceleration> out(tree.size());
  forward_kinematics(tree, q, u, motion.data());
  body_accelerations(tree, q, u, udot, motion.data(), out.data());
  return out;
}

}  // namespace skybody
