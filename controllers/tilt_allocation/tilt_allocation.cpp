// Allocates a wrench of the whole robot to rotors on tilting joints: rotor speeds and joint angles.
#include <string>
#include <vector>

#include "controllers/tilt_allocation/tilt_inverse.h"

namespace skybody {
namespace {

class TiltAllocation : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    const control::CompositeBody all = control::assembly_of(setup, robot);
    arms_ = TiltArms(setup, robot, all);
    first_rotor_ = setup.robots()[robot].first_rotor;
    rotors_ = setup.robots()[robot].rotor_count;
    inverse_ = TiltInverse(arms_, control::robot_name(setup, robot));
    for (const TiltArm& arm : arms_.all()) servo_.declare(setup, arm.joint, arm.inertia);
    Vec3<double> force{0.0, 0.0, 0.0}, moment{0.0, 0.0, 0.0};
    arms_.add_reach(force, moment);
    setup.input(Signal::kWrench, {-force.x, -force.y, -force.z, -moment.x, -moment.y, -moment.z},
                {force.x, force.y, force.z, moment.x, moment.y, moment.z});
    setup.output(Signal::kRotorSpeed, rotors_);
    setup.output(Signal::kJoint, static_cast<int>(arms_.all().size()));
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    Real wrench[6];
    for (int k = 0; k < 6; ++k) wrench[k] = input[k];
    const std::vector<TiltArm>& arms = arms_.all();
    for (std::size_t i = 0; i < arms.size(); ++i) {
      const TiltArm& arm = arms[i];
      const Real along = inverse_.along(i, wrench), across = inverse_.across(i, wrench);
      const Real push = sqrt(along * along + across * across);
      set_speeds(arm, push, output);
      output.set(rotors_ + static_cast<int>(i), angle(env, arm, push, along, across));
    }
  }

 private:
  /// The rotors of an arm share its thrust equally.
  template <class Real>
  SKYBODY_INLINE void set_speeds(const TiltArm& arm, const Real& push, Values<Real> output) const {
    const Real share = clamp(push, Real(0.0), Real(arm.full)) * Real(1.0 / arm.rotors.size());
    for (const TiltRotor& rotor : arm.rotors) {
      output.set(rotor.index - first_rotor_, sqrt(share * rotor.per_constant));
    }
  }

  /// The equivalent tilt nearest to the present one. Without significant thrust, the tilt is held.
  template <class Real>
  SKYBODY_INLINE Real angle(const EnvView<Real>& env, const TiltArm& arm, const Real& push,
                            const Real& along, const Real& across) const {
    const Real now = env.q(arm.joint.q);
    const auto idle = push < least_share_.value() * arm.full;
    const Real turn = wrap_angle(atan2(across, along) - now);
    const Real setpoint = now + select(idle, Real(0.0), turn);
    return arm.joint.low < arm.joint.high
               ? clamp(setpoint, Real(arm.joint.low), Real(arm.joint.high))
               : setpoint;
  }

  control::Servo servo_{this};
  RealParameter least_share_{this,
                             real("least_share", "", 0.005, between(0.0, 0.5),
                                  "share of an arm's full thrust below which its angle is held")};

  TiltArms arms_;
  TiltInverse inverse_;
  int first_rotor_ = 0, rotors_ = 0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::TiltAllocation, "tilt_allocation", "1.0.0",
               "Allocates a wrench to rotors on tilting joints: rotor speeds and joint angles.");
