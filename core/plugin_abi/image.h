// Images as sensor outputs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "core/plugin_abi/abi.h"

namespace skybody {

/// Location of an image in its sensor's memory. Made by Setup::image(), used by EnvView::pixels().
/// @tparam T  type of the values: std::uint8_t, std::uint16_t or float
template <class T>
struct Image {
  std::size_t offset = 0;  ///< first byte
  int count = 0;           ///< values
};

namespace plugin_detail {

template <class T>
constexpr std::uint32_t column_type() {
  constexpr bool is_known = std::is_same_v<T, float> || std::is_same_v<T, std::uint8_t> ||
                            std::is_same_v<T, std::uint16_t>;
  static_assert(is_known, "an image has values of std::uint8_t, std::uint16_t or float");
  if (std::is_same_v<T, float>) return SKYBODY_FLOAT32;
  return std::is_same_v<T, std::uint8_t> ? SKYBODY_UINT8 : SKYBODY_UINT16;
}

/// Number of values after one more extent; 0 for an invalid extent or on overflow.
constexpr int product(int count, int extent) {
  constexpr int most = std::numeric_limits<int>::max();
  return extent > 0 && count <= most / extent ? count * extent : 0;
}

/// Size of an image rounded up to a multiple of 8 bytes, where the next image begins.
constexpr std::size_t image_room(std::size_t bytes) { return (bytes + 7) / 8 * 8; }

}  // namespace plugin_detail

/// Default bounds of an image with values of type T; float has none.
template <class T>
inline constexpr double kLeast = std::is_integral_v<T> ? 0.0
                                                       : -std::numeric_limits<double>::infinity();
template <class T>
inline constexpr double kGreatest = std::is_integral_v<T>
                                        ? static_cast<double>(std::numeric_limits<T>::max())
                                        : std::numeric_limits<double>::infinity();

}  // namespace skybody
