// A strictly convex quadratic program with bounds on every variable:
//   minimise 1/2 x' H x + g' x  subject to  low <= x <= high.
// Solved by DAQP (D. Arnstrom, A. Bemporad, D. Axehill, "A dual active-set solver for embedded
// quadratic programming using recursive LDL' updates", IEEE TAC 67(8), 2022), without allocation:
// its workspace is on the stack (0.3 MB).
#pragma once

namespace skybody::nmpc {

inline constexpr int kMostInputs = 160;  ///< largest number of variables of a program

/// The initially active bound of a variable.
enum class QpBound : signed char { kLower = -1, kNone = 0, kUpper = 1 };

struct QpProblem {
  int size;              ///< n, number of variables, at most kMostInputs
  double* hessian;       ///< H, n x n, row-major; only the upper triangle is read
  double* gradient;      ///< g
  double* low;           ///< below `high`
  double* high;          ///< above `low`
  const QpBound* start;  ///< the initial active set
  int most_iterations;   ///< largest number of active-set changes
};

struct QpResult {
  bool is_solved;  ///< false: `solution` is invalid
  int iterations;
};

/// @param solution  n values
QpResult solve(const QpProblem& problem, double* solution);

}  // namespace skybody::nmpc
