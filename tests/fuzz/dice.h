// The random numbers of one input: they follow from the seed, the area and the input's number
// alone, so that any input can be made again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/random.h"

namespace skybody::fuzz {

class Dice {
 public:
  Dice(std::uint64_t seed, const std::string& area, std::uint64_t input)
      : random_(RandomKey{seed, 0}, input, 0, derive_stream(area.data(), area.size())) {}

  std::uint64_t bits() { return random_.bits(); }
  /// Uniform in 0 .. n - 1, n >= 1.
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_.integer(n)); }
  /// True once in n.
  bool one_in(std::size_t n) { return below(n) == 0; }
  /// A length from 1 to `most`; short ones are more frequent, every magnitude equally so.
  std::size_t length(std::size_t most) {
    std::size_t bound = 1;
    while (bound < most && !one_in(4)) bound *= 2;
    return 1 + below(bound < most ? bound : most);
  }
  /// One entry of a list that is not empty.
  template <class List>
  const auto& pick(const List& list) {
    return *(std::begin(list) + static_cast<std::ptrdiff_t>(below(std::size(list))));
  }

 private:
  Random<double> random_;
};

}  // namespace skybody::fuzz
