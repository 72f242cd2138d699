// Inertial measurement unit on any link: specific force and angular rate, with noise, bias walk,
// rate and latency.
#include <skybody/plugin.h>

#include <numeric>

namespace skybody {
namespace {

class Imu : public Sensor {
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
    const int robot = setup.robot(robot_.value());
    std::string name = link_.value();
    if (name.empty()) name = setup.bodies()[setup.robots()[robot].first_body].name;
    const LinkInfo& link = setup.link(robot, name);
    const Quat<double> frame{link.rotation[0], link.rotation[1], link.rotation[2],
                             link.rotation[3]};
    body_ = link.body;
    point_ = Vec3<double>{link.position[0], link.position[1], link.position[2]} +
             rotate(frame, position_.vec3());
    rotation_ =
        frame * from_rpy(orientation_.value(0), orientation_.value(1), orientation_.value(2));
    gravity_ = setup.find_params("gravity")[0];
    dt_ = setup.dt();
    // Called at the greatest common divisor of period and latency; the delay line has one entry per
    // call.
    const std::int64_t call = std::gcd(period_.value(), latency_.value());
    places_ = static_cast<int>(latency_.value() / call);
    interval_ = static_cast<double>(period_.value()) * dt_;
    setup.need_bodies_before();
    setup.period(static_cast<int>(call));
    if (places_ > 0) {
      setup.buffer(kSize * places_);
    } else {
      setup.only_when_read();
    }
    setup.channel("specific_force", "m/s^2", 3, -kInfinity, kInfinity, robot);
    setup.channel("angular_rate", "rad/s", 3, -kInfinity, kInfinity, robot);
  }

  /// Draws the initial biases of the episode.
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>& state) const {
    Real draws[6];
    fill_normal(random(env, kStartDraws), draws);
    state.force_bias = vec3(draws, 0) * accelerometer_bias_(env);
    state.rate_bias = vec3(draws, 3) * gyroscope_bias_(env);
    state.walked = Real(0.0);
  }

  template <class Real>
  void sense(const EnvView<Real>& env, State<Real>& state, Values<Real> output,
             Values<Real> buffer) const {
    const Real step = to_real(env.physics_step());
    const double period = static_cast<double>(period_.value());
    const auto due = step - period * floor(step / period) == 0.0;
    sample(env, state, due);
    deliver(state, env.physics_step() == Word<Real>(0), output, buffer);
  }

 private:
  static constexpr std::uint64_t kSampleDraws = 0, kStartDraws = 1, kWalkDraws = 2;
  static constexpr int kSize = 6;
  /// Limit of physics steps without calls. A restored state may contain any value.
  static constexpr double kLongestLeftOut = SKYBODY_LONGEST_LEFT_OUT;

  /// Standard normals, in a loop, because the code of one draw is large.
  template <class Real, int N>
  static SKYBODY_INLINE void fill_normal(Random<Real> draw, Real (&draws)[N]) {
    static_assert(N % 2 == 0);
    for (int k = 0; k < N; k += 2) draw.normal_pair(draws[k], draws[k + 1]);
  }
  template <class Real, int N>
  static SKYBODY_INLINE Vec3<Real> vec3(const Real (&draws)[N], int first) {
    return {draws[first], draws[first + 1], draws[first + 2]};
  }

  template <class Real>
  SKYBODY_INLINE Vec3<Real> point_velocity(const BodyMotion<Real>& m) const {
    const Vec3<Real> arm{Real(point_.x), Real(point_.y), Real(point_.z)};
    return m.velocity + rotate(m.rotation, cross(m.angular_velocity, arm));
  }

  /// Takes samples in the lanes of `due`.
  template <class Real>
  SKYBODY_INLINE void sample(const EnvView<Real>& env, State<Real>& state, MaskOf<Real> due) const {
    const BodyMotion<Real> now = env.body(body_), before = env.body_before(body_);
    const Vec3<Real> acceleration = (point_velocity(now) - point_velocity(before)) / Real(dt_);
    const Quat<Real> mount{Real(rotation_.w), Real(rotation_.x), Real(rotation_.y),
                           Real(rotation_.z)};
    const Vec3<Real> gravity{env.param(gravity_), env.param(gravity_ + 1), env.param(gravity_ + 2)};
    Vec3<Real> force = rotate_inverse(now.rotation * mount, acceleration - gravity);
    Vec3<Real> rate = rotate_inverse(mount, now.angular_velocity);
    if (any(is_on(accelerometer_noise_(env), gyroscope_noise_(env)))) {
      Real draws[6];
      fill_normal(random(env, kSampleDraws), draws);
      add_noise(vec3(draws, 0), accelerometer_noise_(env), force);
      add_noise(vec3(draws, 3), gyroscope_noise_(env), rate);
    }
    walk(env, state);
    force += state.force_bias;
    rate += state.rate_bias;
    state.force = select(due, force, state.force);
    state.rate = select(due, rate, state.rate);
  }

  template <class Real>
  static SKYBODY_INLINE MaskOf<Real> is_on(const Real& a, const Real& b) {
    return logical_or(a > 0.0, b > 0.0);
  }

  /// Random walk of the biases since the last call, one due sample after another.
  template <class Real>
  SKYBODY_INLINE void walk(const EnvView<Real>& env, State<Real>& state) const {
    const Real now = to_real(env.physics_step());
    if (none(is_on(accelerometer_walk_(env), gyroscope_walk_(env)))) {
      state.walked = now;
      return;
    }
    const double period = static_cast<double>(period_.value());
    const Real longest_ago = now - (kLongestLeftOut + period);
    const Real walked = select(state.walked >= longest_ago, state.walked, longest_ago);
    Real sample = (floor(walked / period) + 1.0) * period;
    // Counted loop: a restored step number may be so large that adding a period changes nothing.
    const int most = static_cast<int>(kLongestLeftOut / period) + 2;
    for (int k = 0; k < most && any(logical_and(sample <= now, env.served())); ++k) {
      Real draws[6];
      fill_normal(random_at(env, to_word(sample), kWalkDraws), draws);
      walk(vec3(draws, 0), accelerometer_walk_(env), sample <= now, state.force_bias);
      walk(vec3(draws, 3), gyroscope_walk_(env), sample <= now, state.rate_bias);
      sample += period;
    }
    state.walked = now;
  }

  /// A density of zero leaves all bits unchanged, independent of other lanes.
  template <class Real>
  SKYBODY_INLINE void walk(const Vec3<Real>& draw, const Real& density, MaskOf<Real> walks,
                           Vec3<Real>& bias) const {
    const Vec3<Real> moved = bias + draw * (density * sqrt(interval_));
    bias = select(logical_and(walks, density > 0.0), moved, bias);
  }
  template <class Real>
  SKYBODY_INLINE void add_noise(const Vec3<Real>& draw, const Real& density,
                                Vec3<Real>& value) const {
    value = select(density > 0.0, value + draw * (density / sqrt(interval_)), value);
  }

  /// The delay line advances by one entry per call; at a reset it is filled with the first sample.
  template <class Real>
  SKYBODY_INLINE void deliver(const State<Real>& state, MaskOf<Real> fresh, Values<Real> output,
                              Values<Real> buffer) const {
    if (places_ == 0) {
      output.set(0, state.force);
      output.set(3, state.rate);
      return;
    }
    output.set(0, select(fresh, state.force, buffer.vec3(0)));
    output.set(3, select(fresh, state.rate, buffer.vec3(3)));
    for (int i = 0; i + 1 < places_; ++i) {
      const int to = kSize * i, from = kSize * (i + 1);
      buffer.set(to, select(fresh, state.force, buffer.vec3(from)));
      buffer.set(to + 3, select(fresh, state.rate, buffer.vec3(from + 3)));
    }
    buffer.set(kSize * (places_ - 1), state.force);
    buffer.set(kSize * (places_ - 1) + 3, state.rate);
  }

  TextParameter robot_{
      this, {.name = "robot", .doc = "robot with the link; optional for a single robot"}};
  TextParameter link_{this, {.name = "link", .doc = "link of the sensor; empty: the base"}};
  IntegerParameter period_{this,
                           {.name = "period",
                            .unit = "physics steps",
                            .value = 1,
                            .min = 1,
                            .max = 1000000,
                            .doc = "interval of samples"}};
  IntegerParameter latency_{this,
                            {.name = "latency",
                             .unit = "physics steps",
                             .value = 0,
                             .min = 0,
                             .max = 1000,
                             .doc = "delay from a sample to the output"}};
  RealsParameter position_{this,
                           {.name = "position",
                            .unit = "m",
                            .values = {0.0, 0.0, 0.0},
                            .doc = "position of the sensor in the link's frame"}};
  RealsParameter orientation_{this,
                              {.name = "orientation",
                               .unit = "rad",
                               .values = {0.0, 0.0, 0.0},
                               .doc = "roll, pitch, yaw of the sensor's axes in the link's frame"}};
  RealParameter accelerometer_noise_{this,
                                     {.name = "accelerometer_noise",
                                      .unit = "m/s^2/sqrt(Hz)",
                                      .min = 0.0,
                                      .doc = "density of the white noise",
                                      .randomizable = true}};
  RealParameter gyroscope_noise_{this,
                                 {.name = "gyroscope_noise",
                                  .unit = "rad/s/sqrt(Hz)",
                                  .min = 0.0,
                                  .doc = "density of the white noise",
                                  .randomizable = true}};
  RealParameter accelerometer_walk_{this,
                                    {.name = "accelerometer_walk",
                                     .unit = "m/s^3/sqrt(Hz)",
                                     .min = 0.0,
                                     .doc = "density of the bias's random walk",
                                     .randomizable = true}};
  RealParameter gyroscope_walk_{this,
                                {.name = "gyroscope_walk",
                                 .unit = "rad/s^2/sqrt(Hz)",
                                 .min = 0.0,
                                 .doc = "density of the bias's random walk",
                                 .randomizable = true}};
  RealParameter accelerometer_bias_{this,
                                    {.name = "accelerometer_bias",
                                     .unit = "m/s^2",
                                     .min = 0.0,
                                     .doc = "standard deviation of the bias at a reset, per axis",
                                     .randomizable = true}};
  RealParameter gyroscope_bias_{this,
                                {.name = "gyroscope_bias",
                                 .unit = "rad/s",
                                 .min = 0.0,
                                 .doc = "standard deviation of the bias at a reset, per axis",
                                 .randomizable = true}};

  int body_ = 0;
  Vec3<double> point_{};     ///< position of the sensor, body frame [m]
  Quat<double> rotation_{};  ///< body from sensor
  int gravity_ = 0;          ///< first EnvParam
  double dt_ = 0.0;
  double interval_ = 0.0;  ///< between samples [s]
  int places_ = 0;         ///< length of the delay line
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Imu, "imu", "1.0.0",
               "Inertial measurement unit: specific force [m/s^2] and angular rate [rad/s].");
