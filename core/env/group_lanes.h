// Values and counters of the lanes of a group.
#pragma once

#include <cstdint>

#include "core/env/state_group.h"

namespace skybody {

/// Adds one to a header word in each lane of a mask.
void count(StateGroup& group, HeaderWord word, std::uint32_t mask);

/// Copies `count` values of the lanes of a mask. May also overwrite lanes that hold no environment
/// (StateGroup::occupied).
void keep(const StateGroup& group, std::uint32_t mask, int count, const double* from, double* to);

}  // namespace skybody
