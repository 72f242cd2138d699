// Pictures for textures. C++17.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace skybody {

/// Most columns, and most rows, of a picture.
inline constexpr int kLargestPicture = 4096;

/// Rows from the top, pixels from the left.
struct Picture {
  int width = 0, height = 0;      ///< [pixels]
  std::vector<std::uint8_t> rgb;  ///< red, green, blue of each pixel
};

/// Reads a picture from a file. @returns the problem, such as "does not exist", or ""
using ReadPicture = std::string (*)(const std::string& file, Picture& picture);

}  // namespace skybody
