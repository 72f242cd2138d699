// Revolute and prismatic joints of a robot, for controllers of joints.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>

#include "controllers/common/robot.h"

namespace skybody::control {

/// A joint with one coordinate, and the body that it moves.
struct DrivenJoint {
  int body = 0;      ///< world body index
  int q = 0, u = 0;  ///< its coordinate and rate, EnvView::q() and u()
  bool slides = false;
  Vec3<double> point;            ///< a point on the axis, in the body's frame [m]
  Vec3<double> axis;             ///< in the body's frame, unit
  double low = 0.0, high = 0.0;  ///< limits [rad] or [m]; both 0: no limits
};

inline Vec3<double> position_of(const double (&pose)[7]) { return vec3(pose); }
inline Quat<double> rotation_of(const double (&pose)[7]) {
  return {pose[3], pose[4], pose[5], pose[6]};
}

/// @throws std::runtime_error if the joint does not exist or does not have exactly one coordinate
inline DrivenJoint driven_joint(const Setup& setup, int robot, const std::string& name) {
  const BodyInfo& body = setup.joint(robot, name);
  DrivenJoint joint;
  joint.slides = body.joint == SKYBODY_SLIDER;
  if (!joint.slides && body.joint != SKYBODY_PIN) {
    refuse("joint `", name, "` has not one coordinate: revolute and prismatic joints have");
  }
  const Vec3<double> axis =
      joint.slides ? Vec3<double>{1.0, 0.0, 0.0} : Vec3<double>{0.0, 0.0, 1.0};
  joint.body = setup.index_of(body);
  joint.q = body.first_q;
  joint.u = body.first_u;
  joint.point = position_of(body.joint_in_body);
  joint.axis = rotate(rotation_of(body.joint_in_body), axis);
  if (body.joint_is_limited != 0) {
    joint.low = body.joint_lower;
    joint.high = body.joint_upper;
  }
  return joint;
}

/// Whether world body `body` is `ancestor` or one of its descendants.
inline bool hangs_on(const Setup& setup, int body, int ancestor) {
  while (body > ancestor) body = setup.bodies()[body].parent;
  return body == ancestor;
}

}  // namespace skybody::control
