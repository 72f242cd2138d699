// Linear equations of couplings in the environments that one Real holds: symmetric, few, and not
// all of them count.
#pragma once

#include "core/base/math.h"

namespace skybody {

/// The largest pivot that rounding leaves to a row that follows from those before it.
///
/// Two things make rounding. Elimination takes from the row's element what is as large as itself:
/// that leaves less than 1e-11 of it. And the element is a difference of the accelerations of two
/// ends: where these cancel, as out of the plane of a planar loop, it is itself rounding, of what a
/// force does to a single end. That is bounded by what it would do to the end's body if nothing
/// else held it (`mobility`), since joints only take freedom away.
/// @param element   of the row, on the diagonal [1/kg]
/// @param mobility  of its two ends [1/kg]
template <class Real>
SKYBODY_INLINE Real least_pivot_of(const Real& element, const Real& mobility) {
  return max(1e-11 * element, 1e-13 * mobility);
}

/// A f = b for the rows that are held, by A = L D L^T. A row that follows from those before it has
/// no pivot but rounding and gets no force: where the equations agree, the others are met then,
/// too. What rounding leaves depends on the row (least_pivot): rows between heavy bodies have small
/// elements, whatever else is in A.
template <class Real>
struct CouplingEquations {
  int count;
  const Real* mass;         ///< A, its lower triangle
  Real* factor;             ///< L below the diagonal, L D above it
  const Real* least_pivot;  ///< per row: a pivot that is no larger is rounding
  Real* inverse_pivot;      ///< 1 / D; 0 of rows that do not count
  const Real* asked;        ///< b
  Real* force;              ///< f, written

  /// @param is_held  is_held(row): the lanes where it is an equation
  template <class IsHeld>
  SKYBODY_INLINE void solve(const IsHeld& is_held) const {
    factorize(is_held);
    forward();
    backward();
  }

 private:
  template <class IsHeld>
  SKYBODY_INLINE void factorize(const IsHeld& is_held) const {
    const int n = count;
    const Real zero(0.0);
    for (int k = 0; k < n; ++k) {
      const MaskOf<Real> is_mine = is_held(k);
      Real pivot = mass[k * n + k];
      for (int j = 0; j < k; ++j) {
        Real scaled = mass[k * n + j];
        for (int i = 0; i < j; ++i) scaled -= factor[i * n + k] * factor[j * n + i];
        scaled = select(is_mine, scaled, zero);
        const Real l = scaled * inverse_pivot[j];
        factor[j * n + k] = scaled;
        factor[k * n + j] = l;
        pivot -= l * scaled;
      }
      const auto counts = logical_and(is_mine, pivot > least_pivot[k]);
      inverse_pivot[k] = select(counts, 1.0 / select(counts, pivot, Real(1.0)), zero);
    }
  }

  SKYBODY_INLINE void forward() const {
    for (int k = 0; k < count; ++k) {
      Real left = asked[k];
      for (int j = 0; j < k; ++j) left -= factor[k * count + j] * force[j];
      force[k] = left;
    }
  }

  SKYBODY_INLINE void backward() const {
    for (int k = count; k-- > 0;) {
      Real left = force[k] * inverse_pivot[k];
      for (int j = k + 1; j < count; ++j) left -= factor[j * count + k] * force[j];
      force[k] = left;
    }
  }
};

}  // namespace skybody
