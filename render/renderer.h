// Draws images of shapes by casting one ray per pixel, in closed form: a pinhole's grid of pixels,
// or rays of any directions.
//
// An image depends on its inputs only: each pixel is computed by additions, products, divisions and
// square roots of floats in a fixed order, the same for all instruction sets.
//
// 1. see(): constants of each shape, in double, and a rectangle around its picture.
// 2. Shapes are listed by tile (kernel_table.h); each pixel tests the shapes of its tile only. Rays
//    of any directions have up to six faces with tiles of their own (ray_tiles.h).
// 3. The kernels find the nearest surface of each pixel and shade it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/kernels/kernels.h"
#include "render/ray_tiles.h"
#include "render/scene.h"

namespace skybody::render {

/// Images to draw, row by row from the top left; null: not wanted.
struct Frame {
  float* depth = nullptr;  ///< distance along the optical axis [m]; `farthest` for nothing
  float* range = nullptr;  ///< distance from the eye [m]; `farthest` for nothing
  std::uint16_t* instance = nullptr;  ///< PlacedShape::instance; 0: nothing
  std::uint8_t* label = nullptr;      ///< Label
  float* normal = nullptr;  ///< right, down, forward of the outward unit normal; 0, 0, 0: nothing
  std::uint8_t* rgb = nullptr;    ///< red, green, blue
  std::int32_t* shape = nullptr;  ///< index of the shape in the list of draw(); -1: nothing
  /// Of a grid: 1 for tiles to draw, kTileWidth x kTileHeight pixels each, row by row; null: all.
  const std::uint8_t* tiles = nullptr;
  /// Colours of the drawn tiles of a grid, one after the other, kTilePixels each: red, green << 8,
  /// blue << 16. Tiles are whole also at the image's right and bottom.
  std::uint32_t* packed = nullptr;

  bool has_colors() const { return rgb != nullptr || packed != nullptr; }
  bool is_shaded() const { return normal != nullptr || has_colors(); }
};

/// Limits of a scene.
struct Capacity {
  int shapes;     ///< with meshes
  int triangles;  ///< of all meshes
  int textured;   ///< shapes with textures

  Capacity(int most_shapes, int most_triangles = 0, int most_textured = 0)
      : shapes(most_shapes), triangles(most_triangles), textured(most_textured) {}
};

/// Immutable: threads may share one, each with its own scratch memory.
class Renderer {
 public:
  /// @param most      of a call of draw()
  /// @param farthest  depth of pixels that see nothing, and of farther surfaces [m], > 0; of a
  ///   RayImage the range
  /// @param kernels   kernels_of(best_isa()), or others: all give the same bits
  Renderer(const Pinhole& camera, const Capacity& most, double farthest,
           const KernelTable& kernels);
  Renderer(const RayImage& rays, const Capacity& most, double farthest, const KernelTable& kernels);

  /// Doubles of scratch memory for draw().
  std::size_t scratch_size() const;

  /// An eye inside of a shape sees that shape at distance 0 in all pixels; its normals are 0.
  /// Meshes have no inside.
  /// @param scratch  scratch_size() doubles, content undefined
  void draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky, double* scratch,
            const Frame& frame) const;

  int width() const { return width_; }    ///< [pixels]
  int height() const { return height_; }  ///< [pixels]

 private:
  struct Scratch;
  struct TileRange;
  struct Seen;

  int list_triangles(const PlacedShape& shape, const Eye& eye, int part, const Scratch& scratch,
                     int first) const;
  void list_band(int band, const TileRange* ranges, int count, int most, std::uint16_t* counts,
                 std::uint16_t* lists) const;
  int list_parts(const PlacedShape& shape, int number, const Eye& eye, const Scratch& scratch,
                 int first) const;
  void lay_textures(const Eye& eye, std::span<const PlacedShape> shapes, const Scratch& scratch,
                    int parts) const;
  void fill(const PlacedShape& inside, int number, const Frame& frame) const;
  Light light(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
              const Scratch& scratch, const Frame& frame) const;
  void draw_grid(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky,
                 const Scratch& scratch, const Frame& frame) const;
  void draw_face(const RayFace& face, const Eye& eye, std::span<const PlacedShape> shapes,
                 const Sky& sky, const Scratch& scratch, const Frame& frame) const;
  void draw_band(int band, const Scratch& scratch, const Seen& seen, const Light& light,
                 Frame& frame) const;
  template <class Pixels>
  void draw_tile(TileCall& call, const Pixels& pixels, const Light& light, const Scratch& scratch,
                 const Frame& frame) const;

  int width_, height_;  ///< [pixels]
  double pixel_;        ///< Light::pixel
  const KernelTable* kernels_;
  int most_parts_, most_triangles_, most_textured_;
  int columns_ = 1, bands_ = 0;  ///< of tiles, of a grid
  float farthest_;
  std::vector<float> x_, y_;    ///< directions of a grid's pixels, up to whole tiles
  std::vector<RayFace> faces_;  ///< empty: a grid
};

}  // namespace skybody::render
