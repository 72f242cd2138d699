// Dryden turbulence after MIL-F-8785C: random velocities of the air along, across and above the
// mean wind.
//
// The filters run in the dimensionless time tau = V t / L, in which they have no constants left and
// their stationary covariance is a number: 1 along the wind; for the two states across and above
//   x1 = w/(1 + s), x2 = x1/(1 + s), y = sqrt(3) x1 + (1 - sqrt(3)) x2,
//   E x1 x1 = 1/2, E x1 x2 = E x2 x2 = 1/4, E y y = 1.
// A call advances them by their exact transition over the time since the last call and adds noise
// of the exact covariance. So samples have the autocovariance of the continuous process at any
// period, and a change of height or speed changes scale and pace, but leaves them stationary.
#include <skybody/plugin.h>

#include <vector>

#include "effects/common/robots.h"

namespace skybody {
namespace {

constexpr double kFoot = 0.3048;  // [m], by definition
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
  Real ratio;            ///< sigma_u / sigma_w of the low altitude
  Real above;            ///< 0 up to 1000 ft, 1 from 2000 ft on
};

/// At a height [m]: up to 1000 ft the low altitude's, from 2000 ft on the high one's, between them
/// linear.
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

/// What a time tau does to the two states: x <- decay (x1, x2 + tau x1) + noise, whose covariance
/// has the Cholesky factor (a, 0; b, c).
template <class Real>
struct Transition {
  Real tau, decay, a, b, c;
};

/// The covariance of the noise is that of the stationary states less what is left of it:
///   (t1/2, t2/4; t2/4, t3/4), t_n = 1 - e^-z (sum of z^k/k!, k < n), z = 2 tau.
/// Of a small z these are differences of nearly equal numbers; there t3 is e^-z times the rest of
/// the exponential series, which is exact to 1e-16 of itself below z = 1/4. t2 and t1 follow by
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
    setup.buffer((3 + kFilterWords) * count);
    setup.report("velocity", "m/s", 3 * count, 0);
    setup.holds(HeldInput::kWind);
    setup.period(static_cast<int>(period_.value()));
  }

  /// The filters begin where they would be after a long time.
  template <class Real>
  void reset(const EnvView<Real>& env, State<Real>&, Values<Real> buffer) const {
    // What an endless tau leaves: the Cholesky factor of the stationary covariance.
    const Real zero(0.0), a(0.5 * kRoot2), b(0.25 * kRoot2);
    const Transition<Real> forget{zero, zero, a, b, b};
    Random<Real> draw = random(env, kResetDraws);
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      advance(forget, forget, draw, filter_of(r), buffer);
    }
  }

  template <class Real>
  void apply(const EnvView<Real>& env, State<Real>&, Held<Real>& held, Values<Real> buffer) const {
    const SinCos<Real> heading = sincos(heading_(env));
    Random<Real> draw = random(env, kApplyDraws);
    for (std::size_t r = 0; r < robots_.size(); ++r) {
      const Robot& robot = robots_[r];
      const BodyMotion<Real> base = env.body(robot.first_body);
      const Scale<Real> scale = scale_of(base);
      const Real way = airspeed(env, base) * elapsed_;
      advance(transition(way / scale.length), transition(way / scale.length_vertical), draw,
              filter_of(r), buffer);
      const Vec3<Real> wind = velocity(env, scale, heading, filter_of(r), buffer);
      buffer.set(3 * static_cast<int>(r), wind);
      for (int b = 0; b < robot.body_count; ++b) held.add_wind(robot.first_body + b, wind);
    }
  }

 private:
  static constexpr std::uint64_t kApplyDraws = 0, kResetDraws = 1;
  /// A robot's filter: along the wind, two states across, two above.
  static constexpr int kFilterWords = 5;

  struct Robot {
    int first_body, body_count;
  };

  int filter_of(std::size_t robot) const {
    return first_filter_ + kFilterWords * static_cast<int>(robot);
  }

  template <class Real>
  SKYBODY_INLINE Scale<Real> scale_of(const BodyMotion<Real>& base) const {
    if (height_.value() == 0.0) return scale_at(base.position.z);
    const Scale<double>& s = fixed_scale_;
    return {Real(s.length), Real(s.length_vertical), Real(s.ratio), Real(s.above)};
  }

  /// With what speed the turbulence passes.
  template <class Real>
  SKYBODY_INLINE Real airspeed(const EnvView<Real>& env, const BodyMotion<Real>& base) const {
    const Real least = airspeed_(env);
    return follows_.value() ? max(norm(base.velocity), least) : least;
  }

  /// One step of a robot's filters.
  template <class Real>
  SKYBODY_INLINE void advance(const Transition<Real>& level, const Transition<Real>& vertical,
                              Random<Real>& draw, int filter, const Values<Real>& buffer) const {
    Real along, spare;
    draw.normal_pair(along, spare);
    buffer.set(filter, level.decay * buffer[filter] + kRoot2 * level.a * along);
    advance_pair(level, draw, filter + 1, buffer);
    advance_pair(vertical, draw, filter + 3, buffer);
  }
  template <class Real>
  SKYBODY_INLINE void advance_pair(const Transition<Real>& t, Random<Real>& draw, int place,
                                   const Values<Real>& buffer) const {
    Real first, second;
    draw.normal_pair(first, second);
    const Real x1 = buffer[place], x2 = buffer[place + 1];
    buffer.set(place, t.decay * x1 + t.a * first);
    buffer.set(place + 1, t.decay * (x2 + t.tau * x1) + (t.b * first + t.c * second));
  }

  /// What the filters say at this height.
  template <class Real>
  SKYBODY_INLINE Vec3<Real> velocity(const EnvView<Real>& env, const Scale<Real>& scale,
                                     const SinCos<Real>& heading, int filter,
                                     const Values<Real>& buffer) const {
    const Real near_ground = 0.1 * wind_at_20_feet_(env), high = sigma_(env);
    const Real level = near_ground * scale.ratio;
    const Real sigma = level + scale.above * (high - level);
    const Real sigma_vertical = near_ground + scale.above * (high - near_ground);
    const Real along = sigma * buffer[filter];
    const Real across = sigma * second_order(filter + 1, buffer);
    return {heading.cos * along - heading.sin * across, heading.sin * along + heading.cos * across,
            sigma_vertical * second_order(filter + 3, buffer)};
  }
  /// Of variance 1.
  template <class Real>
  SKYBODY_INLINE Real second_order(int place, const Values<Real>& buffer) const {
    return kRoot3 * buffer[place] + (1.0 - kRoot3) * buffer[place + 1];
  }

  TextsParameter names_{this, {.name = "robots", .doc = "whom it blows at; empty: all"}};
  RealParameter wind_at_20_feet_{this,
                                 {.name = "wind_at_20_feet",
                                  .unit = "m/s",
                                  .value = 7.72,
                                  .min = 0.0,
                                  .max = 100.0,
                                  .doc = "mean wind 6.1 m above ground, of which turbulence below "
                                         "2000 ft is made; 15 knots are light",
                                  .randomizable = true}};
  RealParameter sigma_{this,
                       {.name = "sigma",
                        .unit = "m/s",
                        .value = 1.5,
                        .min = 0.0,
                        .max = 100.0,
                        .doc = "standard deviation of each component above 2000 ft",
                        .randomizable = true}};
  RealParameter heading_{this,
                         {.name = "heading",
                          .unit = "rad",
                          .min = -100.0,
                          .max = 100.0,
                          .doc = "where the mean wind blows to, from x of W towards y",
                          .randomizable = true}};
  RealParameter airspeed_{this,
                          {.name = "airspeed",
                           .unit = "m/s",
                           .value = 5.0,
                           .min = 0.01,
                           .max = 1000.0,
                           .doc = "with which the frozen turbulence passes the robot",
                           .randomizable = true}};
  BooleanParameter follows_{
      this,
      {.name = "follows",
       .doc = "the turbulence passes with the speed of the robot's base, but no slower than "
              "`airspeed`"}};
  RealParameter height_{this,
                        {.name = "height",
                         .unit = "m",
                         .min = 0.0,
                         .max = 100000.0,
                         .doc = "above ground, of which scales and intensities are; 0: z of the "
                                "robot's base in W"}};
  IntegerParameter period_{this,
                           {.name = "period",
                            .unit = "physics steps",
                            .value = 10,
                            .min = 1,
                            .max = 1000000,
                            .doc = "between two values of the turbulence"}};

  std::vector<Robot> robots_;
  Scale<double> fixed_scale_{};
  double elapsed_ = 0.0;  ///< between two calls [s]
  int first_filter_ = 0;  ///< word of the buffer
};

}  // namespace
}  // namespace skybody

SKYBODY_PLUGIN(skybody::Dryden, "dryden", "1.0.0",
               "Dryden turbulence by MIL-F-8785C around robots [m/s].");
