// Place of a sensor on a link, as every sensor declares it.
#pragma once

#include <skybody/plugin.h>

#include <string>

namespace skybody::sensor {

/// Robot, link and pose of a sensor. A pose that the scenario sets can be drawn per episode.
class Mount {
 public:
  explicit Mount(Plugin* owner)
      : robot_(owner, word("robot", "", "robot with the link; optional for a single robot")),
        link_(owner, word("link", "", "link of the sensor; empty: the base")),
        position_(owner, when_given(reals("position", "m", {0.0, 0.0, 0.0}, kAny,
                                          "position of the sensor in the link's frame"))),
        orientation_(
            owner, when_given(reals("orientation", "rad", {0.0, 0.0, 0.0}, kAny,
                                    "roll, pitch, yaw of the sensor's axes in the link's frame"))) {
  }

  /// Looks the link up. @throws std::runtime_error with the names that exist
  void configure(const Setup& setup) {
    robot_index_ = setup.robot(robot_.value());
    std::string name = link_.value();
    if (name.empty()) name = setup.bodies()[setup.robots()[robot_index_].first_body].name;
    const LinkInfo& link = setup.link(robot_index_, name);
    body_ = link.body;
    origin_ = {link.position[0], link.position[1], link.position[2]};
    frame_ = {link.rotation[0], link.rotation[1], link.rotation[2], link.rotation[3]};
    point_ = origin_ + rotate(frame_, position_.vec3());
    axes_ = frame_ * from_rpy(orientation_.value(0), orientation_.value(1), orientation_.value(2));
  }

  int robot() const { return robot_index_; }  ///< index of the robot
  int body() const { return body_; }          ///< world body index of the link

  /// Position of the sensor in the body's frame [m].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> point(const EnvView<Real>& env) const {
    if (position_.env_param() < 0) return to_real<Real>(point_);
    return to_real<Real>(origin_) + rotate(to_real<Real>(frame_), position_.vec3(env));
  }
  /// The body's frame from the sensor's axes.
  template <class Real>
  SKYBODY_INLINE Quat<Real> rotation(const EnvView<Real>& env) const {
    if (orientation_.env_param() < 0) return to_real<Real>(axes_);
    const Vec3<Real> turn = orientation_.vec3(env);
    return to_real<Real>(frame_) * from_rpy(turn.x, turn.y, turn.z);
  }
  /// Position of the sensor in W [m].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> position(const EnvView<Real>& env, const BodyMotion<Real>& body) const {
    return body.position + rotate(body.rotation, point(env));
  }
  /// Velocity of the sensor's origin, W axes [m/s].
  template <class Real>
  SKYBODY_INLINE Vec3<Real> velocity(const EnvView<Real>& env, const BodyMotion<Real>& body) const {
    return body.velocity + rotate(body.rotation, cross(body.angular_velocity, point(env)));
  }

 private:
  TextParameter robot_, link_;
  RealsParameter position_, orientation_;
  int robot_index_ = 0, body_ = 0;
  Vec3<double> origin_{};  ///< of the link, body frame [m]
  Quat<double> frame_{};   ///< body from link
  Vec3<double> point_{};   ///< of the sensor without draws, body frame [m]
  Quat<double> axes_{};    ///< body from sensor without draws
};

}  // namespace skybody::sensor
