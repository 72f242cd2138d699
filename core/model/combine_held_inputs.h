// Combination of several effects' values of one held input.
#pragma once

#include "core/base/math/math.h"
#include "core/model/held_inputs.h"

namespace skybody {

/// Combines two effects' values of entry k of a held input of one body or rotor:
/// - rotor gains: the product
/// - rotor limits: the narrower one
/// - rotor rates: the later effect's, unless it is NaN
/// - all others: the sum
template <class Real>
SKYBODY_INLINE Real held_together(int input, int k, const Real& a, const Real& b) {
  switch (input) {
    case SKYBODY_HELD_ROTOR_GAIN:
      return a * b;
    case SKYBODY_HELD_ROTOR_LIMIT:
      return k % 2 == 0 ? select(a < b, b, a) : select(b < a, b, a);
    case SKYBODY_HELD_ROTOR_RATE:
      return select(b == b, b, a);
    default:
      return a + b;
  }
}

}  // namespace skybody
