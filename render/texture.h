// Pictures on surfaces, laid out for the kernels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/kernels/kernel_table.h"

namespace skybody::render {

/// A picture and its halves: each level has half the width and height of the one before, down to
/// one pixel, for the means that distant pixels see. Immutable.
class Texture {
 public:
  /// @param rgb  rows from the top: red, green, blue of each pixel
  /// @param width, height  1 to 4096 [pixels]
  Texture(std::span<const std::uint8_t> rgb, int width, int height);
  Texture(const Texture&) = delete;
  Texture& operator=(const Texture&) = delete;

  const TexelLevels& levels() const { return levels_; }
  int width() const { return levels_.level[0].width; }    ///< [pixels]
  int height() const { return levels_.level[0].height; }  ///< [pixels]

 private:
  std::vector<std::uint32_t> texels_;  ///< of all levels, one after another
  TexelLevels levels_{};
};

}  // namespace skybody::render
