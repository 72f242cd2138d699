// Inertial navigation by an extended Kalman filter on errors: an IMU, corrected by motion capture
// or satellite navigation, a barometer and a magnetometer. It reads other sensors.
#include "sensors/common/timed_sensor.h"
#include "sensors/ekf/covariance.h"
#include "sensors/ekf/tuning.h"

namespace skybody {
namespace {

using ekf::Covariance;
using ekf::Errors;
using ekf::Row;

/// Estimated motion, and the sources of the filter.
template <class Real>
struct Estimate {
  Vec3<Real> position, velocity;  ///< W
  Quat<Real> rotation;            ///< W from the IMU's axes
  Vec3<Real> force_bias, rate_bias;
  Vec3<Real> rate;  ///< [rad/s], IMU axes
  Real origin;      ///< altitude of W's origin as the barometer shows it [m]
};

class Ekf : public sensor::TimedSensor {
 public:
  void configure(const Setup& setup) override {
    const int robot = setup.robot(robot_.value());
    force_ = channel(setup, "imu", imu_, "specific_force");
    rate_ = channel(setup, "imu", imu_, "angular_rate");
    find_sources(setup);
    gravity_ = setup.find_params("gravity")[0];
    const Vec3<double> west = cross(Vec3<double>{0.0, 0.0, 1.0}, field_.vec3());
    if (has(magnetometer_) && !(norm(west) > 0.0)) {
      refuse("`field` is vertical and shows no heading: give its level part");
    }
    west_ = west / norm(west);
    dt_ = setup.dt();
    configure_timing(setup, {.size = kOutputs, .own_words = kWords});
    setup.channel("position", "m", 3, -kInfinity, kInfinity, robot);
    setup.channel("velocity", "m/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("rotation", "", 4, -1.0, 1.0, robot);
    setup.channel("angular_rate", "rad/s", 3, -kInfinity, kInfinity, robot);
    setup.channel("deviation", "", 9, 0.0, kInfinity, robot);
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>&, Values<Real> output,
             Values<Real> buffer) const {
    const auto is_due = due(env, buffer);
    const Values<Real> sample = room(env, output);
    if (any(is_due)) estimate(env, is_due, sample, buffer);
    deliver(env, is_due, sample, output, buffer);
  }

 private:
  // Buffer words: the estimate, its covariance, stamps of the last measurements, the time of the
  // last call.
  static constexpr int kEstimate = 0, kOrigin = 19, kCovariance = kOrigin + 1,
                       kStamps = kCovariance + ekf::kCovarianceWords, kPose = 0, kGnss = 1,
                       kBarometer = 2, kMagnetometer = 3, kLast = kStamps + 4, kWords = kLast + 1,
                       kOutputs = 22;

  static bool has(const TextParameter& source) { return !source.value().empty(); }

  /// Index of a sensor's channel; errors name the parameter.
  static int channel(const Setup& setup, const std::string& parameter, const TextParameter& source,
                     const char* name) {
    try {
      return setup.sensor(source.value(), name);
    } catch (const std::runtime_error& error) {
      refuse("`", parameter, "` is `", source.value(), "`: ", error.what(),
             "; name a sensor that stands before this one");
    }
  }

  void find_sources(const Setup& setup) {
    if (!has(pose_) && !has(gnss_)) {
      refuse(
          "no source of position: name a sensor by `pose`, or one each by `gnss` and "
          "`magnetometer`");
    }
    if (!has(pose_) && !has(magnetometer_)) {
      refuse("`gnss` shows no heading: name a `magnetometer`, too");
    }
    const auto find = [&](const char* parameter, const TextParameter& source, const char* value,
                          int number) {
      if (!has(source)) return;
      value_[number] = channel(setup, parameter, source, value);
      stamp_[number] = channel(setup, parameter, source, "stamp");
    };
    find("pose", pose_, "position", kPose);
    find("gnss", gnss_, "position", kGnss);
    find("barometer", barometer_, "altitude", kBarometer);
    find("magnetometer", magnetometer_, "field", kMagnetometer);
    if (has(pose_)) pose_rotation_ = channel(setup, "pose", pose_, "rotation");
    if (has(gnss_)) gnss_velocity_ = channel(setup, "gnss", gnss_, "velocity");
  }

  template <class Real>
  static Vec3<Real> seen(const EnvView<Real>& env, int first) {
    return {env.sensor(first), env.sensor(first + 1), env.sensor(first + 2)};
  }

  template <class Real>
  void estimate(const EnvView<Real>& env, const MaskOf<Real>& due, const Values<Real>& sample,
                const Values<Real>& buffer) const {
    const auto fresh = env.physics_step() == Word<Real>(0);
    const Real now = to_real(env.physics_step()) * dt_;
    if (any(fresh)) begin(env, fresh, buffer);
    Estimate<Real> state = load(buffer);
    Covariance<Real> covariance(buffer, kCovariance);
    propagate(env, select(due, now - buffer[kLast], Real(0.0)), state, covariance);
    correct(env, due, now, state, covariance, buffer);
    write(state, covariance, sample);
    store(env, due, now, state, covariance, buffer);
  }

  /// The first estimate: from the samples of the reset, without velocity unless `gnss` shows it.
  template <class Real>
  void begin(const EnvView<Real>& env, const MaskOf<Real>& fresh,
             const Values<Real>& buffer) const {
    const Vec3<Real> zero{Real(0.0), Real(0.0), Real(0.0)};
    Estimate<Real> state{zero,     zero, Quat<Real>::identity(), zero, zero, seen(env, rate_),
                         Real(0.0)};
    const int source = has(pose_) ? kPose : kGnss;
    state.position = seen(env, value_[source]);
    if (has(gnss_)) state.velocity = seen(env, gnss_velocity_);
    if (has(pose_)) {
      state.rotation = {env.sensor(pose_rotation_), env.sensor(pose_rotation_ + 1),
                        env.sensor(pose_rotation_ + 2), env.sensor(pose_rotation_ + 3)};
    } else {
      state.rotation = level(env);
    }
    if (has(barometer_)) state.origin = env.sensor(value_[kBarometer]) - state.position.z;
    save(fresh, state, first_covariance(env), buffer);
    const auto put = [&](int word, const Real& value) {
      buffer.set(word, select(fresh, value, buffer[word]));
    };
    for (int k = 0; k < 4; ++k) {
      if (stamp_[k] >= 0) put(kStamps + k, env.sensor(stamp_[k]));
    }
    put(kLast, Real(0.0));
  }

  /// A position of satellites is not better than their assumed noise.
  template <class Real>
  Covariance<Real> first_covariance(const EnvView<Real>& env) const {
    const auto equal = [](const Real& d) { return Vec3<Real>{d, d, d}; };
    Vec3<Real> place = equal(tuning_.first_position(env));
    if (!has(pose_)) {
      const Real level = max(place.x, tuning_.horizontal_noise(env));
      place = {level, level, max(place.z, tuning_.vertical_noise(env))};
    }
    return {{place, equal(tuning_.first_velocity(env)), equal(tuning_.first_rotation(env)),
             equal(tuning_.first_force_bias(env)), equal(tuning_.first_rate_bias(env))},
            tuning_.altitude_noise(env)};
  }

  /// Rotation by two directions: specific force for up, magnetic field for north (TRIAD).
  template <class Real>
  Quat<Real> level(const EnvView<Real>& env) const {
    const Vec3<Real> force = seen(env, force_);
    const Vec3<Real> up = force / norm(force);
    const Vec3<Real> side = cross(up, seen(env, value_[kMagnetometer]));
    const Vec3<Real> west = side / norm(side), north = cross(west, up);
    const Vec3<Real> w = to_real<Real>(west_);
    const Vec3<Real> n{w.y, -w.x, Real(0.0)};
    const auto row = [&](const Real& by_north, const Real& by_west) {
      return north * by_north + west * by_west;
    };
    const Vec3<Real> x = row(n.x, w.x), y = row(n.y, w.y);
    return from_rotation(Mat3<Real>{{x.x, x.y, x.z, y.x, y.y, y.z, up.x, up.y, up.z}});
  }

  /// Strapdown integration over `dt`. The IMU's force is the mean over the last step, in the axes
  /// at its end.
  template <class Real>
  void propagate(const EnvView<Real>& env, const Real& dt, Estimate<Real>& state,
                 Covariance<Real>& covariance) const {
    const Vec3<Real> force = seen(env, force_) - state.force_bias;
    state.rate = seen(env, rate_) - state.rate_bias;
    const Vec3<Real> half = state.rate * (0.5 * dt);
    state.rotation = normalized(state.rotation * Quat<Real>{Real(1.0), half.x, half.y, half.z});
    const Mat3<Real> axes = to_mat3(state.rotation);
    const Vec3<Real> gravity = env.param_vec3(gravity_);
    const Vec3<Real> before = state.velocity;
    state.velocity += (axes * force + gravity) * dt;
    state.position += (before + state.velocity) * (0.5 * dt);
    const Real densities[5] = {square(tuning_.force_noise(env)), square(tuning_.rate_noise(env)),
                               square(tuning_.force_walk(env)), square(tuning_.rate_walk(env)),
                               square(tuning_.altitude_walk(env))};
    covariance.predict(axes, force, state.rate, dt, densities);
  }

  /// Lanes in which a source has a sample that was not used yet.
  template <class Real>
  MaskOf<Real> is_new(const EnvView<Real>& env, const MaskOf<Real>& due, int source,
                      const Values<Real>& buffer) const {
    if (stamp_[source] < 0) return MaskOf<Real>(false);
    return logical_and(due, env.sensor(stamp_[source]) != buffer[kStamps + source]);
  }

  template <class Real>
  void correct(const EnvView<Real>& env, const MaskOf<Real>& due, const Real& now,
               Estimate<Real>& state, Covariance<Real>& covariance,
               const Values<Real>& buffer) const {
    Errors<Real> errors;
    for (Real& e : errors.value) e = Real(0.0);
    const auto age = [&](int source) { return now - env.sensor(stamp_[source]); };
    if (const auto on = is_new(env, due, kPose, buffer); any(on)) {
      const Real late = age(kPose);
      const Real spread = tuning_.position_noise(env);
      take_position(on, seen(env, value_[kPose]), late, {spread, spread, spread}, state, covariance,
                    errors);
      take_rotation(env, on, late, state, covariance, errors);
    }
    if (const auto on = is_new(env, due, kGnss, buffer); any(on)) {
      const Real level = tuning_.horizontal_noise(env);
      take_position(on, seen(env, value_[kGnss]), age(kGnss),
                    {level, level, tuning_.vertical_noise(env)}, state, covariance, errors);
      const Vec3<Real> wrong = seen(env, gnss_velocity_) - state.velocity;
      take_parts(on, wrong, ekf::kVelocity, tuning_.velocity_noise(env), covariance, errors);
    }
    if (const auto on = is_new(env, due, kBarometer, buffer); any(on)) {
      const Real height = env.sensor(value_[kBarometer]) - state.origin;
      const Real late = age(kBarometer);
      const Row<Real> row{
          3, {ekf::kPosition + 2, ekf::kVelocity + 2, ekf::kOrigin}, {Real(1.0), -late, Real(1.0)}};
      covariance.update(on, row, height - (state.position.z - state.velocity.z * late),
                        square(tuning_.altitude_noise(env)), errors);
    }
    if (const auto on = is_new(env, due, kMagnetometer, buffer); any(on)) {
      take_field(env, on, state, covariance, errors);
    }
    inject(errors, state);
  }

  /// Position at the time of the sample: the estimate less its motion since.
  template <class Real>
  static void take_position(const MaskOf<Real>& on, const Vec3<Real>& measured, const Real& late,
                            const Vec3<Real>& deviations, const Estimate<Real>& state,
                            Covariance<Real>& covariance, Errors<Real>& errors) {
    const Vec3<Real> wrong = measured - (state.position - state.velocity * late);
    const Real seen[3] = {wrong.x, wrong.y, wrong.z};
    const Real deviation[3] = {deviations.x, deviations.y, deviations.z};
    for (int i = 0; i < 3; ++i) {
      const Row<Real> row{2, {ekf::kPosition + i, ekf::kVelocity + i, 0}, {Real(1.0), -late, late}};
      covariance.update(on, row, seen[i], square(deviation[i]), errors);
    }
  }

  template <class Real>
  void take_rotation(const EnvView<Real>& env, const MaskOf<Real>& on, const Real& late,
                     const Estimate<Real>& state, Covariance<Real>& covariance,
                     Errors<Real>& errors) const {
    const Vec3<Real> half = state.rate * (-0.5 * late);
    const Quat<Real> then = state.rotation * Quat<Real>{Real(1.0), half.x, half.y, half.z};
    const Quat<Real> measured{env.sensor(pose_rotation_), env.sensor(pose_rotation_ + 1),
                              env.sensor(pose_rotation_ + 2), env.sensor(pose_rotation_ + 3)};
    const Quat<Real> wrong = normalized(conjugate(then) * measured);
    const Real sign = copysign(2.0, wrong.w);
    take_parts(on, Vec3<Real>{wrong.x, wrong.y, wrong.z} * sign, ekf::kRotation,
               tuning_.rotation_noise(env), covariance, errors);
  }

  /// Measures three errors themselves.
  template <class Real>
  static void take_parts(const MaskOf<Real>& on, const Vec3<Real>& wrong, int first,
                         const Real& deviation, Covariance<Real>& covariance,
                         Errors<Real>& errors) {
    const Real seen[3] = {wrong.x, wrong.y, wrong.z};
    for (int i = 0; i < 3; ++i) {
      const Row<Real> row{1, {first + i, 0, 0}, {Real(1.0), Real(0.0), Real(0.0)}};
      covariance.update(on, row, seen[i], square(deviation), errors);
    }
  }

  /// The field in body axes turns against the rotation: its error is field x rotation.
  template <class Real>
  void take_field(const EnvView<Real>& env, const MaskOf<Real>& on, const Estimate<Real>& state,
                  Covariance<Real>& covariance, Errors<Real>& errors) const {
    const Vec3<Real> field = rotate_inverse(state.rotation, field_.vec3(env));
    const Vec3<Real> wrong = seen(env, value_[kMagnetometer]) - field;
    const Mat3<Real> by_rotation = skew(field);
    const Real difference[3] = {wrong.x, wrong.y, wrong.z};
    for (int i = 0; i < 3; ++i) {
      const Vec3<Real> f = by_rotation.row(i);
      const Row<Real> row{
          3, {ekf::kRotation, ekf::kRotation + 1, ekf::kRotation + 2}, {f.x, f.y, f.z}};
      covariance.update(on, row, difference[i], square(tuning_.field_noise(env)), errors);
    }
  }

  template <class Real>
  static void inject(const Errors<Real>& errors, Estimate<Real>& state) {
    state.position += errors.part(ekf::kPosition);
    state.velocity += errors.part(ekf::kVelocity);
    const Vec3<Real> half = errors.part(ekf::kRotation) * Real(0.5);
    state.rotation = normalized(state.rotation * Quat<Real>{Real(1.0), half.x, half.y, half.z});
    state.force_bias += errors.part(ekf::kForceBias);
    state.rate_bias += errors.part(ekf::kRateBias);
    state.rate -= errors.part(ekf::kRateBias);
    state.origin += errors.value[ekf::kOrigin];
  }

  template <class Real>
  static void write(const Estimate<Real>& state, const Covariance<Real>& covariance,
                    const Values<Real>& sample) {
    sample.set(0, state.position);
    sample.set(3, state.velocity);
    sample.set(6, state.rotation);
    sample.set(10, state.rate);
    for (int i = 0; i < 9; ++i) sample.set(13 + i, sqrt(max(covariance.variance(i), 0.0)));
  }

  template <class Real>
  static Estimate<Real> load(const Values<Real>& buffer) {
    return {buffer.vec3(0),  buffer.vec3(3),  buffer.quat(6), buffer.vec3(10),
            buffer.vec3(13), buffer.vec3(16), buffer[kOrigin]};
  }
  template <class Real>
  static void save(const MaskOf<Real>& where, const Estimate<Real>& state,
                   const Covariance<Real>& covariance, const Values<Real>& buffer) {
    const auto put = [&](int word, const Vec3<Real>& v) SKYBODY_INLINE_LAMBDA {
      buffer.set(word, select(where, v, buffer.vec3(word)));
    };
    put(kEstimate, state.position);
    put(kEstimate + 3, state.velocity);
    buffer.set(kEstimate + 6, select(where, state.rotation, buffer.quat(kEstimate + 6)));
    put(kEstimate + 10, state.force_bias);
    put(kEstimate + 13, state.rate_bias);
    put(kEstimate + 16, state.rate);
    buffer.set(kOrigin, select(where, state.origin, buffer[kOrigin]));
    covariance.store(where, buffer, kCovariance);
  }
  template <class Real>
  void store(const EnvView<Real>& env, const MaskOf<Real>& due, const Real& now,
             const Estimate<Real>& state, const Covariance<Real>& covariance,
             const Values<Real>& buffer) const {
    save(due, state, covariance, buffer);
    for (int k = 0; k < 4; ++k) {
      const int word = kStamps + k;
      if (stamp_[k] >= 0) buffer.set(word, select(due, env.sensor(stamp_[k]), buffer[word]));
    }
    buffer.set(kLast, select(due, now, buffer[kLast]));
  }

  TextParameter robot_{this,
                       word("robot", "", "robot with the sensors; optional for a single one")};
  TextParameter imu_{this, word("imu", "imu", "instance of an `imu`")};
  TextParameter pose_{this, word("pose", "", "instance of a `pose`; empty: none")};
  TextParameter gnss_{this, word("gnss", "", "instance of a `gnss`; empty: none")};
  TextParameter barometer_{this, word("barometer", "", "instance of a `barometer`; empty: none")};
  TextParameter magnetometer_{
      this, word("magnetometer", "", "instance of a `magnetometer`; empty: none")};
  RealsParameter field_{this, when_given(reals("field", "uT", {20.0, 0.0, -44.0}, kAny,
                                               "magnetic field that the filter assumes, W axes"))};
  ekf::Tuning tuning_{this};

  // For EnvView::sensor(); -1: no such source.
  int force_ = 0, rate_ = 0, pose_rotation_ = -1, gnss_velocity_ = -1;
  int value_[4] = {-1, -1, -1, -1}, stamp_[4] = {-1, -1, -1, -1};
  int gravity_ = 0;      ///< first EnvParam
  Vec3<double> west_{};  ///< magnetic west in W, level
  double dt_ = 0.0;
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Ekf, "ekf", "1.0.0",
               "Kalman filter of IMU, motion capture or satellites, barometer and magnetometer.");
