// What effects may hold over a physics step, as data. The list is core/base/held_inputs.h.
#pragma once

#include <array>
#include <limits>
#include <string_view>

#include "core/base/held_inputs.h"  // IWYU pragma: export

namespace skybody {

/// One input.
struct HeldInputRow {
  const char* name;   ///< such as "wind"
  bool is_of_rotors;  ///< else of bodies
  int size;           ///< values for each
};

/// In the order of SkybodyHeldInput.
inline constexpr std::array<HeldInputRow, SKYBODY_HELD_COUNT> kHeldInputs = {{
#define SKYBODY_ROW(symbol, type, member, owner, size, doc) \
  {#member, std::string_view(#owner) == "rotor", size},
    SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
}};

/// The most values that an input has for one body or rotor.
inline constexpr int kMostHeldValues = [] {
  int most = 0;
  for (const HeldInputRow& row : kHeldInputs) most = row.size > most ? row.size : most;
  return most;
}();

/// What place k of an input is where nothing is held.
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
