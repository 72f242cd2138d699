// Damped least squares (Levenberg and Marquardt):
//     dq = J^T (J J^T + damping)^-1 e, with e the error to the target.
// Damping keeps steps small if the arm is stretched, and allows a target outside the plane in which
// the arm moves. With levers of 0.1 m, a step leaves a hundredth of the error.
#include "core/policy/hold/arm.h"

#include <algorithm>

#include "core/base/math/math.h"
#include "core/io/yaml/pose.h"

namespace skybody {
namespace {

using V = Vec3<double>;

constexpr int kSearchSteps = 40;
constexpr double kDamping = 1e-4;     // [m^2], one hundredth of a lever of 0.1 m squared
constexpr double kLargestStep = 0.3;  // [rad] or [m] of one joint in one step
constexpr double kNear = 1e-9;        // [m]

bool is_slider(const Body& body) { return body.joint.type == JointType::kSlider; }

/// The axis of a pin or slider in the joint's frame.
V axis_of(const Body& body) { return is_slider(body) ? V{1.0, 0.0, 0.0} : V{0.0, 0.0, 1.0}; }

/// The body's frame in its parent's, with the joint at `position`.
Pose moved(const Body& body, double position) {
  Pose motion;
  if (is_slider(body)) {
    motion.position.x = position;
  } else {
    const SinCos<double> half = sincos(0.5 * position);
    motion.rotation = {half.cos, 0.0, 0.0, half.sin};
  }
  return compose(compose(body.joint.frame_in_parent, motion), inverse(body.joint.frame_in_body));
}

/// Whether `body` is a descendant of `ancestor`, or `ancestor` itself.
bool hangs_on(const World& world, int body, int ancestor) {
  while (body > ancestor) body = world.bodies[static_cast<std::size_t>(body)].parent;
  return body == ancestor;
}

}  // namespace

const double* KnownState::body_params(int body) const {
  return params.data() + world.layout.body_params[static_cast<std::size_t>(body)];
}

Vec3<double> center_of_mass(const KnownState& now, int first, int count) {
  V sum{0.0, 0.0, 0.0};
  double mass = 0.0;
  for (int b = first; b < first + count; ++b) {
    const double* own = now.body_params(b);
    const BodyState& body = now.bodies[static_cast<std::size_t>(b)];
    const MassProperties properties = mass_properties(own);
    sum += properties.mass * (body.position + rotate(body.rotation, properties.com));
    mass += properties.mass;
  }
  return sum / mass;
}

/// Axes and origins of the joints, and the point, in axes and origin of the base.
struct Arm::Posture {
  std::vector<V> axes, origins;
  V point;
};

Arm::Arm(const World& world, int base, int body, const V& point,
         const std::vector<JointDrive>& drives)
    : world_(&world), point_(point) {
  for (int b = body; b != base; b = world.bodies[static_cast<std::size_t>(b)].parent) {
    const JointType type = world.bodies[static_cast<std::size_t>(b)].model->joint.type;
    const auto drive = std::find_if(drives.begin(), drives.end(), [&](const JointDrive& d) {
      return d.body == b && d.mode == JointMode::kPosition;
    });
    const bool is_driven =
        drive != drives.end() && (type == JointType::kPin || type == JointType::kSlider);
    if (!is_driven) {
      joints_.clear();
      return;
    }
    joints_.insert(joints_.begin(), *drive);
  }
}

Arm::Posture Arm::posture(const std::vector<double>& positions) const {
  Posture now;
  Pose pose;
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    const Body& body = *world_->bodies[static_cast<std::size_t>(joints_[k].body)].model;
    pose = compose(pose, moved(body, positions[k]));
    const Pose joint = compose(pose, body.joint.frame_in_body);
    now.axes.push_back(rotate(joint.rotation, axis_of(body)));
    now.origins.push_back(joint.position);
  }
  now.point = transform(pose, point_);
  return now;
}

Vec3<double> Arm::place(const std::vector<double>& positions) const {
  return posture(positions).point;
}

std::vector<double> Arm::reach(const V& target) const {
  std::vector<double> q;
  for (const JointDrive& joint : joints_) {
    const Body& body = *world_->bodies[static_cast<std::size_t>(joint.body)].model;
    q.push_back(std::clamp(body.joint.position, joint.low, joint.high));
  }
  for (int step = 0; step < kSearchSteps; ++step) {
    const Posture now = posture(q);
    const V error = target - now.point;
    if (norm(error) < kNear) break;
    std::vector<V> jacobian;
    SymMat3<double> normal_matrix{kDamping, kDamping, kDamping, 0.0, 0.0, 0.0};
    for (std::size_t k = 0; k < q.size(); ++k) {
      const Body& body = *world_->bodies[static_cast<std::size_t>(joints_[k].body)].model;
      const V j = is_slider(body) ? now.axes[k] : cross(now.axes[k], now.point - now.origins[k]);
      normal_matrix.xx += j.x * j.x, normal_matrix.yy += j.y * j.y, normal_matrix.zz += j.z * j.z;
      normal_matrix.xy += j.x * j.y, normal_matrix.xz += j.x * j.z, normal_matrix.yz += j.y * j.z;
      jacobian.push_back(j);
    }
    const V multiplier = inverse(normal_matrix) * error;
    for (std::size_t k = 0; k < q.size(); ++k) {
      const double wanted = std::clamp(dot(jacobian[k], multiplier), -kLargestStep, kLargestStep);
      q[k] = std::clamp(q[k] + wanted, joints_[k].low, joints_[k].high);
    }
  }
  return q;
}

double Arm::command(const KnownState& now, std::size_t k, double position) const {
  const JointDrive& drive = joints_[k];
  const Body& model = *world_->bodies[static_cast<std::size_t>(drive.body)].model;
  const BodyState& body = now.bodies[static_cast<std::size_t>(drive.body)];
  const V axis = rotate(body.rotation, rotate(model.joint.frame_in_body.rotation, axis_of(model)));
  const V origin = body.position + rotate(body.rotation, model.joint.frame_in_body.position);
  double effort = 0.0;  // of the weight
  for (int b = drive.body; b < static_cast<int>(now.bodies.size()); ++b) {
    if (!hangs_on(*world_, b, drive.body)) continue;
    const V weight = now.body_params(b)[kMass] * now.gravity;
    const V arm = center_of_mass(now, b, 1) - origin;
    effort += dot(axis, is_slider(model) ? weight : cross(arm, weight));
  }
  return position - effort / drive.stiffness;
}

int Arm::joint_of(const JointDrive& drive) const {
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    if (joints_[k].body == drive.body) return static_cast<int>(k);
  }
  return -1;
}

}  // namespace skybody
