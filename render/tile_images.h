// Pixels of drawn tiles, and their places in images.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "render/kernels/kernel_table.h"
#include "render/ray_tiles.h"
#include "render/renderer.h"

namespace skybody::render {

/// Results of the kernels.
struct DrawnTile {
  float depth[kTilePixels];
  std::uint32_t id[kTilePixels];
  std::int32_t surface[kTilePixels];
  float normal[3 * kTilePixels];
  std::uint32_t color[kTilePixels];
};

/// Red, green and blue of a kernel's colour.
inline void write_color(std::uint32_t color, std::uint8_t* rgb) {
  for (int k = 0; k < 3; ++k) rgb[k] = static_cast<std::uint8_t>(color >> (8 * k));
}

/// Distance from the eye at a depth along the optical axis, for the direction (x, y, 1).
inline float range_at(float depth, float x, float y) {
  return depth * std::sqrt((x * x + y * y) + 1.0f);
}

/// Pixels of a tile of a grid.
struct GridPixels {
  const float *x, *y;  ///< directions of its columns and rows
  int width, height;   ///< of its part within the image
  int image_width;
  std::size_t first;  ///< index of its first pixel in the image
  float farthest;     ///< [m]

  /// Calls function(index in the image, index in the tile) for each pixel.
  template <class Function>
  void each(Function&& function) const {
    for (int r = 0; r < height; ++r) {
      const std::size_t row =
          first + static_cast<std::size_t>(r) * static_cast<std::size_t>(image_width);
      for (int c = 0; c < width; ++c) {
        function(row + static_cast<std::size_t>(c), r * kTileWidth + c);
      }
    }
  }
  float depth(const DrawnTile& tile, int at) const { return tile.depth[at]; }
  float range(const DrawnTile& tile, int at) const {
    if (tile.id[at] == 0) return farthest;
    return std::min(range_at(tile.depth[at], x[at % kTileWidth], y[at / kTileWidth]), farthest);
  }
  void write_rgb(const DrawnTile& tile, std::uint8_t* rgb) const {
    for (int r = 0; r < height; ++r) {
      const std::size_t row =
          first + static_cast<std::size_t>(r) * static_cast<std::size_t>(image_width);
      std::uint8_t* to = rgb + 3 * row;
      const std::uint32_t* from = tile.color + r * kTileWidth;
      // Four bytes at a time: the next pixel overwrites the fourth.
      static_assert(std::endian::native == std::endian::little);
      for (int c = 0; c + 1 < width; ++c, to += 3) std::memcpy(to, from++, sizeof(*from));
      write_color(*from, to);
    }
  }
  /// Component `axis` of the normal, camera axes.
  float normal(const DrawnTile& tile, int at, int axis) const {
    return tile.normal[axis * kTilePixels + at];
  }
};

/// Pixels of a tile of scattered rays.
struct RayPixels {
  const RayTile& tile;
  const Mat3<double>& axes;  ///< camera axes from the face's
  float farthest;            ///< [m]

  template <class Function>
  void each(Function&& function) const {
    for (int at = 0; at < tile.count; ++at) {
      function(static_cast<std::size_t>(tile.pixel[at]), at);
    }
  }
  void write_rgb(const DrawnTile& drawn, std::uint8_t* rgb) const {
    each([&](std::size_t to, int at) { write_color(drawn.color[at], rgb + 3 * to); });
  }
  float depth(const DrawnTile& drawn, int at) const {
    return drawn.id[at] == 0 ? farthest : range(drawn, at) * tile.axial[at];
  }
  float range(const DrawnTile& drawn, int at) const {
    if (drawn.id[at] == 0) return farthest;
    return std::min(range_at(drawn.depth[at], tile.x[at], tile.y[at]), farthest);
  }
  /// The axes are a permutation with signs: the sum is exact.
  float normal(const DrawnTile& drawn, int at, int axis) const {
    float sum = 0.0f;
    for (int k = 0; k < 3; ++k) {
      sum += static_cast<float>(axes(axis, k)) * drawn.normal[k * kTilePixels + at];
    }
    return sum;
  }
};

template <class Pixels>
void write_depths(const Pixels& pixels, const DrawnTile& tile, const Frame& frame) {
  if (frame.depth != nullptr) {
    pixels.each([&](std::size_t to, int at) { frame.depth[to] = pixels.depth(tile, at); });
  }
  if (frame.range != nullptr) {
    pixels.each([&](std::size_t to, int at) { frame.range[to] = pixels.range(tile, at); });
  }
  if (frame.instance != nullptr) {
    pixels.each([&](std::size_t to, int at) {
      frame.instance[to] = static_cast<std::uint16_t>(tile.id[at] & 0xffffu);
    });
  }
  if (frame.label != nullptr) {
    pixels.each([&](std::size_t to, int at) {
      frame.label[to] = static_cast<std::uint8_t>(tile.id[at] >> 16);
    });
  }
}

/// @param parts, triangles  indexed by the tile's codes of surfaces
template <class Pixels>
void write_shapes(const Pixels& pixels, const DrawnTile& tile, const SeenShape* parts,
                  const SeenTriangle* triangles, const Frame& frame) {
  pixels.each([&](std::size_t to, int at) {
    const std::int32_t surface = tile.surface[at];
    const std::int32_t part = surface < -1  ? triangles[triangle_of_code(surface)].part
                              : surface < 0 ? -1
                                            : surface >> 2;
    frame.shape[to] = part < 0 ? -1 : parts[part].shape;
  });
}

template <class Pixels>
void write_shades(const Pixels& pixels, const DrawnTile& tile, const Frame& frame) {
  if (frame.normal != nullptr) {
    pixels.each([&](std::size_t to, int at) {
      for (int k = 0; k < 3; ++k) {
        frame.normal[3 * to + static_cast<std::size_t>(k)] = pixels.normal(tile, at, k);
      }
    });
  }
  if (frame.rgb != nullptr) pixels.write_rgb(tile, frame.rgb);
}

}  // namespace skybody::render
