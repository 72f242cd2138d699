// A strictly convex quadratic program with bounds on every variable:
//   minimise 1/2 x' H x + g' x  subject to  low <= x <= high.
// Solved by DAQP (D. Arnstrom, A. Bemporad, D. Axehill, "A dual active-set solver for embedded
// quadratic programming using recursive LDL' updates", IEEE TAC 67(8), 2022), without any
// allocation: its workspace lies on the stack (0.3 MB).
#pragma once

namespace skybody::nmpc {

inline constexpr int kMostInputs = 160;  ///< variables of a program at most

/// Which bound a variable begins at.
enum class QpBound : signed char { kLower = -1, kNone = 0, kUpper = 1 };

struct QpProblem {
  int size;              ///< n, number of variables, at most kMostInputs
  double* hessian;       ///< H, n x n, row-major; only the upper triangle is read
  double* gradient;      ///< g
  double* low;           ///< below `high`
  double* high;          ///< above `low`
  const QpBound* start;  ///< the active set to begin with
  int most_iterations;   ///< changes of the active set before it gives up
};

struct QpResult {
  bool is_solved;  ///< else `solution` is not to be used
  int iterations;
};

/// @param solution  n values
QpResult solve(const QpProblem& problem, double* solution);

}  // namespace skybody::nmpc
