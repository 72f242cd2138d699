// Inputs that effects hold during a physics step: wind, loads, and what they do to rotors. They add
// to rotors, wrenches and drives; each has a neutral value that changes nothing.
#pragma once

#include <array>
#include <string_view>

#include "core/base/held_inputs.h"
#include "core/model/layout.h"

namespace skybody {

/// Which of them a world has words for.
struct HeldInputs {
  bool wind = false;         ///< velocity of the air at each body's origin, W [m/s]
  bool wrench = false;       ///< per body: force at the centre of mass [N], moment [N m]; W axes
  bool rotor_gain = false;   ///< factors of a rotor's first kGainedConstants terms: thrust,
                             ///< reaction, rotor drag, rolling moment
  bool rotor_limit = false;  ///< lower and upper limit of a rotor's speed [rad/s]
  bool rotor_rate = false;   ///< acceleration of a rotor [rad/s^2] instead of its lag; NaN: the lag

  bool any_of_rotors() const { return rotor_gain || rotor_limit || rotor_rate; }
  bool any() const { return wind || wrench || any_of_rotors(); }
};

/// The rotor constants that gains act on are the first ones of kRotorConstants.
inline constexpr int kGainedConstants = 4;
static_assert(kRollingMomentConstant == kGainedConstants - 1);

/// One block of held inputs.
struct HeldBlock {
  const char* name;
  bool HeldInputs::*is_held;
  Block Layout::*place;
  bool is_of_rotors;  ///< else of bodies
  int size;           ///< values of one body or rotor
  double even, odd;   ///< its neutral values, by place

  double neutral(int k) const { return k % size % 2 == 0 ? even : odd; }
};

/// In the order of SkybodyHeldInput.
inline constexpr std::array<HeldBlock, SKYBODY_HELD_COUNT> kHeldBlocks{{
#define SKYBODY_ROW(symbol, member, owner, size, even, odd, doc) \
  {"held_" #member,                                              \
   &HeldInputs::member,                                          \
   &Layout::held_##member,                                       \
   std::string_view(#owner) == "rotor",                          \
   size,                                                         \
   even,                                                         \
   odd},
    SKYBODY_HELD_INPUTS(SKYBODY_ROW)
#undef SKYBODY_ROW
}};
static_assert(kHeldBlocks[SKYBODY_HELD_ROTOR_GAIN].size == kGainedConstants);

/// Calls put(place, k, value) for the neutral value of every word k of every block.
template <class Put>
void each_neutral_input(const Layout& layout, Put&& put) {
  for (const HeldBlock& held : kHeldBlocks) {
    for (int k = 0; k < (layout.*held.place).size; ++k) {
      put(held.place, k, held.neutral(k));
    }
  }
}

}  // namespace skybody
