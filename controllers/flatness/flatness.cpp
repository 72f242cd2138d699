// Converts a trajectory to a lower-level command by differential flatness: feed-forward, plus
// feedback of position and velocity if the gains are above 0.
#include "controllers/common/flatness.h"

#include "controllers/common/guidance.h"
#include "controllers/common/trajectory.h"

namespace skybody {
namespace {

class FlatnessLaw : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    mass_ = control::total_mass(setup, robot);
    drag_.configure(setup, robot);
    guidance_.configure(setup);
    trajectory_.configure(setup);
    const std::string& word = output_.value();
    level_ = word == "attitude" ? Level::kAttitude
             : word == "ctbr"   ? Level::kCtbr
             : word == "force"  ? Level::kForce
                                : Level::kAcceleration;
    setup.output(level_ == Level::kAttitude ? Signal::kAttitude
                 : level_ == Level::kCtbr   ? Signal::kCtbr
                 : level_ == Level::kForce  ? Signal::kForce
                                            : Signal::kAcceleration,
                 level_ == Level::kAttitude ? 8 : 4);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input, Values<Real> output,
               Values<Real> buffer) const {
    const ReferencePoint<Real> reference = reference_point(input);
    const BodyMotion<Real> base = env.body(base_);
    const Vec3<Real> z = body_z(base.rotation);
    const Vec3<Real> setpoint = guidance_.setpoint(env, reference.position - base.position,
                                                   base.velocity - reference.velocity,
                                                   drag_.acceleration(reference, z), buffer);
    if (level_ == Level::kAcceleration) {
      output.set(0, guidance_.limits().held(setpoint, buffer));
      output.set(3, reference.yaw);
      return;
    }
    const Vec3<Real> thrust = guidance_.limits().thrust(setpoint, buffer);
    if (level_ == Level::kForce) {
      output.set(0, thrust * Real(mass_));
      output.set(3, reference.yaw);
      return;
    }
    const auto flat = control::flat_attitude(thrust, reference.yaw);
    const auto rates = control::flat_rates(flat, reference.jerk, reference.yaw_rate);
    output.set(0, max(Real(0.0), mass_ * dot(thrust, z)));
    if (level_ == Level::kAttitude) output.set(1, flat.rotation);
    output.set(level_ == Level::kAttitude ? 5 : 1, rates.value);
  }

 private:
  enum class Level { kAttitude, kCtbr, kForce, kAcceleration };

  TextParameter output_{this,
                        choice("output", "attitude", {"attitude", "ctbr", "force", "acceleration"},
                               "output; an attitude includes its rates")};
  control::Guidance guidance_{this, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, control::kTrajectoryLimits};
  control::DragFeedforward drag_{this};
  control::TrajectoryInput trajectory_{this};

  Level level_ = Level::kAttitude;
  int base_ = 0;
  double mass_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::FlatnessLaw, "flatness", "1.0.0",
               "Follows a trajectory by differential flatness; output: attitude, ctbr, force or "
               "acceleration.");
