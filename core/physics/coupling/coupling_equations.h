// Linear equations of couplings in the environments of one Real: symmetric, few, and only some of
// them active.
#pragma once

#include <cstddef>

#include "core/base/math/math.h"

namespace skybody {

/// The largest pivot that round-off leaves for a row that depends linearly on earlier rows.
///
/// Round-off has two sources:
/// 1. Elimination subtracts terms as large as the row's element, which leaves less than 1e-11 of
///    it.
/// 2. The element is a difference of the accelerations of two ends. If these cancel, as out of the
///    plane of a planar loop, the element itself is round-off of a unit force's effect on one end.
///    That effect is bounded by the mobility of the end's body if it were free (`mobility`), since
///    joints only remove freedom.
/// @param element   of the row, on the diagonal [1/kg]
/// @param mobility  of its two ends [1/kg]
template <class Real>
SKYBODY_INLINE Real least_pivot_of(const Real& element, const Real& mobility) {
  return max(1e-11 * element, 1e-13 * mobility);
}

/// Solves A f = b for the active rows, by A = L D L^T. A row that depends linearly on earlier rows
/// has a pivot of round-off only and gets no force; if the equations are consistent, it is
/// satisfied nevertheless. The bound of round-off is per row (least_pivot): rows between heavy
/// bodies have small elements, independent of the rest of A.
template <class Real>
struct CouplingEquations {
  int count = 0;
  Real* mass = nullptr;           ///< A, its lower triangle: effect of a row's unit force on the
                                  ///< rate of another [1/kg]
  Real* factor = nullptr;         ///< L below the diagonal, L D above it
  Real* least_pivot = nullptr;    ///< per row: a pivot up to this value is round-off
  Real* inverse_pivot = nullptr;  ///< 1 / D; 0 for inactive and dependent rows
  Real* asked = nullptr;          ///< b: required changes of the rates
  Real* force = nullptr;          ///< f, written: the forces or impulses that cause them

  /// @tparam Arena  has take(array, count)   @param rows  number of equations
  template <class Arena>
  SKYBODY_INLINE void take_from(Arena& arena, std::size_t rows) {
    count = static_cast<int>(rows);
    arena.take(mass, rows * rows);
    arena.take(factor, rows * rows);
    for (Real** values : {&inverse_pivot, &least_pivot, &asked, &force}) arena.take(*values, rows);
  }

  /// @param is_held  is_held(row): the lanes in which the row is active
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
