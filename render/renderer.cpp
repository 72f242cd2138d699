#include "render/renderer.h"

#include <algorithm>
#include <cmath>

#include "render/caster.h"
#include "render/seen_shape.h"

namespace skybody::render {
namespace {

/// Tiles [left, right) x [top, bottom).
struct TileRange {
  std::uint16_t left, right, top, bottom;
};

int tiles_for(int pixels, int size) { return (pixels + size - 1) / size; }

/// Directions of pixel centres, up to whole tiles.
std::vector<float> directions(int pixels, int tile, double center, double focal) {
  std::vector<float> values(static_cast<std::size_t>(tiles_for(pixels, tile) * tile));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<float>((static_cast<double>(i) + 0.5 - center) / focal);
  }
  return values;
}

/// The tiles of one axis that a cover from `low` to `high` meets: [first, last).
struct Span {
  std::uint16_t first, last;
};
Span tiles_between(float low, float high, const std::vector<float>& centers, int tile) {
  // Pixels lie at equal distances: the first one that is not below `low`, and the last one.
  const auto size = static_cast<float>(centers.size());
  const float step = centers[1] - centers[0];
  const auto within = [size](float at) { return at > 0.0f ? std::min(at, size) : 0.0f; };
  const float from = within((low - centers[0]) / step - 1.0f);
  const float to = within((high - centers[0]) / step + 2.0f);
  const int first = static_cast<int>(from) / tile, last = tiles_for(static_cast<int>(to), tile);
  return {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(std::max(first, last))};
}

void turn(const Eye& eye, const Vec3<double>& v, float (&out)[3]) {
  const Vec3<double> seen = transpose_times(eye.axes, v);
  out[0] = static_cast<float>(seen.x);
  out[1] = static_cast<float>(seen.y);
  out[2] = static_cast<float>(seen.z);
}

Light light_of(const Sky& sky, const Eye& eye, const Pinhole& camera) {
  Light light{};
  turn(eye, sky.sun, light.sun);
  turn(eye, {0.0, 0.0, 1.0}, light.up);
  light.direct = sky.direct;
  light.ambient = sky.ambient;
  std::copy(sky.zenith.begin(), sky.zenith.end(), light.zenith);
  std::copy(sky.horizon.begin(), sky.horizon.end(), light.horizon);
  light.pixel = static_cast<float>(1.0 / camera.focal_x);
  set_sides(light);
  return light;
}

}  // namespace

/// Parts of shapes with their tiles, the lists of a band of tiles, and casters of shadows.
struct Renderer::Scratch {
  SeenShape* parts = nullptr;
  TileRange* tiles = nullptr;       ///< of each part
  std::uint16_t* counts = nullptr;  ///< of the lists of a band
  std::uint16_t* lists = nullptr;   ///< most_parts_ per tile of a band
  Caster* casters = nullptr;
  CasterBounds bounds{};
  std::uint16_t* shadows = nullptr;  ///< casters of a tile
  std::size_t size = 0;              ///< doubles

  /// @param memory  `size` doubles; null: only computes the size
  Scratch(double* memory, int most_parts, int columns) : memory_(memory) {
    const auto most = static_cast<std::size_t>(most_parts);
    const auto tiles_of_band = static_cast<std::size_t>(columns);
    take(parts, most);
    take(tiles, most);
    take(counts, tiles_of_band);
    take(lists, most * tiles_of_band);
    take(casters, most);
    for (float** bound :
         {&bounds.low[0], &bounds.low[1], &bounds.high[0], &bounds.high[1], &bounds.top}) {
      take(*bound, most + kTileWidth);
    }
    take(shadows, most);
  }

 private:
  template <class T>
  void take(T*& array, std::size_t count) {
    if (memory_ != nullptr) array = reinterpret_cast<T*>(memory_ + size);
    size += (count * sizeof(T) + 7) / 8;
  }

  double* memory_;
};

/// A drawn tile, and its place in the image.
struct Renderer::Tile {
  const float *x, *y;  ///< directions of its columns and rows
  int width, height;   ///< of its part within the image [pixels]
  std::size_t first;   ///< index of its first pixel in the image
  float depth[kTilePixels];
  std::uint32_t id[kTilePixels];
  std::int32_t surface[kTilePixels];
  float normal[3 * kTilePixels];
  std::uint32_t color[kTilePixels];

  /// Calls function(index in the image, index in the tile) for each pixel.
  template <class Function>
  void each_pixel(int image_width, Function&& function) const {
    for (int r = 0; r < height; ++r) {
      const std::size_t row =
          first + static_cast<std::size_t>(r) * static_cast<std::size_t>(image_width);
      for (int c = 0; c < width; ++c) {
        function(row + static_cast<std::size_t>(c), r * kTileWidth + c);
      }
    }
  }
};

Renderer::Renderer(const Pinhole& camera, int most_shapes, double farthest,
                   const KernelTable& kernels)
    : camera_(camera),
      kernels_(&kernels),
      most_parts_(kMostParts * most_shapes),
      columns_(tiles_for(camera.width, kTileWidth)),
      bands_(tiles_for(camera.height, kTileHeight)),
      farthest_(static_cast<float>(farthest)),
      x_(directions(camera.width, kTileWidth, camera.center_x, camera.focal_x)),
      y_(directions(camera.height, kTileHeight, camera.center_y, camera.focal_y)) {}

std::size_t Renderer::scratch_size() const { return Scratch(nullptr, most_parts_, columns_).size; }

void Renderer::draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
                    double* memory, const Frame& frame) const {
  const Scratch scratch(memory, most_parts_, columns_);
  for (const PlacedShape& shape : shapes) {
    if (contains(shape, eye.position)) return fill(shape, frame);
  }
  int count = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    count += list_parts(shapes[i], static_cast<int>(i), eye, scratch, count);
  }
  Light light = light_of(sky, eye, camera_);
  light.casters = scratch.casters;
  light.bounds = scratch.bounds;
  for (std::size_t i = 0; frame.rgb != nullptr && sky.has_shadows && i < shapes.size(); ++i) {
    cast(shapes[i], static_cast<int>(i), eye, light, scratch.casters);
  }
  for (int band = 0; band < bands_; ++band) draw_band(band, scratch, count, light, frame);
}

/// Adds the parts of a shape that meet the image, from `first` on. @returns their number
int Renderer::list_parts(const PlacedShape& shape, int number, const Eye& eye,
                         const Scratch& scratch, int first) const {
  SeenShape* const parts = scratch.parts + first;
  Cover covers[kMostParts];
  const int seen = see(shape, eye, parts, covers);
  int kept = 0;
  for (int k = 0; k < seen; ++k) {
    const Span x = tiles_between(covers[k].left, covers[k].right, x_, kTileWidth);
    const Span y = tiles_between(covers[k].top, covers[k].bottom, y_, kTileHeight);
    if (x.first == x.last || y.first == y.last) continue;
    if (kept != k) parts[kept] = parts[k];
    parts[kept].shape = number;
    scratch.tiles[first + kept++] = {x.first, x.last, y.first, y.last};
  }
  return kept;
}

void Renderer::fill(const PlacedShape& inside, const Frame& frame) const {
  const auto pixels =
      static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
  const auto set = [pixels](auto* image, auto value) {
    if (image != nullptr) std::fill_n(image, pixels, value);
  };
  set(frame.depth, 0.0f);
  set(frame.range, 0.0f);
  set(frame.instance, inside.instance);
  set(frame.label, static_cast<std::uint8_t>(inside.label));
  if (frame.normal != nullptr) std::fill_n(frame.normal, 3 * pixels, 0.0f);
  if (frame.rgb != nullptr) std::fill_n(frame.rgb, 3 * pixels, std::uint8_t{0});
}

void Renderer::draw_band(int band, const Scratch& scratch, int count, const Light& light,
                         const Frame& frame) const {
  std::fill_n(scratch.counts, columns_, std::uint16_t{0});
  for (int k = 0; k < count; ++k) {
    const TileRange& range = scratch.tiles[k];
    if (band < range.top || band >= range.bottom) continue;
    for (int column = range.left; column < range.right; ++column) {
      scratch.lists[column * most_parts_ + scratch.counts[column]++] =
          static_cast<std::uint16_t>(k);
    }
  }
  const int top = band * kTileHeight;
  for (int column = 0; column < columns_; ++column) {
    const int left = column * kTileWidth;
    Tile tile;
    tile.x = x_.data() + left;
    tile.y = y_.data() + top;
    tile.width = std::min(kTileWidth, camera_.width - left);
    tile.height = std::min(kTileHeight, camera_.height - top);
    tile.first = static_cast<std::size_t>(top) * static_cast<std::size_t>(camera_.width) +
                 static_cast<std::size_t>(left);
    const TileCall call{scratch.parts,
                        scratch.lists + column * most_parts_,
                        scratch.counts[column],
                        tile.x,
                        tile.y,
                        farthest_,
                        tile.depth,
                        tile.id,
                        frame.is_shaded() ? tile.surface : nullptr};
    kernels_->draw(call);
    write_depths(tile, frame);
    if (!frame.is_shaded()) continue;
    kernels_->shade({call, &light, scratch.shadows, frame.normal != nullptr ? tile.normal : nullptr,
                     frame.rgb != nullptr ? tile.color : nullptr});
    write_shades(tile, frame);
  }
}

void Renderer::write_depths(const Tile& tile, const Frame& frame) const {
  const int width = camera_.width;
  if (frame.depth != nullptr) {
    tile.each_pixel(width, [&](std::size_t to, int at) { frame.depth[to] = tile.depth[at]; });
  }
  if (frame.range != nullptr) {
    tile.each_pixel(width, [&](std::size_t to, int at) {
      const float x = tile.x[at % kTileWidth], y = tile.y[at / kTileWidth];
      const float range = tile.depth[at] * std::sqrt((x * x + y * y) + 1.0f);
      frame.range[to] = tile.id[at] == 0 ? farthest_ : std::min(range, farthest_);
    });
  }
  if (frame.instance != nullptr) {
    tile.each_pixel(width, [&](std::size_t to, int at) {
      frame.instance[to] = static_cast<std::uint16_t>(tile.id[at] & 0xffffu);
    });
  }
  if (frame.label != nullptr) {
    tile.each_pixel(width, [&](std::size_t to, int at) {
      frame.label[to] = static_cast<std::uint8_t>(tile.id[at] >> 16);
    });
  }
}

void Renderer::write_shades(const Tile& tile, const Frame& frame) const {
  const int width = camera_.width;
  if (frame.normal != nullptr) {
    tile.each_pixel(width, [&](std::size_t to, int at) {
      for (std::size_t k = 0; k < 3; ++k) {
        frame.normal[3 * to + k] = tile.normal[k * kTilePixels + static_cast<std::size_t>(at)];
      }
    });
  }
  if (frame.rgb == nullptr) return;
  tile.each_pixel(width, [&](std::size_t to, int at) {
    for (std::size_t k = 0; k < 3; ++k) {
      frame.rgb[3 * to + k] = static_cast<std::uint8_t>(tile.color[at] >> (8 * k));
    }
  });
}

}  // namespace skybody::render
