// The values of a lane group as dual numbers (core/base/math/dual.h): the inputs and outputs of
// plugins' functions on dual numbers.
#pragma once

#include <cstdint>

#include "core/base/simd/aligned_array.h"
#include "core/env/compiled_scenario.h"
#include "core/physics/world/lane_values.h"

namespace skybody {

/// Each value is a row of kGroupLanes values, followed by a row of tangents. Row k is state word k.
/// Then come the values of the observation, the reward, and the bodies' motion, 13 rows each,
/// unless the motion equals q and u (one free body).
class DualGroup {
 public:
  explicit DualGroup(const CompiledScenario& compiled);

  int rows() const { return rows_; }
  int observation() const { return observation_; }  ///< its first row
  int reward() const { return observation_ + observed_; }
  int bodies() const { return bodies_; }
  int body_rows() const { return rows_ - (reward() + 1); }  ///< 0: the motion is q and u

  double* value(int row) { return data_.data() + std::ptrdiff_t{2} * row * kGroupLanes; }
  double* tangent(int row) { return value(row) + kGroupLanes; }
  std::uint64_t* words(int row) { return reinterpret_cast<std::uint64_t*>(value(row)); }
  const double* tangent(int row) const {
    return data_.data() + (std::ptrdiff_t{2} * row + 1) * kGroupLanes;
  }
  /// Overwrites values; tangents remain.
  /// @param values  `count` rows
  void set_values(int row, int count, const double* values);

  /// The view for plugins. Counters are set by the caller.
  SkybodyLanes view();

 private:
  const StateLayout& layout_;
  int observation_, observed_, rows_, bodies_;
  AlignedArray<double> data_, scratch_;
};

}  // namespace skybody
