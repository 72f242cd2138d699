// Lanes of a group by octets where row kernels can serve them.
#pragma once

#include <cstdint>

#include "core/env/state_group.h"

namespace skybody {

/// The lanes of a mask that row kernels may serve.
std::uint32_t octets_of(const StateGroup& group, std::uint32_t mask);

/// Copies `count` values of the lanes of a mask. May overwrite other lanes, too, where no
/// environment was made (StateGroup::occupied).
void keep(const StateGroup& group, std::uint32_t mask, int count, const double* from, double* to);

}  // namespace skybody
