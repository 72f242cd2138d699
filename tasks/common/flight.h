// What tasks about flying robots share: limits of the flight, boxes of drawn targets.
#pragma once

#include <skybody/plugin.h>

#include <string>

namespace skybody::flight {

/// When a flight has failed. Angles in rad, `bound` in m.
struct Limits {
  double tilt_cosine;  ///< below: tilted too far
  double yaw;
  double bound;
};

/// Cosine of the largest tilt [rad]; -2, which nothing is below, where every tilt is allowed.
inline double tilt_cosine_limit(double tilt_max) { return tilt_max < kPi ? cos(tilt_max) : -2.0; }

/// The parameters of these limits: members of a task, in this order.
struct LimitParameters {
  explicit LimitParameters(Plugin* task) : owner(task) {}
  Limits limits() const {
    return {tilt_cosine_limit(tilt_max.value()), yaw_max.value(), bound.value()};
  }

  Plugin* owner;
  RealParameter tilt_max{owner,
                         {.name = "tilt_max",
                          .unit = "rad",
                          .value = 1.57,
                          .min = 0.0,
                          .max = kPi,
                          .doc = "a robot fails beyond this tilt"}};
  RealParameter yaw_max{owner,
                        {.name = "yaw_max",
                         .unit = "rad",
                         .value = 1.57,
                         .min = 0.0,
                         .max = 4.0,
                         .doc = "or beyond this heading, either way"}};
  RealParameter bound{owner,
                      {.name = "bound",
                       .unit = "m",
                       .value = 7.0,
                       .min = 1e-3,
                       .doc = "or where a coordinate's magnitude exceeds this (W)"}};
};

/// True where the body has tilted too far, has left the box |p_i| <= bound, or `heading` [rad] is
/// too large either way.
template <class Real>
SKYBODY_INLINE MaskOf<Real> failed(const BodyMotion<Real>& body, const Real& heading,
                                   const Limits& limits) {
  const Vec3<Real>& p = body.position;
  const Real farthest = max(max(abs(p.x), abs(p.y)), abs(p.z));
  const auto attitude =
      logical_or(tilt_cosine(body.rotation) < limits.tilt_cosine, abs(heading) > limits.yaw);
  return logical_or(attitude, farthest > limits.bound);
}
/// The same with the body's yaw in W.
template <class Real>
SKYBODY_INLINE MaskOf<Real> failed(const BodyMotion<Real>& body, const Limits& limits) {
  return failed(body, yaw(body.rotation), limits);
}

/// Angle between the body's and the world's z axis, 0 .. pi [rad].
template <class Real>
SKYBODY_INLINE Real tilt(const Quat<Real>& q) {
  return acos(max(tilt_cosine(q), Real(-1.0)));  // rounding may leave less than -1
}

/// The same rotation with w >= 0.
template <class Real>
SKYBODY_INLINE Quat<Real> canonical(const Quat<Real>& q) {
  const Quat<Real> opposite{-q.w, -q.x, -q.y, -q.z};
  return select(q.w < 0.0, opposite, q);
}

/// 1 / (1 + weight x)
template <class Real>
SKYBODY_INLINE Real closeness(const Real& x, double weight) {
  return 1.0 / (1.0 + weight * x);
}

/// Refuses a box of drawn targets, given by x, y, z of two corners, that is upside down.
inline void require_box(const RealsParameter& target_min, const RealsParameter& target_max) {
  for (int k = 0; k < 3; ++k) {
    if (target_min.value(k) <= target_max.value(k)) continue;
    throw std::runtime_error("`target_min[" + std::to_string(k) + "]` " +
                             to_text(target_min.value(k)) + " is above `target_max` " +
                             to_text(target_max.value(k)) + ": swap them");
  }
}

/// Announces that a task draws a randomizable parameter of its own, unless the scenario gives it.
/// @returns its first EnvParam; -1: the scenario gives it
inline int announce_drawn(const Setup& setup, const RealsParameter& parameter) {
  if (parameter.is_given()) return -1;
  for (int k = 0; k < parameter.count(); ++k) setup.writes(parameter.env_param() + k);
  return parameter.env_param();
}

/// The robot's actions; a task that observes them needs a controller.
inline int action_count(const RobotInfo& robot, const std::string& task) {
  if (robot.action_count > 0) return robot.action_count;
  throw std::runtime_error(
      "robot `" + std::string(robot.name) + "` takes no action, and task `" + task +
      "` observes actions: give it a controller, such as `rotor_speed`, that no team feeds");
}

}  // namespace skybody::flight
