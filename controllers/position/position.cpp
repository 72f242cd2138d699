// Position and heading: a PD with gravity feed-forward. Chain `attitude`, then `ctbr`.
#include "controllers/common/flatness.h"

namespace skybody {
namespace {

class Position : public Controller {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    const int robot = setup.robot();
    base_ = control::base_of(setup, robot);
    mass_ = control::total_mass(setup, robot);
    gravity_ = control::gravity_of(setup);
    if (max_down_.value() > 0.9 * gravity_) {
      throw std::runtime_error(
          "`max_acceleration_down` " + to_text(max_down_.value()) +
          " would leave no thrust to steer with: at most 0.9 g = " + to_text(0.9 * gravity_));
    }
    low_ = position_min_.vec3();
    high_ = position_max_.vec3();
    control::require_order("position_min[0]", low_.x, "position_max[0]", high_.x);
    control::require_order("position_min[1]", low_.y, "position_max[1]", high_.y);
    control::require_order("position_min[2]", low_.z, "position_max[2]", high_.z);
    setup.input(Signal::kPosition, {low_.x, low_.y, low_.z, -kPi},
                {high_.x, high_.y, high_.z, kPi});
    setup.output(Signal::kAttitude, 5);
  }

  template <class Real>
  void control(const EnvView<Real>& env, State<Real>&, ConstValues<Real> input,
               Values<Real> output) const {
    const BodyMotion<Real> base = env.body(base_);
    const Vec3<Real> target{clamp(input[0], Real(low_.x), Real(high_.x)),
                            clamp(input[1], Real(low_.y), Real(high_.y)),
                            clamp(input[2], Real(low_.z), Real(high_.z))};
    const Vec3<Real> wish = multiply_elements(kp_.vec3(env), target - base.position) -
                            multiply_elements(kd_.vec3(env), base.velocity);
    const Vec3<Real> force = limited(wish);
    const Vec3<Real> up = force / norm(force);
    output.set(0, max(Real(0.0), mass_ * dot(force, body_z(base.rotation))));
    output.set(1, control::tilted(up, sincos(0.5 * wrap_angle(input[3]))));
  }

 private:
  /// Thrust per mass [m/s^2]: acceleration within its limits, plus weight. Its z stays positive.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> limited(const Vec3<Real>& a) const {
    const Real side = norm(a.x, a.y);
    const Real most(max_side_.value());
    const auto beyond = side > most;
    const Real scale = select(beyond, most / select(beyond, side, Real(1.0)), Real(1.0));
    return {a.x * scale, a.y * scale, clamp(a.z, -max_down_.value(), max_up_.value()) + gravity_};
  }

  RealsParameter kp_{this,
                     {.name = "kp",
                      .unit = "1/s^2",
                      .values = {4.0, 4.0, 9.0},
                      .min = 0.0,
                      .doc = "acceleration per position error, W axes",
                      .randomizable = true}};
  RealsParameter kd_{this,
                     {.name = "kd",
                      .unit = "1/s",
                      .values = {3.2, 3.2, 5.4},
                      .min = 0.0,
                      .doc = "acceleration per velocity, W axes",
                      .randomizable = true}};
  RealParameter max_side_{this,
                          {.name = "max_acceleration_side",
                           .unit = "m/s^2",
                           .value = 4.0,
                           .min = 1e-3,
                           .doc = "limit of the horizontal acceleration asked for"}};
  RealParameter max_up_{this,
                        {.name = "max_acceleration_up",
                         .unit = "m/s^2",
                         .value = 5.0,
                         .min = 1e-3,
                         .doc = "limit of the upward acceleration asked for"}};
  RealParameter max_down_{this,
                          {.name = "max_acceleration_down",
                           .unit = "m/s^2",
                           .value = 4.0,
                           .min = 1e-3,
                           .doc = "limit of the downward acceleration asked for; at most 0.9 g"}};
  RealsParameter position_min_{this,
                               {.name = "position_min",
                                .unit = "m",
                                .values = {-5.0, -5.0, 0.5},
                                .doc = "position that action -1 means (W)"}};
  RealsParameter position_max_{this,
                               {.name = "position_max",
                                .unit = "m",
                                .values = {5.0, 5.0, 3.0},
                                .doc = "position that action +1 means (W)"}};

  Vec3<double> low_{}, high_{};
  int base_ = 0;
  double mass_ = 0.0;
  double gravity_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Position, "position", "1.0.0",
               "Position [m] and yaw [rad]; gives attitude.");
