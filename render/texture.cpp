#include "render/texture.h"

#include <algorithm>

namespace skybody::render {
namespace {

constexpr std::uint32_t kBytes[] = {0, 8, 16};  ///< places of red, green, blue

int half_of(int size) { return std::max(1, size / 2); }

/// The mean of four texels, rounded.
std::uint32_t mean_of(const std::uint32_t (&texels)[4]) {
  std::uint32_t mean = 0;
  for (const std::uint32_t at : kBytes) {
    std::uint32_t sum = 2;
    for (const std::uint32_t texel : texels) sum += texel >> at & 0xffu;
    mean |= (sum >> 2) << at;
  }
  return mean;
}

}  // namespace

Texture::Texture(std::span<const std::uint8_t> rgb, int width, int height) {
  std::size_t total = 0;
  for (int w = width, h = height;; w = half_of(w), h = half_of(h)) {
    levels_.level[levels_.count++] = {nullptr, w, h};
    total += static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    if ((w == 1 && h == 1) || levels_.count == kMostLevels) break;
  }
  texels_.resize(total);
  for (std::size_t i = 0; 3 * i < rgb.size(); ++i) {
    texels_[i] =
        rgb[3 * i] | std::uint32_t{rgb[3 * i + 1]} << 8 | std::uint32_t{rgb[3 * i + 2]} << 16;
  }
  std::uint32_t* next = texels_.data();
  for (int k = 0; k < levels_.count; ++k) {
    TexelLevel& level = levels_.level[k];
    level.texels = next;
    for (int row = 0; k > 0 && row < level.height; ++row) {
      for (int column = 0; column < level.width; ++column) {
        const TexelLevel& above = levels_.level[k - 1];
        const int left = 2 * column, right = std::min(left + 1, above.width - 1);
        const int top = 2 * row, bottom = std::min(top + 1, above.height - 1);
        const auto texel = [&above](int r, int c) { return above.texels[r * above.width + c]; };
        next[row * level.width + column] = mean_of(
            {texel(top, left), texel(top, right), texel(bottom, left), texel(bottom, right)});
      }
    }
    next += static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
  }
}

}  // namespace skybody::render
