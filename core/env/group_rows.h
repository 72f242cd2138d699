// Between the rows of learners, one per environment in float, and the values of a full group, in
// lanes of double. For groups of kGroupLanes all of which take part; others go lane by lane.
#pragma once

#include <cstddef>
#include <cstdint>

namespace skybody {

/// One set of functions per instruction set; all give the same bits.
struct RowKernels {
  /// Values of all lanes, clipped to [-1, 1].
  /// @param rows   row of lane l at rows + l * stride, `count` values each
  /// @param values `count` values in lanes
  /// @returns false, and nothing is written, if one of them is not finite
  bool (*read_clipped)(const float* rows, std::ptrdiff_t stride, int count, double* values);

  /// low + (a + 1) / 2 (high - low) for each of `count` values of all lanes.
  void (*scale)(const double* action, int count, const double* low, const double* high,
                double* command);

  /// Whether all values of all lanes are finite as floats.
  bool (*are_finite)(const double* values, int count);

  /// @param values  `count` values in lanes
  /// @param rows    as floats, row of lane l at rows + l * count
  /// @returns whether all of them are finite as floats
  bool (*write)(const double* values, int count, float* rows);

  /// What tells the outcome of a transition of all lanes.
  /// @param end      bits by the task, 1 word per lane: those of kTerminated and kTruncated count
  /// @param step     actions taken in the episode, 1 word per lane
  /// @param horizon  an episode is truncated at so many; 0: never
  /// @param status   EpisodeStatus bits, 1 word per lane
  void (*end)(const std::uint64_t* end, const std::uint64_t* step, std::uint64_t horizon,
              std::uint64_t* status);
};

/// Those of the best instruction set at hand (best_isa), chosen once.
const RowKernels& row_kernels();

}  // namespace skybody
