// Commands that replace the policy's.
#pragma once

#include <span>

#include "onboard/mission.h"
#include "onboard/situation.h"

namespace skybody::onboard {

/// Whether there is a level descent for a signal (SkybodySignal): not for rotors, torques and
/// wrenches, which need an attitude controller.
bool can_descend(int signal);

/// Commands of zero: rotors at rest, no thrust. For poses and attitudes: level, no thrust.
void stop_command(const Mission& mission, std::span<double> command);

/// A level descent under a share of the hover thrust.
/// @param motion  the last known one: its heading is kept
/// @param is_fresh  whether the pose is known now; otherwise body rates are zero
void descend_command(const Mission& mission, const Motion& motion, bool is_fresh,
                     std::span<double> command);

}  // namespace skybody::onboard
