// The random numbers of one input: a function of the seed, the area and the input's number only, so
// any input can be reproduced.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/math/random.h"

namespace skybody::fuzz {

class Dice {
 public:
  Dice(std::uint64_t seed, const std::string& area, std::uint64_t input)
      : random_(RandomKey{seed, 0}, input, 0, derive_stream(area.data(), area.size())) {}

  std::uint64_t bits() { return random_.bits(); }
  /// Uniform in 0 .. n - 1, n >= 1.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_.integer(n)); }
  /// True with probability 1/n.
  bool one_in(std::size_t n) { return below(n) == 0; }
  /// A length from 1 to `most`, uniform over orders of magnitude; short lengths are more frequent.
  std::size_t length(std::size_t most) {
    std::size_t bound = 1;
    while (bound < most && !one_in(4)) bound *= 2;
    return 1 + below(bound < most ? bound : most);
  }
  /// A random entry of a list that is not empty.
  template <class List>
  const auto& pick(const List& list) {
    return *(std::begin(list) + static_cast<std::ptrdiff_t>(below(std::size(list))));
  }

 private:
  Random<double> random_;
};

}  // namespace skybody::fuzz
