// Pictures from PNG and JPEG files.
#pragma once

#include <cstddef>
#include <string>

#include "core/model/picture.h"

namespace skybody {

/// Size limit of a picture's file [bytes].
inline constexpr std::size_t kLargestPictureFile = 32u << 20;

/// Reads a PNG or JPEG file, whatever its name, of up to kLargestPicture rows and columns.
/// Transparency is left out, and grey becomes red, green and blue.
/// @returns the problem, such as "is neither PNG nor JPEG", or an empty text
std::string read_picture(const std::string& file, Picture& picture);

}  // namespace skybody
