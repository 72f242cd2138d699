// Between the rows of learners, one per environment in float, and the values of a group of
// kGroupLanes, in lanes of double. Eight lanes at a time: those of octets (core/base/octets.h) that
// take part only in part go lane by lane, elsewhere.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skybody {

/// One set of functions per instruction set; all give the same bits. `octets`: the lanes to serve,
/// whole octets.
struct RowKernels {
  /// Values clipped to [-1, 1].
  /// @param rows   row of lane l at rows + l * stride, `count` values each
  /// @param values `count` values in lanes
  /// @returns the octets that were read: of the others, nothing is, for a value is not finite, or
  ///          the sum of all of them is not
  std::uint32_t (*read_clipped)(std::uint32_t octets, const float* rows, std::ptrdiff_t stride,
                                int count, double* values);

  /// low + (a + 1) / 2 (high - low) for each of `count` values.
  void (*scale)(std::uint32_t octets, const double* action, int count, const double* low,
                const double* high, double* command);

  /// `count` values of any lanes, octets or not.
  void (*copy)(std::uint32_t lanes, const double* from, int count, double* to);

  /// @returns octets whose values are all finite as floats; one whose values are so large that
  /// their
  ///          sum is not may be missing
  std::uint32_t (*are_finite)(std::uint32_t octets, const double* values, int count);

  /// @param values  `count` values in lanes
  /// @param rows    as floats, row of lane l at rows + l * count
  /// @returns as are_finite; the other octets are written, too
  std::uint32_t (*write)(std::uint32_t octets, const double* values, int count, float* rows);

  /// What tells the outcome of a transition.
  /// @param end      bits by the task, 1 word per lane: those of kTerminated and kTruncated count
  /// @param step     actions taken in the episode, 1 word per lane
  /// @param horizon  an episode is truncated at so many; 0: never
  /// @param status   EpisodeStatus bits, 1 word per lane
  /// @param rows     the same once more
  void (*end)(std::uint32_t octets, const std::uint64_t* end, const std::uint64_t* step,
              std::uint64_t horizon, std::uint64_t* status, std::uint64_t* rows);
};

/// Those of the best instruction set at hand (best_isa), chosen once.
const RowKernels& row_kernels();

}  // namespace skybody
