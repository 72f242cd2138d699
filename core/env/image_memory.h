// Images made by the sensors of a group of environments.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/simd/aligned_array.h"

namespace skybody {

/// One run of words per environment. Sensors write bytes into it; a sensor that is not due keeps
/// its images. They are no part of a saved state: after a restore the sensors draw them again.
/// Hashes use words, as for state words.
class ImageMemory {
 public:
  /// @param words  per environment; 0: no images
  ImageMemory(int words, int lanes)
      : words_(static_cast<std::size_t>(words)),
        memory_(words_ * static_cast<std::size_t>(lanes)) {}

  std::size_t words() const { return words_; }
  /// The memory of one environment.
  std::span<const std::uint64_t> of(int lane) const {
    return {memory_.data() + static_cast<std::size_t>(lane) * words_, words_};
  }
  const unsigned char* bytes_of(int lane) const {
    return reinterpret_cast<const unsigned char*>(of(lane).data());
  }
  /// First byte of the first environment. Consecutive environments are 8 words() bytes apart.
  unsigned char* bytes() { return reinterpret_cast<unsigned char*>(memory_.data()); }

  void clear(int lane) { std::fill_n(start_of(lane), words_, std::uint64_t{0}); }

 private:
  std::uint64_t* start_of(int lane) {
    return memory_.data() + static_cast<std::size_t>(lane) * words_;
  }

  std::size_t words_;
  AlignedArray<std::uint64_t> memory_;
};

}  // namespace skybody
