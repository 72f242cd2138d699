// Lines over a drawn image: flat colours, smooth edges, hidden behind nearer surfaces.
#pragma once

#include <cstdint>
#include <span>

#include "render/scene.h"

namespace skybody::render {

/// A point of a line. Widths, colours and opacity change evenly from point to point.
struct LinePoint {
  Vec3<double> position{0.0, 0.0, 0.0};  ///< W [m]
  Color color{0.0f, 0.0f, 0.0f};         ///< red, green, blue in [0, 1]
  float opacity = 1.0f;                  ///< 0: not seen
  float width = 1.0f;                    ///< [pixels]
  bool is_first = false;                 ///< no line leads to it from the point before
};

/// @param depth  of each pixel, as Frame::depth
/// @param rgb    as Frame::rgb; lines are blended into it
void draw_lines(const Pinhole& camera, const Eye& eye, std::span<const LinePoint> points,
                const float* depth, std::uint8_t* rgb);

}  // namespace skybody::render
