// Sizes of arrays from counts that are stored as int.
#pragma once

#include <cstddef>

namespace skybody::learn {

/// a b, which may exceed an int.
constexpr std::size_t product(int a, int b) {
  return static_cast<std::size_t>(a) * static_cast<std::size_t>(b);
}

}  // namespace skybody::learn
