#include "render/smooth_renderer.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "render/kernels/kernel_table.h"
#include "render/tile_images.h"

namespace skybody::render {
namespace {

/// Rays along each edge of a pixel.
constexpr int kFine = 4;
/// Pixels of the image that a fine tile covers: a part of one row.
constexpr int kCovered = kTileWidth / kFine;
static_assert(kTileWidth % kFine == 0 && kTileHeight == kFine);
/// Least difference of a colour between neighbouring pixels that is an edge.
constexpr int kEdge = 10;
/// Pixels that are searched for edges at once.
constexpr int kRun = 16;
static_assert(kRun % kCovered == 0);

Pinhole finer(const Pinhole& camera) {
  return {kFine * camera.width,   kFine * camera.height,   kFine * camera.focal_x,
          kFine * camera.focal_y, kFine * camera.center_x, kFine * camera.center_y};
}

bool differs(const std::uint8_t* a, const std::uint8_t* b) {
  return std::abs(a[0] - b[0]) > kEdge || std::abs(a[1] - b[1]) > kEdge ||
         std::abs(a[2] - b[2]) > kEdge;
}

/// Whether some of kRun pixels may differ; 3 vectors of bytes.
bool may_differ(const std::uint8_t* a, const std::uint8_t* b) {
  typedef std::uint8_t Bytes __attribute__((vector_size(16)));
  static_assert(3 * kRun == 3 * sizeof(Bytes));
  Bytes found{};
  for (std::size_t k = 0; k < 3 * kRun; k += sizeof(Bytes)) {
    Bytes x, y;
    std::memcpy(&x, a + k, sizeof(Bytes));
    std::memcpy(&y, b + k, sizeof(Bytes));
    found |= (x > y ? x - y : y - x) > static_cast<std::uint8_t>(kEdge);
  }
  std::uint64_t halves[2];
  std::memcpy(halves, &found, sizeof(found));
  return (halves[0] | halves[1]) != 0;
}

/// The mean of a pixel's rays, rounded.
/// @param rays  the first of them in a fine tile
std::uint32_t mean_of(const std::uint32_t* rays) {
  constexpr std::uint32_t kEven = 0x00ff00ff, kHalf = kFine * kFine / 2;
  std::uint32_t even = kHalf | kHalf << 16, odd = kHalf;  // red and blue, green
  for (int row = 0; row < kFine; ++row) {
    for (int column = 0; column < kFine; ++column) {
      const std::uint32_t ray = rays[row * kTileWidth + column];
      even += ray & kEven;
      odd += ray >> 8 & 0xff;
    }
  }
  constexpr int kShift = 4;
  static_assert(1 << kShift == kFine * kFine);
  return (even >> kShift & kEven) | odd >> kShift << 8;
}

}  // namespace

SmoothRenderer::SmoothRenderer(const Pinhole& camera, const Capacity& most, double farthest,
                               const KernelTable& kernels)
    : camera_(camera),
      coarse_(camera, most, farthest, kernels),
      fine_(finer(camera), most, farthest, kernels),
      columns_((camera.width + kCovered - 1) / kCovered) {}

SmoothRenderer::Scratch::Scratch(const SmoothRenderer& renderer)
    : memory_(std::max(renderer.coarse_.scratch_size(), renderer.fine_.scratch_size())),
      tiles_(static_cast<std::size_t>(renderer.columns_) *
             static_cast<std::size_t>(renderer.height())),
      depth_(static_cast<std::size_t>(renderer.width()) *
             static_cast<std::size_t>(renderer.height())) {}

void SmoothRenderer::draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
                          Scratch& scratch, std::uint8_t* rgb,
                          std::span<const LinePoint> lines) const {
  Frame coarse;
  coarse.rgb = rgb;
  coarse.depth = lines.empty() ? nullptr : scratch.depth_.data();
  coarse_.draw(eye, shapes, sky, scratch.memory_.data(), coarse);
  const std::size_t tiles = mark_edges(rgb, scratch.tiles_.data());
  if (scratch.rays_.size() < tiles * kTilePixels) scratch.rays_.resize(tiles * kTilePixels);
  Frame fine;
  fine.packed = scratch.rays_.data();
  fine.tiles = scratch.tiles_.data();
  if (tiles > 0) fine_.draw(eye, shapes, sky, scratch.memory_.data(), fine);
  average(scratch, rgb);
  draw_lines(camera_, eye, lines, scratch.depth_.data(), rgb);
}

/// Marks the fine tiles of all pixels that differ from the one to the right or below.
/// @returns their number
std::size_t SmoothRenderer::mark_edges(const std::uint8_t* rgb, std::uint8_t* tiles) const {
  const std::ptrdiff_t count = static_cast<std::ptrdiff_t>(columns_) * height();
  std::fill_n(tiles, count, std::uint8_t{0});
  const std::ptrdiff_t row = 3 * static_cast<std::ptrdiff_t>(width());
  for (int y = 0; y < height(); ++y) {
    const bool has_below = y + 1 < height();
    for (int first = 0; first < width(); first += kRun) {
      const std::uint8_t* pixel = rgb + y * row + 3 * first;
      const int last = std::min(first + kRun, width());
      const bool is_whole = first + kRun < width() && has_below;
      if (is_whole && !may_differ(pixel, pixel + 3) && !may_differ(pixel, pixel + row)) continue;
      for (int x = first; x < last; ++x, pixel += 3) {
        const bool right = x + 1 < width() && differs(pixel, pixel + 3);
        const bool below = has_below && differs(pixel, pixel + row);
        std::uint8_t* const tile = tiles + y * columns_ + x / kCovered;
        if (right || below) tile[0] = 1;
        if (right) tiles[y * columns_ + (x + 1) / kCovered] = 1;
        if (below) tile[columns_] = 1;
      }
    }
  }
  return static_cast<std::size_t>(std::count(tiles, tiles + count, 1));
}

/// Replaces the pixels of marked tiles by the means of their rays.
void SmoothRenderer::average(const Scratch& scratch, std::uint8_t* rgb) const {
  const std::uint32_t* rays = scratch.rays_.data();
  const std::uint8_t* tile = scratch.tiles_.data();
  for (int y = 0; y < height(); ++y) {
    std::uint8_t* const row = rgb + 3 * static_cast<std::ptrdiff_t>(y) * width();
    for (int first = 0; first < width(); first += kCovered, ++tile) {
      if (*tile == 0) continue;
      const int last = std::min(first + kCovered, width());
      for (int x = first; x < last; ++x) {
        write_color(mean_of(rays + kFine * (x - first)), row + 3 * x);
      }
      rays += kTilePixels;
    }
  }
}

}  // namespace skybody::render
