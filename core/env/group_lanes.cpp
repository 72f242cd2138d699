#include "core/env/group_lanes.h"

#include <cstring>

#include "core/base/octets.h"
#include "core/env/group_rows.h"
#include "core/physics/lane_values.h"

namespace skybody {

std::uint32_t octets_of(const StateGroup& group, std::uint32_t mask) {
  return group.lanes() == kGroupLanes ? whole_octets(mask) : 0u;
}

void keep(const StateGroup& group, std::uint32_t mask, int count, const double* from, double* to) {
  const int lanes = group.lanes();
  // Empty lanes may be written: one call to memcpy is quicker than a loop over few values. With
  // many (formation of 20: 6440) half of what it moved would be for nothing.
  constexpr int kFew = 64;
  const bool is_full = mask == first_lanes(lanes);
  if (is_full || (mask == group.occupied() && count <= kFew)) {
    std::memcpy(to, from, static_cast<std::size_t>(count * lanes) * sizeof(double));
    return;
  }
  if (lanes == kGroupLanes) {
    row_kernels().copy(mask, from, count, to);
    return;
  }
  for (int k = 0; k < count; ++k, from += lanes, to += lanes) {
    each_lane(mask, [&](int lane) { to[lane] = from[lane]; });
  }
}

}  // namespace skybody
