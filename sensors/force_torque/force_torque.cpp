// Force and torque sensor in a joint: the load that the joint exerts on the body that it moves.
#include "sensors/common/errors.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

class ForceTorque : public sensor::TimedSensor {
 public:
  void configure(const Setup& setup) override {
    const int robot = setup.robot(robot_.value());
    const BodyInfo& moved = setup.joint(robot, joint_.value());
    body_ = setup.index_of(moved);
    const double* frame = moved.joint_in_body;
    origin_ = {frame[0], frame[1], frame[2]};
    axes_ = {frame[3], frame[4], frame[5], frame[6]};
    reaction_ = setup.joint_reaction(body_);
    configure_timing(setup, {.size = 6, .may_leave_out = true});
    setup.channel("force", "N", 3, -kInfinity, kInfinity, robot);
    setup.channel("moment", "N m", 3, -kInfinity, kInfinity, robot);
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    const Values<Real> sample = room(env, output);
    if (any(is_due)) measure(env, sample);
    deliver(env, is_due, sample, output, buffer);
  }

 private:
  template <class Real>
  SKYBODY_INLINE void measure(const EnvView<Real>& env, const Values<Real>& sample) const {
    const JointReaction<Real> load = env.joint_reaction(reaction_);
    const Quat<Real> rotation = env.body(body_).rotation;
    const Vec3<Real> arm = rotate(rotation, to_real<Real>(origin_));
    const Quat<Real> axes = rotation * to_real<Real>(axes_);
    Vec3<Real> force = rotate_inverse(axes, load.force);
    Vec3<Real> moment = rotate_inverse(axes, load.moment - cross(arm, load.force));
    if (force_noise_.is_given() || moment_noise_.is_given()) {
      Real draws[6];
      sensor::fill_normal(random(env), draws);
      force = sensor::with_noise(force, force_noise_(env), sensor::vec3_of(draws, 0));
      moment = sensor::with_noise(moment, moment_noise_(env), sensor::vec3_of(draws, 3));
    }
    if (force_bias_.is_given()) force += force_bias_.vec3(env);
    if (moment_bias_.is_given()) moment += moment_bias_.vec3(env);
    sample.set(0, digitized(env, force, force_resolution_, force_range_));
    sample.set(3, digitized(env, moment, moment_resolution_, moment_range_));
  }

  template <class Real>
  static SKYBODY_INLINE Vec3<Real> digitized(const EnvView<Real>& env, const Vec3<Real>& v,
                                             const RealParameter& resolution,
                                             const RealParameter& range) {
    if (!resolution.is_given() && !range.is_given()) return v;
    const auto read = [&](const Real& x) {
      return sensor::saturated(sensor::quantized(x, resolution(env)), range(env));
    };
    return {read(v.x), read(v.y), read(v.z)};
  }
  static RealsSpec bias(const char* name, const char* unit) {
    return when_given(reals(name, unit, {0.0, 0.0, 0.0}, kAny, "offset of each axis"));
  }

  TextParameter robot_{this,
                       word("robot", "", "robot with the joint; optional for a single robot")};
  TextParameter joint_{this, required(word("joint", "", "joint with the sensor"))};
  RealParameter force_noise_{this,
                             sensor::error_size("force_noise", "N", "standard deviation per axis")};
  RealParameter moment_noise_{
      this, sensor::error_size("moment_noise", "N m", "standard deviation per axis")};
  RealsParameter force_bias_{this, bias("force_bias", "N")};
  RealsParameter moment_bias_{this, bias("moment_bias", "N m")};
  RealParameter force_range_{
      this, sensor::error_size("force_range", "N", "greatest magnitude of a reading; 0: no limit")};
  RealParameter moment_range_{this, sensor::error_size("moment_range", "N m",
                                                       "greatest magnitude of a reading; 0: no "
                                                       "limit")};
  RealParameter force_resolution_{
      this, sensor::error_size("force_resolution", "N",
                               "readings are multiples of this; 0: not rounded")};
  RealParameter moment_resolution_{
      this, sensor::error_size("moment_resolution", "N m",
                               "readings are multiples of this; 0: not rounded")};

  int body_ = 0, reaction_ = 0;
  Vec3<double> origin_{};  ///< of the joint, body frame [m]
  Quat<double> axes_{};    ///< body from joint
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::ForceTorque, "force_torque", "1.0.0",
               "Force [N] and moment [N m] that a joint exerts on the body that it moves.");
