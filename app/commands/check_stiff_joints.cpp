#include "app/commands/check_stiff_joints.h"

#include <cmath>
#include <string>
#include <vector>

#include "app/report/rounded.h"
#include "core/model/model_marks.h"
#include "core/physics/bodies/body_constants.h"
#include "core/physics/bodies/default_state.h"
#include "core/physics/tree/multibody_tree.h"

namespace skybody {
namespace {

/// The largest rate of a damper, and frequency of a spring, times dt: half the stability limit of
/// explicit midpoint and semi-implicit Euler.
constexpr double kLargestStep = 1.0;

/// The fastest response of a robot's joints.
struct Quickest {
  double value = 0.0;  ///< rate of decay [1/s], or square of a frequency [rad^2/s^2]
  int u = 0;           ///< the coordinate with the largest motion
};

/// Accelerations of one robot caused by forces along its joints.
class JointAnswer {
 public:
  JointAnswer(const World& world, int robot)
      : world_(world),
        index_(robot),
        robot_(world.layout.robots[static_cast<std::size_t>(robot)]),
        multibody_(world),
        constants_(kBodyConstantCount * world.bodies.size()),
        bodies_(world.bodies.size()),
        balls_(world.bodies.size()),
        accelerations_(world.bodies.size()),
        at_rest_(world.bodies.size()),
        no_forces_(world.bodies.size(), SpatialForce<double>::zero()),
        nothing_(static_cast<std::size_t>(world.layout.u.size), 0.0) {
    write_default_state(world, start_);
    make_body_constants(world, start_.params.data(), constants_.data());
    forward_kinematics(multibody_.bodies(), robot_.first_body,
                       robot_.first_body + robot_.body_count, start_.q.data(), nothing_.data(),
                       at_rest_.data());
  }

  /// The largest eigenvalue of M^-1 S, with S the strengths, by power iteration.
  Quickest quickest(const std::vector<double>& strength) const {
    std::vector<double> change = strength, force(strength.size());
    Quickest found;
    for (int k = 0; k < 100; ++k) {
      double size = 0.0;
      for (const double c : change) size = std::max(size, std::fabs(c));
      if (!(size > 0.0)) return {};
      for (std::size_t i = 0; i < force.size(); ++i) force[i] = strength[i] * change[i] / size;
      multibody_.respond_to_joints(
          index_, start_.q.data(), at_rest_.data(), constants_.data(), nothing_.data(),
          no_forces_.data(), force.data(), nothing_.data(),
          {bodies_.data(), balls_.data(), accelerations_.data()}, change.data());
      found = {};
      for (std::size_t i = 0; i < force.size(); ++i) {
        const double moved = strength[i] > 0.0 ? std::fabs(change[i]) : 0.0;
        if (moved > found.value) found = {moved, static_cast<int>(i)};
        change[i] = strength[i] > 0.0 ? change[i] : 0.0;
      }
    }
    return found;
  }

  /// For each u of the world: the sum of a constant of the robot's joints and of their drives.
  std::vector<double> strengths(int constant, double JointDrive::*of_drive) const {
    std::vector<double> strength(nothing_.size(), 0.0);
    for (int i = robot_.first_body + 1; i < robot_.first_body + robot_.body_count; ++i) {
      const auto index = static_cast<std::size_t>(i);
      const WorldBody& body = world_.bodies[index];
      const Joint& joint = body.model->joint;
      const int count = velocity_size(joint.type);
      const bool has_spring = joint.type == JointType::kPin || joint.type == JointType::kSlider;
      for (int k = 0; k < count && (constant == kJointDamping || has_spring); ++k) {
        const int at = world_.layout.joint_params[index] + constant;
        strength[static_cast<std::size_t>(body.u + k)] =
            start_.params[static_cast<std::size_t>(at)];
      }
    }
    for (const JointDrive& drive : world_.joint_drives) {
      const WorldBody& body = world_.bodies[static_cast<std::size_t>(drive.body)];
      if (body.robot != index_ || drive.mode == JointMode::kEffort) continue;
      strength[static_cast<std::size_t>(body.u + drive.coordinate)] += drive.*of_drive;
    }
    return strength;
  }

  /// Index in the robot of the body whose joint has a coordinate.
  std::size_t body_of(int u) const {
    int found = robot_.first_body;
    for (int i = robot_.first_body; i < robot_.first_body + robot_.body_count; ++i) {
      const int first = world_.bodies[static_cast<std::size_t>(i)].u;
      if (first <= u && first >= world_.bodies[static_cast<std::size_t>(found)].u) found = i;
    }
    return static_cast<std::size_t>(found - robot_.first_body);
  }

 private:
  const World& world_;
  int index_;
  const RobotLayout& robot_;
  MultibodyTree multibody_;
  LaneState start_;
  std::vector<double> constants_;
  mutable std::vector<ArticulatedBodyCache<double>> bodies_;
  mutable std::vector<BallJointCache<double>> balls_;
  mutable std::vector<SpatialAcceleration<double>> accelerations_;
  std::vector<BodyKinematics<double>> at_rest_;
  std::vector<SpatialForce<double>> no_forces_;
  std::vector<double> nothing_;
};

/// Location of a joint's constant: in the URDF or in the scenario, otherwise the robot's entry.
SourceLocation mark_of(const RobotUse& robot, std::size_t body, int constant) {
  if (!robot.model.marks) return robot.mark;
  const SourceLocation& mark =
      robot.model.marks->bodies[body].joint[static_cast<std::size_t>(constant)];
  return mark.file.empty() ? robot.mark : mark;
}

}  // namespace

void warn_of_stiff_joints(const CompiledScenario& compiled, Diagnostics& diagnostics) {
  const Scenario& scenario = compiled.scenario();
  const double dt = scenario.stepping.dt;
  if (is_error_controlled(scenario.stepping.integrator)) return;
  for (std::size_t r = 0; r < scenario.robots.size(); ++r) {
    const RobotUse& use = scenario.robots[r];
    if (use.model.bodies.size() < 2) continue;
    const JointAnswer answer(compiled.world(), static_cast<int>(r));
    const Quickest damped = answer.quickest(answer.strengths(kJointDamping, &JointDrive::damping));
    const Quickest swung =
        answer.quickest(answer.strengths(kJointStiffness, &JointDrive::stiffness));
    const double frequency = std::sqrt(swung.value);
    const bool is_damper = damped.value >= frequency;
    const double rate = is_damper ? damped.value : frequency;
    if (rate * dt <= kLargestStep) continue;
    const std::string name = is_damper ? "damping" : "stiffness";
    const std::size_t body = answer.body_of(is_damper ? damped.u : swung.u);
    diagnostics.warning(
        mark_of(use, body, is_damper ? kJointDamping : kJointStiffness),
        "joint `" + use.model.bodies[body].joint.name + "` of robot `" + use.name + "` has a " +
            name + " that moves its light links within " + rounded(1.0 / rate) + " s: steps of " +
            rounded(dt) + " s do not follow, and from " + rounded(2.0 / rate) +
            " s on they end in a fault; take a `dt` of at most " + rounded(kLargestStep / rate) +
            " s, a smaller " + name + ", heavier links, or `integrator: cvode`");
  }
}

}  // namespace skybody
