// Projections of cameras other than the pinhole: from pixels to directions.
#pragma once

#include <vector>

#include "render/scene.h"

namespace skybody::camera {

/// A lens and its image. The centre of pixel (column, row) has the image coordinates
/// u = (column + 1/2 - width / 2) / focal, v = (row + 1/2 - height / 2) / focal.
struct Lens {
  int width = 64, height = 64;     ///< [pixels]
  double field_of_view = 0.0;      ///< horizontal, without distortion [rad]
  std::vector<double> distortion;  ///< coefficients, or none
};

/// A pinhole with the radial and tangential distortion of Brown and Conrady, in the order of
/// OpenCV: k1, k2, p1, p2, k3. @throws std::runtime_error if the image is folded: two directions
/// have one pixel
render::RayImage distorted(const Lens& lens);

/// A fisheye: the distance of a pixel from the centre is angle (1 + k1 angle^2 + k2 angle^4 + k3
/// angle^6 + k4 angle^8) focal lengths (Kannala and Brandt; equidistant without coefficients).
/// @throws std::runtime_error if the image is folded
render::RayImage fisheye(const Lens& lens);

/// A panorama: columns are equidistant in azimuth, rows in elevation (equirectangular).
render::RayImage panorama(const Lens& lens);

}  // namespace skybody::camera
