// Schedule of a randomizer: it draws at the first reset, then at every n-th, and on request; and
// writing of the drawn values.
#pragma once

#include <skybody/plugin.h>

#include <cstdint>

namespace skybody::randomization {

/// A randomizer's state, kept across resets.
template <class Real>
struct Schedule {
  Word<Real> waited;  ///< resets since the last draw; 0: draw at the next one
};

/// The parameter of all randomizers with a schedule.
inline IntegerSpec every_spec() {
  return {
      .name = "every", .value = 1, .min = 1, .doc = "draw at every n-th reset, the first included"};
}

/// Mask of the lanes in which to draw now.
template <class Real>
SKYBODY_INLINE MaskOf<Real> is_due(const Schedule<Real>& schedule, bool requested) {
  return logical_or(MaskOf<Real>(requested), schedule.waited == Word<Real>(0));
}

/// Writes a parameter in the due lanes; the others keep their values.
template <class Real>
SKYBODY_INLINE void put(Start<Real>& start, int param, const MaskOf<Real>& due, const Real& value) {
  start.params.set(param, select(due, value, start.params[param]));
}

/// Counts a reset. A requested draw in mid-episode does not count.
template <class Real>
SKYBODY_INLINE void count_reset(Schedule<Real>& schedule, bool requested, std::int64_t every) {
  if (requested) return;
  const Word<Real> next = schedule.waited + Word<Real>(1);
  const Word<Real> whole(static_cast<std::uint64_t>(every));
  schedule.waited = select(next == whole, Word<Real>(0), next);
}

}  // namespace skybody::randomization
