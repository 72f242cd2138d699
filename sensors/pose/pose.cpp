// Motion capture: position and attitude of a link.
#include "sensors/common/errors.h"
#include "sensors/common/mount.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

class PoseSensor : public sensor::TimedSensor {
 public:
  PoseSensor()
      : TimedSensor({.steps = 0,
                     .rate = 120.0,
                     .doc = "interval of frames; 0: 120 Hz, to the nearest physics step"}) {}

  void configure(const Setup& setup) override {
    mount_.configure(setup);
    configure_timing(setup, {.size = 7, .has_stamp = true, .may_leave_out = true});
    setup.channel("position", "m", 3, -kInfinity, kInfinity, mount_.robot());
    setup.channel("rotation", "", 4, -1.0, 1.0, mount_.robot());
    setup.channel("stamp", "s", 1, 0.0, kInfinity, mount_.robot());
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
    const BodyMotion<Real> body = env.body(mount_.body());
    Vec3<Real> position = mount_.position(env, body);
    Quat<Real> rotation = body.rotation * mount_.rotation(env);
    if (position_noise_.is_given() || rotation_noise_.is_given()) {
      Real draws[6];
      sensor::fill_normal(random(env), draws);
      position = sensor::with_noise(position, position_noise_(env), sensor::vec3_of(draws, 0));
      if (rotation_noise_.is_given()) {
        const Vec3<Real> turn = sensor::vec3_of(draws, 3) * rotation_noise_(env);
        rotation = turned(rotation, turn);
      }
    }
    sample.set(0, position);
    sample.set(3, rotation);
  }

  /// The rotation after a small turn about the sensor's axes; exact to the third order.
  template <class Real>
  static SKYBODY_INLINE Quat<Real> turned(const Quat<Real>& rotation, const Vec3<Real>& turn) {
    return normalized(rotation * Quat<Real>{Real(1.0), 0.5 * turn.x, 0.5 * turn.y, 0.5 * turn.z});
  }

  sensor::Mount mount_{this};
  RealParameter position_noise_{
      this, sensor::error_size("position_noise", "m", "standard deviation per axis")};
  RealParameter rotation_noise_{
      this, sensor::error_size("rotation_noise", "rad",
                               "standard deviation of the rotation error about each axis")};
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::PoseSensor, "pose", "1.0.0",
               "Motion capture: position [m] and quaternion of a link, with time of the frame.");
