// Held inputs of effects, as data. The list is in core/base/held_inputs.h.
#pragma once

#include <array>
#include <limits>
#include <string_view>

#include "core/base/held_inputs.h"  // IWYU pragma: export

namespace skybody {

/// One held input.
struct HeldInputRow {
  const char* name;   ///< such as "wind"
  bool is_of_rotors;  ///< per rotor; else per body
  int size;           ///< values per rotor or body
};

/// In the order of SkybodyHeldInput.
inline constexpr std::array<HeldInputRow, SKYBODY_HELD_COUNT> kHeldInputs = {{
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) \
  {#member, std::string_view(#owner) == "rotor", size},
    SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
}};

/// The largest number of values of an input for one body or rotor.
inline constexpr int kMostHeldValues = [] {
  int most = 0;
  for (const HeldInputRow& row : kHeldInputs) most = row.size > most ? row.size : most;
  return most;
}();

/// The neutral value of entry k of an input, used without effects.
constexpr double neutral_value(int input, int k) {
  using Limits = std::numeric_limits<double>;
  switch (input) {
    case SKYBODY_HELD_ROTOR_GAIN:
      return 1.0;
    case SKYBODY_HELD_ROTOR_LIMIT:
      return k % 2 == 0 ? 0.0 : Limits::infinity();
    case SKYBODY_HELD_ROTOR_RATE:
      return Limits::quiet_NaN();
    default:
      return 0.0;
  }
}

}  // namespace skybody
