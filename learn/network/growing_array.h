// Memory that grows to the largest call.
#pragma once

#include <cstddef>

#include "core/base/simd/aligned_array.h"

namespace skybody::learn {

/// Enlarges an array; the content of an array that is too small is lost.
inline void make_large_enough(AlignedArray<float>& array, std::size_t size) {
  if (array.size() < size) array = AlignedArray<float>(size);
}

}  // namespace skybody::learn
