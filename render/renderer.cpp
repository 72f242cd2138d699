#include "render/renderer.h"

#include <algorithm>

#include "render/caster.h"
#include "render/mesh.h"
#include "render/seen_shape.h"
#include "render/textured_shape.h"
#include "render/tile_images.h"

namespace skybody::render {
namespace {

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

/// Where the pixels' centres of an axis are. From the first to the last one: the difference of two
/// neighbours has the rounding error of both.
GridAxis axis_of(const std::vector<float>& centers, int pixels) {
  const double length = static_cast<double>(centers.back()) - static_cast<double>(centers.front());
  const double inverse_step = static_cast<double>(centers.size() - 1) / length;
  return {centers.front(), static_cast<float>(inverse_step), static_cast<float>(pixels)};
}

bool meets(const Cover& a, const Cover& b) {
  return a.left <= b.right && a.right >= b.left && a.top <= b.bottom && a.bottom >= b.top;
}

void turn(const Eye& eye, const Vec3<double>& v, float (&out)[3]) {
  const Vec3<double> seen = transpose_times(eye.axes, v);
  out[0] = static_cast<float>(seen.x);
  out[1] = static_cast<float>(seen.y);
  out[2] = static_cast<float>(seen.z);
}

Light light_of(const Sky& sky, const Eye& eye, double pixel) {
  Light light{};
  turn(eye, sky.sun, light.sun);
  turn(eye, {0.0, 0.0, 1.0}, light.up);
  light.direct = sky.direct;
  light.ambient = sky.ambient;
  std::copy(sky.zenith.begin(), sky.zenith.end(), light.zenith);
  std::copy(sky.horizon.begin(), sky.horizon.end(), light.horizon);
  light.haze = sky.haze * sky.haze;
  light.pixel = static_cast<float>(pixel);
  set_sides(light);
  return light;
}

}  // namespace

/// Tiles [left, right) x [top, bottom).
struct Renderer::TileRange {
  std::uint16_t left, right, top, bottom;
};

/// Numbers of parts and triangles that an eye may see.
struct Renderer::Seen {
  int parts = 0, triangles = 0;
};

/// Parts of shapes with their tiles, the lists of a band of tiles, and casters of shadows.
struct Renderer::Scratch {
  SeenShape* parts = nullptr;
  TileRange* tiles = nullptr;       ///< of each part, in a grid
  Cover* covers = nullptr;          ///< of each part, for scattered rays
  std::uint16_t* counts = nullptr;  ///< of the lists of a band
  std::uint16_t* lists = nullptr;   ///< most_parts_ per tile of a band
  Caster* casters = nullptr;
  CasterBounds bounds{};
  std::uint16_t* shadows = nullptr;  ///< casters of a tile
  SeenTriangle* triangles = nullptr;
  TileRange* triangle_tiles = nullptr;       ///< of each triangle, in a grid
  std::uint16_t* triangle_counts = nullptr;  ///< of the lists of a band
  std::uint16_t* triangle_lists = nullptr;   ///< as `lists`
  TexturedShape* textured = nullptr;
  std::size_t size = 0;  ///< doubles

  /// @param memory  `size` doubles; null: only computes the size
  Scratch(double* memory, int most_parts, int most_triangles, int most_textured, int columns)
      : memory_(memory) {
    const auto most = static_cast<std::size_t>(most_parts);
    const auto tiles_of_band = static_cast<std::size_t>(columns);
    take(parts, most);
    take(tiles, most);
    take(counts, tiles_of_band);
    take(lists, most * tiles_of_band);
    take(casters, most);
    for (float** bound :
         {&bounds.low[0], &bounds.low[1], &bounds.high[0], &bounds.high[1], &bounds.top}) {
      take(*bound, most + kMostLanes);
    }
    take(shadows, most);
    take(covers, most);
    take(textured, static_cast<std::size_t>(most_textured));
    if (most_triangles == 0) return;
    const auto of_meshes = static_cast<std::size_t>(most_triangles);
    take(triangles, of_meshes);
    take(triangle_tiles, of_meshes);
    take(triangle_counts, tiles_of_band);
    take(triangle_lists, of_meshes * tiles_of_band);
  }

 private:
  template <class T>
  void take(T*& array, std::size_t count) {
    if (memory_ != nullptr) array = reinterpret_cast<T*>(memory_ + size);
    size += (count * sizeof(T) + 7) / 8;
  }

  double* memory_;
};

Renderer::Renderer(const Pinhole& camera, const Capacity& most, double farthest,
                   const KernelTable& kernels)
    : width_(camera.width),
      height_(camera.height),
      pixel_(1.0 / camera.focal_x),
      kernels_(&kernels),
      most_parts_(kMostParts * most.shapes),
      most_triangles_(most.triangles),
      most_textured_(most.textured),
      columns_(tiles_for(camera.width, kTileWidth)),
      bands_(tiles_for(camera.height, kTileHeight)),
      farthest_(static_cast<float>(farthest)),
      x_(directions(camera.width, kTileWidth, camera.center_x, camera.focal_x)),
      y_(directions(camera.height, kTileHeight, camera.center_y, camera.focal_y)) {}

Renderer::Renderer(const RayImage& rays, const Capacity& most, double farthest,
                   const KernelTable& kernels)
    : width_(rays.width),
      height_(rays.height),
      pixel_(widest_pixel(rays)),
      kernels_(&kernels),
      most_parts_(kMostParts * most.shapes),
      most_triangles_(most.triangles),
      most_textured_(most.textured),
      farthest_(static_cast<float>(farthest)),
      faces_(faces_of(rays)) {}

std::size_t Renderer::scratch_size() const {
  return Scratch(nullptr, most_parts_, most_triangles_, most_textured_, columns_).size;
}

void Renderer::draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
                    double* memory, const Frame& frame) const {
  const Scratch scratch(memory, most_parts_, most_triangles_, most_textured_, columns_);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    if (contains(shapes[i], eye.position)) return fill(shapes[i], static_cast<int>(i), frame);
  }
  if (faces_.empty()) draw_grid(eye, shapes, sky, scratch, frame);
  for (const RayFace& face : faces_) {
    draw_face(face, {eye.position, eye.axes * face.axes}, shapes, sky, scratch, frame);
  }
}

/// Light and casters of shadows, in axes of the eye.
Light Renderer::light(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
                      const Scratch& scratch, const Frame& frame) const {
  Light light = light_of(sky, eye, pixel_);
  light.casters = scratch.casters;
  light.bounds = scratch.bounds;
  for (std::size_t i = 0; frame.has_colors() && sky.has_shadows && i < shapes.size(); ++i) {
    if (!shapes[i].casts_shadow) continue;
    cast(shapes[i], static_cast<int>(i), eye, light, scratch.casters);
  }
  return light;
}

void Renderer::draw_grid(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
                         const Scratch& scratch, const Frame& frame) const {
  Seen seen;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const int part = seen.parts;
    seen.parts += list_parts(shapes[i], static_cast<int>(i), eye, scratch, part);
    if (shapes[i].solid != Solid::kMesh || seen.parts == part) continue;
    scratch.tiles[part] = {};  // the mesh's triangles are listed instead
    const int first = seen.triangles;
    seen.triangles += list_triangles(shapes[i], eye, part, scratch, first);
    for (int k = first; k < seen.triangles; ++k) {
      const Cover& cover = scratch.triangles[k].cover;
      const Span x = tiles_between(cover.left, cover.right, x_, kTileWidth);
      const Span y = tiles_between(cover.top, cover.bottom, y_, kTileHeight);
      scratch.triangle_tiles[k] = {x.first, x.last, y.first, y.last};
    }
  }
  if (frame.has_colors()) lay_textures(eye, shapes, scratch, seen.parts);
  const Light lit = light(eye, shapes, sky, scratch, frame);
  Frame rest = frame;  // `packed` moves from tile to tile
  for (int band = 0; band < bands_; ++band) draw_band(band, scratch, seen, lit, rest);
}

/// @param eye  with the axes of the face
void Renderer::draw_face(const RayFace& face, const Eye& eye, std::span<const PlacedShape> shapes,
                         const Sky& sky, const Scratch& scratch, const Frame& frame) const {
  Seen seen;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const int part = seen.parts;
    seen.parts += see(shapes[i], eye, scratch.parts + part, scratch.covers + part);
    for (int k = part; k < seen.parts; ++k) scratch.parts[k].shape = static_cast<int>(i);
    if (shapes[i].solid != Solid::kMesh || seen.parts == part) continue;
    scratch.covers[part] = kNowhere;  // the mesh's triangles are listed instead
    seen.triangles += list_triangles(shapes[i], eye, part, scratch, seen.triangles);
  }
  if (frame.has_colors()) lay_textures(eye, shapes, scratch, seen.parts);
  const Light lit = light(eye, shapes, sky, scratch, frame);
  for (const RayTile& tile : face.tiles) {
    int shapes_listed = 0, triangles_listed = 0;
    for (int k = 0; k < seen.parts; ++k) {
      if (!meets(scratch.covers[k], tile.bounds)) continue;
      scratch.lists[shapes_listed++] = static_cast<std::uint16_t>(k);
    }
    for (int k = 0; k < seen.triangles; ++k) {
      if (!meets(scratch.triangles[k].cover, tile.bounds)) continue;
      scratch.triangle_lists[triangles_listed++] = static_cast<std::uint16_t>(k);
    }
    TileCall call{};
    call.list = scratch.lists;
    call.count = shapes_listed;
    call.triangle_list = scratch.triangle_lists;
    call.triangle_count = triangles_listed;
    call.is_scattered = true;
    call.x = tile.x;
    call.y = tile.y;
    draw_tile(call, RayPixels{tile, face.axes, farthest_}, lit, scratch, frame);
  }
}

/// Lays textures on the shapes of the seen parts. Parts of a shape follow one another.
void Renderer::lay_textures(const Eye& eye, std::span<const PlacedShape> shapes,
                            const Scratch& scratch, int parts) const {
  TexturedShape* next = scratch.textured;
  for (int k = 0; most_textured_ > 0 && k < parts; ++k) {
    SeenShape& part = scratch.parts[k];
    const PlacedShape& shape = shapes[static_cast<std::size_t>(part.shape)];
    if (shape.paint.texture == nullptr) continue;
    const bool is_first = k == 0 || scratch.parts[k - 1].shape != part.shape;
    if (is_first) *next++ = lay_texture(shape, eye);
    part.textured = next - 1;
  }
}

/// Writes the triangles of a mesh that may be seen, from `first` on. @returns their number
int Renderer::list_triangles(const PlacedShape& shape, const Eye& eye, int part,
                             const Scratch& scratch, int first) const {
  MeshCall call{};
  for (int k = 0; k < 9; ++k) call.coordinates[k] = shape.mesh->coordinate(k);
  call.count = shape.mesh->count();
  const Vec3<double> from = transpose_times(shape.axes, eye.position - shape.position);
  const double place[3] = {from.x, from.y, from.z};
  for (int k = 0; k < 3; ++k) {
    call.eye[k] = static_cast<float>(place[k]);
    call.eye_rest[k] = static_cast<float>(place[k] - static_cast<double>(call.eye[k]));
  }
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      call.axes[row][column] =
          static_cast<float>(dot(eye.axes.column(row), shape.axes.column(column)));
    }
  }
  call.has_grid = faces_.empty();
  if (call.has_grid) {
    call.columns = axis_of(x_, width_);
    call.rows = axis_of(y_, height_);
  }
  call.id = scratch.parts[part].id;
  call.part = part;
  call.seen = scratch.triangles + first;
  return kernels_->see_triangles(call);
}

/// Adds the parts of a shape that meet a grid's image, from `first` on. @returns their number
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

void Renderer::fill(const PlacedShape& inside, int number, const Frame& frame) const {
  const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  const auto set = [pixels](auto* image, auto value) {
    if (image != nullptr) std::fill_n(image, pixels, value);
  };
  set(frame.depth, 0.0f);
  set(frame.range, 0.0f);
  set(frame.instance, inside.instance);
  set(frame.label, static_cast<std::uint8_t>(inside.label));
  set(frame.shape, number);
  if (frame.normal != nullptr) std::fill_n(frame.normal, 3 * pixels, 0.0f);
  if (frame.rgb != nullptr) std::fill_n(frame.rgb, 3 * pixels, std::uint8_t{0});
}

/// Lists the numbers of tile ranges by the columns of a band.
/// @param lists  `most` per column
void Renderer::list_band(int band, const TileRange* ranges, int count, int most,
                         std::uint16_t* counts, std::uint16_t* lists) const {
  std::fill_n(counts, columns_, std::uint16_t{0});
  for (int k = 0; k < count; ++k) {
    const TileRange& range = ranges[k];
    if (band < range.top || band >= range.bottom) continue;
    for (int column = range.left; column < range.right; ++column) {
      lists[column * most + counts[column]++] = static_cast<std::uint16_t>(k);
    }
  }
}

void Renderer::draw_band(int band, const Scratch& scratch, const Seen& seen, const Light& light,
                         Frame& frame) const {
  const std::uint8_t* wanted = frame.tiles;
  if (wanted != nullptr) {
    wanted += static_cast<std::ptrdiff_t>(band) * columns_;
    if (std::find(wanted, wanted + columns_, 1) == wanted + columns_) return;
  }
  list_band(band, scratch.tiles, seen.parts, most_parts_, scratch.counts, scratch.lists);
  if (seen.triangles > 0) {
    list_band(band, scratch.triangle_tiles, seen.triangles, most_triangles_,
              scratch.triangle_counts, scratch.triangle_lists);
  }
  const int top = band * kTileHeight;
  for (int column = 0; column < columns_; ++column) {
    if (wanted != nullptr && wanted[column] == 0) continue;
    const int left = column * kTileWidth;
    const GridPixels pixels{x_.data() + left,
                            y_.data() + top,
                            std::min(kTileWidth, width_ - left),
                            std::min(kTileHeight, height_ - top),
                            width_,
                            static_cast<std::size_t>(top) * static_cast<std::size_t>(width_) +
                                static_cast<std::size_t>(left),
                            farthest_};
    TileCall call{};
    call.list = scratch.lists + column * most_parts_;
    call.count = scratch.counts[column];
    if (seen.triangles > 0) {
      call.triangle_list = scratch.triangle_lists + column * most_triangles_;
      call.triangle_count = scratch.triangle_counts[column];
    }
    call.x = pixels.x;
    call.y = pixels.y;
    draw_tile(call, pixels, light, scratch, frame);
    if (frame.packed != nullptr) frame.packed += kTilePixels;
  }
}

/// @param call    with lists and directions. By reference: a copy waits for its fresh stores.
/// @param pixels  GridPixels or RayPixels
template <class Pixels>
void Renderer::draw_tile(TileCall& call, const Pixels& pixels, const Light& light,
                         const Scratch& scratch, const Frame& frame) const {
  DrawnTile tile;
  call.shapes = scratch.parts;
  call.triangles = scratch.triangles;
  call.farthest = farthest_;
  call.depth = tile.depth;
  call.id = tile.id;
  call.surface = frame.is_shaded() || frame.shape != nullptr ? tile.surface : nullptr;
  kernels_->draw(call);
  write_depths(pixels, tile, frame);
  if (frame.shape != nullptr) write_shapes(pixels, tile, scratch.parts, scratch.triangles, frame);
  if (!frame.is_shaded()) return;
  kernels_->shade({&call, &light, scratch.shadows, frame.normal != nullptr ? tile.normal : nullptr,
                   frame.has_colors() ? tile.color : nullptr, most_textured_ > 0});
  if (frame.packed != nullptr) std::copy_n(tile.color, kTilePixels, frame.packed);
  write_shades(pixels, tile, frame);
}

}  // namespace skybody::render
