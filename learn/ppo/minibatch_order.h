// The order in which the rows of a rollout go into minibatches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/math/random.h"

namespace skybody::learn {

/// A permutation of the rows of a rollout, or of its sequences, whose rows then stay together. A
/// sequence is the rows of one environment or robot: row step * rows + row.
class MinibatchOrder {
 public:
  /// @param steps, rows  of a rollout
  /// @param together     whether sequences stay together
  MinibatchOrder(int steps, int rows, bool together)
      : steps_(steps),
        rows_(rows),
        together_(together),
        order_(static_cast<std::size_t>(steps) * static_cast<std::size_t>(rows)) {}

  std::span<const int> order() const { return order_; }

  /// Shuffles (Durstenfeld 1964, algorithm 235). A word serves two draws: each is the upper half of
  /// a half-word times the number of choices, biased by less than 1e-5 for fewer than 40,000 rows.
  void shuffle(Random<double> random);

 private:
  int steps_, rows_;
  bool together_;
  std::vector<int> order_;
};

}  // namespace skybody::learn
