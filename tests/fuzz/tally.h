// Counts of the results of one area's inputs.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tests/fuzz/finding.h"

namespace skybody::fuzz {

struct Tally {
  std::string area;
  std::uint64_t refused = 0, accepted = 0;
  std::array<std::uint64_t, kFindingKinds> findings{};
  double seconds = 0.0;  ///< summed over the processes that ran them
  double slowest = 0.0;  ///< processor time of the slowest input that ended [s]

  std::uint64_t bad() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : findings) sum += count;
    return sum;
  }
  /// A leak is found by running inputs again; the first run of each has already counted it.
  std::uint64_t inputs() const {
    return refused + accepted + bad() - findings[static_cast<std::size_t>(FindingKind::kLeak)];
  }
};

}  // namespace skybody::fuzz
