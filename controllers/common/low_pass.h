// A second-order Butterworth low-pass filter for values sampled at a fixed interval.
//
// The continuous filter w^2 / (s^2 + sqrt(2) w s + w^2), discretised by the bilinear transform with
// prewarping, which keeps the cutoff. With K = tan(pi f T), f the cutoff and T the interval:
//   n = 1 + sqrt(2) K + K^2,  b0 = K^2 / n,  b1 = 2 b0,  b2 = b0,
//   a1 = 2 (K^2 - 1) / n,     a2 = (1 - sqrt(2) K + K^2) / n
// in transposed direct form II:
//   y = b0 x + s1,  s1' = b1 x - a1 y + s2,  s2' = b2 x - a2 y
// Source: A. V. Oppenheim and R. W. Schafer, Discrete-Time Signal Processing, 2010, sections 6.3
// and 7.2. tests/oracle compares it with SciPy's butter and lfilter.
#pragma once

#include <skybody/plugin.h>

#include <stdexcept>
#include <string>

namespace skybody::control {

/// State of the filter. Zero: the input has always been zero.
/// @tparam T  a Real or a Vec3 of them
template <class T>
struct LowPassState {
  T first, second;
};

/// Coefficients of the filter; the same for all environments. Immutable after configure().
class LowPass {
 public:
  /// @param name      name of the parameter `cutoff`, for messages
  /// @param cutoff    frequency of -3 dB gain [Hz], above 0
  /// @param interval  time between two samples [s]
  /// @throws std::runtime_error if the interval is too long for the cutoff
  void configure(const std::string& name, double cutoff, double interval) {
    const double most = 0.45 / interval;  // a little below half the sampling rate
    if (cutoff > most) {
      refuse("`", name, "` ", cutoff, " Hz is too high for ", interval,
             " s between two samples: at most ", most, " Hz, or a shorter `period`");
    }
    const double k = tan(kPi * cutoff * interval), square = k * k;
    const double scale = 1.0 / (1.0 + kRootOfTwo * k + square);
    b0_ = square * scale;
    a1_ = 2.0 * (square - 1.0) * scale;
    a2_ = (1.0 - kRootOfTwo * k + square) * scale;
  }

  /// Filters the next sample. @returns the filtered value
  template <class T>
  SKYBODY_INLINE T filtered(const T& sample, LowPassState<T>& state) const {
    const T share = sample * b0_;
    const T value = share + state.first;
    state.first = ((share + share) - value * a1_) + state.second;
    state.second = share - value * a2_;
    return value;
  }

 private:
  static constexpr double kRootOfTwo = 1.41421356237309504880;
  double b0_ = 1.0, a1_ = 0.0, a2_ = 0.0;
};

}  // namespace skybody::control
