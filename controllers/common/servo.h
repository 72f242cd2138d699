// Position drives of joints that tilt rotors. Stiffness and damping follow from the driven inertia.
// The parameters are declared here once.
#pragma once

#include <limits>

#include "controllers/common/driven_joint.h"

namespace skybody::control {

/// Nominal inertia of a joint's body about the joint's axis [kg m^2]; for a prismatic joint its
/// mass [kg].
inline double carried_inertia(const BodyInfo& body, const DrivenJoint& joint) {
  if (joint.slides) return body.mass;
  const Vec3<double> lever = vec3(body.com) - joint.point;
  return dot(joint.axis, inertia_of(body) * joint.axis) +
         body.mass * squared_norm(cross(joint.axis, lever));
}

/// Parameters of a controller with such drives.
class Servo {
 public:
  explicit Servo(Plugin* owner)
      : bandwidth_(owner, real("bandwidth", "rad/s", 60.0, between(1e-3, 1e4),
                               "bandwidth of the joints' drives, whose gains scale with the "
                               "inertia about their axes")),
        damping_(owner, real("damping_ratio", "", 1.0, between(0.0, 100.0),
                             "damping ratio of the joints' drives; 1: no overshoot")),
        effort_limit_(owner, real("effort_limit", "N m", 0.0, between(0.0, 1e6),
                                  "largest effort of a joint's drive; 0: no limit")),
        tau_(owner,
             real("tau", "s", 0.0, between(0.0, 100.0), "lag of the joints' commands; 0: none")) {}

  /// Declares the drive of a joint.
  /// @param inertia  the driven inertia (carried_inertia)
  void declare(const Setup& setup, const DrivenJoint& joint, double inertia) const {
    const double infinity = std::numeric_limits<double>::infinity();
    const double limit = effort_limit_.value() > 0.0 ? effort_limit_.value() : infinity;
    const double w = bandwidth_.value(), turn = 4.0 * kPi;
    const bool is_limited = joint.low < joint.high;
    setup.joint({joint.body, 0, SKYBODY_JOINT_POSITION, inertia * w * w,
                 2.0 * damping_.value() * inertia * w, limit, tau_.value(),
                 is_limited ? joint.low : -turn, is_limited ? joint.high : turn});
  }

 private:
  RealParameter bandwidth_, damping_, effort_limit_, tau_;
};

}  // namespace skybody::control
