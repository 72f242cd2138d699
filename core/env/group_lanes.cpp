#include "core/env/group_lanes.h"

#include <cstring>

#include "core/base/simd/lane_mask.h"
#include "core/env/row_conversion.h"

namespace skybody {

void count(StateGroup& group, HeaderWord word, std::uint32_t mask) {
  row_kernels().count(mask, group.writable(word));
}

void keep(const StateGroup& group, std::uint32_t mask, int count, const double* from, double* to) {
  const int lanes = group.lanes();
  // Lanes without an environment may be overwritten: for few values, one memcpy is faster than a
  // loop. For many values (formation of 20: 6440), half of the copied memory would be empty lanes.
  constexpr int kFew = 64;
  const bool is_full = mask == first_lanes(lanes);  // such as the lane of a group of one
  if (mask == 0) return;
  if (is_full || (mask == group.occupied() && count <= kFew)) {
    std::memcpy(to, from, static_cast<std::size_t>(count * lanes) * sizeof(double));
    return;
  }
  row_kernels().copy(mask, from, count, to);
}

}  // namespace skybody
