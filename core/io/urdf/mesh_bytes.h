// Reads numbers from a mesh's bytes. Internal to core/io.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

namespace skybody {

/// The number at `bytes`, stored in the byte order `order`.
template <class Number>
Number read_bytes(const char* bytes, std::endian order = std::endian::little) {
  std::array<char, sizeof(Number)> own;
  std::memcpy(own.data(), bytes, own.size());
  if (order != std::endian::native) std::reverse(own.begin(), own.end());
  return std::bit_cast<Number>(own);
}

}  // namespace skybody
