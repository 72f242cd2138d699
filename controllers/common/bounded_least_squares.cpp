#include "controllers/common/bounded_least_squares.h"

#include <skybody/plugin.h>

namespace skybody::control {
namespace {

/// g: small against the smallest weight, large against rounding errors.
constexpr double kTieBreak = 1e-8;
/// Slopes below this are rounding errors, for rows of B of order 1.
constexpr double kFlat = 1e-13;

}  // namespace

void BoundedLeastSquares::configure(int count, const double* weighted) {
  count_ = count;
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      double sum = i == j ? kTieBreak : 0.0;
      for (int k = 0; k < kRows; ++k) sum += weighted[k * count + i] * weighted[k * count + j];
      hessian_[i][j] = sum;
    }
  }
}

void BoundedLeastSquares::solve(const double* setpoint, double* x, Place* at) const {
  for (int i = 0; i < count_; ++i) {
    at[i] = setpoint[i] < 0.0 ? kAtNothing : setpoint[i] > 1.0 ? kAtFull : kFree;
    x[i] = clamp(setpoint[i], 0.0, 1.0);
  }
  double goal[kMostRotors];
  for (int round = 0; round < kMostRounds; ++round) {
    for (int i = 0; i < count_; ++i) goal[i] = x[i];
    fill_free(setpoint, at, goal);
    if (go(goal, x, at) && !release(setpoint, x, at)) return;
  }
}

void BoundedLeastSquares::move(const double* setpoint, const Place* at, double* x) const {
  for (int i = 0; i < count_; ++i) x[i] = 0.0;
  fill_free(setpoint, at, x);
}

void BoundedLeastSquares::fill_free(const double* setpoint, const Place* at, double* x) const {
  int free[kMostRotors], frees = 0;
  for (int i = 0; i < count_; ++i) {
    if (at[i] == kFree) free[frees++] = i;
  }
  double factor[kMostRotors][kMostRotors], y[kMostRotors];
  for (int r = 0; r < frees; ++r) {  // Cholesky row by row, with the forward substitution
    const double* const row = hessian_[free[r]];
    double right = 0.0;
    for (int j = 0; j < count_; ++j) {
      if (at[j] != kFree) right -= row[j] * (x[j] - setpoint[j]);
    }
    double pivot = row[free[r]];
    for (int c = 0; c < r; ++c) {
      double sum = row[free[c]];
      for (int k = 0; k < c; ++k) sum -= factor[r][k] * factor[c][k];
      factor[r][c] = sum / factor[c][c];
      pivot -= factor[r][c] * factor[r][c];
      right -= factor[r][c] * y[c];
    }
    factor[r][r] = sqrt(max(pivot, 0.5 * kTieBreak));
    y[r] = right / factor[r][r];
  }
  for (int r = frees - 1; r >= 0; --r) {
    for (int k = r + 1; k < frees; ++k) y[r] -= factor[k][r] * y[k];
    y[r] /= factor[r][r];
    x[free[r]] = setpoint[free[r]] + y[r];
  }
}

bool BoundedLeastSquares::go(const double* goal, double* x, Place* at) const {
  double share = 1.0;
  int first = -1;
  for (int i = 0; i < count_; ++i) {
    if (at[i] != kFree || (goal[i] >= 0.0 && goal[i] <= 1.0)) continue;
    const double room = (goal[i] < 0.0 ? 0.0 : 1.0) - x[i];
    const double fits = room / (goal[i] - x[i]);
    if (fits < share) {
      share = fits;
      first = i;
    }
  }
  for (int i = 0; i < count_; ++i) {
    if (at[i] == kFree) x[i] = clamp(x[i] + share * (goal[i] - x[i]), 0.0, 1.0);
  }
  if (first < 0) return true;
  at[first] = goal[first] < 0.0 ? kAtNothing : kAtFull;
  x[first] = goal[first] < 0.0 ? 0.0 : 1.0;
  return false;
}

bool BoundedLeastSquares::release(const double* setpoint, const double* x, Place* at) const {
  double most = kFlat;
  int best = -1;
  for (int i = 0; i < count_; ++i) {
    if (at[i] == kFree) continue;
    double slope = 0.0;
    for (int j = 0; j < count_; ++j) slope += hessian_[i][j] * (x[j] - setpoint[j]);
    const double pull = at[i] == kAtFull ? slope : -slope;
    if (pull > most) {
      most = pull;
      best = i;
    }
  }
  if (best < 0) return false;
  at[best] = kFree;
  return true;
}

}  // namespace skybody::control
