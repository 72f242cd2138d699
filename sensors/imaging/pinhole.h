// Pinholes without distortion, from a field of view.
#pragma once

#include <skybody/plugin.h>

#include "render/scene.h"

namespace skybody::sensor {

/// Greatest field of view of a pinhole [rad].
inline constexpr double kWidestPinhole = 3.0;

/// Focal length of a pinhole [pixels]. @param field_of_view  horizontal [rad]
inline double pinhole_focal(int width, double field_of_view) {
  const SinCos<double> half = sincos(0.5 * field_of_view);
  return 0.5 * width * half.cos / half.sin;
}

/// A pinhole with square pixels, and its principal point in the middle of the image.
inline render::Pinhole pinhole(int width, int height, double field_of_view) {
  render::Pinhole camera;
  camera.width = width;
  camera.height = height;
  camera.center_x = 0.5 * camera.width;
  camera.center_y = 0.5 * camera.height;
  camera.focal_x = camera.focal_y = pinhole_focal(width, field_of_view);
  return camera;
}

}  // namespace skybody::sensor
