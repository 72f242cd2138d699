// Colour images without jagged edges: pixels beside a change of colour are the mean of 16 rays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/lines.h"
#include "render/renderer.h"
#include "render/scene.h"

namespace skybody::render {

/// Draws an image with a ray per pixel, then again, with 16 rays per pixel, the tiles in which
/// neighbouring pixels differ, and then lines over it. Immutable, as Renderer.
class SmoothRenderer {
 public:
  /// @param most, farthest, kernels  as of Renderer
  SmoothRenderer(const Pinhole& camera, const Capacity& most, double farthest,
                 const KernelTable& kernels);

  /// Memory of a call of draw(); each thread has its own.
  class Scratch {
   public:
    explicit Scratch(const SmoothRenderer& renderer);

   private:
    friend class SmoothRenderer;
    std::vector<double> memory_;
    std::vector<std::uint8_t> tiles_;  ///< 1: to be drawn finely
    std::vector<std::uint32_t> rays_;  ///< Frame::packed of these tiles
    std::vector<float> depth_;         ///< of the image
  };

  /// @param rgb  red, green, blue of each pixel, row by row from the top left
  void draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky, Scratch& scratch,
            std::uint8_t* rgb, std::span<const LinePoint> lines = {}) const;

  int width() const { return camera_.width; }    ///< [pixels]
  int height() const { return camera_.height; }  ///< [pixels]

 private:
  std::size_t mark_edges(const std::uint8_t* rgb, std::uint8_t* tiles) const;
  void average(const Scratch& scratch, std::uint8_t* rgb) const;

  Pinhole camera_;
  Renderer coarse_, fine_;
  int columns_;  ///< of fine tiles
};

}  // namespace skybody::render
