// Tilting arms: each joint with its rotors. Nominal constants, in the frame of the base.
//
// At tilt a the rotors of arm i push along n_i cos(a) + s_i sin(a), with t_i the joint's axis, n_i
// the rotors' axis at a = 0 and s_i = t_i x n_i. With f_n = T cos(a) and f_s = T sin(a) the wrench
// of a thrust T about the robot's centre of mass c is linear in both:
//   force  f_n n_i + f_s s_i,  moment  (p_i - c) x force + k_i force
// with p_i the point on the joint's axis next to the hubs, and k_i = -(mean of d k_m / k_f) of the
// arm's rotors: 0 for a counter-rotating pair.
#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "controllers/common/composite_body.h"
#include "controllers/common/servo.h"

namespace skybody {

struct TiltRotor {
  int index = 0;              ///< world index of the rotor
  double per_constant = 0.0;  ///< 1 / k_f
};

/// A joint with its rotors.
struct TiltArm {
  control::DrivenJoint joint;
  std::vector<TiltRotor> rotors;
  double full = 0.0;      ///< thrust of all rotors when the weakest is at its limit [N]
  double inertia = 0.0;   ///< about the joint's axis [kg m^2]
  Vec3<double> place;     ///< position relative to the robot's centre of mass [m]
  Vec3<double> normal;    ///< n
  Vec3<double> side;      ///< s
  double reaction = 0.0;  ///< k [m]

  /// Moment of a unit push along `force`.
  Vec3<double> moment(const Vec3<double>& force) const {
    return cross(place, force) + force * reaction;
  }
};

class TiltArms {
 public:
  TiltArms() = default;
  /// @throws std::runtime_error if a rotor is not on a tilting joint of the base
  TiltArms(const Setup& setup, int robot, const control::CompositeBody& all) {
    const View<RotorInfo> rotors = control::working_rotors(setup, robot, "tilt_allocation");
    for (const RotorInfo& rotor : rotors) {
      TiltArm& arm = arm_of(setup, robot, rotor);
      add(setup, all, rotor, static_cast<int>(&rotor - setup.rotors().begin()), arm);
    }
  }

  const std::vector<TiltArm>& all() const { return arms_; }

  /// Adds the largest wrench of all arms along each axis, each axis separately.
  void add_reach(Vec3<double>& force, Vec3<double>& moment) const {
    for (const TiltArm& arm : arms_) {
      const Vec3<double> fn = arm.normal * arm.full, fs = arm.side * arm.full;
      const Vec3<double> mn = arm.moment(fn), ms = arm.moment(fs);
      force += longest(fn, fs);
      moment += longest(mn, ms);
    }
  }

 private:
  static Vec3<double> longest(const Vec3<double>& a, const Vec3<double>& b) {
    return {sqrt(a.x * a.x + b.x * b.x), sqrt(a.y * a.y + b.y * b.y), sqrt(a.z * a.z + b.z * b.z)};
  }

  /// Tolerances for rounded values in files: 1.57 for a quarter turn is off by 8e-4 rad, and
  /// positions are written to 0.1 mm. The neglected error is 0.2 % of a force and 1 mm of a lever
  /// arm, less than the uncertainty of thrust constants.
  static constexpr double kAskew = 2e-3, kBeside = 1e-3;  // [rad], [m]

  static void require_small(const RotorInfo& rotor, const BodyInfo& body, double value, double most,
                            const std::string& how) {
    if (value <= most) return;
    refuse("rotor `", rotor.name, "` pushes ", value, " ", how, " joint `", body.joint_name,
           "`; tilt_allocation allows ", most, ": check `position` and `axis` in the rotors file");
  }

  TiltArm& arm_of(const Setup& setup, int robot, const RotorInfo& rotor) {
    const BodyInfo& body = setup.bodies()[rotor.body];
    const int base = control::base_of(setup, robot);
    if (rotor.body == base || body.parent != base || body.joint != SKYBODY_PIN) {
      refuse("rotor `", rotor.name, "` sits on `", body.name,
             "`, which no revolute joint turns on the base: tilt_allocation is for rotors on "
             "tilting arms; use `mixer` or `ctbt` for rotors on the base");
    }
    for (TiltArm& arm : arms_) {
      if (arm.joint.body == rotor.body) return arm;
    }
    arms_.emplace_back();
    arms_.back().joint = control::driven_joint(setup, robot, body.joint_name);
    return arms_.back();
  }

  static void add(const Setup& setup, const control::CompositeBody& all, const RotorInfo& rotor,
                  int index, TiltArm& arm) {
    const BodyInfo& body = setup.bodies()[rotor.body];
    const control::Placed here = control::placed_in_parent(body, 0.0);  // the parent is the base
    const control::DrivenJoint& joint = arm.joint;
    const Vec3<double> n = control::vec3(rotor.axis);
    const Vec3<double> hub = control::vec3(rotor.position) - joint.point;
    const Vec3<double> side = cross(joint.axis, n);
    require_small(rotor, body, std::fabs(dot(joint.axis, n)), kAskew,
                  "rad off the plane across the axis of");
    require_small(rotor, body, std::fabs(dot(hub, side)), kBeside, "m beside the axis of");
    const Vec3<double> place =
        here.point(joint.point + joint.axis * dot(joint.axis, hub)) - all.com;
    const Vec3<double> normal = rotate(here.rotation, n);
    if (!arm.rotors.empty()) {
      require_small(rotor, body, norm(place - arm.place), kBeside, "m beside the others on");
      require_small(rotor, body, norm(normal - arm.normal), kAskew, "rad off the others on");
    }
    arm.place = place;
    arm.normal = normal;
    arm.side = rotate(here.rotation, side);
    const double* c = rotor.constants;
    const double others = static_cast<double>(arm.rotors.size()), count = others + 1.0;
    const double weakest = others > 0.0 ? min(arm.full / others, control::full_thrust(rotor))
                                        : control::full_thrust(rotor);
    arm.full = weakest * count;
    const double reaction =
        -rotor.direction * c[SKYBODY_ROTOR_MOMENT_CONSTANT] / c[SKYBODY_ROTOR_THRUST_CONSTANT];
    arm.reaction = (arm.reaction * others + reaction) / count;
    arm.rotors.push_back({index, 1.0 / c[SKYBODY_ROTOR_THRUST_CONSTANT]});
    arm.inertia = control::carried_inertia(body, joint);
  }

  std::vector<TiltArm> arms_;
};

}  // namespace skybody
