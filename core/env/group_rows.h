// Between the rows of learners, one per environment in float, and the values of a full group, in
// lanes of double. For groups of kGroupLanes all of which take part; others go lane by lane.
#pragma once

#include <cstddef>

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
  /// @param copy    the same values once more in lanes; null: not wanted
  void (*write)(const double* values, int count, float* rows, double* copy);
};

/// Those of the best instruction set at hand (best_isa), chosen once.
const RowKernels& row_kernels();

}  // namespace skybody
