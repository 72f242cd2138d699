// Images that a sensor gives.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "plugins/api/abi.h"

namespace skybody {

/// Where an image of a sensor lies in its memory. Made by Setup::image(), used by
/// EnvView::pixels().
/// @tparam T  of its values: std::uint8_t, std::uint16_t or float
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

/// The number of values with one more extent; what no image can have becomes 0.
constexpr int product(int count, int extent) {
  constexpr int most = std::numeric_limits<int>::max();
  return extent > 0 && count <= most / extent ? count * extent : 0;
}

/// Bytes of an image, up to the next multiple of 8: there the next one begins.
constexpr std::size_t image_room(std::size_t bytes) { return (bytes + 7) / 8 * 8; }

}  // namespace plugin_detail

/// Bounds of T where an image declares none: of float there are none.
template <class T>
inline constexpr double kLeast = std::is_integral_v<T> ? 0.0
                                                       : -std::numeric_limits<double>::infinity();
template <class T>
inline constexpr double kGreatest = std::is_integral_v<T>
                                        ? static_cast<double>(std::numeric_limits<T>::max())
                                        : std::numeric_limits<double>::infinity();

}  // namespace skybody
