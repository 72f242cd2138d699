// What several effects that hold one input hold together.
#pragma once

#include "core/base/math.h"
#include "core/model/held_inputs.h"

namespace skybody {

/// What two effects hold together of value k of an input of a body or rotor: gains are multiplied,
/// of limits the narrower holds, of rates of rotors the later effect's, all else is added.
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
