// Speeds of a robot's rotors, as motor controllers report them.
#include "sensors/common/errors.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

class RotorSpeed : public sensor::TimedSensor {
 public:
  void configure(const Setup& setup) override {
    const int index = setup.robot(robot_.value());
    const RobotInfo& robot = setup.robots()[index];
    first_ = robot.first_rotor;
    count_ = robot.rotor_count;
    if (count_ == 0) {
      refuse("robot `", robot.name,
             "` has no rotors, whose speeds sensor `rotor_speed` measures: name "
             "another `robot`, or remove the sensor");
    }
    configure_timing(setup, {.size = count_, .may_leave_out = true});
    setup.channel("speed", "rad/s", count_, -kInfinity, kInfinity, index);
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    const Values<Real> speeds = room(env, output);
    if (any(is_due)) measure(env, speeds);
    deliver(env, is_due, speeds, output, buffer);
  }

 private:
  template <class Real>
  SKYBODY_INLINE void measure(const EnvView<Real>& env, const Values<Real>& speeds) const {
    for (int i = 0; i < count_; ++i) speeds.set(i, env.rotor_speed(first_ + i));
    if (noise_.is_given()) {
      Random<Real> draw = random(env);
      for (int i = 0; i < count_; i += 2) {
        Real errors[2];
        draw.normal_pair(errors[0], errors[1]);
        for (int k = i; k < i + 2 && k < count_; ++k) {
          speeds.set(k, sensor::with_noise(speeds[k], noise_(env), errors[k - i]));
        }
      }
    }
    if (!resolution_.is_given()) return;
    for (int i = 0; i < count_; ++i) {
      speeds.set(i, sensor::quantized(speeds[i], resolution_(env)));
    }
  }

  TextParameter robot_{this, word("robot", "", "robot with the rotors; optional for a single one")};
  RealParameter noise_{this,
                       sensor::error_size("noise", "rad/s", "standard deviation of each reading")};
  RealParameter resolution_{
      this,
      sensor::error_size("resolution", "rad/s", "readings are multiples of this; 0: not rounded")};

  int first_ = 0, count_ = 0;  ///< world rotors
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::RotorSpeed, "rotor_speed", "1.0.0", "Speeds of a robot's rotors [rad/s].");
