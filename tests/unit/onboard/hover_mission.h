// A mission of the task `hover` for a quadrotor of 1 kg, made without a scenario.
#pragma once

#include "core/plugin_abi/signals.h"
#include "onboard/mission.h"

namespace skybody::onboard {

inline constexpr double kMass = 1.0;           // [kg]
inline constexpr double kMostThrust = 20.0;    // of the four rotors [N]
inline constexpr double kHoverAction = -0.02;  // of every output: 9.8 N by the range 0 ... 20 N

/// @param signal  of the command; ctbr, force, ... with four values
Mission hover_mission(int signal = SKYBODY_CTBR);

/// A pose at a place, level, at rest.
struct Motion level_at(double x, double y, double z);

}  // namespace skybody::onboard
