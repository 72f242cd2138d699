// Inertial measurement unit on any link: specific force and angular rate, with the errors
// of real units.
#include "sensors/common/mount.h"
#include "sensors/common/timed_sensor.h"
#include "sensors/imu/triad.h"

namespace skybody {
namespace {

using sensor::fill_normal;
using sensor::vec3_of;

class Imu : public sensor::TimedSensor {
 public:
  template <class Real>
  struct State {
    Vec3<Real> force_bias;  ///< [m/s^2]
    Vec3<Real> rate_bias;   ///< [rad/s]
    Vec3<Real> force;       ///< latest sample, held until the next
    Vec3<Real> rate;
    Real walked;  ///< physics step of the latest update of the biases' random walk
  };

  void configure(const Setup& setup) override {
    mount_.configure(setup);
    gravity_ = setup.find_params("gravity")[0];
    dt_ = setup.dt();
    preset_ = imu::preset_called(preset_name_.value());
    accelerometer_.configure(preset_.accelerometer);
    gyroscope_.configure(preset_.gyroscope);
    is_unstable_ = accelerometer_.is_unstable() || gyroscope_.is_unstable();
    has_g_sensitivity_ = g_sensitivity_.is_given() || preset_.g_sensitivity > 0.0;
    setup.need_bodies_before();
    configure_timing(
        setup, {.size = 6, .own_words = is_unstable_ ? 6 : 0, .may_leave_out = !is_unstable_});
    setup.channel("specific_force", "m/s^2", 3, -kInfinity, kInfinity, mount_.robot());
    setup.channel("angular_rate", "rad/s", 3, -kInfinity, kInfinity, mount_.robot());
  }

  /// Draws the initial biases of the episode.
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    Real draws[6];
    fill_normal(random(env, kStartDraws), draws);
    state.force_bias =
        vec3_of(draws, 0) * standard(accelerometer_bias_, preset_.accelerometer.bias, env);
    state.rate_bias = vec3_of(draws, 3) * standard(gyroscope_bias_, preset_.gyroscope.bias, env);
    state.walked = Real(0.0);
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>& state, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    if (any(is_due)) sample(env, state, is_due, buffer);
    const Values<Real> taken = room(env, output);
    taken.set(0, state.force);
    taken.set(3, state.rate);
    deliver(env, is_due, taken, output, buffer);
  }

 private:
  static constexpr std::uint64_t kSampleDraws = 0, kStartDraws = 1, kWalkDraws = 2,
                                 kWanderDraws = 3;
  /// Limit of physics steps without calls. A restored state may contain any value.
  static constexpr double kLongestLeftOut = SKYBODY_LONGEST_LEFT_OUT;

  /// A parameter, or the preset's value where neither scenario nor draw sets it.
  template <class Real>
  static SKYBODY_INLINE Real standard(const RealParameter& given, double preset,
                                      const EnvView<Real>& env) {
    const Real value = given(env);
    if (given.is_given() || preset == 0.0) return value;
    return select(value > 0.0, value, Real(preset));
  }
  template <class Real>
  SKYBODY_INLINE Real force_noise(const EnvView<Real>& env) const {
    return standard(accelerometer_noise_, preset_.accelerometer.noise, env);
  }
  template <class Real>
  SKYBODY_INLINE Real rate_noise(const EnvView<Real>& env) const {
    return standard(gyroscope_noise_, preset_.gyroscope.noise, env);
  }

  /// Takes samples in the lanes of `due`.
  template <class Real>
  SKYBODY_INLINE void sample(const EnvView<Real>& env, State<Real>& state, const MaskOf<Real>& due,
                             const Values<Real>& buffer) const {
    const BodyMotion<Real> now = env.body(mount_.body()), before = env.body_before(mount_.body());
    const Vec3<Real> acceleration =
        (mount_.velocity(env, now) - mount_.velocity(env, before)) / Real(dt_);
    const Quat<Real> axes = mount_.rotation(env);
    const Vec3<Real> gravity{env.param(gravity_), env.param(gravity_ + 1), env.param(gravity_ + 2)};
    Vec3<Real> force = rotate_inverse(now.rotation * axes, acceleration - gravity);
    Vec3<Real> rate = rotate_inverse(axes, now.angular_velocity);
    distort(env, force, rate);
    if (any(is_on(force_noise(env), rate_noise(env)))) {
      Real draws[6];
      fill_normal(random(env, kSampleDraws), draws);
      add_noise(vec3_of(draws, 0), force_noise(env), force);
      add_noise(vec3_of(draws, 3), rate_noise(env), rate);
    }
    walk(env, state, buffer);
    force += state.force_bias;
    rate += state.rate_bias;
    if (is_unstable_) wander(env, due, force, rate, buffer);
    state.force = select(due, accelerometer_.digitized(env, force), state.force);
    state.rate = select(due, gyroscope_.digitized(env, rate), state.rate);
  }

  /// Errors in proportion to the motion.
  template <class Real>
  SKYBODY_INLINE void distort(const EnvView<Real>& env, Vec3<Real>& force, Vec3<Real>& rate) const {
    rate = gyroscope_.distorted(env, rate);
    if (has_g_sensitivity_) {
      const double g = preset_.g_sensitivity;
      const Vec3<Real> per_force = g_sensitivity_.is_given()
                                       ? g_sensitivity_.vec3(env)
                                       : Vec3<Real>{Real(g), Real(g), Real(g)};
      rate += multiply_elements(per_force, force);
    }
    force = accelerometer_.distorted(env, force);
  }

  template <class Real>
  SKYBODY_INLINE Real instability(const EnvView<Real>& env, int i) const {
    return i < 3 ? accelerometer_.instability(env) : gyroscope_.instability(env);
  }

  /// Adds the wandering biases, after their next step.
  template <class Real>
  SKYBODY_INLINE void wander(const EnvView<Real>& env, const MaskOf<Real>& due, Vec3<Real>& force,
                             Vec3<Real>& rate, const Values<Real>& buffer) const {
    Real draws[6];
    fill_normal(random(env, kWanderDraws), draws);
    for (int i = 0; i < 6; ++i) {
      sensor::wandered(env, due, instability(env, i), instability_time_(env), interval(), draws[i],
                       buffer, i);
    }
    force += buffer.vec3(0);
    rate += buffer.vec3(3);
  }

  template <class Real>
  static SKYBODY_INLINE MaskOf<Real> is_on(const Real& a, const Real& b) {
    return logical_or(a > 0.0, b > 0.0);
  }

  /// Random walk of the biases since the last call, one due sample after another.
  template <class Real>
  SKYBODY_INLINE void walk(const EnvView<Real>& env, State<Real>& state,
                           const Values<Real>& buffer) const {
    const Real now = to_real(env.physics_step());
    if (none(is_on(accelerometer_walk_(env), gyroscope_walk_(env)))) {
      state.walked = now;
      return;
    }
    const double steps = static_cast<double>(period());
    const Real first = phase(buffer);
    const Real longest_ago = now - (kLongestLeftOut + steps);
    const Real walked = select(state.walked >= longest_ago, state.walked, longest_ago);
    Real sample = first + (floor((walked - first) / steps) + 1.0) * steps;
    // Counted loop: a restored step number may be so large that adding a period changes nothing.
    const int most = static_cast<int>(kLongestLeftOut / steps) + 2;
    for (int k = 0; k < most && any(logical_and(sample <= now, env.served())); ++k) {
      Real draws[6];
      fill_normal(random_at(env, to_word(sample), kWalkDraws), draws);
      walk(vec3_of(draws, 0), accelerometer_walk_(env), sample <= now, state.force_bias);
      walk(vec3_of(draws, 3), gyroscope_walk_(env), sample <= now, state.rate_bias);
      sample += steps;
    }
    state.walked = now;
  }

  /// A density of zero leaves all bits unchanged, independent of other lanes.
  template <class Real>
  SKYBODY_INLINE void walk(const Vec3<Real>& draw, const Real& density, MaskOf<Real> walks,
                           Vec3<Real>& bias) const {
    const Vec3<Real> moved = bias + draw * (density * sqrt(interval()));
    bias = select(logical_and(walks, density > 0.0), moved, bias);
  }
  template <class Real>
  SKYBODY_INLINE void add_noise(const Vec3<Real>& draw, const Real& density,
                                Vec3<Real>& value) const {
    value = select(density > 0.0, value + draw * (density / sqrt(interval())), value);
  }

  sensor::Mount mount_{this};
  TextParameter preset_name_{
      this,
      choice("preset", "none", {"none", "bmi088", "icm42688", "mpu6000", "adis16448"},
             "errors of a part by its datasheet; parameters that are set replace its values")};
  RealParameter accelerometer_noise_{
      this, randomizable(real("accelerometer_noise", "m/s^2/sqrt(Hz)", 0.0, at_least(0.0),
                              "density of the white noise"))};
  RealParameter gyroscope_noise_{
      this, randomizable(real("gyroscope_noise", "rad/s/sqrt(Hz)", 0.0, at_least(0.0),
                              "density of the white noise"))};
  RealParameter accelerometer_walk_{
      this, randomizable(real("accelerometer_walk", "m/s^3/sqrt(Hz)", 0.0, at_least(0.0),
                              "density of the bias's random walk"))};
  RealParameter gyroscope_walk_{
      this, randomizable(real("gyroscope_walk", "rad/s^2/sqrt(Hz)", 0.0, at_least(0.0),
                              "density of the bias's random walk"))};
  RealParameter accelerometer_bias_{
      this, randomizable(real("accelerometer_bias", "m/s^2", 0.0, at_least(0.0),
                              "standard deviation of the bias at a reset, per axis"))};
  RealParameter gyroscope_bias_{
      this, randomizable(real("gyroscope_bias", "rad/s", 0.0, at_least(0.0),
                              "standard deviation of the bias at a reset, per axis"))};

  imu::Triad accelerometer_{this, imu::kAccelerometer};
  imu::Triad gyroscope_{this, imu::kGyroscope};
  RealsParameter g_sensitivity_{
      this, when_given(reals("g_sensitivity", "rad/s/(m/s^2)", {0.0, 0.0, 0.0}, kAny,
                             "angular rate of x, y, z per specific force on that axis"))};
  RealParameter instability_time_{this,
                                  when_given(real("instability_time", "s", 100.0, at_least(1e-3),
                                                  "correlation time of the wandering biases"))};

  imu::Preset preset_{};
  int gravity_ = 0;  ///< first EnvParam
  double dt_ = 0.0;
  bool is_unstable_ = false, has_g_sensitivity_ = false;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Imu, "imu", "1.1.0",
               "Inertial measurement unit: specific force [m/s^2] and angular rate [rad/s].");
