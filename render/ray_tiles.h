// Rays of any directions in tiles, for the kernels: views of fisheye cameras, panoramas, lidars.
//
// The kernels cast rays (x, y, 1). A view in all directions is therefore cut into the faces of a
// cube about the eye: each face is a camera of its own axes, whose rays lie within its square.
#pragma once

#include <cstdint>
#include <vector>

#include "render/kernels/kernel_table.h"
#include "render/scene.h"
#include "render/seen_shape.h"

namespace skybody::render {

/// Rays of one face, close to each other. A tile that is not full repeats its last ray.
struct RayTile {
  float x[kTilePixels], y[kTilePixels];  ///< directions (x, y, 1), axes of the face
  float axial[kTilePixels];              ///< cosines of their angles to the optical axis
  std::int32_t pixel[kTilePixels];       ///< indices in the image
  int count;                             ///< without repetitions
  Cover bounds;                          ///< of the directions
};

/// A face of the cube, as a camera.
struct RayFace {
  Mat3<double> axes;  ///< camera axes from the face's: a permutation with signs
  std::vector<RayTile> tiles;
};

/// @param rays  directions in camera axes, of any length above 0
/// @returns the faces that have rays
std::vector<RayFace> faces_of(const RayImage& rays);

/// The widest distance between the unit vectors of neighbouring pixels of a row.
double widest_pixel(const RayImage& rays);

}  // namespace skybody::render
