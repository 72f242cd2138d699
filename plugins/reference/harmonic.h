// Paths with one sine per axis: Lissajous figures, circles, ellipses, helices, figures of eight.
//
//   p_i(angle) = centre_i + amplitude_i sin(cycles_i angle + phase_i),  and z rises by
//   climb angle / (2 pi)
#pragma once

#include "plugins/reference/path_jet.h"

namespace skybody::reference {

/// W axes.
template <class Real>
struct Harmonic {
  Vec3<Real> centre;     ///< [m]
  Vec3<Real> amplitude;  ///< [m]
  Vec3<Real> cycles;     ///< oscillations of each axis per period
  Vec3<Real> phase;      ///< [rad]
  Real climb;            ///< [m] per period

  /// The point with derivatives up to order N - 1 by time, for an angle that grows at a constant
  /// rate.
  /// @param rate  of the angle [rad/s]
  template <int N>
  SKYBODY_INLINE PathPoint<Real, N> at(const Real& angle, const Real& rate) const {
    PathPoint<Real, N> point{on_axis<N>(angle, rate, centre.x, amplitude.x, cycles.x, phase.x),
                             on_axis<N>(angle, rate, centre.y, amplitude.y, cycles.y, phase.y),
                             on_axis<N>(angle, rate, centre.z, amplitude.z, cycles.z, phase.z)};
    const Real rise = climb * (0.5 / kPi);
    point.z.c[0] = point.z.c[0] + rise * angle;
    if constexpr (N > 1) point.z.c[1] = point.z.c[1] + rise * rate;
    return point;
  }

  /// Maximum of |dp/dangle| over a period [m], from 256 samples. Too low by less than 0.04 % for
  /// one cycle and 0.15 % for two, since samples lie within 0.0123 rad of the peak.
  SKYBODY_INLINE Real steepest() const {
    constexpr int kSamples = 256;
    Real square(0.0);
    for (int k = 0; k < kSamples; ++k) {
      const Real angle(2.0 * kPi / kSamples * k);
      const Vec3<Real> slope{slope_of(angle, amplitude.x, cycles.x, phase.x),
                             slope_of(angle, amplitude.y, cycles.y, phase.y),
                             slope_of(angle, amplitude.z, cycles.z, phase.z) + climb * (0.5 / kPi)};
      square = max(square, squared_norm(slope));
    }
    return sqrt(square);
  }

 private:
  /// Coefficient k is w^k / k! times the sine or cosine, with the signs +, +, -, -.
  template <int N>
  static SKYBODY_INLINE Jet<Real, N> on_axis(const Real& angle, const Real& rate,
                                             const Real& middle, const Real& swing,
                                             const Real& cycle, const Real& offset) {
    const SinCos<Real> at = sincos(angle * cycle + offset);
    const Real w = rate * cycle;
    Jet<Real, N> out;
    Real factor = swing;
    for (int k = 0; k < N; ++k) {
      if (k > 0) factor = factor * w * (1.0 / k);
      const Real value = factor * (k % 2 == 0 ? at.sin : at.cos);
      out.c[k] = k % 4 < 2 ? value : -value;
    }
    out.c[0] = out.c[0] + middle;
    return out;
  }
  static SKYBODY_INLINE Real slope_of(const Real& angle, const Real& swing, const Real& cycle,
                                      const Real& offset) {
    return swing * cycle * sincos(angle * cycle + offset).cos;
  }
};

}  // namespace skybody::reference
