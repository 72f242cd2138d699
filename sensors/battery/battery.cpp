// Voltage, current and charge of the pack that the effect `battery` simulates.
#include "sensors/common/errors.h"
#include "sensors/common/settings.h"
#include "sensors/common/timed_sensor.h"

namespace skybody {
namespace {

class BatteryMonitor : public sensor::TimedSensor {
 public:
  void configure(const Setup& setup) override {
    const int robot = setup.robot(robot_.value());
    voltage_ = setup.offered("battery.voltage", robot);
    current_ = setup.offered("battery.current", robot);
    charge_ = setup.offered("battery.charge", robot);
    configure_timing(setup, {.size = 3, .may_leave_out = true});
    setup.channel("voltage", "V", 1, -kInfinity, kInfinity, robot);
    setup.channel("current", "A", 1, -kInfinity, kInfinity, robot);
    setup.channel("charge", "", 1, -kInfinity, kInfinity, robot);
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
    Real draws[4] = {Real(0.0), Real(0.0), Real(0.0), Real(0.0)};
    if (voltage_noise_.is_given() || current_noise_.is_given() || charge_noise_.is_given()) {
      sensor::fill_normal(random(env), draws);
    }
    sample.set(0, sensor::with_noise(env.offered(voltage_), voltage_noise_(env), draws[0]));
    sample.set(1, sensor::with_noise(env.offered(current_), current_noise_(env), draws[1]));
    sample.set(2, sensor::with_noise(env.offered(charge_), charge_noise_(env), draws[2]));
  }

  TextParameter robot_{this, word("robot", "", "robot with the pack; optional for a single one")};
  RealParameter voltage_noise_{
      this, sensor::error_size("voltage_noise", "V", "standard deviation of each voltage")};
  RealParameter current_noise_{
      this, sensor::error_size("current_noise", "A", "standard deviation of each current")};
  RealParameter charge_noise_{
      this, sensor::error_size("charge_noise", "", "standard deviation of each charge")};

  int voltage_ = 0, current_ = 0, charge_ = 0;  ///< for EnvView::offered()
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::BatteryMonitor, "battery", "1.0.0",
               "Voltage [V], current [A] and charge of a pack of the effect `battery`.");
