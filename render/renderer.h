// Draws images of shapes by casting one ray per pixel, in closed form.
//
// An image depends on its inputs only: each pixel is computed by additions, products, divisions and
// square roots of floats in a fixed order, the same for all instruction sets.
//
// 1. see(): constants of each shape, in double, and a rectangle around its picture.
// 2. Shapes are listed by tile (kernel_table.h); each pixel tests the shapes of its tile only.
// 3. The kernels find the nearest surface of each pixel and shade it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/kernels/kernels.h"
#include "render/scene.h"

namespace skybody::render {

/// Images to draw, row by row from the top left; null: not wanted.
struct Frame {
  float* depth = nullptr;             ///< distance along the optical axis [m]; see Renderer
  float* range = nullptr;             ///< distance from the eye [m]; `farthest` for nothing
  std::uint16_t* instance = nullptr;  ///< PlacedShape::instance; 0: nothing
  std::uint8_t* label = nullptr;      ///< Label
  float* normal = nullptr;  ///< right, down, forward of the outward unit normal; 0, 0, 0: nothing
  std::uint8_t* rgb = nullptr;  ///< red, green, blue

  bool is_shaded() const { return normal != nullptr || rgb != nullptr; }
};

/// Immutable: threads may share one, each with its own scratch memory.
class Renderer {
 public:
  /// @param most_shapes  most shapes of a call of draw()
  /// @param farthest     depth of pixels that see nothing, and of farther surfaces [m], > 0
  /// @param kernels      kernels_of(best_isa()), or others: all give the same bits
  Renderer(const Pinhole& camera, int most_shapes, double farthest, const KernelTable& kernels);

  /// Doubles of scratch memory for draw().
  std::size_t scratch_size() const;

  /// An eye inside of a shape sees that shape at distance 0 in all pixels; its normals are 0.
  /// @param scratch  scratch_size() doubles, content undefined
  void draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky, double* scratch,
            const Frame& frame) const;

  const Pinhole& camera() const { return camera_; }

 private:
  struct Scratch;
  struct Tile;

  int list_parts(const PlacedShape& shape, int number, const Eye& eye, const Scratch& scratch,
                 int first) const;
  void fill(const PlacedShape& inside, const Frame& frame) const;
  void draw_band(int band, const Scratch& scratch, int count, const Light& light,
                 const Frame& frame) const;
  void write_depths(const Tile& tile, const Frame& frame) const;
  void write_shades(const Tile& tile, const Frame& frame) const;

  Pinhole camera_;
  const KernelTable* kernels_;
  int most_parts_;
  int columns_, bands_;  ///< of tiles
  float farthest_;
  std::vector<float> x_, y_;  ///< directions of pixels, up to whole tiles
};

}  // namespace skybody::render
