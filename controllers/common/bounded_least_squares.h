// Weighted least squares with bounds: rotor thrusts within their limits with the smallest weighted
// error of a command.
//
// Shares x_i = f_i / full_i. x0 = P u / full is the pseudo-inverse's solution, possibly outside [0,
// 1]. With B_ki = w_k A_ki full_i / scale_k, minimise
//   |B (x - x0)|^2 + g |x - x0|^2   over 0 <= x_i <= 1.
// Since A P u = u, the first term is |w (A f - u) / scale|^2. g selects one of several thrusts with
// equal error.
//
// Algorithm: primal active set, started from the clipped x0. Rotors at a limit are held. The others
// move to the minimum (Cholesky factor) or stop at the first limit on the way. When all are within
// limits, the held rotor with the largest gradient away from its limit is released.
//
// Sizes are fixed; nothing is allocated. There are at most kMostRounds rounds; the result is always
// within limits and no worse than the start. Compiled once for the baseline instruction set and run
// lane by lane, so that results are bitwise equal on every processor.
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

  /// State of a rotor in the active set.
  enum Place : std::int8_t { kAtNothing = -1, kFree = 0, kAtFull = 1 };

  /// @param count    number of rotors, up to kMostRotors
  /// @param weighted  B, row by row: kRows x count values
  void configure(int count, const double* weighted);

  /// @param setpoint    x0, finite
  /// @param[out] x  shares within [0, 1]
  /// @param[out] at  state of each rotor
  void solve(const double* setpoint, double* x, Place* at) const;

  /// Derivative of the solution for a derivative `setpoint` of x0, while no rotor changes its
  /// state.
  void move(const double* setpoint, const Place* at, double* x) const;

 private:
  /// Computes the free entries of x from the held ones: H_ff (x - x0)_f = -H_fb (x - x0)_b.
  void fill_free(const double* setpoint, const Place* at, double* x) const;
  /// Moves the free entries to `goal`, or to the first limit on the way; that rotor is then held.
  /// @returns whether the goal was reached
  bool go(const double* goal, double* x, Place* at) const;
  /// Releases the held rotor with the largest gradient away from its limit. @returns false if there
  /// is none
  bool release(const double* setpoint, const double* x, Place* at) const;

  int count_ = 0;
  double hessian_[kMostRotors][kMostRotors] = {};  ///< H = B^T B + g
};

}  // namespace skybody::control
