// Images of some rows of a rollout.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/simd/aligned_array.h"

namespace skybody::learn {

/// Image k of row r has its bytes at columns[k].data() + index(r) * bytes.
struct ImageRows {
  const AlignedArray<std::uint8_t>* columns = nullptr;  ///< one per image
  std::size_t first = 0;
  const int* order = nullptr;  ///< index(r) = order[r]; null: first + r
};

}  // namespace skybody::learn
