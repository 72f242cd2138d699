// Text about a mission.
#pragma once

#include <string>

#include "onboard/mission.h"
#include "onboard/needs.h"

namespace skybody::onboard {

/// The page that --about prints: task, columns with units and frames, command with ranges, limits.
std::string about(const Mission& mission, const Needs& needs);

/// The name of a SkybodySignal.
const char* signal_word(int signal);

}  // namespace skybody::onboard
