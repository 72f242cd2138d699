#include "render/smooth_renderer.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "render/haze.h"
#include "render/kernels/kernel_table.h"

namespace skybody::render {
namespace {

/// Rays along each edge of a pixel.
constexpr int kFine = 3;
/// Least difference of a colour between neighbouring pixels that is an edge.
constexpr int kEdge = 10;
/// Pixels that are searched for edges at once.
constexpr int kRun = 16;

Pinhole finer(const Pinhole& camera) {
  return {kFine * camera.width,   kFine * camera.height,   kFine * camera.focal_x,
          kFine * camera.focal_y, kFine * camera.center_x, kFine * camera.center_y};
}

int tiles_for(int pixels, int size) { return (pixels + size - 1) / size; }

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

}  // namespace

SmoothRenderer::SmoothRenderer(const Pinhole& camera, const Capacity& most, double farthest,
                               const KernelTable& kernels)
    : camera_(camera),
      farthest_(static_cast<float>(farthest)),
      coarse_(camera, most, farthest, kernels),
      fine_(finer(camera), most, farthest, kernels) {}

SmoothRenderer::Scratch::Scratch(const SmoothRenderer& renderer)
    : memory_(std::max(renderer.coarse_.scratch_size(), renderer.fine_.scratch_size())),
      tiles_(static_cast<std::size_t>(renderer.fine_columns()) *
             static_cast<std::size_t>(renderer.fine_bands())),
      rgb_(3 * static_cast<std::size_t>(renderer.fine_.width()) *
           static_cast<std::size_t>(renderer.fine_.height())),
      depth_(static_cast<std::size_t>(renderer.width()) *
             static_cast<std::size_t>(renderer.height())) {}

int SmoothRenderer::fine_columns() const { return tiles_for(fine_.width(), kTileWidth); }
int SmoothRenderer::fine_bands() const { return tiles_for(fine_.height(), kTileHeight); }

void SmoothRenderer::draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
                          Scratch& scratch, std::uint8_t* rgb, const Overlay& overlay) const {
  const Haze haze(sky.horizon, overlay.haze, farthest_);
  Frame coarse;
  coarse.rgb = rgb;
  coarse.depth = haze.is_none() && overlay.lines.empty() ? nullptr : scratch.depth_.data();
  coarse_.draw(eye, shapes, sky, scratch.memory_.data(), coarse);
  haze.fade(scratch.depth_.data(), static_cast<std::ptrdiff_t>(width()) * height(), rgb);
  mark_edges(rgb, scratch.tiles_.data());
  Frame fine;
  fine.rgb = scratch.rgb_.data();
  fine.tiles = scratch.tiles_.data();
  fine_.draw(eye, shapes, sky, scratch.memory_.data(), fine);
  average(scratch, haze, rgb);
  draw_lines(camera_, eye, overlay.lines, scratch.depth_.data(), rgb);
}

/// Marks the fine tiles of all pixels that differ from the one to the right or below.
void SmoothRenderer::mark_edges(const std::uint8_t* rgb, std::uint8_t* tiles) const {
  std::fill_n(tiles, fine_columns() * fine_bands(), std::uint8_t{0});
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
        if (right || below) mark(x, y, tiles);
        if (right) mark(x + 1, y, tiles);
        if (below) mark(x, y + 1, tiles);
      }
    }
  }
}

/// Marks the fine tiles of a pixel.
void SmoothRenderer::mark(int x, int y, std::uint8_t* tiles) const {
  for (const int column : {kFine * x / kTileWidth, (kFine * x + kFine - 1) / kTileWidth}) {
    for (const int band : {kFine * y / kTileHeight, (kFine * y + kFine - 1) / kTileHeight}) {
      tiles[band * fine_columns() + column] = 1;
    }
  }
}

/// Replaces the pixels whose rays were all drawn finely by the mean of these.
void SmoothRenderer::average(const Scratch& scratch, const Haze& haze, std::uint8_t* rgb) const {
  const int columns = fine_columns();
  for (int y = 0; y < height(); ++y) {
    const std::uint8_t* first = scratch.tiles_.data() + (kFine * y / kTileHeight) * columns;
    const std::uint8_t* last =
        scratch.tiles_.data() + ((kFine * y + kFine - 1) / kTileHeight) * columns;
    for (int column = 0; column < columns; ++column) {
      if ((first[column] & last[column]) == 0) continue;
      // The pixels that begin in this tile.
      const int begin = (column * kTileWidth + kFine - 1) / kFine;
      const int end = std::min(((column + 1) * kTileWidth + kFine - 1) / kFine, width());
      for (int x = begin; x < end; ++x) {
        const int right = (kFine * x + kFine - 1) / kTileWidth;
        if ((first[right] & last[right]) != 0) average_pixel(scratch, haze, x, y, rgb);
      }
    }
  }
}

void SmoothRenderer::average_pixel(const Scratch& scratch, const Haze& haze, int x, int y,
                                   std::uint8_t* rgb) const {
  const std::ptrdiff_t fine_row = 3 * static_cast<std::ptrdiff_t>(fine_.width());
  const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(y) * width() + x;
  const std::uint8_t* rays = scratch.rgb_.data() + kFine * (y * fine_row + 3 * x);
  for (int c = 0; c < 3; ++c) {
    int sum = kFine * kFine / 2;
    for (int j = 0; j < kFine; ++j) {
      for (int i = 0; i < kFine; ++i) sum += rays[j * fine_row + 3 * i + c];
    }
    rgb[3 * at + c] = static_cast<std::uint8_t>(sum / (kFine * kFine));
  }
  haze.fade(scratch.depth_.data() + at, 1, rgb + 3 * at);
}

}  // namespace skybody::render
