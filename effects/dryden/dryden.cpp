// Dryden turbulence after MIL-F-8785C: random air velocities along, across and above the mean wind.
//
// The filters run in the dimensionless time tau = V t / L. In it they have no parameters, and their
// stationary covariance is constant: 1 along the wind; for the two states across and above
//   x1 = w/(1 + s), x2 = x1/(1 + s), y = sqrt(3) x1 + (1 - sqrt(3)) x2,
//   E x1 x1 = 1/2, E x1 x2 = E x2 x2 = 1/4, E y y = 1.
// A call advances them by their exact transition over the time since the last call and adds noise
// of the exact covariance. So samples have the autocovariance of the continuous process at any
// period. A change of height or speed changes scale and rate, but leaves them stationary.
//
// Height and speed are those of the last call, so the next values are already determined then. One
// call computes them for all lanes of a pack, although the lanes are due at other steps. They are
// stored in the memo, with all their inputs.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/robots.h"

namespace skybody {
namespace {

constexpr double kFoot = 0.3048;  // [m], exact
constexpr double kRoot2 = 1.41421356237309504880, kRoot3 = 1.73205080756887729353;

/// 1/3!, 1/4!, ...: e^z = 1 + z + z^2/2 + z^3 (sum of kRest[k] z^k).
constexpr int kRestTerms = 11;
constexpr double kRest[kRestTerms] = {
    1.0 / 6,      1.0 / 24,      1.0 / 120,      1.0 / 720,       1.0 / 5040,      1.0 / 40320,
    1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};

/// Lengths and intensities of the turbulence at one height.
template <class Real>
struct Scale {
  Real length;           ///< L_u = L_v [m]
  Real length_vertical;  ///< L_w [m]
  Real ratio;            ///< sigma_u / sigma_w at low altitude
  Real above;            ///< 0 up to 1000 ft, 1 from 2000 ft on
};

/// Scale at a height [m]: low-altitude model up to 1000 ft, high-altitude model from 2000 ft on,
/// linear in between.
template <class Real>
SKYBODY_INLINE Scale<Real> scale_at(const Real& height) {
  const Real feet = height / kFoot;
  const Real low = clamp(feet, Real(10.0), Real(1000.0));
  const Real power = exp(0.4 * log(0.177 + 0.000823 * low));
  const Real length = low / (power * power * power);
  const Real above = clamp((feet - 1000.0) / 1000.0, Real(0.0), Real(1.0));
  return {kFoot * (length + above * (1750.0 - length)), kFoot * (low + above * (1750.0 - low)),
          1.0 / power, above};
}

/// Transition of the two states over a time tau: x <- decay (x1, x2 + tau x1) + noise, whose
/// covariance has the Cholesky factor (a, 0; b, c).
template <class Real>
struct Transition {
  Real tau, decay, a, b, c;
};

/// The noise's covariance is the stationary one minus its decayed part:
///   (t1/2, t2/4; t2/4, t3/4), t_n = 1 - e^-z (sum of z^k/k!, k < n), z = 2 tau.
/// For a small z these are differences of nearly equal numbers. There t3 is e^-z times the rest of
/// the exponential series, which has a relative error of 1e-16 below z = 1/4. t2 and t1 follow by
/// sums of positive terms.
template <class Real>
SKYBODY_INLINE Transition<Real> transition(const Real& tau) {
  const Real decay = exp(-tau), left = decay * decay, z = 2.0 * tau;
  Real rest(kRest[kRestTerms - 1]);
  for (int k = kRestTerms - 2; k >= 0; --k) rest = kRest[k] + z * rest;
  const Real half_square = 0.5 * z * z;
  const Real t3 = select(z < 0.25, left * (z * z * z) * rest, 1.0 - left * (1.0 + z + half_square));
  const Real t2 = t3 + left * half_square, t1 = t2 + left * z;
  const Real a = sqrt(0.5 * t1);
  const Real b = 0.25 * t2 / a;
  return {tau, decay, a, b, sqrt(0.25 * t3 - b * b)};
}

class Dryden : public Effect {
 public:
  static constexpr bool kSmooth = true;

  void configure(const Setup& setup) override {
    for (const int robot : effect::robots_called(setup, names_.values())) {
      const RobotInfo& r = setup.robots()[robot];
      robots_.push_back({r.first_body, r.body_count});
    }
    fixed_scale_ = scale_at(height_.value());
    elapsed_ = static_cast<double>(period_.value()) * setup.dt();
    const int count = static_cast<int>(robots_.size());
    first_filter_ = 3 * count;
    inputs_ = kRobotWords * count;
    setup.buffer(first_filter_ + inputs_);
    setup.memo(kMemoInputs + 2 * inputs_);
    setup.report("velocity", "m/s", 3 * count, 0);
    setup.holds(HeldInput::kWind);
    setup.period(static_cast<int>(period_.value()));
  }

  /// The filters start in their stationary distribution.
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>&, Values<Real> buffer) const {
    // Limit of an infinite tau: the Cholesky factor of the stationary covariance.
    const Real zero(0.0), a(0.5 * kRoot2), b(0.25 * kRoot2);
    const Transition<Real> forget{zero, zero, a, b, b};
    Random<Real> draw = random(env, kResetDraws);
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      Real filter[kFilterWords] = {};
      advance(forget, forget, draw, filter);
      for (int k = 0; k < kFilterWords; ++k) buffer.set(words_of(r) + k, filter[k]);
      look(env, r, buffer);
    }
  }

  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held, Values<Real> buffer) const {
    [[maybe_unused]] Random<Real> draw = random(env, kApplyDraws);  // used for dual numbers only
    SinCos<Real> heading;
    if constexpr (kIsDual<Real>) {
      heading = sincos(heading_(env));
    } else {
      fill_memo(env, buffer);
      const Values<Real> memo = env.memo();
      heading = {memo[kMemoSine], memo[kMemoCosine]};
    }
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      Next<Real> next;
      if constexpr (kIsDual<Real>) {
        next = next_of(r, draw, buffer);
      } else {
        next = next_in_memo(env, r);
      }
      for (int k = 0; k < kFilterWords; ++k) buffer.set(words_of(r) + k, next.filter[k]);
      look(env, r, buffer);
      const Robot& robot = robots_[r];
      const Vec3<Real> wind = velocity(env, next, heading);
      buffer.set(3 * static_cast<int>(r), wind);
      for (int b = 0; b < robot.body_count; ++b) held.add_wind(robot.first_body + b, wind);
    }
  }

 private:
  static constexpr std::uint64_t kApplyDraws = 0, kResetDraws = 1;
  /// A robot's filter: along the wind, two states across, two above.
  static constexpr int kFilterWords = 5;
  /// A robot's words in the buffer after its filter: height [m] and distance through the air [m]
  /// over the coming period.
  static constexpr int kHeight = kFilterWords, kWay = kHeight + 1, kRobotWords = kWay + 1;
  /// Layout of the memo: seed, environment, episode, physics step and heading; sine and cosine of
  /// the heading; all robots' words of the buffer; all robots' Next.
  static constexpr int kKeyWords = 5;
  static constexpr int kMemoSine = kKeyWords, kMemoCosine = kMemoSine + 1;
  static constexpr int kMemoInputs = kMemoCosine + 1;

  struct Robot {
    int first_body, body_count;
  };

  /// A robot's values at the end of a period. The same size as kRobotWords.
  template <class Real>
  struct Next {
    Real filter[kFilterWords];
    Real ratio, above;  ///< from Scale
  };

  int words_of(std::size_t robot) const {
    return first_filter_ + kRobotWords * static_cast<int>(robot);
  }

  /// Stores the inputs of the next values.
  template <class Real>
  SKYBODY_INLINE void look(const EnvView<Real>& env, std::size_t robot,
                           const Values<Real>& buffer) const {
    const BodyMotion<Real> base = env.body(robots_[robot].first_body);
    buffer.set(words_of(robot) + kHeight, base.position.z);
    buffer.set(words_of(robot) + kWay, airspeed(env, base) * elapsed_);
  }

  template <class Real>
  SKYBODY_INLINE Scale<Real> scale_of(const Real& height) const {
    if (height_.value() == 0.0) return scale_at(height);
    const Scale<double>& s = fixed_scale_;
    return {Real(s.length), Real(s.length_vertical), Real(s.ratio), Real(s.above)};
  }

  /// Values at the period's end, from the buffer's inputs at its beginning.
  template <class Real>
  SKYBODY_INLINE Next<Real> next_of(std::size_t robot, Random<Real>& draw,
                                    const Values<Real>& buffer) const {
    const int first = words_of(robot);
    const Scale<Real> scale = scale_of(Real(buffer[first + kHeight]));
    const Real way = buffer[first + kWay];
    Next<Real> next;
    for (int k = 0; k < kFilterWords; ++k) next.filter[k] = buffer[first + k];
    advance(transition(way / scale.length), transition(way / scale.length_vertical), draw,
            next.filter);
    next.ratio = scale.ratio;
    next.above = scale.above;
    return next;
  }

  /// Fills the memo unless it already has the values of the served lanes.
  template <class Real>
  SKYBODY_INLINE void fill_memo(const EnvView<Real>& env, const Values<Real>& buffer) const {
    const Values<Real> memo = env.memo();
    const Word<Real> step = due_step(env);
    const Real heading = heading_(env);
    const Word<Real> key[kKeyWords] = {env.seed(), env.stream_env(), env.episode(), step,
                                       bit_cast_word(heading)};
    Word<Real> other = bit_cast_word(Real(memo[0])) ^ key[0];
    for (int k = 1; k < kKeyWords; ++k) other |= bit_cast_word(Real(memo[k])) ^ key[k];
    for (int first = 0; first < inputs_; first += kRobotWords) {
#pragma GCC unroll 7
      for (int k = first; k < first + kRobotWords; ++k) {  // otherwise g++ gathers lane by lane
        other |= bit_cast_word(Real(memo[kMemoInputs + k])) ^
                 bit_cast_word(Real(buffer[first_filter_ + k]));
      }
    }
    const auto is_other = to_real((other | (other >> 32)) & 0xffffffffu) != 0.0;
    if (none(logical_and(env.served(), is_other))) return;
    Random<Real> draw = random_of_all(env, step, kApplyDraws);
    for (int k = 0; k < kKeyWords; ++k) memo.set(k, bit_cast_real(key[k]));
    const SinCos<Real> turn = sincos(heading);
    memo.set(kMemoSine, turn.sin);
    memo.set(kMemoCosine, turn.cos);
    for (int k = 0; k < inputs_; ++k) memo.set(kMemoInputs + k, buffer[first_filter_ + k]);
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      const Next<Real> next = next_of(r, draw, buffer);
      const int first = memo_of(r);
      for (int k = 0; k < kFilterWords; ++k) memo.set(first + k, next.filter[k]);
      memo.set(first + kFilterWords, next.ratio);
      memo.set(first + kFilterWords + 1, next.above);
    }
  }

  template <class Real>
  SKYBODY_INLINE Next<Real> next_in_memo(const EnvView<Real>& env, std::size_t robot) const {
    const Values<Real> memo = env.memo();
    const int first = memo_of(robot);
    Next<Real> next;
    for (int k = 0; k < kFilterWords; ++k) next.filter[k] = memo[first + k];
    next.ratio = memo[first + kFilterWords];
    next.above = memo[first + kFilterWords + 1];
    return next;
  }

  int memo_of(std::size_t robot) const {
    return kMemoInputs + inputs_ + kRobotWords * static_cast<int>(robot);
  }

  /// The physics step at which each lane is due; for served lanes, the present one.
  template <class Real>
  SKYBODY_INLINE Word<Real> due_step(const EnvView<Real>& env) const {
    const auto period = static_cast<double>(period_.value());
    const Real now = to_real(env.physics_step());
    const Real near = round_half_even(now * (1.0 / period)) * period;
    return to_word(select(env.served(), now, select(near < now, near + period, near)));
  }

  /// Speed at which the turbulence passes.
  template <class Real>
  SKYBODY_INLINE Real airspeed(const EnvView<Real>& env, const BodyMotion<Real>& base) const {
    const Real least = airspeed_(env);
    return follows_.value() ? max(norm(base.velocity), least) : least;
  }

  /// One step of a robot's filters.
  template <class Real>
  SKYBODY_INLINE static void advance(const Transition<Real>& level,
                                     const Transition<Real>& vertical, Random<Real>& draw,
                                     Real* filter) {
    Real along, spare;
    draw.normal_pair(along, spare);
    filter[0] = level.decay * filter[0] + kRoot2 * level.a * along;
    advance_pair(level, draw, filter + 1);
    advance_pair(vertical, draw, filter + 3);
  }
  template <class Real>
  SKYBODY_INLINE static void advance_pair(const Transition<Real>& t, Random<Real>& draw, Real* x) {
    Real first, second;
    draw.normal_pair(first, second);
    const Real x1 = x[0], x2 = x[1];
    x[0] = t.decay * x1 + t.a * first;
    x[1] = t.decay * (x2 + t.tau * x1) + (t.b * first + t.c * second);
  }

  /// Air velocity from the filters' outputs, W axes.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> velocity(const EnvView<Real>& env, const Next<Real>& next,
                                     const SinCos<Real>& heading) const {
    const Real near_ground = 0.1 * wind_at_20_feet_(env), high = sigma_(env);
    const Real level = near_ground * next.ratio;
    const Real sigma = level + next.above * (high - level);
    const Real sigma_vertical = near_ground + next.above * (high - near_ground);
    const Real along = sigma * next.filter[0];
    const Real across = sigma * second_order(next.filter + 1);
    return {heading.cos * along - heading.sin * across, heading.sin * along + heading.cos * across,
            sigma_vertical * second_order(next.filter + 3)};
  }
  /// Output of a second-order filter, of variance 1.
  template <class Real>
  SKYBODY_INLINE static Real second_order(const Real* x) {
    return kRoot3 * x[0] + (1.0 - kRoot3) * x[1];
  }

  TextsParameter names_{this, words("robots", "affected robots; empty: all")};
  RealParameter wind_at_20_feet_{
      this, randomizable(real("wind_at_20_feet", "m/s", 7.72, between(0.0, 100.0),
                              "mean wind 6.1 m above ground, which determines turbulence below "
                              "2000 ft; 15 knots are light"))};
  RealParameter sigma_{this,
                       randomizable(real("sigma", "m/s", 1.5, between(0.0, 100.0),
                                         "standard deviation of each component above 2000 ft"))};
  RealParameter heading_{
      this, randomizable(real("heading", "rad", 0.0, between(-100.0, 100.0),
                              "direction to which the mean wind blows, from x of W towards y"))};
  RealParameter airspeed_{
      this, randomizable(real("airspeed", "m/s", 5.0, between(0.01, 1000.0),
                              "speed at which the frozen turbulence passes the robot"))};
  BooleanParameter follows_{
      this,
      boolean(
          "follows", false,
          "the turbulence passes at the speed of the robot's base, but no slower than `airspeed`")};
  RealParameter height_{
      this, real("height", "m", 0.0, between(0.0, 100000.0),
                 "height above ground for scales and intensities; 0: z of the robot's base in W")};
  IntegerParameter period_{this, integer("period", "physics steps", 10, between(1, 1000000),
                                         "interval of new turbulence values")};

  std::vector<Robot> robots_;
  Scale<double> fixed_scale_{};
  double elapsed_ = 0.0;  ///< between two calls [s]
  int first_filter_ = 0;  ///< word of the buffer
  int inputs_ = 0;        ///< number of buffer words from there on
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Dryden, "dryden", "1.0.0",
               "Dryden turbulence by MIL-F-8785C around robots [m/s].");
