// The output of a batch of environments: compared bit by bit and checked for finite values.
#pragma once

#include <cstdint>
#include <vector>

#include "core/batch/pool.h"
#include "tests/fuzz/flight_check.h"

namespace skybody::fuzz {

/// Rows of one transition of every environment, in the order of their ids.
class BatchRows {
 public:
  /// Receives all environments in flight.
  /// @throws Finding if a value is not finite, except in rows with a fault under
  ///         Faults::kAreAnything
  static BatchRows receive(Pool& envs, Faults faults = Faults::kAreFinite);

  /// Words of one environment's row.
  const std::vector<std::uint32_t>& of(int env) const {
    return words_[static_cast<std::size_t>(env)];
  }

 private:
  void add(const Batch& batch, int row, Faults faults);

  std::vector<std::vector<std::uint32_t>> words_;
};

/// @throws Finding if the row or hash of an environment other than `changed` differs
void check_others(const BatchRows& rows, const BatchRows& expected, int envs, int changed);

}  // namespace skybody::fuzz
