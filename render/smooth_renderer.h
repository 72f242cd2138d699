// Colour images without jagged edges: pixels beside a change of colour are the mean of nine rays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/lines.h"
#include "render/renderer.h"
#include "render/scene.h"

namespace skybody::render {

class Haze;

/// The parts of an image that are no shapes.
struct Overlay {
  float haze = 0.0f;  ///< depth at which surfaces have half the colour of the horizon [m]; 0: none
  std::span<const LinePoint> lines;
};

/// Draws an image with a ray per pixel, then again, with nine rays per pixel, the tiles in which
/// neighbouring pixels differ. Immutable, as Renderer.
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
    std::vector<std::uint8_t> rgb_;    ///< of the fine image
    std::vector<float> depth_;         ///< of the image
  };

  /// @param rgb  red, green, blue of each pixel, row by row from the top left
  void draw(const Eye& eye, std::span<const PlacedShape> shapes, const Sky& sky, Scratch& scratch,
            std::uint8_t* rgb, const Overlay& overlay = {}) const;

  int width() const { return coarse_.width(); }    ///< [pixels]
  int height() const { return coarse_.height(); }  ///< [pixels]

 private:
  void mark_edges(const std::uint8_t* rgb, std::uint8_t* tiles) const;
  void mark(int x, int y, std::uint8_t* tiles) const;
  void average(const Scratch& scratch, const Haze& haze, std::uint8_t* rgb) const;
  void average_pixel(const Scratch& scratch, const Haze& haze, int x, int y,
                     std::uint8_t* rgb) const;
  int fine_columns() const;
  int fine_bands() const;

  Pinhole camera_;
  float farthest_;
  Renderer coarse_, fine_;
};

}  // namespace skybody::render
