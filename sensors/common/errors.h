// Errors of measurements that several sensors have: noise, drift, resolution, range.
#pragma once

#include <skybody/plugin.h>

namespace skybody::sensor {

/// Standard normals, in a loop, because the code of one draw is large.
template <class Real, int N>
SKYBODY_INLINE void fill_normal(Random<Real> draw, Real (&draws)[N]) {
  static_assert(N % 2 == 0);
  for (int k = 0; k < N; k += 2) draw.normal_pair(draws[k], draws[k + 1]);
}

/// Three of them.
template <class Real, int N>
SKYBODY_INLINE Vec3<Real> vec3_of(const Real (&draws)[N], int first) {
  return {draws[first], draws[first + 1], draws[first + 2]};
}

/// With an error of that standard deviation. @param draw  a standard normal
template <class Real>
SKYBODY_INLINE Real with_noise(const Real& value, const Real& deviation, const Real& draw) {
  return value + deviation * draw;
}
template <class Real>
SKYBODY_INLINE Vec3<Real> with_noise(const Vec3<Real>& value, const Real& deviation,
                                     const Vec3<Real>& draw) {
  return value + draw * deviation;
}

/// Rounded to a multiple of `resolution`, ties to even multiples; unchanged where it is 0.
template <class Real>
SKYBODY_INLINE Real quantized(const Real& value, const Real& resolution) {
  const auto is_on = resolution > 0.0;
  const Real unit = select(is_on, resolution, Real(1.0));
  return select(is_on, round_half_even(value / unit) * unit, value);
}

/// Held to -range..range; unchanged where the range is 0.
template <class Real>
SKYBODY_INLINE Real saturated(const Real& value, const Real& range) {
  const auto is_on = range > 0.0;
  return select(is_on, min(max(value, -range), range), value);
}

/// A Gauss-Markov process of first order: an Ornstein-Uhlenbeck process at equidistant times. Its
/// standard deviation is constant, its autocorrelation exp(-t / time).
template <class Real>
struct GaussMarkov {
  Real keep;      ///< factor on the last value: exp(-interval / time)
  Real innovate;  ///< factor on a standard normal

  /// @param deviation  standard deviation of the process   @param time  correlation time [s], > 0
  SKYBODY_INLINE GaussMarkov(const Real& deviation, const Real& time, double interval)
      : keep(exp(-interval / time)), innovate(deviation * sqrt(max(1.0 - keep * keep, 0.0))) {}

  SKYBODY_INLINE Real next(const Real& value, const Real& normal) const {
    return keep * value + innovate * normal;
  }
};

/// Next value of a Gauss-Markov process in buffer word `word`, in the lanes of `due`; at a reset a
/// draw of its stationary distribution.
/// @param draw  a standard normal
template <class Real>
SKYBODY_INLINE Real wandered(const EnvView<Real>& env, const MaskOf<Real>& due,
                             const Real& deviation, const Real& time, double interval,
                             const Real& draw, const Values<Real>& buffer, int word) {
  const GaussMarkov<Real> process(deviation, time, interval);
  const auto fresh = env.physics_step() == Word<Real>(0);
  const Real next = select(fresh, deviation * draw, process.next(buffer[word], draw));
  buffer.set(word, select(due, next, buffer[word]));
  return buffer[word];
}

}  // namespace skybody::sensor
