// Thrusts of rotors within their limits that come nearest to a command: weighted least squares with
// bounds.
//
// With x_i = f_i / full_i the rotors' shares, x0 = P u / full those of the pseudo-inverse, which
// may lie beyond [0, 1], and B_ki = w_k A_ki full_i / scale_k,
//   minimise  |B (x - x0)|^2 + g |x - x0|^2   over 0 <= x_i <= 1,
// which is |w (A f - u) / scale|^2 since A P u = u; g decides between thrusts that do the same. It
// is solved by a primal active set from the clipped x0: rotors at a limit are held there, the
// others go to the minimum by a Cholesky factor, or to the first limit on the way; where all are
// within limits, the held rotor that wants away from its limit most is let go.
//
// Fixed sizes, no memory, at most kMostRounds rounds: what it has then is within limits and no
// worse than where it began. Compiled once, for the baseline instruction set, and run lane by lane,
// so that bits are the same on every processor.
//
// Sources: O. Harkegard, Efficient active set algorithms for solving constrained least squares
// problems in aircraft control allocation, CDC 2002, section III; E. Smeur, D. Hoppener, C. De
// Wagter, Prioritized control allocation for quadrotors subject to saturation, IMAV 2017.
#pragma once

#include <cstdint>

namespace skybody::control {

class BoundedLeastSquares {
 public:
  static constexpr int kMostRotors = 16;
  static constexpr int kMostRounds = 4 * kMostRotors;
  static constexpr int kRows = 4;  ///< thrust, roll, pitch, yaw

  /// Where a rotor is.
  enum Place : std::int8_t { kAtNothing = -1, kFree = 0, kAtFull = 1 };

  /// @param count    of rotors, up to kMostRotors
  /// @param weighted  B, row by row: kRows x count values
  void configure(int count, const double* weighted);

  /// @param setpoint    x0, finite
  /// @param[out] x  shares within [0, 1]
  /// @param[out] at  where each of them is
  void solve(const double* setpoint, double* x, Place* at) const;

  /// How the solution moves while x0 moves at `setpoint` and no rotor changes its place.
  void move(const double* setpoint, const Place* at, double* x) const;

 private:
  /// Free entries of x from those that are held: H_ff (x - x0)_f = -H_fb (x - x0)_b.
  void fill_free(const double* setpoint, const Place* at, double* x) const;
  /// Moves the free entries to `goal` or to the first limit on the way, where it holds that rotor.
  /// @returns whether they reached it
  bool go(const double* goal, double* x, Place* at) const;
  /// Lets the rotor go that wants away from its limit most. @returns false if none does
  bool release(const double* setpoint, const double* x, Place* at) const;

  int count_ = 0;
  double hessian_[kMostRotors][kMostRotors] = {};  ///< H = B^T B + g
};

}  // namespace skybody::control
