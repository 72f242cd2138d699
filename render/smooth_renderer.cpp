#include "render/smooth_renderer.h"

#include <algorithm>
#include <cstdlib>

#include "render/kernels/kernel_table.h"

namespace skybody::render {
namespace {

/// Rays along each edge of a pixel.
constexpr int kFine = 3;
/// Least difference of a colour between neighbouring pixels that is an edge.
constexpr int kEdge = 10;

Pinhole finer(const Pinhole& camera) {
  return {kFine * camera.width,   kFine * camera.height,   kFine * camera.focal_x,
          kFine * camera.focal_y, kFine * camera.center_x, kFine * camera.center_y};
}

int tiles_for(int pixels, int size) { return (pixels + size - 1) / size; }

bool differs(const std::uint8_t* a, const std::uint8_t* b) {
  return std::abs(a[0] - b[0]) > kEdge || std::abs(a[1] - b[1]) > kEdge ||
         std::abs(a[2] - b[2]) > kEdge;
}

}  // namespace

SmoothRenderer::SmoothRenderer(const Pinhole& camera, const Capacity& most, double farthest,
                               const KernelTable& kernels)
    : coarse_(camera, most, farthest, kernels), fine_(finer(camera), most, farthest, kernels) {}

SmoothRenderer::Scratch::Scratch(const SmoothRenderer& renderer)
    : memory_(std::max(renderer.coarse_.scratch_size(), renderer.fine_.scratch_size())),
      tiles_(static_cast<std::size_t>(renderer.fine_columns()) *
             static_cast<std::size_t>(renderer.fine_bands())),
      rgb_(3 * static_cast<std::size_t>(renderer.fine_.width()) *
           static_cast<std::size_t>(renderer.fine_.height())) {}

int SmoothRenderer::fine_columns() const { return tiles_for(fine_.width(), kTileWidth); }
int SmoothRenderer::fine_bands() const { return tiles_for(fine_.height(), kTileHeight); }

void SmoothRenderer::draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
                          Scratch& scratch, std::uint8_t* rgb) const {
  Frame coarse;
  coarse.rgb = rgb;
  coarse_.draw(eye, shapes, sky, scratch.memory_.data(), coarse);
  mark_edges(rgb, scratch.tiles_.data());
  Frame fine;
  fine.rgb = scratch.rgb_.data();
  fine.tiles = scratch.tiles_.data();
  fine_.draw(eye, shapes, sky, scratch.memory_.data(), fine);
  average(scratch, rgb);
}

/// Marks the fine tiles of all pixels that differ from the one to the right or below.
void SmoothRenderer::mark_edges(const std::uint8_t* rgb, std::uint8_t* tiles) const {
  const int columns = fine_columns();
  std::fill_n(tiles, columns * fine_bands(), std::uint8_t{0});
  const auto mark = [&](int x, int y) {
    for (const int column : {kFine * x / kTileWidth, (kFine * x + kFine - 1) / kTileWidth}) {
      for (const int band : {kFine * y / kTileHeight, (kFine * y + kFine - 1) / kTileHeight}) {
        tiles[band * columns + column] = 1;
      }
    }
  };
  const std::ptrdiff_t row = 3 * static_cast<std::ptrdiff_t>(width());
  for (int y = 0; y < height(); ++y) {
    const std::uint8_t* pixel = rgb + y * row;
    for (int x = 0; x < width(); ++x, pixel += 3) {
      const bool right = x + 1 < width() && differs(pixel, pixel + 3);
      const bool below = y + 1 < height() && differs(pixel, pixel + row);
      if (!right && !below) continue;
      mark(x, y);
      if (right) mark(x + 1, y);
      if (below) mark(x, y + 1);
    }
  }
}

/// Replaces the pixels whose rays were all drawn finely by the mean of these.
void SmoothRenderer::average(const Scratch& scratch, std::uint8_t* rgb) const {
  const int columns = fine_columns();
  const std::ptrdiff_t fine_row = 3 * static_cast<std::ptrdiff_t>(fine_.width());
  for (int y = 0; y < height(); ++y) {
    const std::uint8_t* first = scratch.tiles_.data() + (kFine * y / kTileHeight) * columns;
    const std::uint8_t* last =
        scratch.tiles_.data() + ((kFine * y + kFine - 1) / kTileHeight) * columns;
    for (int x = 0; x < width(); ++x) {
      const int left = kFine * x / kTileWidth, right = (kFine * x + kFine - 1) / kTileWidth;
      if ((first[left] & first[right] & last[left] & last[right]) == 0) continue;
      std::uint8_t* pixel = rgb + 3 * (static_cast<std::ptrdiff_t>(y) * width() + x);
      const std::uint8_t* rays = scratch.rgb_.data() + kFine * (y * fine_row + 3 * x);
      for (int c = 0; c < 3; ++c) {
        int sum = kFine * kFine / 2;
        for (int j = 0; j < kFine; ++j) {
          for (int i = 0; i < kFine; ++i) sum += rays[j * fine_row + 3 * i + c];
        }
        pixel[c] = static_cast<std::uint8_t>(sum / (kFine * kFine));
      }
    }
  }
}

}  // namespace skybody::render
